"""Search for lower local minima of the cost of a driven stage.

Slips, lift-offs and hysteresis give the cost of a driven stage many narrow local minima. A fit ends in the one near its
start, where the friction limit of the contact may be wrong by a factor. Two methods find lower minima:

- multistart: each value in turn is moved away from its fitted one, and the fit continues from there;
- synchronisation (nudging): during the fit the simulated position is corrected by a fraction of its deviation from the
  measured one after every row. An error then decays within some rows, and the cost has few, widely separated minima
  (Abarbanel, Creveling, Farsian and Kostuk, SIAM J. Applied Dynamical Systems 8 (2009) 1341). The correction feeds the
  noise of the measured motion into the simulation, so the result is a starting point, not an estimate.

The simulation takes as long as the record; long records are truncated during the search.

Initial values of a friction drive: coarse search over gain, preload indentation, stiffness and friction limits.

The effects of slips and lift-offs on the position accumulate, so a fit does not recover from a start with slip or
lift-off where there is none, or without where there is some. A few hundred trial points are compared in the
displacement of the stage from stroke to stroke, which does not accumulate; the best are refined and fitted.
"""

from collections.abc import Collection, Sequence
from dataclasses import replace
from itertools import product
from typing import TypeAlias

import numpy as np

from sim.effects.catalogue import find, rigid_friction
from sim.effects.effect import Effect
from sysid.estimation.fit import FittedModel, fit_model, root_mean_huber
from sysid.estimation.least_squares import least_squares
from sysid.estimation.misfit import ResidualWeights
from sysid.prediction.friction_drive.friction import CONTACT
from sysid.prediction.friction_drive.record import (
    CONTACT_STIFFNESS,
    TRANSVERSE,
    FrictionDriveRecord,
    contact_damping,
    leading_segment,
    predict_friction_drive,
)
from sysid.prediction.model import Model, Scales, in_contact, with_effect
from sysid.prediction.prepared_record import PreparedRecord

TRUNCATED_ROWS = 3000
"""Largest number of rows of each record that are kept."""

NUDGING_GAIN = 0.3
"""Fraction of the deviation from the measured position that is corrected per row: an error is halved in two rows."""

SYNCHRONISED_STEPS = 15
"""Steps of a synchronisation fit."""

FACTORS = (0.6, 1.6)
"""Factors by which a value is moved."""
SHORT_STEPS = 6
"""Steps of the fit from a moved value, before it is compared."""
STIFFNESS, DAMPING = "rig.contact_stiffness", "rig.contact_damping"
ROUNDS = 3
"""Largest number of rounds over all values."""
LOWER = 0.98
"""Ratio of costs below which another local minimum counts as lower."""
AT_THE_NOISE = 1.03
"""Root mean Huber loss at which the search ends."""


def _along_one_axis(records: Sequence[PreparedRecord]) -> list[FrictionDriveRecord]:
    """The records, if all are of stages driven along one axis; otherwise an empty result."""
    driven = [r for r in records if isinstance(r, FrictionDriveRecord) and TRANSVERSE not in r.measured]
    return driven if len(driven) == len(records) else []


def truncated(
    fitted: FittedModel, records: Sequence[PreparedRecord], rows: int = TRUNCATED_ROWS
) -> tuple[FittedModel, list[PreparedRecord]]:
    """A fit and its records truncated to their first rows, if they are long and of a stage driven along one axis."""
    driven = _along_one_axis(records)
    if all(record.size <= rows for record in driven):
        return fitted, list(records)
    weights = fitted.weights
    kept = [{channel: index < rows for channel, index in samples.items()} for samples in weights.samples]
    mask = np.concatenate([of_channel for of_record in kept for of_channel in of_record.values()])
    short = ResidualWeights(
        tuple({c: values[:rows] for c, values in std.items()} for std in weights.std),
        tuple({c: s[k[c]] for c, s in samples.items()} for samples, k in zip(weights.samples, kept, strict=True)),
    )
    fit = fitted.fit
    fit = replace(fit, residual=fit.residual[mask], jacobian=fit.jacobian[mask], weights=fit.weights[mask])
    return FittedModel(fitted.model, fit, short), [leading_segment(record, rows) for record in driven]


