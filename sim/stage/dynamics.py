"""One step of the driven stage, and as many as are asked for: compiled once for every machine.

States are kept at full steps, forces are taken half-way between (drift, kick, drift: Verlet's method, second order,
no drift of the energy). Rates that a force depends on are carried half a step on by the last acceleration.

Stage, six degrees of freedom about its centre of mass, turned little about x and y and freely about z.
Tip, three: height z of its axis in the piezos' plane, slopes a, b of its axis towards x and y:

    apex = (h a, h b, z)      stretch at piezo i = z - p_i . (a, b)

Contacts (pads, tips): N = K delta^1.5 (1 + damping delta'), none in the gap. Tangentially elements that stick and slip
(`slip_elements.py`). Their stiffness goes with the load; an element keeps its force when load is added, and loses force
in proportion when load is taken away, so that no energy comes of it (Thornton, Cummins, Cleary, Powder Technol. 233
(2013) 30).

This module imports numba: import it only when something is simulated.
"""

from __future__ import annotations

import math

import numpy as np

from sim.numerics.compilation import compile_function
from sim.stage import state as state_module

ELEMENTS = 4
HEAD, PER_ACTUATOR, PER_PAD = 18, 13, 5
"""Columns of a row: time, position (6), velocity (6), energy kept and works (5); then of each actuator, of each pad."""


def _slip(force, tangent_before, tangent, cap, stiffness_shares, cap_shares, dx, dy, lag):
    """Move elements by (dx, dy); returns the force that resists (x, y), the heat and the energy kept.

    An element that sticks damps as well: its force is k (z + tau z'), `lag` = tau over the step. Slip begins when that
    passes the cap, and the force stays at the cap while z goes there with tau: at speed nothing is left of the damping.
    """
    fx, fy, heat, kept = 0.0, 0.0, 0.0, 0.0
    if tangent <= 0.0:
        for e in range(force.shape[0]):
            if tangent_before > 0.0:
                heat += (force[e, 0] ** 2 + force[e, 1] ** 2) / (2.0 * tangent_before * stiffness_shares[e])
            force[e, 0] = 0.0
            force[e, 1] = 0.0
        return fx, fy, heat, kept
    loss = 1.0
    if tangent < tangent_before:
        loss = tangent / tangent_before
    for e in range(force.shape[0]):
        stiffness = tangent * stiffness_shares[e]
        most = cap * cap_shares[e]
        x0, y0 = force[e, 0], force[e, 1]
        before = 0.0
        if tangent_before > 0.0:
            before = (x0 * x0 + y0 * y0) / (2.0 * tangent_before * stiffness_shares[e])
        x, y = x0 * loss, y0 * loss
        whole_x = x + (1.0 + lag) * stiffness * dx
        whole_y = y + (1.0 + lag) * stiffness * dy
        size = math.sqrt(whole_x * whole_x + whole_y * whole_y)
        if size > most:
            whole_x *= most / size
            whole_y *= most / size
            x += (whole_x - x) / (1.0 + lag)
            y += (whole_y - y) / (1.0 + lag)
        else:
            x += stiffness * dx
            y += stiffness * dy
        after = (x * x + y * y) / (2.0 * stiffness)
        work = (0.5 * (x0 + x) + whole_x - x) * dx + (0.5 * (y0 + y) + whole_y - y) * dy
        heat += work - (after - before)
        kept += after
        force[e, 0] = x
        force[e, 1] = y
        fx += whole_x
        fy += whole_y
    return fx, fy, heat, kept


def _stretch_piezo(c, voltage, play, creep, slow_step):
    """Free stretch from mid-stroke of one stack at `voltage`, m; its plays move on, and its creep by `slow_step`, s."""
    u = voltage
    for i in range(play.size):
        out = play[i]
        if voltage - out > c.thresholds[i]:
            out = voltage - c.thresholds[i]
        elif out - voltage > c.thresholds[i]:
            out = voltage + c.thresholds[i]
        play[i] = out
        u += c.strength * c.weights[i] * (out - voltage)
    u -= c.bias
    slow = 0.0
    for i in range(creep.size):
        if slow_step > 0.0:
            creep[i] += (u - creep[i]) * (1.0 - math.exp(-c.creep_rates[i] * slow_step))
        slow += c.creep_weights[i] * creep[i]
    return c.gain * (u + slow)


CREEP_EVERY = 128
"""Steps between two updates of the creep, whose quickest lag is 0.1 s."""


