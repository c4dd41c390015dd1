"""Prediction of a force-balance record by a model, in the measured channels.

Initial state of a friction state model, from the force in the first rows of a record.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.optimize import root_scalar

from sim.effects.effect import Axis, Effect
from sim.integration.simulate import Simulation
from sim.numerics.elasto_plastic import Elements, contact_across_gap, position_behind_gap, springs_of
from sysid.prediction import sensors
from sysid.prediction.effect_terms import (
    Values,
    axis_force,
    friction_axis,
    friction_level,
    lost_motion,
    split_channel,
    values_of,
)
from sysid.prediction.force_balance import reversals
from sysid.prediction.force_balance.record import ForceBalanceRecord, make_axis
from sysid.prediction.force_balance.state_observer import at_rows, observed_motion
from sysid.prediction.force_balance.stick_phases import (
    FULLY_AT_REST,
    STICK_DISPLACEMENT,
    bristles_of,
    median_level,
    presliding_displacement,
)


def predict_balance(
    balance: ForceBalanceRecord, effects: Sequence[Effect], values: Values, at: Mapping[str, np.ndarray] | None = None
) -> dict[str, np.ndarray]:
    """Predicted channels (n,) of a force balance, filtered as the measured ones are."""
    # Effects on the filtered channels make a sample depend on others.
    if at is None or any(effect.acts_on in ("drive", "sensor") and not effect.rounds for effect in effects):
        every = _sensed_balance(balance, effects, values)
        return every if at is None else {channel: found[at[channel]] for channel, found in every.items()}
    channel = balance.force_channel
    out = {channel: _total_at(balance, effects, values, at[channel])}
    if channel == "position":
        out[channel] = balance.inputs["pull_position"][at[channel]] - out[channel] / values["rig.pull_stiffness"]
    if _has_stretch(balance):
        out["position"] = _stretch_relation(balance, effects, values, at["position"])
    if balance.stick_phases is not None:
        out[STICK_DISPLACEMENT] = _stick_displacement(balance, effects, values)[at[STICK_DISPLACEMENT]]
    return out


def unfiltered_force(balance: ForceBalanceRecord, effects: Sequence[Effect], values: Values) -> np.ndarray:
    """Force (n,) against the motion of a driven mass without its inertia, N, unfiltered."""
    friction, resolved_friction = _friction(balance, effects, values)
    return friction if resolved_friction is None else friction + resolved_friction


def _has_stretch(balance: ForceBalanceRecord) -> bool:
    return "position" in balance.measured and balance.force_channel == "spring_force"


def _level(balance: ForceBalanceRecord, effects: Sequence[Effect], values: Values) -> np.ndarray:
    """Level (n,) of the friction, N."""
    return np.broadcast_to(friction_level(balance, effects, values), (balance.size,))


def friction_along(
    motion: Simulation, balance: ForceBalanceRecord, effects: Sequence[Effect], values: Values
) -> np.ndarray:
    """Friction (n,) along an observer's motion, N: elements yield smoothly in its integration, but ideally along it."""
    if not any(e.has_presliding and e.friction_state.springs is not None for e in effects):
        return at_rows(motion.friction)
    own, step = balance.axis, float(motion.time[1] - motion.time[0])

    def between(values: np.ndarray) -> np.ndarray:
        return np.interp(motion.time, own.time, values)

    acceleration = np.gradient(motion.velocity, step)
    surroundings = between(own.load), between(own.temperature)
    along = replace(
        balance,
        step=step,
        axis=make_axis(motion.time, motion.position, motion.velocity, acceleration, *surroundings, 0.0),
        measured={channel: between(values) for channel, values in balance.measured.items()},
        inputs={channel: between(values) for channel, values in balance.inputs.items()},
        valid={channel: between(valid) == 1.0 for channel, valid in balance.valid.items()},
        acceleration=None if balance.acceleration is None else between(balance.acceleration),
        undirected=None,
        observer=None,
        stick_fraction=None,
    )
    friction, _ = _friction(along, effects, values)
    return at_rows(0.5 * (friction[1:] + friction[:-1]))


