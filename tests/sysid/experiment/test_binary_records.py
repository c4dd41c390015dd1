"""MAT and Parquet files that crash their reader, or take more memory than they should, end in one line."""

import os
import resource
import sys
from contextlib import suppress
from pathlib import Path

import numpy as np
import pyarrow
import pytest
from pyarrow import parquet
from scipy.io import savemat

from stagecad.parameters.errors import InputError
from sysid.experiment.readers import base, isolated
from sysid.experiment.readers.open import open_record_file

T = np.arange(200) * 0.01


def _mat(path: Path, **given: np.ndarray) -> bytes:
    savemat(path, given, do_compression=True)
    return path.read_bytes()


def _parquet(path: Path, **given: np.ndarray) -> bytes:
    parquet.write_table(pyarrow.table(given), path)
    return path.read_bytes()


def test_a_reader_that_crashes_is_a_damaged_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    _mat(tmp_path / "fit.mat", time=T)
    abort = f"import os, signal; os.kill(os.getpid(), signal.SIGSEGV); from {isolated.__name__} import answer"
    real = isolated.subprocess.run
    monkeypatch.setattr(
        isolated.subprocess, "run", lambda command, **given: real([sys.executable, "-c", abort], **given)
    )
    with pytest.raises(InputError, match=r"fit\.mat: is not a MAT file up to version 7\.3, or is damaged"):
        open_record_file(tmp_path / "fit.mat", "fit.mat")


def test_a_small_file_of_many_gigabytes_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    data = _mat(tmp_path / "fit.mat", time=T, zeros=np.zeros(30_000_000))
    assert len(data) < 400_000
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    code = f"import {isolated.__name__}; {isolated.__name__}.MEMORY = 500 * 1024**2; {isolated.__name__}.answer()"
    real = isolated.subprocess.run
    monkeypatch.setattr(
        isolated.subprocess, "run", lambda command, **given: real([*command[:3], code, *command[4:]], **given)
    )
    with pytest.raises(InputError, match=r"fit\.mat: takes more than 0\.\d+ GB of memory"):
        open_record_file(tmp_path / "fit.mat", "fit.mat")
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss < before + 100_000


def test_only_the_columns_asked_for_are_read(tmp_path: Path) -> None:
    _parquet(tmp_path / "fit.parquet", time=T, text=np.array(["a" * 100] * T.size), force=-T)
    opened = open_record_file(tmp_path / "fit.parquet", "fit.parquet")
    assert opened.header.labels == ("time", "text", "force")
    found = [column.values for column in opened.columns([2, 0, 0])]
    assert np.array_equal(found, [-T, T, T])
    with pytest.raises(InputError, match="column 'text': holds string, numbers are required"):
        opened.columns([1])


def test_columns_of_one_name_are_told_apart(tmp_path: Path) -> None:
    parquet.write_table(pyarrow.Table.from_arrays([pyarrow.array(T), pyarrow.array(-T)], ["a", "a"]), tmp_path / "f.pq")
    found = open_record_file(tmp_path / "f.pq", "f.pq").columns([1, 0])
    assert np.array_equal([column.values for column in found], [-T, T])


@pytest.mark.parametrize("kind", ["mat", "parquet"])
def test_damaged_bytes_never_end_in_a_traceback(tmp_path: Path, kind: str) -> None:
    path = tmp_path / f"fit.{kind}"
    data = {"mat": _mat, "parquet": _parquet}[kind](path, time=T, position=np.sin(T), force=np.cos(T))
    random = np.random.default_rng(5)
    for _ in range(6):
        damaged = bytearray(data)
        for place in random.integers(0, len(data), 4):
            damaged[place] = random.integers(256)
        path.write_bytes(damaged)
        # Any other exception fails the test.
        with suppress(InputError):
            opened = open_record_file(path, path.name)
            opened.columns(range(len(opened.header.labels)))


def test_the_reader_imports_nothing_from_the_working_folder(tmp_path: Path) -> None:
    _mat(tmp_path / "fit.mat", time=T)
    for module in ("json", "numpy", "scipy", "sysid", "signal"):
        (tmp_path / f"{module}.py").write_text("open('flag', 'w').close()\n")
    code = (
        "from pathlib import Path; from sysid.experiment.readers.open import open_record_file;"
        "print(open_record_file(Path('fit.mat'), 'fit.mat').header.labels)"
    )
    found = isolated.subprocess.run(
        [sys.executable, "-P", "-c", code],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": os.getcwd()},
        capture_output=True,
        text=True,
    )
    assert found.stdout == "('time',)\n", found.stderr
    assert not (tmp_path / "flag").exists()


def test_what_is_no_plain_or_too_large_a_file_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "fit.csv").symlink_to("/dev/zero")
    with pytest.raises(InputError, match=r"fit\.csv: is not a regular file"):
        open_record_file(tmp_path / "fit.csv", "fit.csv")
    (tmp_path / "wide.csv").write_text(",".join(f"c{n} [m]" for n in range(base.MOST_COLUMNS + 1)) + "\n")
    with pytest.raises(InputError, match=r"wide\.csv: has 10001 columns; at most 10000 are read"):
        open_record_file(tmp_path / "wide.csv", "wide.csv")
    monkeypatch.setattr(base, "MOST_BYTES", 100)
    with pytest.raises(InputError, match=r"wide\.csv: is larger than"):
        open_record_file(tmp_path / "wide.csv", "wide.csv")