def synchronised_starts(
    starts: Sequence[Model], records: Sequence[PreparedRecord], weights: ResidualWeights | None, steps: int
) -> list[Model]:
    """The result of the synchronisation fit of lowest cost from several starts.

    Empty if some record is not of a stage driven along one axis, or if the model has presliding, whose displacement
    depends on the simulated motion and is not corrected.
    """
    synchronised = [replace(record, nudging_gain=NUDGING_GAIN) for record in _along_one_axis(records)]
    presliding = starts and any(e.has_presliding for e in starts[0].effects)
    if not synchronised or not starts or presliding:
        return []
    fits = [fit_model(start, synchronised, weights, steps) for start in starts]
    return [min(fits, key=lambda fitted: fitted.fit.cost).model]


def lowest_minimum(fitted: FittedModel, records: Sequence[PreparedRecord], rounds: int = ROUNDS) -> FittedModel:
    """The fit, or one from another start that ended at a lower cost; unchanged if no stage is driven."""
    if not any(isinstance(record, FrictionDriveRecord) for record in records):
        return fitted
    short, beginnings = truncated(fitted, records)
    if short is fitted:
        return _multistart(fitted, records, rounds)
    near = _multistart(fit_model(short.model, beginnings, short.weights, SHORT_STEPS), beginnings, rounds)
    whole = fit_model(near.model, records, fitted.weights)
    return whole if whole.fit.cost < LOWER * fitted.fit.cost else fitted


def _multistart(fitted: FittedModel, records: Sequence[PreparedRecord], rounds: int) -> FittedModel:
    best = fitted
    for _ in range(rounds):
        before = best
        starts = [best.model, *_other_stiffnesses(best.model)]
        synchronised = synchronised_starts(starts, records, best.weights, SYNCHRONISED_STEPS)
        fits = [fit_model(start, records, best.weights, SHORT_STEPS) for start in (*synchronised, *starts[1:])]
        best = min([best, *fits], key=lambda f: f.fit.cost)
        for key in [u.key for u in best.model.unknowns]:
            if root_mean_huber(best.fit.residual) <= AT_THE_NOISE:
                return best
            best = min([best, *_fits_beside(best, key, records)], key=lambda f: f.fit.cost)
        if best.fit.cost > LOWER * before.fit.cost:
            break
        best = fit_model(best.model, records, best.weights)
    return best


def _other_stiffnesses(model: Model) -> list[Model]:
    """The model with a softer, a stiffer, and the default contact, all forces scaled alike: the motion determines their
    ratio well, but the stiffness itself only through inertia."""
    unknowns = {u.key: u for u in model.unknowns}
    if STIFFNESS not in unknowns:
        return []
    values = model.values
    starts = []
    for factor in (*FACTORS, CONTACT_STIFFNESS / values[STIFFNESS]):
        moved = {key: factor * values[key] for key in unknowns if key == STIFFNESS or key.endswith(".force")}
        if DAMPING in unknowns:
            moved[DAMPING] = float(np.sqrt(factor)) * values[DAMPING]
        starts.append(model.at({key: min(max(v, unknowns[key].low), unknowns[key].high) for key, v in moved.items()}))
    return starts


def _fits_beside(fitted: FittedModel, key: str, records: Sequence[PreparedRecord]) -> list[FittedModel]:
    """Short fits from a smaller and a larger value."""
    unknown = next(u for u in fitted.model.unknowns if u.key == key)
    value = fitted.model.values[key]
    moved = [min(max(factor * value, unknown.low), unknown.high) for factor in FACTORS]
    starts = [fitted.model.at({key: other}) for other in moved if not np.isclose(other, value, rtol=0.05)]
    return [fit_model(start, records, fitted.weights, SHORT_STEPS) for start in starts]


Point: TypeAlias = dict[str, float]
"""Values of the open parameters, by key."""

QUANTILES = (0.5, 0.75, 0.9)
"""Quantiles of the ratio of stage to tip motion that are tried as the gain: both motions are equal during sticking."""
INDENTATIONS = (0.25, 0.45, 0.65, 0.85, 1.1)
"""Preload indentations over the largest descent of the tip; above one the tip never lifts off."""
WIND_UPS = (0.01, 0.03, 0.1)
"""Elastic displacement of the contact when the pads start to slide, over the stroke."""
FRICTION_LIMITS = (1.05, 1.4, 2.0, 3.0, 5.0, 9.0)
"""Friction limit of the contact over that of the pads."""
STIFFNESSES = (0.15, 0.25, 0.4, 0.5, 0.63, 0.8, 1.0, 1.25, 1.6, 2.0, 2.5, 4.0)
"""Contact stiffness over its start, forces scaled by the same factor; for the best points only, if it is fitted."""
FINE_FACTORS = (0.7, 0.84, 1.2, 1.4)
"""Factors on each other value of the best points, one after the other."""
AMONTONS = 1.0
"""Sensitivity of a friction limit that is proportional to the load."""
LOAD_KEY = f"{CONTACT}load_dependent_friction.sensitivity"
ROWS = 6000
"""First rows of each record that are used."""
SHORTEST_STROKE = 12
"""Least number of rows."""
MOTION_THRESHOLD = 1e-4
"""Change of the tip's inclination per row, over its range, below which the tip is at rest."""
DISTINCT = 0.2
"""Relative difference in some value from which two points are distinct starts."""

