"""A friction-drive record: voltages of one actuator in, position of the stage out, along one axis.

    tip:      along = -h (d2 - d1)/D,   up = (d1 + d2)/2  (with a third piezo, the mean of all three),
              d_i = gain * (voltage_i - bias_voltage), after every effect on drive and piezo
    contact:  force T on the stage while the tip touches, 1 + up/press > 0; without a contact effect a spring and a
              dashpot that never slip, T = k (tip - x) + c (tip' - x'); with one, friction between tip and stage
    stage:    m x'' = T - (friction of the pads) - (other forces of the pads' effects)

With `position_y` logged the stage moves in the plane: the third stack leans the tip across,
-h [d3 - (d1 + d2)/2]/(D sqrt(3)/2), a guide holds the stage across, and the sensors may stand turned to the tip.

The stage's motion is predicted, from rest, and compared with the measured position: the form is `output`. Friction
sticks and slips: rigid for `coulomb`, as bristles that yield at their share of a level for `presliding`; their
stretch follows the predicted motion, and so does a level that goes by the speed. What else sets a level (position,
load, distance) is read off the measured motion: it is known far better than any level changes with it, and the
prediction stays one pass. Where a level grows at rest, a second pass reads the motion of the first.

The motion tells forces and mass over the contact's stiffness k (`friction_drive_parameters`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from sim.library.effect import Axis, Effect
from stagecad.parameters.errors import InputError
from sysid.experiment.record import Record
from sysid.experiment.resampling import uniform
from sysid.noise.estimate import Noise
from sysid.prediction.actuator_tip import piezo_stretch
from sysid.prediction.effect_terms import Values, axis_force, friction_level, values_of
from sysid.prediction.force_balance.record import ForceBalanceRecord, filled, make_axis
from sysid.prediction.friction_drive.event_driven_simulation import follow_exactly
from sysid.prediction.friction_drive.friction import (
    CONTACT,
    LIGHT,
    bristles_of,
    contact_level,
    core_of,
    pads_friction,
    slipping_contact,
)
from sysid.prediction.friction_drive.midpoint import follow
from sysid.prediction.friction_drive.motion import ages_at_rest, as_it_moved
from sysid.prediction.friction_drive.planar import follow_plane
from sysid.prediction.sensors import sensed
from sysid.signals.gaussian_filter import GaussianFilter

TRANSVERSE = "position_y"
"""The channel across the travel: where it is measured, the stage's motion is predicted in the plane."""
GRAVITY = 9.80665
PAD_FRICTION = 0.05
"""Friction over weight of a run-in pad: where a fit of the pads' level begins."""
REST_SIGMAS = 5.0
LIGHTEST = 1.0
"""The same of the position itself: its noise is far below any pitch, its turns are not wider than a few rows."""
TOP = 1.5
"""Over the largest speeds of tip and stage: how far curves of speed go."""


@dataclass
class FrictionDriveRecord(ForceBalanceRecord):
    """One friction-drive record, prepared; the axis is the pads'.

    Args:
        drives: voltages from the bias, V, each (n,).
        lever: h/D.
        force_scale: size of a pad friction, N.
        nudging_gain: part of the way to where it was measured that the predicted stage is brought after every row; zero
        for
            a prediction that is one.
    """

    drives: list[np.ndarray] = field(default_factory=list)
    lever: float = 0.0
    force_scale: float = 1.0
    nudging_gain: float = 0.0

    @property
    def time(self) -> np.ndarray:
        """s, shape (n,)."""
        return self.axis.time


