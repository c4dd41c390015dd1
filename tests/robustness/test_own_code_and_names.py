"""A user's own Python code and names: no end of the code passes as success, no name leads to another folder."""

from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stagecad import Experiment, InputError
from stagecad.parameters.dimension import Dimension
from stagecad.parameters.names import file_stem, identifier
from tests.experiments import replace_in, write_rig
from tests.robustness.test_written_files import content
from tests.sysid.slide import SIGN, slide

ENDS = {
    "sys.exit(0)": "SystemExit: 0",
    "sys.exit()": "SystemExit",
    "__import__('os')._exit(0)": "SystemExit: 0",
    "raise BaseException('own')": "BaseException: own",
    "raise GeneratorExit": "GeneratorExit",
    "1 / 0": "ZeroDivisionError: division by zero",
}
CHECK = """import sys
from designcalc.checks.check import Check, at_most
{top}
def check(r):
    {inside}
"""
HOSTILE = [
    "../UP", "/tmp/ABS", "a/b", "..", ".hidden", "", " ", "A", "\x1b[31m", "<b>", "=cmd", "x" * 300, "con:1", "a\\b",
]  # fmt: skip


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    from designcalc.checks import run

    work = tmp_path / "work"
    work.mkdir()
    monkeypatch.chdir(work)
    monkeypatch.setattr(run, "OWN", run.OWN)
    yield work
    run.OWN.clear()


@pytest.mark.parametrize("place", ["top", "inside"])
@pytest.mark.parametrize("code", ENDS)
def test_an_own_check_that_ends_the_program_is_an_error(folder: Path, command, place: str, code: str) -> None:
    line = _refused_check(command, **{"top": "pass", "inside": "pass", place: code})
    assert f"checks/a.py: line {3 if place == 'top' else 5}: {ENDS[code]}" in line.splitlines()[-1]


def _refused_check(command, top: str = "pass", inside: str = "pass") -> str:
    Path("stage.toml").write_text('extends = "thesis"\n')
    Path("checks").mkdir()
    Path("checks/a.py").write_text(CHECK.format(top=top, inside=inside))
    return command("check", "--trust", "--no-solids", status=2).err.strip()


def test_an_own_check_that_gives_no_check_is_an_error(folder: Path, command) -> None:
    assert "checks/a.py: check(r) gives int; a Check is required" in _refused_check(command, inside="return 5")


@pytest.mark.parametrize("code", ENDS)
def test_an_own_part_that_ends_the_program_is_an_error(folder: Path, command, code: str) -> None:
    Path("own.py").write_text(f"import sys\n{code}\n")
    assert f"own.py: line 2: {ENDS[code]}" in command("drawings", "--part", "own.py", "--trust", status=2).err


@pytest.mark.parametrize("code", ["sys.exit(0)", "raise BaseException('own')"])
@pytest.mark.parametrize("place", ["top", "law"])
def test_an_own_effect_that_ends_the_program_is_an_error(folder: Path, command, code: str, place: str) -> None:
    words = {"top": "pass", "law": "pass", place: code}
    Path("own.py").write_text(
        "import sys\nfrom sim import Effect, Parameter\n{top}\ndef law(axis, p):\n    {law}\n    return axis.position\n"
        "effect = Effect('own_spring', 'A spring', equation='F = k x', shows='A slope.', force=law, parameters=["
        "Parameter('k', 'N/m', 1.0, 0.0, 9.0, 'stiffness', 'assumed: small')])\n".format(**words)
    )
    one = np.array([0.0, 1.0])
    columns = {"time": one, "position": one, "velocity": one, "friction_force": one}
    write_rig(Path(), "velocity-drive", {"fit": columns}, ["own_spring"])
    replace_in(Path("experiment.toml"), '["own_spring"]', '["own_spring"]\ncustom = ["own.py"]')
    err = command("compare", ".", "--trust", status=2).err
    assert "own.py" in err and ("SystemExit: 0" in err or "BaseException: own" in err)


