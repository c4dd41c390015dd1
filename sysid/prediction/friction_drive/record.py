"""A friction-drive record: voltages of one actuator in, position of the stage out, along one axis or in the plane.

    tip:      along = -h (d2 - d1)/D,   up = (d1 + d2)/2  (with a third piezo, the mean of all three),
              d_i = gain * (voltage_i - bias_voltage), after every effect on drive and piezo
    contact:  force T on the stage while the tip touches, 1 + up/press > 0, with `press` the preload indentation;
              without a contact effect a spring and a dashpot that never slip, T = k (tip - x) + c (tip' - x'); with
              one, friction between tip and stage
    stage:    m x'' = T - (friction of the pads) - (other forces of the pads' effects)

With `position_y` logged the stage moves in the plane: the third stack tilts the tip across,
-h [d3 - (d1 + d2)/2]/(D sqrt(3)/2), a guide holds the stage across, and the sensors may be rotated against the tip.

The motion of the stage is simulated from rest and compared with the measured position: the form is `output`. Friction
sticks and slips: rigid for `coulomb`, as parallel elasto-plastic bristles for `presliding`, whose stretch follows the
simulated motion, as a friction limit does that depends on the velocity. Other dependences of a limit (position, load,
distance) are evaluated along the measured motion: it is known far better than any limit changes with it, and one
simulation suffices. If a limit grows with the time at rest, a second simulation uses the motion of the first.

Known parameters of the rig are fixed, the others are estimated from its records and fitted. The motion determines
forces and mass over the contact stiffness only. Where neither mass nor stiffness is known, the stiffness is fixed;
where the mass is known, the inertial part of the motion determines the stiffness, and it is fitted within a decade or
so of that of a Hertz contact under some newtons.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from designcalc.drive.friction_drive import GRAVITY
from sim.effects.catalogue import find
from sim.effects.effect import Axis, Effect
from sim.integration.friction_drive.event_driven import simulate_event_driven
from sim.integration.friction_drive.inputs import DrivenStage, Nudging, TipMotion
from sim.integration.friction_drive.midpoint import Bristles, simulate_midpoint
from sim.integration.friction_drive.planar import Guide, PlanarTipMotion, simulate_planar
from stagecad.parameters.errors import InputError
from sysid.experiment.experiment import Rig
from sysid.experiment.known import Known
from sysid.experiment.record import Record
from sysid.noise.estimate import Noise
from sysid.prediction.actuator_tip import LENGTHS, VOLTAGES, piezo_signals, piezo_stretch
from sysid.prediction.effect_terms import Values, values_of
from sysid.prediction.force_balance.record import ForceBalanceRecord, make_axis, optional_channel
from sysid.prediction.friction_drive.friction import (
    CONTACT,
    PREFILTER_STEPS,
    bristles_of,
    contact_friction,
    friction_state_of,
    pad_friction,
    simulated_axis,
)
from sysid.prediction.prepared_record import PredictsChannels
from sysid.prediction.resampling import uniform
from sysid.prediction.rig_model import Channels, Effects, Noises, RigModel, RigParameters, Start
from sysid.prediction.sensors import sensed
from sysid.signals import GaussianFilter

CONTACT_STIFFNESS = 1e7
"""N/m, where the user gives none: the order of a Hertz contact under some newtons."""
STIFFNESS_DECADE = 20.0
"""Factor by which a fitted stiffness may be softer or stiffer than that."""
CONTACT_DAMPING = 0.03
"""Damping ratio of the stage on its contact, where a fit of the dashpot begins."""
MASS = 1.0
"""kg, where a fit of the mass begins."""
MOST_DAMPING = 10.0
"""Largest value of the dashpot over its start, a third of critical; a fit at this bound indicates a missing effect."""
GUIDE = 0.01
"""Scale of the fitted stiffness of a guide across the travel (teeth, a flexure), over that of the contact."""
MOST_TURN = 0.3
"""Largest rotation of the sensors against the tip, rad."""
GOES_UP = 0.02
"""Range of the tip's rise over the swing of its lean from which the rise counts."""


