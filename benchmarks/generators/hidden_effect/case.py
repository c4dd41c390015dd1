"""One experiment with something hidden in it: planned, simulated, brought to its size, spoilt, written, and its key."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd

from .drawn import Plan, draw_rig
from .hidden import HIDDEN
from .logged import experiment_text, known_numbers, logged_columns
from .nuisance import as_logged, draw_units
from .running import REACH, draw_record, run_axis, settings
from .size import LEVELS, acceptable, to_size, visible_beside, visible_of

LEAST_BESIDE = 3.0
"""Noise deviations that each of two effects must still be worth once the other is known."""


@dataclass(frozen=True)
class Case:
    """A finished experiment: two tables, the text of experiment.toml, and the entry of the key."""

    fit: pd.DataFrame
    validate: pd.DataFrame
    toml: str
    key: dict

    def write(self, folder: Path) -> None:
        """experiment.toml, fit.csv and validate.csv in `folder`, which is made."""
        folder.mkdir(parents=True, exist_ok=True)
        self.fit.to_csv(folder / "fit.csv", index=False, float_format="%.9g")
        self.validate.to_csv(folder / "validate.csv", index=False, float_format="%.9g")
        (folder / "experiment.toml").write_text(self.toml, encoding="utf-8")


def make_case(plan: Plan, rng: np.random.Generator, tries: int = 12) -> Case:
    """Make one case; the same plan and generator state give the same case.

    Raises ValueError when the effect cannot be brought to the level on this rig in `tries` draws.
    """
    hidden = [HIDDEN[name] for name in plan.effects]
    for _ in range(tries):
        rig = draw_rig(rng, plan)
        fit, validate = draw_record(rng, rig), draw_record(rng, rig)
        texture_seed = int(rng.integers(2**31))
        draws = [entry.draw(rng, rig.numbers) for entry in hidden]
        if plan.same_form:
            draws = [replace(d, fixed={k: v for k, v in d.fixed.items() if k != "stribeck_lorentzian"}) for d in draws]
        strengths: list[float] = []
        for draw in draws:
            strength, _ = to_size(rng, rig, fit, draw, plan.level, texture_seed)
            strengths.append(strength)
        if not all(strengths):
            continue
        beside = visible_beside(rig, fit, hidden, draws, strengths, texture_seed) if len(hidden) == 2 else []
        if all(left >= LEAST_BESIDE for left in beside):
            break
    else:
        raise ValueError(f"{'+'.join(plan.effects)} cannot be made {plan.level} on {plan.rig}")
    set_ = settings(draws, strengths)
    if plan.rig == "force-drive" and any(
        np.abs(run_axis(rig, record, set_, texture_seed).position).max() > 1.5 * REACH for record in (fit, validate)
    ):
        raise ValueError(f"{'+'.join(plan.effects)} drives the axis out of its travel")
    visible, also = visible_of(rig, fit, set_, texture_seed)
    tables = []
    units: dict[str, tuple[str, float]] | None = None
    noises: dict[str, tuple[float, str]] = {}
    for record in (fit, validate):
        columns, measured, noises = logged_columns(rng, rig, record, set_, texture_seed)
        if units is None:
            units = draw_units(rng, {name: unit for name, (unit, _) in columns.items()}, rig.how)
        tables.append(as_logged(rng, columns, measured, rig.how, units))
    size = plan.level
    if len(hidden) == 1:
        size = next((name for name, (low, _) in LEVELS.items() if visible >= low), "faint")
    where = sorted({name for entry in hidden for name in entry.where})
    key = {
        "rig": plan.rig,
        "base": list(rig.base),
        "effect": "+".join(plan.effects) or "none",
        "accept": acceptable(rig, hidden, visible, also),
        "size": size,
        "visible": visible,
        "strength": strengths[0] if len(strengths) == 1 else strengths,
        "nuisance": plan.nuisance,
        "hard": plan.hard,
        "rotary": rig.radius is not None,
        "idle": list(rig.channels),
        "nuisances": rig.how.__dict__ | {},
        "truth": {**rig.axis._replace(**set_.law)._asdict()}
        if plan.rig != "actuator-tip"
        else {**rig.tip._replace(**set_.law)._asdict()},
        "sensor": set_.sensor._asdict(),
        "rivals_left": {name: round(left, 3) for name, left in also.items()},
    }
    if where:
        key["where"] = where
    if beside:
        key["beside"] = beside
    return Case(tables[0], tables[1], experiment_text(rig, known_numbers(rng, rig), noises), key)
