"""The compiled steps of the driven stage; `simulation.py` runs them.

The steps are compiled once for every machine. Positions are kept at full steps, those of the bending modes half-way
between, where forces are evaluated (drift, kick, drift: Verlet's method, second order, without drift of the energy).
Rates that a force depends on are extrapolated half a step by the last acceleration.

Stage, six degrees of freedom about its centre of mass, small turns about x and y and free turn about z.
Its bending modes add to its height: w = z + y turn_x - x turn_y + sum phi_m(x, y) eta_m, eta_m'' = phi_m F - ...
Tip, five: height z of its axis in the piezos' plane, slopes a, b of its axis towards x and y, sway (s_x, s_y) of the
plane on the bending stacks:

    apex = (s_x + h a, s_y + h b, z)      stretch at piezo i = z - p_i . (a, b)

The force of the contact is normal to the drive surface as it is tilted and bent.

Contacts (pads, tips): N = K delta^1.5 (1 + damping delta'), none in the gap. Tangentially Iwan elements
(`slip_elements.py`). Their stiffness goes with the load; an element keeps its force when load is added, and loses force
in proportion when load is removed, so that no energy is created (Thornton, Cummins, Cleary, Powder Technol. 233
(2013) 30).

This module imports numba: import it only when something is simulated.
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from sim.integration.compiled.views import OverViews
from sim.numerics.compilation import INLINED, SUMS_IN_ANY_ORDER, compile_function
from sim.stage import constants as constants_module
from sim.stage import machine as machine_module
from sim.stage import slip_elements
from sim.stage import state as state_module
from sim.stage.state import TIP_FREEDOMS

HEAD, PER_ACTUATOR, PER_PAD = 18, 13, 5
"""Columns of a row: time, position (6), velocity (6), energy and works (5); then of each actuator, of each pad."""
# Not Python's integers: numba compiles a function once more for each of those that it is called with.
X, Y = np.int64(0), np.int64(1)
SHAPES_EVERY = 16
"""Steps between two evaluations of the bending modes above a tip, which slides some micrometres in that time; between
them a mode is a plane there."""
CREEP_EVERY = 128
"""Steps between two updates of the creep, whose shortest time constant is 0.1 s."""


class Loads(NamedTuple):
    """Forces of one step, N and N m, written in place."""

    # force, torque: on the stage, (3,)
    force: np.ndarray
    torque: np.ndarray
    mean: np.ndarray  # velocity at the middle of the step, (6,)
    tip_force: np.ndarray  # of each tip on the stage, (actuators, 3)
    pad_force: np.ndarray  # of each pad on the stage, (pads, 3)
    apex: np.ndarray  # of each tip from mid-stroke, m, (actuators, 3)
    energy: np.ndarray  # kinetic and potential energy, J, (1,); complete in the steps that write a row
    bend: np.ndarray  # on the bending modes, N kg^-1/2, (modes,)


_SOURCES = [str(module.__file__) for module in (constants_module, machine_module, state_module)]
"""Files with the types of what the kernel receives."""
_KERNELS: Any = state_module.advance_modes, state_module.surface, slip_elements.slip
_bend, _surface, _slip = (function.kernel() for function in _KERNELS)


def _inlined(function: Callable[..., Any]) -> Any:
    return compile_function(function, _SOURCES, **{**INLINED, "fastmath": SUMS_IN_ANY_ORDER})


@_inlined
def _stretch_piezo(c, voltage, play, creep, creep_step):
    """Free stretch of one stack at `voltage` from mid-stroke, m; updates its play operators, and its creep by
    `creep_step`, s."""
    u = voltage
    for i in range(play.shape[0]):
        out = min(max(play[i], voltage - c.response.thresholds[i]), voltage + c.response.thresholds[i])
        play[i] = out
        u += c.response.strength * c.response.weights[i] * (out - voltage)
    u -= c.piezo.bias
    slow = 0.0
    for i in range(creep.shape[0]):
        if creep_step > 0.0:
            creep[i] += (u - creep[i]) * (1.0 - math.exp(-c.response.creep_rates[i] * creep_step))
        slow += c.response.creep_weights[i] * creep[i]
    return c.response.gain * (u + slow)


@_inlined
def _add_force(force_at, contact, loads):
    """Add a contact's force on the stage at a place (x, y, z) from the centre of mass."""
    x, y, z = force_at
    fx, fy, load = contact
    loads.force[0] += fx
    loads.force[1] += fy
    loads.force[2] += load
    loads.torque[0] += y * load - z * fy
    loads.torque[1] += z * fx - x * load
    loads.torque[2] += x * fy - y * fx


