"""Where fits of a friction drive begin: a coarse look over gain, press, stiffness, and what pads and contact hold.

Slips and lift-offs add up, so a fit that begins with the wrong side of either stays there. Some hundred rough models
are held against what the stage does from one stroke to the next, in which nothing adds up; the best few are fitted.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from sim.effects.catalogue import find
from sim.library.effect import Effect
from sysid.estimation.fit import root_mean_huber
from sysid.estimation.least_squares import least_squares
from sysid.prediction.friction_drive.friction import CONTACT
from sysid.prediction.friction_drive.parameters import CONTACT_STIFFNESS, contact_damping
from sysid.prediction.friction_drive.record import FrictionDriveRecord, leading_segment, predict_friction_drive
from sysid.prediction.model import Model, PreparedRecord, Scales, in_contact, with_effect

QUANTILES = (0.5, 0.75, 0.9)
"""Of the stage's motion over the tip's, which are tried as the gain: while the contact sticks, the one is the other."""
PRESSES = (0.25, 0.45, 0.65, 0.85, 1.1)
"""Over the largest fall of the tip; beyond one it never leaves the stage."""
WIND_UPS = (0.01, 0.03, 0.1)
"""Stretch of the contact when the pads slide, over the stroke."""
HOLDS = (1.05, 1.4, 2.0, 3.0, 5.0, 9.0)
"""What the contact holds over what the pads do."""
STIFFNESSES = (0.15, 0.25, 0.4, 0.5, 0.63, 0.8, 1.0, 1.25, 1.6, 2.0, 2.5, 4.0)
"""Over the contact's stiffness at the start, where it is fitted, forces going along: for the best rough models only."""
FINER = (0.7, 0.84, 1.2, 1.4)
"""Over each other number of the best rough models, one after the other."""
AMONTONS = 1.0
"""Sensitivity of what a contact holds to its load."""
LOAD_KEY = f"{CONTACT}load_dependent_friction.sensitivity"
ROWS = 6000
"""Of a record, at the most, that are looked at."""
SHORTEST = 12
"""Rows of a stroke, at the least."""
MOVES = 1e-4
"""Of the lean's range, in a row: less is a rest."""
UNLIKE = 0.2
"""Relative difference of some number from which two rough models are two starts."""

ALIKE = 1e-6
"""Relative difference of their errors up to which two rough models predict the same."""


@dataclass(frozen=True)
class Effort:
    """How much is tried.

    Args:
        refined: rough models that are looked at more closely.
        tried: of those, how many are fitted to the beginnings of the records.
        steps: of these fits.
        kept: of those, how many are then fitted in full.
    """

    refined: int = 12
    tried: int = 10
    steps: int = 10
    kept: int = 2


def slipping_starts(
    base: Model,
    effect: Effect,
    records: Sequence[PreparedRecord],
    scales: Scales,
    far: bool,
    point: dict[str, float] | None,
) -> list[Model]:
    """Rough models with an effect that decides where a contact slips; none for another effect.

    Where the base model's contact hardly slips, neither its level nor how that goes with the load has a gradient; where
    the base model is far off, every number of the contact had to make up for what is missing.

    Args:
        base: the fitted model.
        effect: tried on top of it.
        records: those fitted.
        scales: of the records.
        far: whether the base model is far off.
        point: values of the effect to begin with, where some are known.
    """
    if not in_contact(effect):
        return []
    grown = with_effect(base, effect, scales, point)
    if effect.friction_state is None and f"{effect.name}.sensitivity" != LOAD_KEY:
        return rough_starts(grown.at(_neutral(grown)), records, (), Effort(6, 4, 6, 1)) if far else []
    plain = with_effect(base, find(f"{CONTACT}coulomb"), scales) if effect.friction_state is not None else grown
    found = rough_starts(plain, records, ("rig.gain", "rig.contact_stiffness"), Effort(6, 4, 6, 1))
    if effect.friction_state is not None:
        # A contact that never slips had to make up for every slip: its numbers may be no start.
        found += rough_starts(plain.at(_neutral(plain)), records, ())
    # A law with presliding begins from where plain slip comes nearest.
    levels = {_level_key(plain, True): _level_key(grown, True)}
    return [
        grown.at({levels.get(k, k): v for k, v in start.values.items() if levels.get(k, k) in grown.values})
        for start in found
    ]


