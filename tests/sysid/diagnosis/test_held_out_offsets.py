"""Held-out records of an actuator tip may have another offset than those of the fit; another gain is a misfit."""

from pathlib import Path

import numpy as np
import pytest

from sysid.diagnosis.candidate import Reference
from sysid.estimation.misfit import misfit
from sysid.estimation.reference_fit import fit_stated_model
from sysid.prediction.problem import load_problem

NOISE, GAIN, SPACING, HEIGHT = 1e-9, 1e-7, 0.046, 0.02


def _reference(folder: Path, offset: float, gain: float = GAIN) -> Reference:
    time = np.arange(4000) * 1e-3
    header = "time [s],voltage_1 [V],voltage_2 [V],tip_x [m],tip_y [m]"
    for k, (name, zero, slope) in enumerate((("fit", 0.0, GAIN), ("validate", offset, gain))):
        noise = NOISE * np.random.default_rng(k).standard_normal((2, time.size))
        first, second = 40.0 * np.sin(7.0 * time + k), 40.0 * np.sin(9.0 * time)
        tip_x = -HEIGHT * slope * (second - first) / SPACING + zero + noise[0]
        tip_y = 0.5 * slope * (first + second) + zero + noise[1]
        table = np.column_stack([time, first + 50.0, second + 50.0, tip_x, tip_y])
        np.savetxt(folder / f"{name}.csv", table, "%.12g", ",", header=header, comments="")
    (folder / "experiment.toml").write_text(
        'schema = 1\n[rig]\nkind = "actuator-tip"\n[rig.known]\npiezo_spacing = "46 mm"\ntip_height = "20 mm"\n'
        'bias_voltage = "50 V"\n[model]\neffects = []\n[[record]]\nfile = "fit.csv"\nrole = "fit"\n'
        '[[record]]\nfile = "validate.csv"\nrole = "validate"\n[noise]\ntip_x = "1e-9 m"\ntip_y = "1e-9 m"\n',
        encoding="utf-8",
    )
    problem = load_problem(folder)
    return Reference.of(problem, fit_stated_model(problem))


@pytest.mark.parametrize("offset", [0.0, 100.0 * NOISE])
def test_another_offset_of_held_out_records_is_no_misfit(tmp_path: Path, offset: float) -> None:
    reference = _reference(tmp_path, offset)
    assert reference.held_out.loss == pytest.approx(1.0, abs=0.05)
    found = misfit(reference.base.fitted.model, reference.problem.validate_records)
    assert [one.over_noise for one in found.values()] == pytest.approx([1.0, 1.0], abs=0.05)


def test_another_gain_of_held_out_records_is_a_misfit(tmp_path: Path) -> None:
    assert _reference(tmp_path, 0.0, 1.02 * GAIN).held_out.loss > 10.0