@_inlined
def _weight_and_guides(c, q, yaw, writes, loads):
    """Weight, preload and the guiding tooth irons."""
    force, torque = loads.force, loads.torque
    energy = 0.0
    force[0], force[1] = 0.0, 0.0
    force[2] = -c.weight - c.preload
    cosine, sine = yaw
    px = cosine * c.preload_at[0] - sine * c.preload_at[1]
    py = sine * c.preload_at[0] + cosine * c.preload_at[1]
    torque[0], torque[1], torque[2] = -py * c.preload, px * c.preload, 0.0
    if writes:
        energy += c.weight * q[2] + c.preload * (q[2] + q[3] * py - q[4] * px)
    for k in range(c.guide_at.shape[0]):
        gx = cosine * c.guide_at[k, 0] - sine * c.guide_at[k, 1]
        gy = sine * c.guide_at[k, 0] + cosine * c.guide_at[k, 1]
        gz = c.guide_at[k, 2]
        away = q[1] + gy - c.guide_at[k, 1] - q[3] * gz
        pull = -c.guide_stiffness * away
        force[1] += pull
        torque[0] -= gz * pull
        torque[2] += gx * pull - c.guide_yaw * q[5]
        if writes:
            energy += 0.5 * c.guide_stiffness * away * away + 0.5 * c.guide_yaw * q[5] * q[5]
    loads.energy[0] = energy
    for m in range(c.bend_rates.shape[0]):
        loads.bend[m] = -c.bend_preload[m]


@_inlined
def _pad(c, s, k, yaw, writes, loads):
    """Contact of pad `k` with its way; `yaw`: cosine and sine of the turn about z."""
    q, v, a = s.position, s.velocity, s.acceleration
    h, half = c.step, 0.5 * c.step
    cosine, sine = yaw
    x = cosine * c.pad_at[k, 0] - sine * c.pad_at[k, 1]
    y = sine * c.pad_at[k, 0] + cosine * c.pad_at[k, 1]
    z = c.pad_at[k, 2]
    deep = -(q[2] + q[3] * y - q[4] * x)
    rising = v[2] + v[3] * y - v[4] * x + half * (a[2] + a[3] * y - a[4] * x)
    shape = c.bend_at_pads[k]
    for m in range(shape.shape[0]):
        deep -= shape[m] * s.bend[m]
        rising += shape[m] * s.bend_speed[m]
    load, tangent, mu = 0.0, 0.0, 0.0
    vx = v[0] + v[4] * z - v[5] * y
    vy = v[1] + v[5] * x - v[3] * z
    if deep > 0.0:
        rate = -rising
        spring = c.pads.contact_rate * deep * math.sqrt(deep)
        load = max(spring * (1.0 + c.pads.damping * rate), 0.0)
        s.totals[3] += (load - spring) * rate * h
        tangent = c.pad_bristle * load
        speed = (vx * vx + vy * vy) / (c.pads.stribeck_velocity * c.pads.stribeck_velocity)
        mu = c.pads.dynamic_friction + (c.pads.static_friction - c.pads.dynamic_friction) * math.exp(-speed)
        if writes:
            loads.energy[0] += 0.4 * spring * deep
        s.pad_totals[k, 1] += math.sqrt(vx * vx + vy * vy) * h
        for m in range(shape.shape[0]):
            loads.bend[m] += shape[m] * load
    else:
        s.pad_totals[k, 0] += h
    stiffness, shares = (s.pad_tangent[k], tangent), (c.pad_stiffness_shares, c.pad_cap_shares)
    way, lag = (vx * h, vy * h), c.pads.tangential_lag / h
    fx, fy, heat, kept = _slip(s.pad_force[k], stiffness, s.pad_stored[k], mu * load, shares, way, lag)
    s.pad_tangent[k], s.pad_stored[k] = tangent, kept
    s.totals[1] += heat
    loads.energy[0] += kept
    # The elements resist the motion of the pad: their force on the stage is opposite.
    loads.pad_force[k, 0], loads.pad_force[k, 1], loads.pad_force[k, 2] = -fx, -fy, load
    _add_force((x, y, z), (-fx, -fy, load), loads)