def _friction(
    balance: ForceBalanceRecord, effects: Sequence[Effect], values: Values
) -> tuple[np.ndarray, np.ndarray | None]:
    """Force against the motion (n,) for the filter `complementary_filter`, and the event-resolved part of it for the
    filter `full_filter`, N."""
    if balance.observer is not None and effects:
        motion = observed_motion(balance, effects, values)
        return np.zeros(balance.size), friction_along(motion, balance, effects, values)
    core = next((e for e in effects if e.friction_state is not None), None)
    level, forces = _level(balance, effects, values), axis_force(balance, effects, values)
    axis, _ = friction_axis(balance, effects, values)
    if core is None:
        return forces, None
    if core.has_presliding or balance.stick_fraction is None:
        p = values_of(core, values)
        usual = median_level(level) if core.has_presliding else 0.0
        # The level of the law, not the median along the record: the same for each part of a record.
        declared = float(getattr(p, "force", usual))
        unseen = unobservable_part(balance, core, declared, p, values.get("rig.mass", 0.0))
        if core.friction_state.rigid:
            p = p._replace(stretch=balance.stretch)
        gap = lost_motion(effects, values) if balance.acceleration is None else 0.0
        touches = np.ones(1)
        if gap > 0.0:
            axis, touches = _across_gap(balance, core, axis, level, forces, gap, p)
            # A sensor shows its offset in the gap too, but no force on the body behind it.
            offset = axis_force(balance, [effect for effect in effects if not effect.coordinates], values)
            forces = offset + touches * (forces - offset)
        inertia = 0.0 if balance.acceleration is None else values.get("rig.mass", 0.0) * balance.acceleration
        held = friction_from_initial_state(balance, core, axis, level, p, forces + inertia)
        if core.friction_state.rigid and balance.velocity_sign is not None and axis.position is balance.axis.position:
            # Position differences have the sign of a mean over the step, the given velocity that at its end.
            # At rest the force stays that of the stop, though the level of an aged contact rises.
            most = level if balance.stop_row is None else np.minimum(level, level[balance.stop_row])
            held = np.where(balance.velocity_sign != 0.0, balance.velocity_sign * most, held)
        held = held * touches if core.friction_state.rigid and gap > 0.0 else held
        if unseen > LEAST_UNOBSERVABLE:
            resolved_friction = _event_resolved(balance, effects, values, forces, level, usual, core)
            part = unseen
            if balance.stick_phases is not None and balance.stick_fraction is not None:
                # The presliding displacement of the body at rest is scored from rest to rest.
                part = np.where(
                    balance.stick_fraction > FULLY_AT_REST, min(1.0, unseen / DISPLACEMENT_SUFFICES), unseen
                )
            return forces + (1.0 - part) * held, part * resolved_friction
        return forces + held, None
    resolved_friction = _event_resolved(balance, effects, values, forces, level, 0.0, core)
    return forces, resolved_friction


def _across_gap(
    balance: ForceBalanceRecord, core: Effect, axis: Axis, level: np.ndarray, forces: np.ndarray, gap: float, p: Any
) -> tuple[Axis, np.ndarray]:
    """The axis along which a friction core acts behind a gap of full width `gap`, m, and whether the sides touch (n,),
    0 to 1. A force on the body that exceeds its friction level keeps it in contact."""
    position, crossed = balance.axis.position, _initially_crossed(balance, level, forces, gap)
    if core.friction_state is not None and core.friction_state.rigid:
        axis, direction = balance.axis, balance.axis.direction
        sign = direction if balance.velocity_sign is None else balance.velocity_sign
        touches = contact_across_gap(position, sign, gap, crossed)
    else:
        elements = _unloading_elements(core, float(np.median(level)), p)
        axis = axis._replace(position=position_behind_gap(position, level, elements, gap, crossed))
        moved, driven = (np.diff(x, prepend=x[0]) for x in (axis.position, position))
        touches = np.divide(moved, driven, np.ones(moved.size), where=driven != 0.0)
    return axis, np.where(np.abs(forces) > level, 1.0, touches)