def friction_drive_record(
    record: Record, known: Mapping[str, float], noise: Mapping[str, Noise]
) -> FrictionDriveRecord:
    """A record of the rig kind `friction-drive`; of what is known, `piezo_spacing` and `tip_height` are needed, m."""
    time, step, channels, hole = uniform(record)
    drives, missing = [], hole.copy()
    for name in ("voltage_1", "voltage_2", "voltage_3"):
        if name in channels:
            voltage, gap = filled(channels[name])
            missing |= gap
            drives.append(voltage - known.get("bias_voltage", 0.0))
    position, gap = filled(channels["position"])
    measured, valid = {"position": position}, {"position": ~(gap | missing)}
    if TRANSVERSE in channels:
        measured[TRANSVERSE], gap = filled(channels[TRANSVERSE])
        valid[TRANSVERSE] = ~(gap | missing)
    for scored in valid.values():
        scored[0] = False
    sigma = noise["position"].value
    light = GaussianFilter(LIGHT * step, step, time.size)
    velocity = light(position, 1)
    rest = REST_SIGMAS * sigma * light.noise_gain(1) + 1e-6 * float(np.max(np.abs(velocity)))
    load, temperature = (_optional(channels, name) for name in ("normal_load", "temperature"))
    axis = make_axis(time, light(position), velocity, light(position, 2), load, temperature, rest)
    return FrictionDriveRecord(
        name=record.name, role=record.role, kind="friction-drive", step=step,
        axis=axis._replace(position=GaussianFilter(LIGHTEST * step, step, time.size)(position)),
        measured=measured, valid=valid, noise={name: noise[name].value for name in measured},
        acceleration=None, stick_fraction=None, complementary_filter=GaussianFilter(0.0, step, time.size),
        force_channel="position", drives=drives, lever=known["tip_height"] / known["piezo_spacing"],
        force_scale=PAD_FRICTION * GRAVITY * known.get("mass", 1.0),
    )  # fmt: skip


def _optional(channels: Mapping[str, np.ndarray], name: str) -> np.ndarray | None:
    values = channels.get(name)
    return None if values is None or not np.isfinite(values).any() else filled(values)[0]