@_inlined
def _piezos(c, s, k, commands, creep_step, writes, loads):
    """Amplifiers and stacks of actuator `k`: force along z and torques on the tip, N and N m."""
    tip, rate_of, acceleration = s.tip[k], s.tip_velocity[k], s.tip_acceleration[k]
    half = 0.5 * c.step
    follow = 1.0 - math.exp(-c.amplifier_rate * c.step)
    most = c.voltage_rate * c.step
    push, turn_a, turn_b = 0.0, 0.0, 0.0
    for i in range(3):
        change = follow * (commands[k, i] - s.voltage[k, i])
        change = min(max(change, -most), most)
        s.voltage[k, i] = min(max(s.voltage[k, i] + change, 0.0), c.piezo.highest_voltage)
        free = _stretch_piezo(c, s.voltage[k, i], s.play[k, i], s.creep[k, i], creep_step)
        ax, ay = c.tip.piezo_places[i, 0], c.tip.piezo_places[i, 1]
        stretch = tip[0] - ax * tip[1] - ay * tip[2]
        later = half * (acceleration[0] - ax * acceleration[1] - ay * acceleration[2])
        rate = rate_of[0] - ax * rate_of[1] - ay * rate_of[2] + later
        spring = c.tip.stiffness * (free - stretch)
        # Work of the drive on the spring: its force times the change of the free length.
        s.totals[0] += 0.5 * (spring + s.piezo_force[k, i]) * (free - s.stretch[k, i])
        s.totals[3] += c.tip.damping * rate * rate * c.step
        s.stretch[k, i] = free
        s.piezo_force[k, i] = spring
        if writes:
            loads.energy[0] += 0.5 * spring * spring / c.tip.stiffness
        pressed = spring - c.tip.damping * rate
        push += pressed
        turn_a -= ax * pressed
        turn_b -= ay * pressed
    return push, turn_a, turn_b