def _unloading_elements(core: Effect, level: float, p: Any) -> Elements:
    """Elements that a displacement after a reversal unloads as it does a friction core at a friction level, N."""
    model = core.friction_state
    assert model is not None
    if model.springs is not None:
        return model.springs(p)
    back = np.linspace(0.0, 2.0 * _stretch_of(core, level, p), 401)
    position = np.concatenate([np.linspace(-20.0 * back[-1], 0.0, 8001), -back[1:]])
    velocity, time = np.gradient(position), np.arange(position.size, dtype=float)
    force = model.along_record(position, velocity, time, np.full(position.size, level), p)[-back.size :]
    stretch = float(np.interp(0.0, -force, back))
    return Elements(np.array([max(stretch, 1e-300)]), np.ones(1), level)


def _initially_crossed(balance: ForceBalanceRecord, level: np.ndarray, forces: np.ndarray, gap: float) -> float:
    """Part of a gap of full width `gap` that is crossed as a record begins, m; NaN where it begins in contact: the
    contact closes where the measured friction first exceeds half of its level."""
    friction = balance.measured[balance.force_channel] - forces
    closed = balance.valid[balance.force_channel] & (np.abs(friction) > 0.5 * level)
    first = int(np.argmax(closed))
    rows = np.abs(friction[first_rows(balance)])
    if not closed.any() or not rows.size or float(np.median(rows)) > 0.5 * float(np.median(level)):
        return np.nan
    moved = float(balance.axis.position[first] - balance.axis.position[0])
    return min(max(gap - moved if friction[first] > 0.0 else -moved, 0.0), gap)


LEAST_UNOBSERVABLE = 0.02
"""Part of a bristle's force below which it is not taken from the force balance."""

DISPLACEMENT_SUFFICES = 0.25
"""Part from which the displacements while sticking determine the bristles better than the force."""


def _stretch_of(core: Effect, usual: float, p: Any) -> float:
    """Displacement at which the bristles of a core slip, m, at the level that is usual."""
    if hasattr(p, "stretch"):
        return float(p.stretch)
    assert core.friction_state is not None
    return usual / max(float(p.stiffness), 1e-300) if hasattr(p, "stiffness") else float(core.friction_state.scale(p))


EVENT_ERROR = 0.01
"""Error of event-resolved friction over the friction level, of a LuGre axis against its exact motion."""

BLUR = 0.027
"""Error of the friction along a filtered motion, of the same axis, over the level and the cube of the phase by which
the mass oscillates on its bristles in the width of the filter."""


def unobservable_part(balance: ForceBalanceRecord, core: Effect, usual: float, p: Any, mass: float) -> float:
    """Part of a bristle's force, 0 to 1, that is taken from the force balance since the motion does not show it.

    Bristles of stiffness k are known along the motion to the noise k s_x and the blur by the filter; from the balance
    to the noise s_F and the error of its events. The two are weighted by their variances. The blur is at most what the
    filter takes from the measured motion: bristles that stretch by more are seen.
    """
    if balance.stick_fraction is None or not core.has_presliding:
        return 0.0
    own = balance.noise[balance.force_channel]
    if balance.force_channel == "position":
        own *= balance.pull_stiffness
    stiffness = usual / max(_stretch_of(core, usual, p), 1e-300)
    phase = balance.prefilter_samples * balance.step * float(np.sqrt(stiffness / max(mass, 1e-300)))
    blur = min(BLUR * usual * phase**3, stiffness * balance.largest_blur)
    along = stiffness**2 * balance.prefiltered_noise**2 + blur**2
    return along / (along + own**2 + (EVENT_ERROR * usual) ** 2)