def friction_drive_parameters(rig: Rig, records: Sequence[Record]) -> RigParameters:
    """Parameters of the rig, from what is known of it and the records of the fit."""
    found, known = RigParameters(rig), rig.known
    gain, indentation = gain_and_indentation(known, records)
    mass = found.put("mass", MASS)
    soft, stiff = CONTACT_STIFFNESS / STIFFNESS_DECADE, CONTACT_STIFFNESS * STIFFNESS_DECADE
    stiffness = found.put("contact_stiffness", CONTACT_STIFFNESS, (soft, stiff), free="mass" in known)
    damping = contact_damping(stiffness, mass)
    stiffest = contact_damping(stiff, mass) if "contact_stiffness" not in known else damping
    found.put("contact_damping", damping, (0.0, MOST_DAMPING * max(damping, stiffest)))
    found.put("gain", gain)
    if indentation is not None:
        found.put("press", indentation)
    if any("position_y" in record.channels for record in records):
        found.put_free("guide_stiffness", 0.0, (0.0, STIFFNESS_DECADE * stiffness), GUIDE * stiffness)
        found.put_free("turn", 0.0, (-MOST_TURN, MOST_TURN), 1e-2)
    return found


def contact_damping(stiffness: float, mass: float) -> float:
    """Start of a fit of the contact's dashpot, N s/m."""
    return CONTACT_DAMPING * 2.0 * float(np.sqrt(stiffness * mass))


def gain_and_indentation(known: Mapping[str, Known], records: Sequence[Record]) -> tuple[float, float | None]:
    """Start of a fit: the gain that makes the tip's travel the stage's, m/V, and the preload indentation of the
    tip, m.

    The indentation is none where the tip does not move up and down: then it is not identifiable.
    """
    lever = known["tip_height"].value / known["piezo_spacing"].value
    across, common, travel = [], [], []
    for record in records:
        volts = [record.channels[name] for name in VOLTAGES if name in record.channels]
        across.append(float(np.nanstd(volts[1] - volts[0])))
        common.append(float(np.ptp(np.nanmean(volts, axis=0))))
        travel.append(float(np.nanstd(record.channels["position"])))
    gain = known["piezo_gain"].value if "piezo_gain" in known else max(travel) / max(lever * max(across), 1e-300)
    return gain, gain * max(common) if max(common) > GOES_UP * max(across) else None


TRANSVERSE = "position_y"
"""The channel across the travel: if it is measured, the motion is simulated in the plane."""
PAD_FRICTION = 0.05
"""Friction over weight of a run-in pad: initial value of the pads' friction level."""
REST_SIGMAS = 5.0
POSITION_STEPS = 1.0
"""Width in steps of the filter of the position: its noise is far below any pitch, its reversals take a few rows."""
TABLE_RANGE = 1.5
"""Range of the velocity tables over the largest speeds of tip and stage together."""
LEAST_TIP_SPEED = 0.02
"""Part of the largest speed of the tip from which a row counts for the gain from tip to stage."""


@dataclass(eq=False, kw_only=True)
class FrictionDriveRecord(ForceBalanceRecord):
    """One friction-drive record, prepared; its axis is that of the pads."""

    drives: list[np.ndarray] = field(default_factory=list)  # voltages from the bias, V, each (n,)
    lever: float = 0.0  # h/D
    force_scale: float = 1.0  # typical friction of the pads, N
    # part of its distance to the measured position by which the simulated stage is corrected after every row
    # (`Nudging`); zero for a free simulation
    nudging_gain: float = 0.0

    @property
    def settled_from(self) -> int:
        """The first row: the stage is simulated from rest."""
        return 0

    def scales(self) -> dict[str, float]:
        swing = max(float(np.ptp(u)) for u in self.drives)
        return {**super().scales(), "force": self.force_scale, "input": swing, "sliding": sliding_speed(self)}

    def driven_by(self, name: str, step: float, drives: list[np.ndarray]) -> FrictionDriveRecord:
        """The record as if the rig had been driven by other voltages, its stage following the tip; V, each (n,)."""
        n, position = drives[0].size, -self.lever * (drives[1] - drives[0])
        load, temperature = (np.full(n, np.mean(values)) for values in (self.axis.load, self.axis.temperature))
        velocity = np.gradient(position, step)
        return replace(
            self,
            name=name,
            step=step,
            axis=make_axis(np.arange(n) * step, position, velocity, np.zeros(n), load, temperature, 1e-9),
            drives=drives,
            complementary_filter=GaussianFilter(0.0, step, n),
            measured={"position": np.zeros(n)},
            valid={"position": np.arange(n) >= 1},
        )


