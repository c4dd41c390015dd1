"""Rows that a log lost: a few here and there cost nothing but themselves, a long hole costs what leans on it."""

from pathlib import Path

import numpy as np

from sysid.prediction.force_balance.record import EDGE_WIDTHS, ForceBalanceRecord
from sysid.prediction.problem import load_problem
from sysid.signals.masks import longer_than

STEP, MASS, STIFFNESS = 1e-3, 1.2, 3000.0
TIME = np.arange(6000) * STEP
POSITION = 5e-3 * np.sin(2 * np.pi * 0.8 * TIME)
FORCE = -MASS * 5e-3 * (2 * np.pi * 0.8) ** 2 * np.sin(2 * np.pi * 0.8 * TIME) + 40.0 * np.gradient(POSITION, STEP)


def pulled(folder: Path, keep: np.ndarray) -> ForceBalanceRecord:
    """A mass on a spring without dry friction; the rows of `keep` (n,) are logged."""
    rng = np.random.default_rng(1)
    table = np.column_stack([
        TIME, POSITION + FORCE / STIFFNESS, POSITION + rng.normal(0, 2e-7, TIME.size),
        FORCE + rng.normal(0, 2e-3, TIME.size),
    ])  # fmt: skip
    header = "time [s],pull_position [m],position [m],spring_force [N]"
    np.savetxt(folder / "log.csv", table[keep], "%.10g", ",", header=header, comments="")
    (folder / "experiment.toml").write_text(
        f'schema = 1\n[rig]\nkind = "spring-pull"\n[rig.known]\nmass = "{MASS} kg"\n'
        f'pull_stiffness = "{STIFFNESS} N/m"\n[model]\neffects = ["viscous"]\n'
        '[[record]]\nfile = "log.csv"\nrole = "fit"\n[noise]\nposition = "2e-7 m"\nspring_force = "2 mN"\n'
    )
    record = load_problem(folder).fit_records[0]
    assert isinstance(record, ForceBalanceRecord)
    return record


def test_a_row_lost_here_and_there_costs_itself_only(tmp_path: Path) -> None:
    keep = np.random.default_rng(5).random(TIME.size) > 0.07
    keep[:2] = True
    record = pulled(tmp_path, keep)
    scored = record.valid["spring_force"]
    assert record.full_filter is not None
    edges = EDGE_WIDTHS * record.full_filter.width / STEP
    assert scored.sum() > 0.9 * scored.size - 2.0 * edges
    assert not scored[~keep[: scored.size]].any()
    # What is scored is as good as it was: the balance closes to the noise.
    assert record.acceleration is not None
    left = record.measured["spring_force"] - MASS * record.acceleration - 40.0 * record.axis.velocity
    assert np.std(left[scored]) < 1.3 * record.noise["spring_force"]


def test_a_long_hole_takes_its_neighbourhood_with_it(tmp_path: Path) -> None:
    keep = np.ones(TIME.size, dtype=bool)
    keep[3000:3100] = False
    record = pulled(tmp_path, keep)
    assert record.full_filter is not None
    reach = int(EDGE_WIDTHS * record.full_filter.width / STEP)
    scored = record.valid["spring_force"]
    assert not scored[3000 - reach + 2 : 3100 + reach - 2].any()
    assert scored[3100 + reach + 5 :].any()


def test_only_stretches_longer_than_asked_for_are_left() -> None:
    mask = np.array([1, 0, 1, 1, 0, 1, 1, 1, 0], dtype=bool)
    assert longer_than(mask, 2.0).tolist() == [False] * 5 + [True] * 3 + [False]