def _event_resolved(
    balance: ForceBalanceRecord,
    effects: Sequence[Effect],
    values: Values,
    forces: np.ndarray,
    level: np.ndarray,
    usual: float,
    core: Effect,
) -> np.ndarray:
    """Event-resolved friction (n,) of a driven mass, N: by the sign of its motion and, while sticking, by the push."""
    # While sticking, Coulomb friction balances the push, up to the level; it does not follow from the motion.
    assert balance.direction is not None and balance.stick_fraction is not None and balance.slip_phases is not None
    assert core.friction_state is not None
    push, mass = _as_driven(balance, effects, values) - forces, values.get("rig.mass", 0.0)
    if core.friction_state.sliding is not None:
        # At rest the speed is noise.
        sliding = core.friction_state.sliding(level, balance.axis.velocity, values_of(core, values))
        level = np.where(balance.stick_fraction > 0.0, level, sliding)
    level = np.ascontiguousarray(level, dtype=float)
    phases, search = balance.slip_phases, MOST_SHIFT * balance.prefilter_samples + 2.0
    forces_on_mass = reversals.Forces(push, level)
    velocity, width = balance.axis.velocity, balance.prefilter_samples
    onsets = reversals.sticking_onsets(phases, velocity, forces_on_mass, balance.step / mass, width, search)
    leaves = reversals.break_away_times(phases, forces_on_mass, search)
    motion = reversals.shifted_events(balance.direction, balance.stick_fraction, phases, onsets, leaves)
    p, scale = values_of(core, values), balance.step**2 / mass
    friction = reversals.event_resolved_friction(motion, forces_on_mass, _stretch_of(core, usual, p), scale)
    sticks, following = ~phases.reverses, phases.next_direction
    reversals.write_sharp_steps(friction, forces_on_mass, onsets, phases.direction, np.where(sticks, 0.0, following))
    reversals.write_sharp_steps(friction, forces_on_mass, leaves[sticks], np.zeros(np.sum(sticks)), following[sticks])
    if core.has_presliding:
        bristles = bristles_of(core.friction_state, p, max(usual, 1e-12), OSCILLATION_SPRINGS)
        substeps = reversals.substeps_of(bristles, scale)
        if substeps:
            shown = 3.0 * float(np.max(bristles.stretches)) + 8.0 * balance.prefiltered_noise
            slip = reversals.Slip(motion.direction, balance.axis.position, shown)
            reversals.write_presliding_friction(
                friction, onsets, phases.direction, slip, forces_on_mass, springs_of(bristles), scale, substeps
            )
    return friction


OSCILLATION_SPRINGS = 8
"""Springs that approximate a friction state model without a yield point where a mass oscillates on it."""

MOST_SHIFT = 2.5
"""Widths of the prefilter by which the momentum may shift a sticking onset."""


def _stick_displacement(balance: ForceBalanceRecord, effects: Sequence[Effect], values: Values) -> np.ndarray:
    """Displacement (n,) in each stick phase from its mean, as the position sensor measures it, m."""
    stick_phases = balance.stick_phases
    core = next((e for e in effects if e.friction_state is not None), None)
    assert stick_phases is not None
    moved = np.zeros(balance.size)
    if core is None:
        # Without a friction model nothing is predicted, and the residual is zero.
        moved = stick_phases.displacement
    elif core.has_presliding:
        friction, level = stick_phases.force - axis_force(balance, effects, values), _level(balance, effects, values)
        moved = presliding_displacement(stick_phases, friction, level, core.friction_state, values_of(core, values))
    if stick_phases.compliance:
        # The position was computed from the force and the known stiffness.
        moved = moved + (1.0 / values["rig.pull_stiffness"] - stick_phases.compliance) * stick_phases.centred(
            stick_phases.force
        )
    seen_by = "spring_force" if stick_phases.compliance else "position"
    seen = np.ascontiguousarray(stick_phases.force if stick_phases.compliance else balance.axis.position)
    for effect in effects:
        if effect.acts_on != "sensor" or split_channel(effect.name)[1] not in (None, seen_by) or effect.rounds:
            continue
        p = values_of(effect, values)
        if effect.inverse is not None and not stick_phases.compliance:
            moved = moved + stick_phases.centred(seen - effect.inverse(seen, balance.step, p))
        elif effect.signal is not None:
            more = stick_phases.centred(effect.signal(seen, balance.step, p) - seen)
            moved = moved - stick_phases.compliance * more if stick_phases.compliance else moved + more
    return moved