SAME_ERROR = 1e-6
"""Relative difference of the errors up to which two points count as equal."""

FULL, SMALL = (12, 10, 10, 2), (6, 4, 6, 1)
"""Trial points that are refined; of those, how many are fitted to the first rows of the records; steps of these fits;
and how many are then fitted to convergence: of a search alone, and of one of many."""


def slipping_starts(
    base: Model, effect: Effect, records: Sequence[PreparedRecord], scales: Scales, far: bool, point: Point | None
) -> list[Model]:
    """Starting models of a fit with an effect that acts between tip and stage; empty for other effects.

    If the contact of the base model hardly slips, its friction limit and load dependence have no gradient; if the
    error of the base model is large, its contact values compensate for missing effects.
    """
    if not in_contact(effect):
        return []
    grown = with_effect(base, effect, scales, point)
    if effect.friction_state is None and f"{effect.name}.sensitivity" != LOAD_KEY:
        return rough_starts(grown.at(_default_contact(grown)), records, (), small=True) if far else []
    rigid = find(CONTACT + rigid_friction().name)
    plain = grown if effect.friction_state is None else with_effect(base, rigid, scales)
    found = rough_starts(plain, records, ("rig.gain", "rig.contact_stiffness"), small=True)
    if effect.friction_state is not None:
        # Fitted without slip, the contact values compensate for slips: start from the default values too.
        found += rough_starts(plain.at(_default_contact(plain)), records, ())
    # A contact with presliding starts from the best contact with plain slip.
    limits = {_limit_key(plain, True): _limit_key(grown, True)}
    return [
        grown.at({limits.get(k, k): v for k, v in start.values.items() if limits.get(k, k) in grown.values})
        for start in found
    ]


def rough_starts(
    model: Model, records: Sequence[PreparedRecord], given: Collection[str], small: bool = False
) -> list[Model]:
    """The model at the best points of the initial-value search, best first; empty if there is no value to search."""
    refined, tried, steps, kept = SMALL if small else FULL
    driven = [leading_segment(r, ROWS) for r in records if isinstance(r, FrictionDriveRecord)]
    free = {u.key: u for u in model.unknowns if u.key not in given}
    grids = _grids(model, driven, free) if driven else {}
    if not grids:
        return []
    strokes = [_stroke(record) for record in driven]

    def stroke_residual(values: Point) -> np.ndarray:
        return np.concatenate([_stroke_residual(r, s, model, values) for r, s in zip(driven, strokes, strict=True)])

    def ranked(points: list[Point]) -> list[Point]:
        near = np.array([np.mean(np.abs(stroke_residual({**model.values, **point}))) for point in points])
        order = np.argsort(near, kind="stable")
        # If a value has no influence (an indentation at which the tip never lifts off), one point is kept.
        differs = np.diff(near[order], prepend=-1.0) > SAME_ERROR * near[order]
        return [points[k] for k in order[differs]]

    def stiffer(point: Point, part: float) -> Point:
        forces = {key: part * value for key, value in point.items() if key.endswith(".force")}
        return model.bounded({**point, **forces, "rig.contact_stiffness": part * stiffness})

    points = [_in_si(model, dict(zip(grids, v, strict=True)), free) for v in product(*grids.values())]
    best = ranked(points)
    stiffness = model.values["rig.contact_stiffness"]
    if "rig.contact_stiffness" in free:
        near = best[:refined]
        best = ranked([stiffer(point, part) for point in near for part in STIFFNESSES])
    for key in grids:
        near = best[:refined]
        fine = [model.bounded({**point, key: part * point[key]}) for point in near for part in FINE_FACTORS]
        best = ranked([*near, *fine])
    keys = [u.key for u in model.unknowns]

    def residual(point: np.ndarray) -> np.ndarray:
        return stroke_residual({**model.values, **dict(zip(keys, point.tolist(), strict=True))})

    fits = [least_squares(residual, model.at(point).unknowns, iterations=steps) for point in _distinct(best, tried)]
    nearest = [found.values for found in sorted(fits, key=lambda f: root_mean_huber(f.residual))]
    return [model.at(least_squares(residual, model.at(point).unknowns).values) for point in _distinct(nearest, kept)]


