"""Several channels, one of which no model explains: what the other one shows is found, with its values."""

from pathlib import Path

import numpy as np
import pytest

from sysid.compare import compare
from sysid.diagnose import diagnose
from tests.experiments import write_rig
from workbench.operations.measurement.statements import diagnosis_statement

SPACING, HEIGHT, BIAS, GAIN, NOISE = 0.046, 0.02, 75.0, 1.1e-7, 2e-9
JUMP = 100e-9
TIME = np.arange(3000) * 1e-3


def _play(voltage: np.ndarray, width: float) -> np.ndarray:
    """Output (n,) of a play operator of a half width, V."""
    out, last = np.empty_like(voltage), voltage[0]
    for k, value in enumerate(voltage):
        last = min(max(last, value - width), value + width)
        out[k] = last
    return out


def _experiment(folder: Path, hysteresis: float) -> Path:
    """Two records of a tip on two piezos; its holder jumps in the x direction at random times."""
    records = {}
    for seed, role in enumerate(("fit", "validate")):
        rng = np.random.default_rng(seed)
        phase = rng.uniform(0.0, 6.0, 4)
        rates = (3.1, 0.9), (2.3, 1.7)
        drives = [
            sum(a * np.sin(2 * np.pi * f * TIME + p) for a, f, p in zip((28.0, 18.0), rate, phase[2 * k : 2 * k + 2]))
            for k, rate in enumerate(rates)
        ]
        moved = [GAIN * (u + hysteresis * (_play(u, 8.0) + _play(u, 20.0) - 2.0 * u)) for u in drives]
        tip = [-HEIGHT / SPACING * (moved[1] - moved[0]), 0.5 * (moved[0] + moved[1])]
        tip[0] = tip[0] + JUMP * np.sign(np.sin(np.cumsum(rng.exponential(0.02, TIME.size)) * 2.0))
        rows = [TIME, *(BIAS + u for u in drives), *(y + NOISE * rng.normal(size=TIME.size) for y in tip)]
        names = "time [s]", "voltage_1 [V]", "voltage_2 [V]", "tip_x [m]", "tip_y [m]"
        records[role] = dict(zip(names, rows, strict=True))
    known = {"piezo_spacing": f"{SPACING} m", "tip_height": f"{HEIGHT} m", "bias_voltage": f"{BIAS} V"}
    noise = {"tip_x": f"{NOISE} m", "tip_y": f"{NOISE} m"}
    return write_rig(folder, "actuator-tip", records, known=known, noise=noise)


def test_effect_of_one_channel_is_established_beside_a_channel_that_nothing_explains(tmp_path: Path) -> None:
    found = diagnose(_experiment(tmp_path, 0.03))
    assert [(e.name, e.reason.endswith("on tip y")) for e in found.ledger.established] == [("piezo_hysteresis", True)]
    after = found.ledger.model.after_validate
    assert after["tip_y"].over_noise < min(1.5, 0.25 * found.before_validate["tip_y"].over_noise)
    assert after["tip_x"].over_noise > 10.0
    statement = diagnosis_statement(found)
    assert "the error of tip y on the held-out records falls" in statement
    assert "That of tip x," in statement


def test_channel_that_nothing_explains_leaves_the_values_to_the_other(tmp_path: Path) -> None:
    found = compare(_experiment(tmp_path, 0.0))
    fitted = found.base.fitted
    assert fitted.model.values["rig.gain"] == pytest.approx(GAIN, rel=3e-4)
    at = fitted.fit.keys.index("rig.gain")
    curvature = float(fitted.fit.weights @ fitted.fit.jacobian[:, at] ** 2)
    # The amplitude of the voltages is 24 V: of one channel alone 3000 rows of 2 nm give 2 nm / (24 V sqrt(1500)).
    assert curvature**-0.5 == pytest.approx(NOISE / (24.0 * np.sqrt(1500.0)), rel=0.5)