def _total_at(balance: ForceBalanceRecord, effects: Sequence[Effect], values: Values, index: np.ndarray) -> np.ndarray:
    """Force (k,) that the motion requires at some samples, N, filtered."""
    friction, resolved_friction = _friction(balance, effects, values)
    total = balance.complementary_filter.at(friction, index)
    if resolved_friction is not None:
        assert balance.full_filter is not None
        total = total + balance.full_filter.at(resolved_friction, index)
    return total if balance.acceleration is None else total + values.get("rig.mass", 0.0) * balance.acceleration[index]


def _sensed_balance(balance: ForceBalanceRecord, effects: Sequence[Effect], values: Values) -> dict[str, np.ndarray]:
    """Every channel (n,), with the effects of drive, structure and sensors."""
    total = _total_at(balance, effects, values, np.arange(balance.size))
    out: dict[str, np.ndarray] = {}
    channel = balance.force_channel
    if channel == "position":
        pull = sensors.delayed_like_motion(balance, effects, values, balance.inputs["pull_position"])
        out["position"] = pull - total / values["rig.pull_stiffness"]
        effects = [effect for effect in effects if not sensors.delays_motion(balance, effect)]
    else:
        out[channel] = _before_delay(balance, effects, values, total)
    if _has_stretch(balance):
        out["position"] = _stretch_relation(balance, effects, values)
    out = sensors.sensed(effects, values, out, balance.step)
    if balance.stick_phases is not None:
        out[STICK_DISPLACEMENT] = _stick_displacement(balance, effects, values)
    return out


def _before_delay(
    balance: ForceBalanceRecord, effects: Sequence[Effect], values: Values, total: np.ndarray
) -> np.ndarray:
    """The force (n,) to be compared with the logged one where the motion is logged late.

    A delay is inverted; a lag acts on the logged force, since its inverse amplifies the noise of the motion, and the
    residual is divided by what the lag keeps of the force: in a long one the signal to be explained vanishes.
    """
    if balance.acceleration is None:
        return total
    total = sensors.ahead_of_motion(balance, effects, values, total)
    given, late = _given_and_late(balance, effects, values)
    if late is given:
        return total
    assert balance.full_filter is not None
    logged, lagged = balance.full_filter(given), balance.full_filter(late)
    return logged - (lagged - total) / sensors.kept_by_lag(given, late)


RINGING = 2000
"""Samples over which the response of a mode or a lag to the noise of one sample is followed."""