def _distinct(points: Sequence[Point], count: int) -> list[Point]:
    """The first points that each differ from all earlier ones by a least relative difference in some value."""
    chosen: list[Point] = []
    for point in points:
        if len(chosen) == count:
            break
        if all(any(abs(point[k] - other[k]) > DISTINCT * abs(other[k]) for k in point) for other in chosen):
            chosen.append(point)
    return chosen


def _grids(model: Model, records: Sequence[FrictionDriveRecord], free: Collection[str]) -> dict[str, list[float]]:
    """Grid of trial values: gain and indentation in SI, pad friction as elastic displacement of the contact (m),
    contact friction over pad friction."""
    grids: dict[str, list[float]] = {}
    if "rig.gain" in free:
        grids["rig.gain"] = [*dict.fromkeys([model.values["rig.gain"], *_gains(records)])]
    if "rig.press" in free:
        fall = max(float(np.max(-np.mean(r.drives, axis=0))) for r in records)
        if fall > 0.0:
            # Proportional to the gain: twice the descent with twice the indentation gives lift-off at the same time.
            grids["rig.press"] = [part * fall for part in INDENTATIONS]
    if LOAD_KEY in free:
        grids[LOAD_KEY] = [AMONTONS]
    pads = _limit_key(model, False)
    if pads in free:
        stroke = max(float(np.ptp(r.drives[1] - r.drives[0])) * r.lever for r in records)
        grids[pads] = [part * stroke for part in WIND_UPS]
    contact = _limit_key(model, True)
    if contact in free:
        grids[contact] = list(FRICTION_LIMITS)
    # A single value is left to the fit itself.
    return grids if len(grids) > 1 else {}


def _limit_key(model: Model, contact: bool) -> str:
    name = next(
        (e.name for e in model.effects if e.friction_state is not None and e.name.startswith(CONTACT) == contact), ""
    )
    return f"{name}.force"


def _in_si(model: Model, trial: Point, free: Collection[str]) -> Point:
    """A trial point in SI units, within the bounds."""
    point = dict(trial)
    gain = trial.get("rig.gain", model.values["rig.gain"])
    if "rig.press" in point:
        point["rig.press"] *= gain
    pads, contact = _limit_key(model, False), _limit_key(model, True)
    if pads in point:
        point[pads] *= gain * model.values["rig.contact_stiffness"]
    if contact in point:
        point[contact] *= point.get(pads, model.values.get(pads, 1.0))
    return model.bounded(point)


def _default_contact(model: Model) -> Point:
    """Default stiffness and damping of the contact, as far as they are fitted."""
    free = {u.key for u in model.unknowns}
    stiffness = CONTACT_STIFFNESS if STIFFNESS in free else model.values[STIFFNESS]
    neutral = {STIFFNESS: stiffness, DAMPING: contact_damping(stiffness, model.values["rig.mass"])}
    return {key: value for key, value in neutral.items() if key in free}


def _gains(records: Sequence[FrictionDriveRecord]) -> list[float]:
    """Gains (m/V) at which the tip would have moved as the stage did: weighted quantiles of the ratio of their
    motions."""
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
    """Rows of a stroke and its return: twice the mean number between reversals of the inclination, without rests."""
    inclination = record.drives[1] - record.drives[0]
    change = np.diff(inclination)
    moves = np.abs(change) > MOTION_THRESHOLD * np.ptp(inclination)
    turns = int(np.count_nonzero(np.diff(np.sign(change[moves]))))
    rows = 2 * int(np.count_nonzero(moves)) // max(turns, 1)
    return min(max(rows, SHORTEST_STROKE), record.size // 2)


def _stroke_residual(record: FrictionDriveRecord, stroke: int, model: Model, values: Point) -> np.ndarray:
    """Measured minus predicted displacement from stroke to stroke, over its noise, (k,)."""
    error = record.measured["position"] - predict_friction_drive(record, model.effects, values)["position"]
    ok = record.valid["position"][stroke:] & record.valid["position"][:-stroke]
    return (error[stroke:] - error[:-stroke])[ok] / (np.sqrt(2.0) * record.noise["position"])