DIMENSIONS = [
    f"[Dimension('a', {kind}, 1.0, 'box.length', ((0, 0, 0), (1, 0, 0)), (1, 0, 0){field})]"
    for kind, field in (("''", ""), *(("'linear'", f", {one}") for one in ("note=5", "view='up'", "table='up'")))
]
REQUIREMENTS = [
    "[DatumFeature('A', ((0, 0, 0),), (0, 0, 1), 'up')]",
    "[SurfaceTexture('s', 0.8, 'a.b', ((0, 0, 0),), (0, 0, 1), 'up')]",
    "[GeometricTolerance('t', 'evenness', 0.01, 'a.b', ((0, 0, 0),), (0, 0, 1), 'top')]",
]
WRONG = {
    "material": ("[]", "5", "design", "None", "'no-such'"),
    "datums": ("None", "5", "[]", "{'a': 1}", "design"),
    "dimensions": ("None", "5", "'x'", "[None]", "(one for one in (1,))", "design", *DIMENSIONS),
    "requirements": ("None", "5", "'x'", "[None]", "float('nan')", *REQUIREMENTS),
    "notes": ("None", "5", "[1]"),
    "build": ("5()", "None", "5", "'x'", "lambda: 1"),
}
"""What a function of an own part must not return."""
STATED = [
    "NAME = 5", "PARAMETERS = 5", "VIEWS = 'top'", "VIEWS = ('x',)", "VIEWS = ('section',)", "VIEW = ('top',)",
    "SYMMETRIC = 'yes'", "TURNED = 0", "NOTES = (1,)", "TREATMENT = None", "TURNED = 'x'", "build = 5",
]  # fmt: skip


@pytest.mark.parametrize(
    "line", [*STATED, *(f"def {word}(design): return {one}" for word, wrong in WRONG.items() for one in wrong)]
)
def test_an_own_part_of_other_types_than_the_interface_says_is_an_error(folder: Path, command, line: str) -> None:
    command("new", "part", "box")
    Path("box.py").write_text(Path("box.py").read_text() + f"\nfrom {Dimension.__module__} import *\n{line}\n")
    said = command("drawings", "--part", "box.py", "--trust", status=2).err.strip().splitlines()
    assert "box.py: " in said[-1], said


@pytest.mark.parametrize("name", HOSTILE)
def test_a_key_of_machine_parts_is_a_name(folder: Path, command, name: str) -> None:
    key = '"' + "".join(f"\\u{ord(sign):04x}" for sign in name) + '"'
    for table, other in ((key, "base"), ("base", key)):
        Path("stage.toml").write_text(
            f'extends = "thesis"\n[machine.parts]\n{table} = {{part = "magnet"}}\n[machine.mates]\n{other} = {{}}\n'
        )
        before = content(folder.parent)
        assert "a name has small letters, digits and _" in command("parts", "--out", "out", status=2).err
        assert content(folder.parent) == before


def log() -> dict[str, np.ndarray]:
    t = np.linspace(0.0, 10.0, 201)
    return {"time [s]": t, "position [mm]": np.sin(t), "friction_force [N]": np.sign(np.cos(t))}


@pytest.mark.parametrize("name", [*(name for name in HOSTILE if name not in ("A", "=cmd")), None, 5])
def test_a_record_that_leads_out_of_its_folder_is_refused(name) -> None:
    with pytest.raises(InputError, match="a file is named after it"):
        Experiment.from_dataframes({name: log()}, rig="velocity-drive", model=["coulomb"])


def test_a_saved_experiment_is_in_its_folder(tmp_path: Path) -> None:
    made = Experiment.from_dataframes({"Lauf 1 (ü) 50%.": log()}, rig="velocity-drive", model=["coulomb"])
    made.save(tmp_path / "rig")
    assert {path.parent for path in tmp_path.rglob("*") if path.is_file()} == {tmp_path / "rig"}


@settings(max_examples=500)
@given(st.text(max_size=40) | st.sampled_from(HOSTILE))
def test_no_name_leads_to_another_folder(name: str) -> None:
    """What the two functions accept stays one name in its folder."""
    for accepted in (identifier, file_stem):
        with suppress(InputError):
            accepted(name, "here")
            assert (Path("/out") / f"{name}.step").resolve().parent == Path("/out")
            assert (Path("/out") / name).resolve() == Path("/out") / name


def test_results_of_two_experiments_of_one_name_are_kept_apart(folder: Path, tmp_path: Path, command) -> None:
    for place in ("a/rig", "b/rig", "build/rig", "../x/rig", "../y/rig", "../x/rig"):
        slide(Path(place), 1.3 * SIGN, "coulomb", held_out=True)
        command("look", place)
    found = {str(path.parent) for path in Path("build").rglob("look.png")}
    assert found == {"build/a/rig", "build/b/rig", "build/rig", "build/rig_2", "build/rig_3"}