def residual_noise(balance: ForceBalanceRecord, effects: Sequence[Effect], values: Values) -> float:
    """Standard deviation of the force channel's residual: the acceleration's noise passes the modes of the model, which
    part of the mass does not follow, and the force's noise passes its delays. A balance scored in the position delays
    the pull instead."""
    noise, of_force = balance.noise[balance.force_channel], balance.force_channel != "position"
    modes = [effect for effect in effects if effect.is_mode]
    delays = any(sensors.delays_motion(balance, effect) for effect in effects)
    if balance.full_filter is None or not of_force or not (delays or modes):
        return noise
    kernels = balance.full_filter.kernel(2), balance.full_filter.kernel(0)
    taken, given = (np.pad(kernel, (kernel.size, kernel.size + RINGING)) for kernel in kernels)
    for effect in modes:
        p = values_of(effect, values)
        assert effect.signal is not None
        taken = taken + getattr(p, "mass_ratio", 1.0) * (effect.signal(taken, balance.step, p) - taken)
    taken = sensors.ahead_of_motion(balance, effects, values, taken)
    late = sensors.delayed_like_motion(balance, effects, values, given, lags=True)
    passed = [float(np.linalg.norm(one) / np.linalg.norm(k)) for one, k in zip((taken, late), kernels, strict=True)]
    moved = min(values.get("rig.mass", 0.0) * balance.acceleration_noise, noise)
    kept = sensors.kept_by_lag(*_given_and_late(balance, effects, values)) if delays else 1.0
    return float(np.hypot(moved * passed[0], np.sqrt(noise**2 - moved**2) * passed[1])) / kept


def _given_and_late(
    balance: ForceBalanceRecord, effects: Sequence[Effect], values: Values, lags: bool = True
) -> tuple[np.ndarray, np.ndarray]:
    """The applied force (n,) as it was logged, before its sensor, and after the lags, or all delays, of the motion."""
    assert balance.applied is not None
    given = balance.applied * sensors.scale_ratio(values, balance.force_channel)
    if balance.force_channel == "spring_force":
        given = sensors.sensor_input(given, "spring_force", effects, values, balance.step)
    return given, sensors.delayed_like_motion(balance, effects, values, given, lags)


def _as_driven(balance: ForceBalanceRecord, effects: Sequence[Effect], values: Values) -> np.ndarray:
    """The applied force (n,) at the time of the logged motion, which friction balances while sticking; of a pulling
    spring, before its sensor."""
    assert balance.applied is not None
    if balance.force_channel != "position":
        return _given_and_late(balance, effects, values, lags=False)[1]
    # The force is the spring's: stiffness times (pull - position), with the position that the sensor was given.
    logged, pull = np.ascontiguousarray(balance.axis.position), balance.inputs["pull_position"]
    unbent = sensors.sensor_input(logged, "position", effects, values, balance.step, late=False)
    late = sensors.delayed_like_motion(balance, effects, values, pull)
    return balance.applied + balance.pull_stiffness * (logged - unbent + late - pull)


def _stretch_relation(
    balance: ForceBalanceRecord, effects: Sequence[Effect], values: Values, index: np.ndarray | None = None
) -> np.ndarray:
    """Position that the force of the pulling spring and a dashpot beside it implies, pull - (force - damping * rate of
    the stretch) / stiffness, at samples (k,) or all (n,)."""
    stiffness, damping = values["rig.pull_stiffness"], values.get("rig.pull_damping", 0.0)
    every = slice(None) if index is None else index
    force, pull = balance.inputs["spring_force"], balance.inputs["pull_position"]
    force = sensors.sensor_input(force, "spring_force", effects, values, balance.step)
    if damping:
        force = force - damping * np.gradient(pull - balance.measured["position"], balance.step)
    force, pull = force[every], pull[every]
    stretch = force / stiffness
    # The gap is open on the side the spring pulls from; without force it is where the measured position has it.
    slight, half = 3.0 * balance.noise["spring_force"], 0.5 * lost_motion(effects, values)
    low, high = np.where(force >= slight, half, -half), np.where(force <= -slight, -half, half)
    return pull - stretch - np.clip(pull - stretch - balance.measured["position"][every], low, high)


FIRST_ROWS = 50
"""Rows, filter widths apart, over which the first force is averaged where the record does not begin at rest."""

MOST_ROWS = 400
"""Largest number of rows up to the end of those, as their path is evaluated at every step of the search."""

ACCURACY = 1e-8
"""Relative accuracy of the preceding motion: its error is far below the steps of numerical derivatives."""