def _advance(c, s, commands, rows, stride):
    """Advance by `commands.shape[0]` steps.

    Args:
        c, s: constants and state.
        commands: voltages asked for half-way through each step, V, shape (steps, actuators, 3).
        rows: written every `stride` steps at the step's middle, shape (steps // stride, columns).
        stride: steps a row.
    """
    h = c.step
    half = 0.5 * h
    actuators, pads = c.tip_at.shape[0], c.pad_at.shape[0]
    share = 1.0 - math.exp(-c.amplifier_rate * h)
    most = c.voltage_rate * h
    force = np.zeros(3)
    torque = np.zeros(3)
    mean = np.zeros(6)
    normal = np.zeros(actuators)
    side = np.zeros((actuators, 2))
    apex = np.zeros((actuators, 3))
    pad_normal = np.zeros(pads)
    pad_side = np.zeros((pads, 2))
    row = 0
    for n in range(commands.shape[0]):
        q, v, a = s.position, s.velocity, s.acceleration
        for i in range(6):
            q[i] += half * v[i]
        writes = (n + 1) % stride == 0
        slow_step = h * CREEP_EVERY if (n + 1) % CREEP_EVERY == 0 else 0.0
        stored = 0.0
        force[0], force[1] = 0.0, 0.0
        force[2] = -c.weight - c.preload
        cosine, sine = math.cos(q[5]), math.sin(q[5])
        px = cosine * c.preload_at[0] - sine * c.preload_at[1]
        py = sine * c.preload_at[0] + cosine * c.preload_at[1]
        torque[0], torque[1], torque[2] = -py * c.preload, px * c.preload, 0.0
        if writes:
            stored += c.weight * q[2] + c.preload * (q[2] + q[3] * py - q[4] * px)

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
                stored += 0.5 * c.guide_stiffness * away * away + 0.5 * c.guide_yaw * q[5] * q[5]

        for k in range(pads):
            x = cosine * c.pad_at[k, 0] - sine * c.pad_at[k, 1]
            y = sine * c.pad_at[k, 0] + cosine * c.pad_at[k, 1]
            z = c.pad_at[k, 2]
            deep = -(q[2] + q[3] * y - q[4] * x)
            load, tangent, mu = 0.0, 0.0, 0.0
            vx = v[0] + v[4] * z - v[5] * y
            vy = v[1] + v[5] * x - v[3] * z
            if deep > 0.0:
                rate = -(v[2] + v[3] * y - v[4] * x) - half * (a[2] + a[3] * y - a[4] * x)
                spring = c.pad_rate * deep * math.sqrt(deep)
                load = max(spring * (1.0 + c.pad_damping * rate), 0.0)
                s.totals[3] += (load - spring) * rate * h
                tangent = c.pad_bristle * load
                speed = (vx * vx + vy * vy) / (c.pad_stribeck * c.pad_stribeck)
                mu = c.pad_dynamic + (c.pad_static - c.pad_dynamic) * math.exp(-speed)
                if writes:
                    stored += 0.4 * spring * deep
                s.pad_totals[k, 1] += math.sqrt(vx * vx + vy * vy) * h
            else:
                s.pad_totals[k, 0] += h
            fx, fy, heat, kept = _slip(
                s.pad_force[k], s.pad_tangent[k], tangent, mu * load,
                c.pad_stiffness_shares, c.pad_cap_shares, vx * h, vy * h, c.pad_lag / h,
            )  # fmt: skip
            s.pad_tangent[k] = tangent
            s.totals[1] += heat
            stored += kept
            # The elements are stretched by the pad's motion over the way: their force on the stage is the other way.
            fx, fy = -fx, -fy
            force[0] += fx
            force[1] += fy
            force[2] += load
            torque[0] += y * load - z * fy
            torque[1] += z * fx - x * load
            torque[2] += x * fy - y * fx
            pad_normal[k], pad_side[k, 0], pad_side[k, 1] = load, fx, fy

        for k in range(actuators):
            tip, rate_of = s.tip[k], s.tip_velocity[k]
            for i in range(3):
                tip[i] += half * rate_of[i]
            push, turn_a, turn_b = 0.0, 0.0, 0.0
            for i in range(3):
                asked = commands[n, k, i]
                change = share * (asked - s.voltage[k, i])
                change = min(max(change, -most), most)
                s.voltage[k, i] = min(max(s.voltage[k, i] + change, 0.0), c.voltage_high)
                free = _stretch_piezo(c, s.voltage[k, i], s.play[k, i], s.creep[k, i], slow_step)
                ax, ay = c.piezo_at[i, 0], c.piezo_at[i, 1]
                stretch = tip[0] - ax * tip[1] - ay * tip[2]
                rate = (
                    rate_of[0] - ax * rate_of[1] - ay * rate_of[2]
                    + half * (s.tip_acceleration[k, 0] - ax * s.tip_acceleration[k, 1]
                              - ay * s.tip_acceleration[k, 2])
                )  # fmt: skip
                spring = c.piezo_stiffness * (free - stretch)
                # Work of the drive on the spring: its force times the change of the free length.
                s.totals[0] += 0.5 * (spring + s.piezo_force[k, i]) * (free - s.stretch[k, i])
                s.totals[3] += c.piezo_damping * rate * rate * h
                s.stretch[k, i] = free
                s.piezo_force[k, i] = spring
                if writes:
                    stored += 0.5 * spring * spring / c.piezo_stiffness
                pressed = spring - c.piezo_damping * rate
                push += pressed
                turn_a -= ax * pressed
                turn_b -= ay * pressed

            x = c.tip_at[k, 0] - c.centre_start[0] - q[0]
            y = c.tip_at[k, 1] - c.centre_start[1] - q[1]
            z = -c.centre_start[2]
            apex[k, 0], apex[k, 1] = c.tip_height * tip[1], c.tip_height * tip[2]
            apex[k, 2] = tip[0]
            x += apex[k, 0]
            y += apex[k, 1]
            deep = c.apex_rest[k] + tip[0] - (q[2] + q[3] * y - q[4] * x)
            load, tangent = 0.0, 0.0
            slide_x = v[0] + v[4] * z - v[5] * y - c.tip_height * rate_of[1]
            slide_y = v[1] + v[5] * x - v[3] * z - c.tip_height * rate_of[2]
            if deep > 0.0:
                rate = (
                    rate_of[0] - (v[2] + v[3] * y - v[4] * x)
                    + half * (s.tip_acceleration[k, 0] - (a[2] + a[3] * y - a[4] * x))
                )  # fmt: skip
                spring = c.contact_rate * deep * math.sqrt(deep)
                load = max(spring * (1.0 + c.contact_damping * rate), 0.0)
                s.totals[3] += (load - spring) * rate * h
                tangent = c.contact_ratio * 1.5 * c.contact_rate * math.sqrt(deep)
                if writes:
                    stored += 0.4 * spring * deep
                s.actuator_totals[k, 3] += h
            fx, fy, heat, kept = _slip(
                s.contact_force[k], s.contact_tangent[k], tangent, c.contact_friction * load,
                c.contact_stiffness_shares, c.contact_cap_shares, slide_x * h, slide_y * h, 0.0,
            )  # fmt: skip
            s.contact_tangent[k] = tangent
            s.totals[2] += heat
            stored += kept
            fx, fy = -fx, -fy
            force[0] += fx
            force[1] += fy
            force[2] += load
            torque[0] += y * load - z * fy
            torque[1] += z * fx - x * load
            torque[2] += x * fy - y * fx
            normal[k], side[k, 0], side[k, 1] = load, fx, fy
            s.actuator_totals[k, 0] += fx * h
            s.actuator_totals[k, 1] += fy * h
            s.actuator_totals[k, 2] += load * h

            move = s.tip_acceleration[k]
            move[0] = (push - load) / c.tip_mass
            move[1] = (turn_a - fx * c.tip_height) / c.tip_inertia
            move[2] = (turn_b - fy * c.tip_height) / c.tip_inertia
            for i in range(3):
                before = rate_of[i]
                rate_of[i] += h * move[i]
                tip[i] += half * rate_of[i]
                if writes:
                    middle = 0.5 * (before + rate_of[i])
                    stored += 0.5 * (c.tip_mass if i == 0 else c.tip_inertia) * middle * middle

        for i in range(3):
            a[i] = force[i] / c.mass
            a[3 + i] = 0.0
            for j in range(3):
                a[3 + i] += c.inertia_inverse[i, j] * torque[j]
        if writes:
            rows[row, 0] = s.clock[0] + (n + 0.5) * h
            for i in range(6):
                mean[i] = v[i] + half * a[i]
                rows[row, 1 + i] = q[i]
                rows[row, 7 + i] = mean[i]
            for i in range(3):
                stored += 0.5 * c.mass * mean[i] * mean[i]
                for j in range(3):
                    stored += 0.5 * c.inertia[i, j] * mean[3 + i] * mean[3 + j]
            rows[row, 13] = stored
            for i in range(4):
                rows[row, 14 + i] = s.totals[i]
            for k in range(actuators):
                at = HEAD + PER_ACTUATOR * k
                for i in range(3):
                    rows[row, at + i] = apex[k, i]
                    rows[row, at + 6 + i] = s.actuator_totals[k, i]
                    rows[row, at + 10 + i] = s.voltage[k, i]
                rows[row, at + 3], rows[row, at + 4], rows[row, at + 5] = side[k, 0], side[k, 1], normal[k]
                rows[row, at + 9] = s.actuator_totals[k, 3]
            for k in range(pads):
                at = HEAD + PER_ACTUATOR * actuators + PER_PAD * k
                rows[row, at], rows[row, at + 1], rows[row, at + 2] = pad_side[k, 0], pad_side[k, 1], pad_normal[k]
                rows[row, at + 3], rows[row, at + 4] = s.pad_totals[k, 0], s.pad_totals[k, 1]
            row += 1
        for i in range(6):
            v[i] += h * a[i]
            q[i] += half * v[i]
    s.clock[0] += commands.shape[0] * h


_slip = compile_function(_slip)
_stretch_piezo = compile_function(_stretch_piezo)
advance = compile_function(_advance, [state_module.__file__])
