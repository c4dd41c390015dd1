"""Rows that are missing: what bridges them must not shake what remembers."""

from pathlib import Path

import numpy as np
import pytest

from sim.numerics.record_operators import resonance
from sysid.prediction.force_balance.record import ForceBalanceRecord
from sysid.prediction.problem import load_problem

STEP = 1e-3
MASS = 1.5
TIME = STEP * np.arange(6000)
GAP = slice(2950, 3080)


def _balance(folder: Path, gap: slice) -> ForceBalanceRecord:
    """A mass pushed to and fro by a sine, its position noisy by a tenth of a micrometre."""
    folder.mkdir()
    omega = 2 * np.pi * 2.0
    force = 3.0 * np.sin(omega * TIME)
    position = -3.0 / (MASS * omega**2) * np.sin(omega * TIME)
    position = position + 1e-7 * np.random.default_rng(8).standard_normal(TIME.size)
    position[gap] = np.nan
    table = np.column_stack([TIME, force, position])
    np.savetxt(folder / "fit.csv", table, "%.10g", ",", header="time [s],drive_force [N],position [m]", comments="")
    (folder / "experiment.toml").write_text(
        f'schema = 1\n[rig]\nkind = "force-drive"\n[rig.known]\nmass = "{MASS} kg"\n[model]\neffects = ["viscous"]\n'
        '[[record]]\nfile = "fit.csv"\nrole = "fit"\n[noise]\nposition = "0.1 um"\ndrive_force = "1 mN"\n'
    )
    balance = load_problem(folder).fit_records[0]
    assert isinstance(balance, ForceBalanceRecord)
    return balance


def test_a_mode_does_not_ring_with_the_bridge_over_a_gap(tmp_path: Path) -> None:
    whole, gap = (_balance(tmp_path / name, rows) for name, rows in (("whole", slice(0, 0)), ("gap", GAP)))
    rung = [resonance(np.ascontiguousarray(b.axis.acceleration), STEP, 38.0, 0.03) for b in (whole, gap)]
    after = slice(GAP.stop + 40, GAP.stop + 1000)
    own = np.std(rung[0] - whole.axis.acceleration)
    assert np.std((rung[1] - rung[0])[after]) < own
    # The line that bridges the position turns by kinks at the gap's ends, and those would have rung:
    time = whole.axis.time
    bridged = np.interp(time, *(np.delete(values, np.r_[GAP]) for values in (time, whole.axis.position)))
    kinked = resonance(np.gradient(np.gradient(bridged, STEP), STEP), STEP, 38.0, 0.03)
    assert np.std((kinked - rung[0])[after]) > 5.0 * own
    assert gap.valid["drive_force"][after].any()
    assert not gap.valid["drive_force"][GAP].any()


def test_away_from_a_gap_nothing_changes(tmp_path: Path) -> None:
    whole, gap = (_balance(tmp_path / name, rows) for name, rows in (("whole", slice(0, 0)), ("gap", GAP)))
    far = np.r_[200 : GAP.start - 100, GAP.stop + 100 : whole.size - 200]
    assert gap.axis.acceleration[far] == pytest.approx(whole.axis.acceleration[far], abs=1e-9)
