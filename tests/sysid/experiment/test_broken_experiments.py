"""Each way a file can be wrong gives one line: file, key or row, what is wrong, what would be right."""

import tomllib
from pathlib import Path

import pytest
from scipy.io import savemat

from stagecad.parameters.errors import InputError
from sysid.experiment.experiment import load_experiment, trust_experiment
from sysid.experiment.record import load_records
from tests.refusals import refused

CASES = tomllib.loads((Path(__file__).parent / "broken" / "cases.toml").read_text(encoding="utf-8"))

EXPERIMENT = """schema = 1

[rig]
kind = "spring-pull"

[rig.known]
mass = "1.79 kg"
pull_stiffness = "5752 N/m"

[model]
effects = ["coulomb"]

[[record]]
file = "fit.csv"
role = "fit"

[noise]
position = "2e-07 m"
"""
CSV = "time [s],pull_position [m],position [m],spring_force [N]\n" + "".join(
    f"{i / 100:g},{i / 1000:g},{i / 2000:g},{i / 10:g}\n" for i in range(40)
)


def _write(folder: Path, case: dict) -> None:
    toml = case.get("prepend", "") + EXPERIMENT.replace(*case.get("toml", ("", "")))
    csv = case.get("whole_csv", CSV).replace(*case.get("csv", ("", "")))
    assert (toml, csv) != (EXPERIMENT, CSV) or set(case) & {"encoding", "delete"}, "the case changes nothing"
    (folder / "experiment.toml").write_text(toml, encoding="utf-8")
    (folder / case.get("rename", "fit.csv")).write_bytes(csv.encode(case.get("encoding", "utf-8")))
    if "custom" in case:
        (folder / "mine.py").write_text(case["custom"])
    if "delete" in case:
        (folder / case["delete"]).unlink()


@pytest.mark.parametrize("name", CASES)
def test_line(tmp_path, name):
    case = CASES[name]
    _write(tmp_path, case)
    if "custom" in case:
        trust_experiment(tmp_path)
    with pytest.raises(InputError) as caught:
        load_records(load_experiment(tmp_path))
    assert str(caught.value) == case["line"].replace("{dir}", str(tmp_path))


def test_there_are_many_broken_files_and_good_ones_are_good(tmp_path):
    assert len(CASES) >= 40
    (tmp_path / "experiment.toml").write_text(EXPERIMENT)
    (tmp_path / "fit.csv").write_text(CSV)
    assert len(load_records(load_experiment(tmp_path))) == 2
    (tmp_path / "rig_1").mkdir()
    refused(r"rig_2: no such folder or file; did you mean 'rig_1'\?", load_experiment, tmp_path / "rig_2")
    (tmp_path / "fit.csv").write_text(CSV)
    (tmp_path / "experiment.toml").write_text(EXPERIMENT.replace("fit.csv", "x" * 5000 + ".csv"))
    with pytest.raises(InputError) as caught:
        load_experiment(tmp_path)
    assert len(str(caught.value)) < 300 and "\n" not in str(caught.value)


@pytest.mark.parametrize("content", [b"PAR1", b"PAR1" + bytes(50) + b"PAR1"])
def test_a_damaged_parquet_file(tmp_path, content):
    (tmp_path / "experiment.toml").write_text(EXPERIMENT.replace("fit.csv", "fit.parquet"))
    (tmp_path / "fit.parquet").write_bytes(content)
    refused(r"fit\.parquet: is not a Parquet file", load_experiment, tmp_path)


def test_a_mat_file_without_vectors_or_of_another_version(tmp_path):
    (tmp_path / "experiment.toml").write_text(EXPERIMENT.replace("fit.csv", "fit.mat"))
    savemat(tmp_path / "fit.mat", {"comment": "nothing measured", "gain": 3.0})
    refused(r"fit\.mat: contains no vector of numbers", load_experiment, tmp_path)
    (tmp_path / "fit.mat").write_bytes(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(512))
    refused(r"version 7\.3", load_experiment, tmp_path)