def first_rows(balance: ForceBalanceRecord) -> slice:
    """Rows in which the first force is measured: an initial rest, or the first scored rows."""
    begin = int(np.argmax(balance.valid[balance.force_channel]))
    if balance.undirected is not None:
        # A rest before the first scored row shows the force with which the motion begins.
        others = np.flatnonzero(~balance.undirected[:begin])
        begin = int(others[-1]) + 1 if others.size else 0
    position = balance.axis.position[begin : begin + MOST_ROWS]
    moved = np.abs(position - position[0]) > balance.stretch
    rest = int(np.argmax(moved)) if moved.any() else position.size
    apart = 1 if balance.full_filter is None else int(np.ceil(balance.full_filter.width / balance.step))
    return slice(begin, min(begin + max(rest, FIRST_ROWS * apart), balance.size, MOST_ROWS))


LONGEST_BEFORE = 1e6
"""Longest time of each part of the motion before a record, s."""


def friction_from_initial_state(
    balance: ForceBalanceRecord, core: Effect, axis: Axis, level: np.ndarray, p: Any, other: np.ndarray
) -> np.ndarray:
    """Force of a friction state model along a record (n,), N, from its initial state.

    The state follows from the force measured in the first rows. A motion that leads to it is put before the record: in
    one direction until everything slips, beyond the initial position, and back to it.
    """
    assert core.friction_state is not None
    along, rows = core.friction_state.along_record, first_rows(balance)
    if rows.stop <= rows.start:
        return along(axis.position, axis.velocity, axis.time, level, p)
    measured = balance.inputs.get("spring_force", balance.measured[balance.force_channel])
    wanted = measured[rows] - other[rows]

    side = 1.0 if _median(wanted) >= 0.0 else -1.0
    far = 1e3 * max(float(np.ptp(axis.position)), 1e-9)
    # At the highest speed of the record: bristles whose damping limits their slip need the time, and contacts age.
    speed = max(float(np.max(np.abs(axis.velocity))), far / LONGEST_BEFORE)

    def with_motion(size: int) -> Callable[[float], np.ndarray]:
        """Force (size,) in the first rows, by the distance of the preceding motion beyond the start, m."""
        count = 3
        position = np.concatenate([np.full(count, axis.position[0]), axis.position[:size]])
        velocity = np.concatenate([np.zeros(count), axis.velocity[:size]])
        time = np.concatenate([np.zeros(count), axis.time[:size]])
        levels = np.concatenate([np.full(count, level[0]), level[:size]])
        begin, before = float(position[count]), float(time[count]) - balance.step

        def force(beyond: float) -> np.ndarray:
            position[:count] = begin - side * far, begin + side * beyond, begin
            there, back = balance.step + (far + beyond) / speed, balance.step + beyond / speed
            time[:count] = before - there - back, before - back, before
            outward, inward = side * (far + beyond) / there, -side * beyond / back
            velocity[:count] = outward, (outward * back + inward * there) / (there + back), inward
            return along(position, velocity, time, levels, p)[count:]

        return force

    first = with_motion(rows.stop)

    def excess(logarithm: float) -> float:
        """Median force above the measured one; it falls as the reversal lies further beyond the initial position."""
        return _median(side * (first(math.exp(logarithm))[rows] - wanted))

    low, high = math.log(1e-9 * far), math.log(far)
    beyond = 0.0
    if _median(side * (first(0.0)[rows] - wanted)) > 0.0:
        if excess(low) <= 0.0:
            beyond = math.exp(low)
        elif excess(high) > 0.0:
            beyond = far
        else:
            beyond = math.exp(root_scalar(excess, bracket=(low, high), xtol=ACCURACY).root)
    return with_motion(axis.time.size)(beyond)


def _median(values: np.ndarray) -> float:
    """Median of finite values (n,): as `numpy.median`, which takes ten times as long for so few."""
    low, high = (values.size - 1) // 2, values.size // 2
    found = np.partition(values, (low, high))
    return 0.5 * float(found[low] + found[high])
