"""Python files of an experiment run after a consent for their content, and only from its folder."""

import hashlib
import re
from pathlib import Path

import numpy as np
import pytest

from stagecad.parameters.errors import InputError
from sysid.experiment.experiment import load_experiment, trust_experiment
from sysid.prediction.problem import load_problem
from workbench.cli import run

CODE = """from pathlib import Path
Path(r"{flag}").write_text("it ran")
from sim import Effect, Parameter

def force(axis, p):
    return p.strength * axis.position**3

effect = Effect("bellows", "stiffens", force=force,
                parameters=[Parameter("strength", "N/m^3", 1.0, 0.0, 1e9, "stiffening", "assumed")])
"""


@pytest.fixture
def rig(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    folder = tmp_path / "rig"
    folder.mkdir()
    t = np.arange(400) * 0.01
    x = 0.01 * np.sin(3.0 * t)
    rows = (f"{a:.6g},{b:.6g},{np.sign(np.cos(3.0 * a)):.6g}" for a, b in zip(t, x, strict=True))
    (folder / "fit.csv").write_text("time [s],position [m],friction_force [N]\n" + "\n".join(rows) + "\n")
    (folder / "mine.py").write_text(CODE.format(flag=tmp_path / "flag"))
    named(folder, "mine.py")
    return folder


def named(folder: Path, custom: str) -> None:
    (folder / "experiment.toml").write_text(
        'schema = 1\n[rig]\nkind = "velocity-drive"\n[model]\neffects = ["coulomb"]\n'
        f'custom = ["{custom}"]\n[[record]]\nfile = "fit.csv"\nrole = "fit"\n'
    )


@pytest.mark.parametrize("command", ["compare", "diagnose", "suggest", "ladder", "simulate", "add"])
def test_no_command_runs_the_code_without_consent(
    rig: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], command: str
) -> None:
    words = [command, str(rig), *(["viscous"] if command == "add" else []), "--out", str(tmp_path / "out")]
    assert run(words) == 2
    said = capsys.readouterr().err
    assert re.fullmatch(r"stagecad: \S+mine\.py: is Python code, .* --trust .*\n", said)
    assert not (tmp_path / "flag").exists()


def test_a_consent_is_for_the_content_of_the_file(
    rig: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["ladder", str(rig), "--out", str(tmp_path / "out")]
    assert run([*words, "--trust"]) == 0
    assert f"trusted as it is now: {rig / 'mine.py'}" in capsys.readouterr().err
    assert (tmp_path / "flag").read_text() == "it ran"
    assert run(words) == 0
    trusted = tmp_path / "state" / "stagecad" / "trusted"
    assert [path.name for path in trusted.iterdir()] == [hashlib.sha256((rig / "mine.py").read_bytes()).hexdigest()]
    assert trusted.stat().st_mode & 0o777 == 0o700
    (rig / "mine.py").write_text((rig / "mine.py").read_text() + "# changed\n")
    (tmp_path / "flag").unlink()
    capsys.readouterr()
    assert run(words) == 2
    assert "mine.py: is Python code that has changed since you consented to it" in capsys.readouterr().err
    assert not (tmp_path / "flag").exists()


def test_a_file_changed_between_reading_and_fitting_does_not_run(rig: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import sysid.prediction.problem as module

    def changing(experiment: object) -> list[object]:
        (rig / "mine.py").write_text("raise RuntimeError('ran')")
        return records(experiment)

    records = module.load_records
    monkeypatch.setattr(module, "load_records", changing)
    trust_experiment(rig)
    with pytest.raises(InputError, match="is Python code"):
        load_problem(rig)


@pytest.mark.parametrize("way", ["above", "absolute", "link"])
def test_code_outside_the_folder_is_refused_whatever_the_consent(rig: Path, tmp_path: Path, way: str) -> None:
    other = tmp_path / "evil.py"
    (rig / "mine.py").rename(other)
    if way == "link":
        (rig / "mine.py").symlink_to(other)
    named(rig, {"above": "../evil.py", "absolute": str(other), "link": "mine.py"}[way])
    for function in (trust_experiment, load_experiment):
        with pytest.raises(InputError, match=r"model.custom: .* is outside the folder of the experiment"):
            function(rig)
    assert not (tmp_path / "flag").exists()


def test_simulated_records_take_a_copy_of_the_effect_with_them(rig: Path, tmp_path: Path) -> None:
    assert run(["simulate", str(rig), "--trust", "--out", str(tmp_path / "out")]) == 0
    made = tmp_path / "out" / "simulate" / "rig"
    assert (made / "mine.py").read_bytes() == (rig / "mine.py").read_bytes()
    assert load_experiment(made).custom == (made / "mine.py",)
