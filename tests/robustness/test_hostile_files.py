"""Files that wait for ever, lead elsewhere, or are larger than they look, each refused in one line."""

import gzip
import os
from pathlib import Path

import numpy as np
import pytest

from stagecad.parameters.errors import InputError
from stagecad.parameters.input_file import read_input
from sysid.experiment.readers import isolated, limited_text
from sysid.experiment.readers.base import MOST_ROWS
from sysid.experiment.readers.open import open_record_file
from tests.experiments import record_text, state


def read_all(path: Path) -> None:
    opened = open_record_file(path, path.name)
    opened.columns(range(len(opened.header.labels)))


def refusal(path: Path) -> str:
    with pytest.raises(InputError) as caught:
        read_all(path)
    line = str(caught.value)
    assert "\n" not in line
    return line


def test_only_regular_files_are_read(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe.toml"
    os.mkfifo(pipe)
    for path in (pipe, Path("/dev/zero")):
        with pytest.raises(OSError, match="is not a regular file"):
            read_input(path)
    with pytest.raises(IsADirectoryError):
        read_input(tmp_path)
    (tmp_path / "large").write_bytes(b"0" * 11)
    with pytest.raises(OSError, match="is larger than"):
        read_input(tmp_path / "large", 10)


@pytest.mark.parametrize("case", ["experiment", "effect", "parameters", "diff", "part", "table", "rung"])
def test_no_command_waits_for_a_pipe(tmp_path: Path, monkeypatch, command, case: str) -> None:
    """A pipe that nobody writes to, wherever a command reads a file of the user's."""
    monkeypatch.chdir(tmp_path)
    os.mkfifo("pipe")
    os.mkfifo("pipe.py")
    words = {
        "experiment": "compare rig",
        "effect": "compare rig",
        "parameters": "params --params pipe",
        "diff": "diff stage.toml pipe",
        "part": "drawings --part pipe.py --trust",
        "table": "params",
        "rung": "ladder rig",
    }[case].split()
    table = '[hardware]\nscrews = "pipe"\n' if case == "table" else ""
    Path("stage.toml").write_text(f'extends = "thesis"\n{table}')
    Path("rig").mkdir()
    if case == "experiment":
        os.mkfifo("rig/experiment.toml")
    else:
        os.mkfifo("rig/own.py")
        custom = "" if case == "rung" else 'custom = ["own.py"]\n'
        Path("rig/ladder").mkdir()
        os.mkfifo("rig/ladder/000.json")
        os.mkfifo("rig/ladder/pending.json")
        state(Path("rig"), custom + record_text())
        Path("rig/fit.csv").write_text("time [s],velocity [m/s],friction_force [N]\n0,0,0\n1,1,1\n")
    expected = "has no experiment.toml" if case == "experiment" else "is not a regular file"
    assert expected in command.refused(*words)


class TestHdf5:
    """Data sets that are not in the file itself, which may be any file of the user's, or a pipe."""

    h5py = pytest.importorskip("h5py")

    def file(self, folder: Path):
        return self.h5py.File(folder / "a.h5", "w")

    @pytest.mark.parametrize("name", ["x", "group.x", "virtual", "large"])
    def test_what_the_file_does_not_hold_is_refused(self, tmp_path: Path, name: str) -> None:
        (tmp_path / "secret.bin").write_bytes(bytes(800))
        os.mkfifo(tmp_path / "pipe")
        layout = self.h5py.VirtualLayout(shape=(3,), dtype="f8")
        layout[:] = self.h5py.VirtualSource("other.h5", "x", shape=(3,))
        with self.file(tmp_path) as file:
            file["time"] = [0.0, 1.0, 2.0]
            if name == "x":
                file.create_dataset("x", shape=(100,), dtype="f8", external=[(str(tmp_path / "secret.bin"), 0, 800)])
            elif name == "group.x":
                file["group/x"] = self.h5py.ExternalLink(str(tmp_path / "pipe"), "/x")
            elif name == "virtual":
                file.create_virtual_dataset("virtual", layout)
            else:
                file.create_dataset("large", shape=(64, 10**7), dtype="u1", chunks=True)
        words = "takes more than 4 GB of memory" if name == "large" else f"'{name}' is stored in another file"
        assert words in refusal(tmp_path / "a.h5")

    def test_links_within_the_file_are_followed_once(self, tmp_path: Path) -> None:
        with self.file(tmp_path) as file:
            file["group/x"] = [0.0, 1.0, 2.0]
            file["group/again"] = file["group"]
            file["nowhere"] = self.h5py.SoftLink("/none")
        assert open_record_file(tmp_path / "a.h5", "a.h5").header.labels == ("x",)

    def test_a_channel_of_a_file_of_5_gigabytes_is_read_by_itself(self, tmp_path: Path) -> None:
        """The file is sparse: a camera of 5 GB beside two channels."""
        with self.file(tmp_path) as file:
            file["time"], file["x"] = np.arange(1000) * 1e-3, np.ones(1000)
            file.create_dataset("camera", shape=(1000, 1000, 625), dtype="f8")[-1, -1, -1] = 1.0
        if (tmp_path / "a.h5").stat().st_blocks * 512 > 10**8:
            pytest.skip("this file system has no sparse files")
        table = open_record_file(tmp_path / "a.h5", "a.h5")
        found = table.columns([table.header.labels.index(label) for label in ("time", "x")])
        assert [column.values[-1] for column in found] == [0.999, 1.0]


def test_a_reader_that_waits_is_ended(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "a.npz").write_bytes(b"PK")
    monkeypatch.setattr(isolated, "WAITING", 0.01)
    assert "is not read within" in refusal(tmp_path / "a.npz")


def test_a_small_file_of_too_many_rows_is_refused_while_it_is_read(tmp_path, monkeypatch) -> None:
    rows = b"time [s],x [m]\n" + b"1,1\n" * 60_000
    for name, content in (("a.csv", rows), ("a.csv.gz", gzip.compress(rows)), ("b.csv", rows.replace(b"\n", b"\r"))):
        (tmp_path / name).write_bytes(content)
        monkeypatch.setattr(limited_text, "MOST_LINES", 1_000_000)
        read_all(tmp_path / name)
        monkeypatch.setattr(limited_text, "MOST_LINES", 50_000)
        with monkeypatch.context() as nothing:
            # A thread that reads ahead would wait for ever for a stream that refuses.
            nothing.setattr("pyarrow.csv.read_csv", None)
            assert f"has more than {MOST_ROWS} rows" in refusal(tmp_path / name)


def test_a_row_too_long_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "first.csv.gz").write_bytes(gzip.compress(b"1," * 400_000))
    assert "its first row is longer than 256 kB" in refusal(tmp_path / "first.csv.gz")
    wide = b"t [s],x [m]\n" + b"%d,1\n" * 200 % tuple(range(200)) + b"1," * 20_000 + b"\n"
    (tmp_path / "wide.csv").write_bytes(wide + b"200,x\n")
    assert "row 202: has more than 10000 cells" in refusal(tmp_path / "wide.csv")
    monkeypatch.setattr(limited_text, "LONGEST_ROW", 5_000_000)
    (tmp_path / "later.csv.gz").write_bytes(gzip.compress(b"t [s],x [m]\n0,1\n1,1\n" + b"1," * 8_000_000))
    assert "near row 4: a row is longer than 5 MB" in refusal(tmp_path / "later.csv.gz")


@pytest.mark.parametrize(
    "encoding",
    ["idna", "rot13", "undefined", "base64", "no-such", "unicode_escape", "raw_unicode_escape", "utf-7", "punycode"],
)
def test_encodings_that_are_no_text_encodings_are_refused(tmp_path: Path, command, encoding: str) -> None:
    (tmp_path / "fit.csv").write_text("time [s],x [m]\n0,0\n1,1\n")
    state(tmp_path, f'[format]\nencoding = "{encoding}"\n{record_text()}')
    assert "is no text encoding" in command.refused("compare", tmp_path)