@_inlined
def _tip_contact(c, s, k, yaw, refresh, writes, loads):
    """Contact of tip `k` with the stage: force on the stage (x, y, z), N."""
    q, v, a = s.position, s.velocity, s.acceleration
    tip, rate_of, h = s.tip[k], s.tip_velocity[k], c.step
    apex = loads.apex[k]
    apex[0], apex[1], apex[2] = tip[3] + c.tip.height * tip[1], tip[4] + c.tip.height * tip[2], tip[0]
    x = c.tip_at[k, 0] - c.centre_start[0] - q[0] + apex[0]
    y = c.tip_at[k, 1] - c.centre_start[1] - q[1] + apex[1]
    z = -c.centre_start[2]
    cosine, sine = yaw
    place = (cosine * x + sine * y + c.centre[0], cosine * y - sine * x + c.centre[1])
    lift, lifting, slope_x, slope_y, dx, dy = _surface(c, s, k, place, refresh)
    # The stage yaws by milliradians: the slopes of its modes are taken along the axes of the base.
    slope_x, slope_y = slope_x - q[4], slope_y + q[3]
    deep = c.apex_rest[k] + tip[0] - (q[2] + q[3] * y - q[4] * x + lift)
    load, tangent = 0.0, 0.0
    slide_x = v[0] + v[4] * z - v[5] * y - rate_of[3] - c.tip.height * rate_of[1]
    slide_y = v[1] + v[5] * x - v[3] * z - rate_of[4] - c.tip.height * rate_of[2]
    if deep > 0.0:
        later = 0.5 * h * (s.tip_acceleration[k, 0] - (a[2] + a[3] * y - a[4] * x))
        rate = rate_of[0] - (v[2] + v[3] * y - v[4] * x) + later - lifting + slope_x * slide_x + slope_y * slide_y
        spring = c.contact.rate * deep * math.sqrt(deep)
        load = max(spring * (1.0 + c.contact.damping * rate), 0.0)
        s.totals[3] += (load - spring) * rate * h
        tangent = c.contact.tangential_ratio * 1.5 * c.contact.rate * math.sqrt(deep)
        for m in range(c.bend_rates.shape[0]):
            shapes = s.tip_shapes[k]
            loads.bend[m] += (shapes[0, m] + shapes[1, m] * dx + shapes[2, m] * dy) * load
        if writes:
            loads.energy[0] += 0.4 * spring * deep
        s.actuator_totals[k, 3] += h
    stiffness, shares = (s.contact_tangent[k], tangent), (c.contact_stiffness_shares, c.contact_cap_shares)
    way, cap = (slide_x * h, slide_y * h), c.contact.friction * load
    fx, fy, heat, kept = _slip(s.contact_force[k], stiffness, s.contact_stored[k], cap, shares, way, 0.0)
    s.contact_tangent[k], s.contact_stored[k] = tangent, kept
    s.totals[2] += heat
    loads.energy[0] += kept
    fx, fy = -fx - slope_x * load, -fy - slope_y * load
    _add_force((x, y, z), (fx, fy, load), loads)
    loads.tip_force[k, 0], loads.tip_force[k, 1], loads.tip_force[k, 2] = fx, fy, load
    s.actuator_totals[k, 0] += fx * h
    s.actuator_totals[k, 1] += fy * h
    s.actuator_totals[k, 2] += load * h
    return fx, fy, load


@_inlined
def _sway(c, s, k, axis, turn, pull, writes, loads):
    """Acceleration of the tilt and the sway of tip `k` along x or y, under a torque about the piezos'
    plane and a force at the apex, N m and N."""
    acceleration, half = s.tip_acceleration[k], 0.5 * c.step
    tilt, across = 1 + axis, 3 + axis
    torque = turn + pull * c.tip.height
    if c.tip.sway_stiffness == 0.0:
        acceleration[tilt] = torque / c.tip.inertia
        return
    at = s.tip[k, across]
    rate = s.tip_velocity[k, across] + half * acceleration[across]
    over = max(abs(at) - c.tip.sway_play, 0.0)
    stop = math.copysign(c.tip.sway_stop * over, at)
    force = pull - c.tip.sway_stiffness * at - stop - c.tip.sway_damping * rate
    s.totals[3] += c.tip.sway_damping * rate * rate * c.step
    determinant = c.tip.mass * c.tip.inertia - c.tip.moment * c.tip.moment
    acceleration[tilt] = (c.tip.mass * torque - c.tip.moment * force) / determinant
    acceleration[across] = (c.tip.inertia * force - c.tip.moment * torque) / determinant
    if writes:
        swing = s.tip_velocity[k, tilt] + half * acceleration[tilt]
        move = s.tip_velocity[k, across] + half * acceleration[across]
        loads.energy[0] += 0.5 * (c.tip.sway_stiffness * at * at + c.tip.sway_stop * over * over)
        loads.energy[0] += (0.5 * c.tip.mass * move + c.tip.moment * swing) * move