def rough_starts(
    model: Model, records: Sequence[PreparedRecord], given: Collection[str], effort: Effort | None = None
) -> list[Model]:
    """The model at the rough values that come nearest the records, best first; none where nothing is open.

    Args:
        model: as the experiment states it.
        records: those fitted.
        given: keys whose start the experiment states.
        effort: how much is tried.
    """
    effort = effort or Effort()
    driven = [leading_segment(r, ROWS) for r in records if isinstance(r, FrictionDriveRecord)]
    free = {u.key: u for u in model.unknowns if u.key not in given}
    grids = _grids(model, driven, free) if driven else {}
    if not grids:
        return []
    strokes = [_stroke(record) for record in driven]

    def misses(values: dict[str, float]) -> np.ndarray:
        return np.concatenate([_misses(r, s, model, values) for r, s in zip(driven, strokes, strict=True)])

    def ranked(points: list[dict[str, float]]) -> list[dict[str, float]]:
        near = np.array([np.mean(np.abs(misses({**model.values, **point}))) for point in points])
        order = np.argsort(near, kind="stable")
        # Where a number does nothing (a press under which the tip never leaves), one point stands for all alike.
        told = np.diff(near[order], prepend=-1.0) > ALIKE * near[order]
        return [points[k] for k in order[told]]

    points = [_absolute(model, dict(zip(grids, v, strict=True)), free) for v in product(*grids.values())]
    best = ranked(points)
    stiffness = model.values["rig.contact_stiffness"]
    if "rig.contact_stiffness" in free:
        stiffer = [
            _stiffened(model, point, stiffness, part) for point in best[: effort.refined] for part in STIFFNESSES
        ]
        best = ranked(stiffer)
    for key in grids:
        finer = [
            _within(model, {**point, key: part * point[key]}) for point in best[: effort.refined] for part in FINER
        ]
        best = ranked([*best[: effort.refined], *finer])
    keys = [u.key for u in model.unknowns]

    def residual(point: np.ndarray) -> np.ndarray:
        return misses({**model.values, **dict(zip(keys, point.tolist(), strict=True))})

    fits = [
        least_squares(residual, model.at(point).unknowns, iterations=effort.steps)
        for point in _unlike(best, effort.tried, UNLIKE)
    ]
    nearest = [found.values for found in sorted(fits, key=lambda f: root_mean_huber(f.residual))]
    return [
        model.at(least_squares(residual, model.at(point).unknowns).values)
        for point in _unlike(nearest, effort.kept, UNLIKE)
    ]


def _unlike(points: Sequence[dict[str, float]], count: int, part: float) -> list[dict[str, float]]:
    """The first points, each of which differs from those before it by a part of some number."""
    chosen: list[dict[str, float]] = []
    for point in points:
        if len(chosen) == count:
            break
        if all(any(abs(point[k] - other[k]) > part * abs(other[k]) for k in point) for other in chosen):
            chosen.append(point)
    return chosen


def _grids(model: Model, records: Sequence[FrictionDriveRecord], free: Collection[str]) -> dict[str, list[float]]:
    """Values to try: gain and press in SI, what pads hold in metres of the contact's stretch, the contact over them."""
    grids: dict[str, list[float]] = {}
    if "rig.gain" in free:
        grids["rig.gain"] = [*dict.fromkeys([model.values["rig.gain"], *_gains(records)])]
    if "rig.press" in free:
        fall = max(float(np.max(-np.mean(r.drives, axis=0))) for r in records)
        if fall > 0.0:
            # Over the gain: a tip that falls twice as far leaves as soon if it is pressed in twice as far.
            grids["rig.press"] = [part * fall for part in PRESSES]
    if LOAD_KEY in free:
        grids[LOAD_KEY] = [AMONTONS]
    pads = _level_key(model, False)
    if pads in free:
        stroke = max(float(np.ptp(r.drives[1] - r.drives[0])) * r.lever for r in records)
        grids[pads] = [part * stroke for part in WIND_UPS]
    contact = _level_key(model, True)
    if contact in free:
        grids[contact] = list(HOLDS)
    # One number alone is for the fit itself to find.
    return grids if len(grids) > 1 else {}


