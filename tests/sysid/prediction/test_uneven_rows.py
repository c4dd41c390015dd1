"""Rows at uneven times: beside a reversal, interpolated forces are mixtures of both directions."""

import numpy as np
import pandas as pd
import pytest

import stagecad

COULOMB, VISCOUS, NOISE, STEP = 2.2, 45.0, 0.02, 5e-3


def _record(seed: int) -> pd.DataFrame:
    """Coulomb and viscous friction of a slow multisine, sampled evenly, then interpolated to uneven times."""
    random = np.random.default_rng(seed)
    time = STEP * np.arange(4000)
    velocity = 0.02 * np.sin(2.1 * time + 0.3) * np.sin(0.37 * time)
    force = COULOMB * np.sign(velocity) + VISCOUS * velocity + NOISE * random.standard_normal(time.size)
    uneven = time[1:-1] + STEP * random.uniform(-0.15, 0.15, time.size - 2)
    columns = {"velocity [m/s]": velocity, "friction_force [N]": force}
    return pd.DataFrame({"time [s]": uneven, **{name: np.interp(uneven, time, y) for name, y in columns.items()}})


def test_only_rows_that_are_mixtures_themselves_differ_from_the_law() -> None:
    """One row beside a reversal may be interpolated by the logger; resampling makes no further mixtures of it."""
    experiment = stagecad.Experiment.from_dataframes(
        {"fit": _record(1), "validate": _record(2)},
        rig="velocity-drive",
        model=["coulomb", "viscous"],
        noise={"friction_force": "0.02 N"},
        validate=["validate"],
    )
    residuals = stagecad.compare(experiment).residuals.loc["validate"].to_numpy()
    reversals = int(np.sum(np.diff(np.sign(_record(2)["velocity [m/s]"])) != 0.0))
    assert reversals > 10
    assert np.sum(np.abs(residuals) > 10.0 * NOISE) <= reversals


def _turning(seed: int, even: bool) -> pd.DataFrame:
    """Coulomb and viscous friction along an exact position, which turns between the rows."""
    random = np.random.default_rng(seed)
    time = STEP * np.arange(4000)
    if not even:
        time = time + STEP * random.uniform(-0.3, 0.3, time.size)
    position = 0.004 * np.sin(2.3 * time + seed)
    velocity = 0.004 * 2.3 * np.cos(2.3 * time + seed)
    force = COULOMB * np.sign(velocity) + VISCOUS * velocity + NOISE * random.standard_normal(time.size)
    return pd.DataFrame({"time [s]": time, "position [m]": position, "friction_force [N]": force})


@pytest.mark.parametrize("even", [True, False])
def test_direction_at_a_row_after_a_turning_point_between_two_rows(even: bool) -> None:
    """The difference to the row before has the old sign at half of the reversals; the velocity at the row has not."""
    experiment = stagecad.Experiment.from_dataframes(
        {"fit": _turning(1, even), "validate": _turning(2, even)},
        rig="velocity-drive",
        model=["coulomb", "viscous"],
        noise={"friction_force": "0.02 N"},
        validate=["validate"],
    )
    residuals = stagecad.compare(experiment).residuals.loc["validate"].to_numpy()
    assert np.sum(np.abs(residuals) > 10.0 * NOISE) == 0