@_inlined
def _actuator(c, s, k, yaw, commands, updates, writes, loads):
    """Advance the tip of actuator `k` by one step; updates: of the creep, s, and whether of the modes above it."""
    tip, rate_of, acceleration = s.tip[k], s.tip_velocity[k], s.tip_acceleration[k]
    half = 0.5 * c.step
    for i in range(TIP_FREEDOMS):
        tip[i] += half * rate_of[i]
    push, turn_a, turn_b = _piezos(c, s, k, commands, updates[0], writes, loads)
    fx, fy, load = _tip_contact(c, s, k, yaw, updates[1], writes, loads)
    acceleration[0] = (push - load) / c.tip.mass
    _sway(c, s, k, X, turn_a, -fx, writes, loads)
    _sway(c, s, k, Y, turn_b, -fy, writes, loads)
    for i in range(TIP_FREEDOMS):
        before = rate_of[i]
        rate_of[i] += c.step * acceleration[i]
        tip[i] += half * rate_of[i]
        if writes and i < 3:
            middle = 0.5 * (before + rate_of[i])
            loads.energy[0] += 0.5 * (c.tip.mass if i == 0 else c.tip.inertia) * middle * middle


@_inlined
def _write_row(c, s, time, row, loads):
    """Write a row of the record, at the middle of the step."""
    energy, actuators = loads.energy[0], c.tip_at.shape[0]
    row[0] = time
    for i in range(6):
        loads.mean[i] = s.velocity[i] + 0.5 * c.step * s.acceleration[i]
        row[1 + i] = s.position[i]
        row[7 + i] = loads.mean[i]
    for i in range(3):
        energy += 0.5 * c.mass * loads.mean[i] * loads.mean[i]
        for j in range(3):
            energy += 0.5 * c.inertia[i, j] * loads.mean[3 + i] * loads.mean[3 + j]
    row[13] = energy
    for i in range(4):
        row[14 + i] = s.totals[i]
    for k in range(actuators):
        at = HEAD + PER_ACTUATOR * k
        for i in range(3):
            row[at + i] = loads.apex[k, i]
            row[at + 3 + i] = loads.tip_force[k, i]
            row[at + 6 + i] = s.actuator_totals[k, i]
            row[at + 10 + i] = s.voltage[k, i]
        row[at + 9] = s.actuator_totals[k, 3]
    for k in range(c.pad_at.shape[0]):
        at = HEAD + PER_ACTUATOR * actuators + PER_PAD * k
        for i in range(3):
            row[at + i] = loads.pad_force[k, i]
        row[at + 3], row[at + 4] = s.pad_totals[k, 0], s.pad_totals[k, 1]


def _advance(memory):
    c, s, loads, commands, rows, stride = memory[0]
    h, half = c.step, 0.5 * c.step
    q, v, a = s.position, s.velocity, s.acceleration
    for n in range(commands.shape[0]):
        for i in range(6):
            q[i] += half * v[i]
        writes = (n + 1) % stride == 0
        updates = (h * CREEP_EVERY if (n + 1) % CREEP_EVERY == 0 else 0.0, n % SHAPES_EVERY == 0)
        yaw = math.cos(q[5]), math.sin(q[5])
        _weight_and_guides(c, q, yaw, writes, loads)
        for k in range(c.pad_at.shape[0]):
            _pad(c, s, k, yaw, writes, loads)
        for k in range(c.tip_at.shape[0]):
            _actuator(c, s, k, yaw, commands[n], updates, writes, loads)
        _bend(c, s, writes, loads)
        for i in range(3):
            a[i] = loads.force[i] / c.mass
            a[3 + i] = 0.0
            for j in range(3):
                a[3 + i] += c.inertia_inverse[i, j] * loads.torque[j]
        if writes:
            _write_row(c, s, s.clock[0] + (n + 0.5) * h, rows[n // stride], loads)
        for i in range(6):
            v[i] += h * a[i]
            q[i] += half * v[i]
    s.clock[0] += commands.shape[0] * h


advance = OverViews(_advance, _SOURCES, SUMS_IN_ANY_ORDER)