def _level_key(model: Model, contact: bool) -> str:
    name = next(
        (e.name for e in model.effects if e.friction_state is not None and e.name.startswith(CONTACT) == contact), ""
    )
    return f"{name}.force"


def _absolute(model: Model, trial: dict[str, float], free: Collection[str]) -> dict[str, float]:
    """The trial's numbers in SI, within their bounds."""
    point = dict(trial)
    gain = trial.get("rig.gain", model.values["rig.gain"])
    if "rig.press" in point:
        point["rig.press"] *= gain
    pads, contact = _level_key(model, False), _level_key(model, True)
    if pads in point:
        point[pads] *= gain * model.values["rig.contact_stiffness"]
    if contact in point:
        point[contact] *= point.get(pads, model.values.get(pads, 1.0))
    return _within(model, point)


def _stiffened(model: Model, point: dict[str, float], stiffness: float, part: float) -> dict[str, float]:
    """A point with another stiffness of the contact, its forces going along."""
    forces = {key: part * value for key, value in point.items() if key.endswith(".force")}
    return _within(model, {**point, **forces, "rig.contact_stiffness": part * stiffness})


def _neutral(model: Model) -> dict[str, float]:
    """The contact's own numbers, those of them that are free, where any fit begins."""
    free = {u.key for u in model.unknowns}
    stiffness = model.values["rig.contact_stiffness"]
    if "rig.contact_stiffness" in free:
        stiffness = CONTACT_STIFFNESS
    neutral = {
        "rig.contact_stiffness": stiffness,
        "rig.contact_damping": contact_damping(stiffness, model.values["rig.mass"]),
    }
    return {key: value for key, value in neutral.items() if key in free}


def _within(model: Model, point: dict[str, float]) -> dict[str, float]:
    bounds = {u.key: (u.low, u.high) for u in model.unknowns}
    return {key: min(max(value, bounds[key][0]), bounds[key][1]) for key, value in point.items()}


def _gains(records: Sequence[FrictionDriveRecord]) -> list[float]:
    """Gains (m/V) at which the tip would have moved as the stage did, over most of the way."""
    ratios, weights = [], []
    for record in records:
        lag = _stroke(record) // 4
        tip = record.lever * (record.drives[0] - record.drives[1])
        tip, stage = tip[lag:] - tip[:-lag], record.measured["position"][lag:] - record.measured["position"][:-lag]
        moved = np.abs(tip) > 0.2 * np.max(np.abs(tip))
        ratios.append(stage[moved] / tip[moved])
        weights.append(np.abs(tip[moved]))
    ratio, weight = np.concatenate(ratios), np.concatenate(weights)
    order = np.argsort(ratio)
    share = np.cumsum(weight[order]) / weight.sum()
    found = [float(ratio[order][min(int(np.searchsorted(share, q)), ratio.size - 1)]) for q in QUANTILES]
    return [gain for gain in found if gain > 0.0]


def _stroke(record: FrictionDriveRecord) -> int:
    """Rows of a stroke there and back: twice the mean from one turn of the lean to the next, rests left out."""
    lean = record.drives[1] - record.drives[0]
    change = np.diff(lean)
    moves = np.abs(change) > MOVES * np.ptp(lean)
    turns = int(np.count_nonzero(np.diff(np.sign(change[moves]))))
    rows = 2 * int(np.count_nonzero(moves)) // max(turns, 1)
    return min(max(rows, SHORTEST), record.size // 2)


def _misses(record: FrictionDriveRecord, stroke: int, model: Model, values: dict[str, float]) -> np.ndarray:
    """What the stage does from stroke to stroke less what is predicted, over its noise, (k,)."""
    miss = record.measured["position"] - predict_friction_drive(record, model.effects, values)["position"]
    ok = record.valid["position"][stroke:] & record.valid["position"][:-stroke]
    return (miss[stroke:] - miss[:-stroke])[ok] / (np.sqrt(2.0) * record.noise["position"])