def friction_drive_record(
    rig: PredictsChannels, record: Record, known: Mapping[str, Known], noise: Mapping[str, Noise]
) -> FrictionDriveRecord:
    """A record of a friction drive; of what is known, `piezo_spacing` and `tip_height` are needed, m."""
    time, step, channels, hole = uniform(record)
    drives, measured, valid = piezo_signals(channels, hole, known, ("position", TRANSVERSE))
    position, sigma = measured["position"], noise["position"].value
    light = GaussianFilter(PREFILTER_STEPS * step, step, time.size)
    velocity = light(position, 1)
    rest = REST_SIGMAS * sigma * light.noise_gain(1) + 1e-6 * float(np.max(np.abs(velocity)))
    load, temperature = (optional_channel(channels, name) for name in ("normal_load", "temperature"))
    axis = make_axis(time, light(position), velocity, light(position, 2), load, temperature, rest)
    return FrictionDriveRecord(
        name=record.name,
        role=record.role,
        rig=rig,
        step=step,
        axis=axis._replace(position=GaussianFilter(POSITION_STEPS * step, step, time.size)(position)),
        measured=measured,
        valid=valid,
        noise={name: noise[name].value for name in measured},
        complementary_filter=GaussianFilter(0.0, step, time.size),
        force_channel="position",
        drives=drives,
        lever=known["tip_height"].value / known["piezo_spacing"].value,
        force_scale=PAD_FRICTION * GRAVITY * (known["mass"].value if "mass" in known else 1.0),
    )


