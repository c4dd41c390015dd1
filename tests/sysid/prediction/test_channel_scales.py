"""The scale of a channel as a parameter of the fit: found where a known mass determines it, as stated otherwise."""

from pathlib import Path

import numpy as np
import pytest

from stagecad.parameters.errors import InputError
from sysid.compare import compare
from sysid.experiment.readers.memory import MemoryTable
from sysid.ladder import add_effects
from sysid.report import comparison_json
from sysid.simulate_experiment import simulate_experiment

SCALE, INERTIA = 0.12, 0.02
"""Torque constant, N*m/A, and inertia, kg*m^2, of the rig."""


def _write(folder: Path, scale: str, known: str = f'mass = "{INERTIA} kg*m^2"', channel: str = "drive_force") -> Path:
    """Current of a motor that turns an inertia against Coulomb and viscous friction, by Newton's law."""
    random = np.random.default_rng(6)
    for name, phase in (("fit", 0.0), ("validate", 1.3)):
        t = np.arange(4000) * 1e-3
        angle = 0.5 * np.sin(9.0 * t + phase) + 0.1 * np.sin(23.0 * t)
        rate = 4.5 * np.cos(9.0 * t + phase) + 2.3 * np.cos(23.0 * t)
        torque = INERTIA * (-40.5 * np.sin(9.0 * t + phase) - 52.9 * np.sin(23.0 * t))
        torque += 0.15 * np.tanh(rate / 1e-4) + 0.01 * rate
        log = np.column_stack([t, angle, torque / SCALE + 0.01 * random.normal(size=t.size)])
        np.savetxt(folder / f"{name}.csv", log, "%.9g", ",", header="time [s],position [rad],current [A]", comments="")
    records = "".join(f'[[record]]\nfile = "{n}.csv"\nrole = "{n}"\n' for n in ("fit", "validate"))
    (folder / "experiment.toml").write_text(
        f'schema = 1\n[rig]\nkind = "force-drive"\ninput_hold = "linear"\n[rig.known]\n{known}\n'
        '[model]\neffects = ["coulomb", "viscous"]\n'
        f'[channels]\n{channel} = {{column = "current", scale = "{scale}"}}\n'
        f'{records}[noise]\nposition = "1e-7 rad"\n'
    )
    return folder


@pytest.mark.parametrize("scale", ["0.1 +- 0.03 N*m/A", "fit N*m/A"])
def test_a_known_inertia_determines_the_scale(tmp_path: Path, scale: str) -> None:
    found = compare(_write(tmp_path, scale))
    document = comparison_json(found)
    nominal = 1.0 if scale.startswith("fit") else 0.1
    ratio = document["parameters"]["rig.scale_drive_force"]
    assert ratio["unit"] == "1" and ratio["value"] * nominal == pytest.approx(SCALE, rel=0.01)
    assert ratio["low"] * nominal < SCALE < ratio["high"] * nominal
    assert document["parameters"]["coulomb.force"]["value"] == pytest.approx(0.15, rel=0.02)
    assert document["parameters"]["viscous.coefficient"]["value"] == pytest.approx(0.01, rel=0.03)
    assert any("rig.scale_drive_force is its ratio to" in note for note in found.problem.notes)


def test_without_a_known_mass_the_stated_uncertainty_is_what_is_known(tmp_path: Path) -> None:
    document = comparison_json(compare(_write(tmp_path, "0.12 +- 0.006 N*m/A", known="")))
    ratio = document["parameters"]["rig.scale_drive_force"]
    assert ratio["value"] == pytest.approx(1.0, abs=0.05)
    assert ratio["std"] == pytest.approx(0.05, rel=0.2)
    # What is proportional to the scale carries its uncertainty of five percent.
    force = document["parameters"]["coulomb.force"]
    assert force["std"] / force["value"] == pytest.approx(0.05, rel=0.3)


def test_a_scale_stays_a_parameter_when_effects_are_added(tmp_path: Path) -> None:
    folder = _write(tmp_path, "0.1 +- 0.03 N*m/A")
    step = add_effects(folder, ["constant_bias"])
    assert step.base.fitted.model.values["rig.scale_drive_force"] == pytest.approx(1.2, rel=0.01)
    assert 'scale = "0.1 +- 0.03 N*m/A"' in (folder / "experiment.toml").read_text()


def test_simulations_use_the_fitted_scale(tmp_path: Path) -> None:
    """As if the true scale had been stated: the free run, the horizons, and the records that are simulated."""
    runs, simulated = [], []
    for scale in ("0.1 +- 0.03 N*m/A", f"{SCALE} N*m/A"):
        folder = _write(tmp_path, scale)
        document = comparison_json(compare(folder))
        runs.append([document[name] for name in ("free_run", "horizon")])
        simulated.append(simulate_experiment(folder))
    stated = runs[1][0]["validate"]["position"]
    assert runs[0][0]["validate"]["position"]["rms"]["value"] == pytest.approx(stated["rms"]["value"], rel=0.1)
    horizons = [found[1]["0.1 s"]["validate"]["position"]["rms"]["value"] for found in runs]
    assert horizons[0] == pytest.approx(horizons[1], rel=0.1)
    current = np.genfromtxt(tmp_path / "fit.csv", delimiter=",", skip_header=1)[:, 2]
    fitted, true = (found.records[0].channels for found in simulated)
    assert "rig.scale_drive_force" in simulated[0].fitted
    np.testing.assert_allclose(fitted["drive_force"], SCALE * current, rtol=0.01)
    travel = np.ptp(true["position"])
    assert np.abs(fitted["position"] - true["position"]).max() < 0.02 * travel
    # A motion of another file is in its own units.
    motion = {"time [s]": np.arange(400) * 1e-3, "drive_force [N*m]": np.full(400, 0.5)}
    other = simulate_experiment(folder_of(tmp_path), motion=MemoryTable("motion", motion))
    assert other.records[0].channels["drive_force"] == pytest.approx(0.5)


def folder_of(folder: Path) -> Path:
    return _write(folder, "0.1 +- 0.03 N*m/A")


@pytest.mark.parametrize(
    ("scale", "channel", "message"),
    [
        ("fit N*m/V", "drive_force", r"times scale = 'fit N\*m/V' is no 'N'"),
        ("fit N/X", "drive_force", r"channels\.drive_force\.scale: .*X"),
        ("fit N/A", "normal_load", r"channels\.normal_load\.scale = 'fit N/A': it can be fitted of drive_force"),
    ],
)
def test_a_scale_that_cannot_be_fitted_is_refused_in_one_line(tmp_path, scale: str, channel: str, message: str) -> None:
    folder = _write(tmp_path, scale, channel=channel)
    if channel != "drive_force":
        text = (folder / "experiment.toml").read_text().replace("[[record]]", DRIVE, 1)
        (folder / "experiment.toml").write_text(text)
    with pytest.raises(InputError, match=message) as caught:
        compare(folder)
    assert "\n" not in str(caught.value)


DRIVE = 'drive_force = {column = "current", scale = "0.12 N*m/A"}\n[[record]]'