def tip_motion(
    record: FrictionDriveRecord, effects: Sequence[Effect], values: Values, stretches: Sequence[np.ndarray]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Motion of the tip along, across and up, m, each (n,), from the stacks' stretch over their gain, V."""
    gain, first, second = values["rig.gain"], stretches[0], stretches[1]
    along = -record.lever * gain * (second - first)
    up = gain * np.mean(stretches, axis=0)
    across = np.zeros(record.size)
    if len(stretches) > 2:
        # The third stack stands at the top of an equilateral triangle.
        across = -record.lever * gain * (stretches[2] - 0.5 * (first + second)) / (0.5 * np.sqrt(3.0))
    for effect in effects:
        if effect.acts_on == "structure" and effect.signal is not None:
            p = values_of(effect, values)
            along, across, up = (
                u + p.mass_ratio * (effect.signal(u, record.step, p) - u) for u in (along, across, up)
            )  # fmt: skip
    return along, across, up


def predict_friction_drive(
    record: FrictionDriveRecord, effects: Sequence[Effect], values: Values
) -> dict[str, np.ndarray]:
    """Predicted position of the stage (n,), m, and `position_y` where it is measured."""
    stretches = [piezo_stretch(record, effects, values, k) for k in range(len(record.drives))]
    if TRANSVERSE in record.measured:
        return _seen(record, effects, values, _follow_plane(record, effects, values, stretches))
    along, _, up = tip_motion(record, effects, values, stretches)
    position = _follow(record, effects, values, along, 1.0 + up / values.get("rig.press", np.inf))
    return _seen(record, effects, values, {"position": position})


def _seen(
    record: FrictionDriveRecord, effects: Sequence[Effect], values: Values, moved: Mapping[str, np.ndarray]
) -> dict[str, np.ndarray]:
    """The channels (n,), m, as their sensors show a stage that `moved` from its rest at the first row."""
    ok = record.valid
    begun = {name: x + record.measured[name][int(np.argmax(ok[name]))] for name, x in moved.items()}
    seen = sensed(effects, values, begun, record.step)
    # Where a record begins is read with the noise of one sample; its mean is read with all of them.
    return {name: x + float(np.mean((record.measured[name] - x)[ok[name]])) for name, x in seen.items()}


def _follow_plane(
    record: FrictionDriveRecord, effects: Sequence[Effect], values: Values, stretches: Sequence[np.ndarray]
) -> dict[str, np.ndarray]:
    """Motion of the stage along and across, m, each (n,), from its rest at the first row, as the sensors stand to it.

    Raises:
        InputError: a core other than `coulomb`.
    """
    along, across, up = tip_motion(record, effects, values, stretches)
    load = 1.0 + up / values.get("rig.press", np.inf)
    pads = [e for e in effects if not e.name.startswith(CONTACT)]
    contact = [e for e in effects if e.name.startswith(CONTACT)]
    for core in (core_of(pads), core_of(contact)):
        if core is not None and core.friction_state.name != "coulomb":
            raise InputError(
                f"model.effects: '{core.name}' cannot be used where position_y is recorded; the core of a plane is "
                "'coulomb'"
            )
    pad_level = np.zeros(record.size)
    if core_of(pads) is not None:
        pad_level = pad_level + friction_level(record, pads, values)
    level, extra = contact_level(record, contact, values, along, load)
    push = extra - axis_force(record, pads, values)
    stiffness, guide, mass = values["rig.contact_stiffness"], values["rig.guide_stiffness"], values["rig.mass"]
    x, y = follow_plane(
        along, across, push, load, level, stiffness, values["rig.contact_damping"], pad_level,
        values.get("viscous.coefficient", 0.0), guide, mass, record.step,
    )  # fmt: skip
    turn = values["rig.turn"]
    cosine, sine = np.cos(turn), np.sin(turn)
    return {"position": cosine * x - sine * y, TRANSVERSE: sine * x + cosine * y}


def _follow(
    record: FrictionDriveRecord, effects: Sequence[Effect], values: Values, along: np.ndarray, load: np.ndarray
) -> np.ndarray:
    """Position of the stage (n,), m, from its rest at the first row, for a tip `along` the axis under a `load`."""
    pads = [e for e in effects if not e.name.startswith(CONTACT)]
    contact = [e for e in effects if e.name.startswith(CONTACT)]
    pad_core, contact_core = core_of(pads), core_of(contact)
    stiffness, damping, mass = values["rig.contact_stiffness"], values["rig.contact_damping"], values["rig.mass"]
    if all(core is None or core.friction_state.name == "coulomb" for core in (pad_core, contact_core)):
        top = TOP * (float(np.max(np.abs(np.diff(along)))) / record.step + float(np.max(np.abs(record.axis.velocity))))
        level, share, contact_push, contact_curves = slipping_contact(record, contact, values, along, load, top)

        def followed(seen: FrictionDriveRecord) -> np.ndarray:
            pad_level, pad_share, pad_push, pad_curves = pads_friction(seen, pads, values, top)
            return follow_exactly(
                along, contact_push + pad_push, load, level, stiffness, damping, pad_level, mass, record.step,
                contact_curves, share, pad_curves, pad_share,
                record.measured["position"] - record.measured["position"][0], record.nudging_gain,
            )  # fmt: skip

        moved = followed(record)
        if record.nudging_gain > 0.0 or not ages_at_rest(pads):
            return moved
        return followed(replace(record, axis=as_it_moved(record.axis, moved, record.step), memo={}))
    pad_level = np.zeros(record.size)
    if pad_core is not None:
        pad_level = pad_level + friction_level(record, pads, values)
    level, extra = contact_level(record, contact, values, along, load)
    push = extra - axis_force(record, pads, values)
    pad_reach, pad_weights = bristles_of(pad_core, values)
    reach, weights = bristles_of(contact_core, values)
    return follow(
        along, push, np.where(load > 0.0, level, 0.0), reach, weights, stiffness, damping, pad_level, pad_reach,
        pad_weights, mass, record.step,
    )  # fmt: skip


def leading_segment(record: FrictionDriveRecord, rows: int) -> FrictionDriveRecord:
    """The first rows of a record, all of a shorter one, along its axis alone."""
    if record.size <= rows and TRANSVERSE not in record.measured:
        return record
    rows = min(rows, record.size)
    return replace(
        record, axis=Axis(*[values[:rows] for values in record.axis]), drives=[u[:rows] for u in record.drives],
        measured={"position": record.measured["position"][:rows]}, valid={"position": record.valid["position"][:rows]},
        complementary_filter=GaussianFilter(0.0, record.step, rows), memo={},
    )  # fmt: skip


def with_voltages(record: FrictionDriveRecord, name: str, step: float, drives: list[np.ndarray]) -> FrictionDriveRecord:
    """A record as if the rig had been given other voltages, its stage following the tip; V, each (n,)."""
    n = drives[0].size
    time = np.arange(n) * step
    follows = -record.lever * (drives[1] - drives[0])
    axis = make_axis(
        time, follows, np.gradient(follows, step), np.zeros(n), np.full(n, np.mean(record.axis.load)),
        np.full(n, np.mean(record.axis.temperature)), 1e-9,
    )  # fmt: skip
    return replace(
        record, name=name, step=step, axis=axis, drives=drives, memo={}, complementary_filter=GaussianFilter(0.0, step,
        n), measured={"position": np.zeros(n)}, valid={"position": np.arange(n) >= 1},
    )  # fmt: skip