def tip_motion(
    record: FrictionDriveRecord, effects: Sequence[Effect], values: Values, stretches: Sequence[np.ndarray]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Motion of the tip along, across and up, m, each (n,), from the stacks' stretch over their gain, V."""
    gain, first, second = values["rig.gain"], stretches[0], stretches[1]
    along = -record.lever * gain * (second - first)
    up = gain * np.mean(stretches, axis=0)
    across = np.zeros(record.size)
    if len(stretches) > 2:
        # The third stack is at the apex of an equilateral triangle.
        across = -record.lever * gain * (stretches[2] - 0.5 * (first + second)) / (0.5 * np.sqrt(3.0))
    for effect in effects:
        if effect.is_mode and effect.signal is not None:
            p = values_of(effect, values)
            along, across, up = [u + p.mass_ratio * (effect.signal(u, record.step, p) - u) for u in (along, across, up)]
    return along, across, up


def predict_friction_drive(
    record: FrictionDriveRecord, effects: Effects, values: Values, at: Mapping[str, np.ndarray] | None = None
) -> Channels:
    """Predicted position of the stage, m, and `position_y` where it is measured, (n,), or at the samples `at` of each
    channel, (k,)."""
    stretches = [piezo_stretch(record, effects, values, k) for k in range(len(record.drives))]
    if TRANSVERSE in record.measured:
        moved = _planar_motion(record, effects, values, stretches)
    else:
        along, _, up = tip_motion(record, effects, values, stretches)
        tip = TipMotion(along, 1.0 + up / values.get("rig.press", np.inf))
        moved = {"position": _motion(record, effects, values, tip)}
    out = _sensed_from_start(record, effects, values, moved)
    return out if at is None else {channel: out[channel][index] for channel, index in at.items()}


def _sensed_from_start(
    record: FrictionDriveRecord, effects: Sequence[Effect], values: Values, moved: Mapping[str, np.ndarray]
) -> dict[str, np.ndarray]:
    """The channels (n,), m, as their sensors show a stage that `moved` from its rest at the first row."""
    ok = record.valid
    begun = {name: x + record.measured[name][int(np.argmax(ok[name]))] for name, x in moved.items()}
    seen = sensed(effects, values, begun, record.step)
    # The first position has the noise of one sample; the mean averages the noise of all samples.
    return {name: x + float(np.mean((record.measured[name] - x)[ok[name]])) for name, x in seen.items()}


def _planar_motion(
    record: FrictionDriveRecord, effects: Sequence[Effect], values: Values, stretches: Sequence[np.ndarray]
) -> dict[str, np.ndarray]:
    """Motion of the stage along and across, m, each (n,), from rest at the first row, in the frame of the sensors."""
    along, across, up = tip_motion(record, effects, values, stretches)
    load = 1.0 + up / values.get("rig.press", np.inf)
    pads, contact = _by_contact(effects)
    for effect in (friction_state_of(pads), friction_state_of(contact)):
        if effect is not None and effect.has_presliding:
            raise InputError(
                f"model.effects: '{effect.name}' cannot be used where position_y is recorded; allowed: 'coulomb'"
            )
    between = contact_friction(record, contact, values, TipMotion(along, load))
    below = pad_friction(record, pads, values)
    push = between.push + below.push
    guide = Guide(values["rig.guide_stiffness"], values.get("viscous.coefficient", 0.0))
    tip = PlanarTipMotion(along, across, load)
    x, y = simulate_planar(tip, push, between.limit.at_rest, below.limit.at_rest, _stage(record, values), guide)
    cosine, sine = np.cos(values["rig.turn"]), np.sin(values["rig.turn"])
    return {"position": cosine * x - sine * y, TRANSVERSE: sine * x + cosine * y}


def _by_contact(effects: Sequence[Effect]) -> tuple[list[Effect], list[Effect]]:
    """Effects of the pads (and of everything else), and those between tip and stage."""
    return ([e for e in effects if not e.name.startswith(CONTACT)], [e for e in effects if e.name.startswith(CONTACT)])


def _stage(record: FrictionDriveRecord, values: Values) -> DrivenStage:
    return DrivenStage(values["rig.contact_stiffness"], values["rig.contact_damping"], values["rig.mass"], record.step)


def _motion(record: FrictionDriveRecord, effects: Sequence[Effect], values: Values, tip: TipMotion) -> np.ndarray:
    """Position of the stage (n,), m, from rest at the first row."""
    pads, contact = _by_contact(effects)
    states = friction_state_of(pads), friction_state_of(contact)
    stage = _stage(record, values)
    if any(state is not None and state.has_presliding for state in states):
        between, below = contact_friction(record, contact, values, tip), pad_friction(record, pads, values)
        pad_bristles = Bristles(below.limit.at_rest, bristles_of(states[0], values))
        limit = np.where(tip.load > 0.0, between.limit.at_rest, 0.0)
        bristles = Bristles(limit, bristles_of(states[1], values))
        return simulate_midpoint(tip.along, between.push + below.push, bristles, pad_bristles, stage)
    fastest = float(np.max(np.abs(np.diff(tip.along)))) / record.step + float(np.max(np.abs(record.axis.velocity)))
    top = TABLE_RANGE * fastest
    between = contact_friction(record, contact, values, tip, top)
    nudging = None
    if record.nudging_gain > 0.0:
        gain, measured = record.nudging_gain, record.measured["position"]
        nudging = Nudging(measured - measured[0], gain, gain * gain / (2.0 - gain))

    def simulated(along: FrictionDriveRecord) -> np.ndarray:
        friction = pad_friction(along, pads, values, top)
        return simulate_event_driven(tip, between.push + friction.push, between.limit, friction.limit, stage, nudging)

    position = simulated(record)
    if nudging is not None or not any(e.level is not None and "contact_age" in e.coordinates for e in pads):
        return position
    return simulated(replace(record, axis=simulated_axis(record.axis, position, record.step)))


def leading_segment(record: FrictionDriveRecord, rows: int) -> FrictionDriveRecord:
    """The first rows of a record, all of a shorter one, along its axis alone."""
    if record.size <= rows and TRANSVERSE not in record.measured:
        return record
    rows = min(rows, record.size)
    return replace(
        record,
        axis=Axis(*[values[:rows] for values in record.axis]),
        drives=[u[:rows] for u in record.drives],
        measured={"position": record.measured["position"][:rows]},
        valid={"position": record.valid["position"][:rows]},
        complementary_filter=GaussianFilter(0.0, record.step, rows),
    )


def sliding_speed(record: FrictionDriveRecord) -> float:
    """Upper bound of the speed of the tip over the stage, m/s: the largest speeds of both added.

    While the contact sticks, in most rows, the stage moves as fast as the tip: the median of its speed over that of the
    tip, in volts, is the gain.
    """
    tip = record.lever * np.abs(np.diff(record.drives[1] - record.drives[0])) / record.step
    fastest = float(np.max(tip))
    speed = np.abs(record.axis.velocity)
    if fastest == 0.0:
        return float(np.max(speed))
    moves = tip > LEAST_TIP_SPEED * fastest
    gain = float(np.median(speed[1:][moves] / tip[moves]))
    return gain * fastest + float(np.max(speed))


CONTACT_EFFECTS = ("coulomb", "presliding", "stribeck", "viscous", "direction_asymmetry", "load_dependent_friction")

ROUNDS = 12
"""Most iterations of the motion of a simulated stage."""

SETTLED = 1e-4
"""Change from one iteration to the next, over the range of the motion, at which the motion is taken as found."""


class FrictionDrive(RigModel):
    """Voltages in, position of the stage out."""

    name = "friction-drive"
    predict = staticmethod(predict_friction_drive)
    required = LENGTHS
    restarts = True

    def parameters(self, rig: Rig, records: Sequence[Record], noise: Noises) -> RigParameters:
        return friction_drive_parameters(rig, [r for r in records if r.role == "fit"])

    def prepare(self, rig: Rig, records: Sequence[Record], noise: Noises, values: Values) -> list[FrictionDriveRecord]:
        return [friction_drive_record(self, record, rig.known, noise) for record in records]

    def shows(self, effect: Effect, records: Sequence[FrictionDriveRecord], channels: set[str]) -> bool:
        # Voltages are taken to go straight from row to row.
        if effect.acts_on in ("drive", "piezo", "sensor"):
            return effect.signal is not None and not effect.name.endswith(":of_curves")
        if effect.acts_on == "structure":
            return effect.is_mode and ":" not in effect.name
        if effect.friction_state is not None:
            elements = effect.friction_state.springs is not None
            return effect.friction_state.rigid or (elements and all(TRANSVERSE not in r.measured for r in records))
        has_law = effect.level is not None or effect.factor is not None or effect.force is not None
        return (effect.acts_on in ("friction", "axis") and has_law) or effect.acts_on == "memory"

    def further_candidates(self, records: Sequence[FrictionDriveRecord], present: Sequence[str]) -> list[Effect]:
        """Effects between tip and stage to try on top of a model: first that it slips, then how."""
        effects = [find(CONTACT + name) for name in CONTACT_EFFECTS]
        state = next((e for e in effects if e.friction_state is not None and e.name in present), None)
        goes_up = any(np.ptp(np.mean(r.drives, axis=0)) > 0.02 * np.ptp(r.drives[1] - r.drives[0]) for r in records)

        def is_tried(effect: Effect) -> bool:
            if effect.name in present or ("load" in effect.needs and not goes_up):
                return False
            if effect.friction_state is None:
                return state is not None
            # Presliding may take the place of plain slip; nothing else takes the place of presliding.
            return state is None or (effect.has_presliding and not state.has_presliding)

        return [e for e in effects if is_tried(e) and self.shows(e, records, set())]

    def simulate(self, rig: Rig, record: Record, effects: Effects, values: Values, start: Start | None) -> Channels:
        """The predicted motion; laws that depend on the motion are evaluated along the predicted one, by iteration."""
        names = ["position", *([TRANSVERSE] if "rig.turn" in values else [])]
        found = {name: np.full(record.size, start.position if start is not None else 0.0) for name in names}
        for _ in range(ROUNDS):
            before, found = found, self.predict_along(rig, record, found, effects, values)
            change = max(float(np.max(np.abs(found[name] - before[name]))) for name in names)
            if change <= SETTLED * float(np.ptp(found["position"])):
                break
        return found
