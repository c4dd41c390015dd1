"""Dynamic error budgets: spectra of disturbances through the position loop to the payload, and the loop's margin."""

from functools import partial

import numpy as np

from designcalc.checks.check import Check, CheckFunction, DesignInputs, at_most, show
from designcalc.errors.dynamic_budget import DynamicBudget
from designcalc.friction_stage.physics.loads import tip_load
from designcalc.friction_stage.physics.plate_vibration import held_plate
from designcalc.friction_stage.physics.position_loop import (
    INTERFEROMETER,
    PROBE,
    dynamic_budget,
    position_loop,
    suspension,
)
from designcalc.friction_stage.physics.tip_dynamics import usable_ellipse
from stagecad.parameters.design import Design

_SOURCE = "Schmidt, Schitter, Rankers (2020), section 8.2: densities through the closed loop, added as powers"
NAMES = (f"along, {PROBE}", f"along, {INTERFEROMETER}", "normal")
PEAK_SENSITIVITY = 2.0
"""Usual limit of the largest sensitivity, 6 dB."""


def checks(design: Design) -> list[CheckFunction]:
    """One check for each budget, one for the loop with each sensor, and the time to settle."""
    return [
        *(partial(total, position=k) for k in range(len(NAMES))),
        *(partial(stability, sensor=sensor) for sensor in (PROBE, INTERFEROMETER)),
        settling,
    ]


def limit_key(found: DynamicBudget) -> str:
    """Key of the requirement that a budget is compared with."""
    return "requirements.smoothness" if found.name == "normal" else "requirements.resolution_coarse"


def total(r: DesignInputs, position: int) -> Check:
    found = dynamic_budget(r, position)
    lowest = 1 / r("loop.observation")
    rows = found.largest_first(lowest)
    whole = found.rms(found.total, lowest)
    first, rest = rows[0][0].name, np.sqrt(sum(size**2 for _, size in rows[1:]))
    along = found.name != "normal"
    return Check(
        f"dynamic error budget at the payload: {found.name}",
        at_most(whole, r(limit_key(found)), "m"),
        source=_SOURCE + f"; at rest, over {show(r('loop.observation'), 's')}",
        formula="sqrt(integral from 1/T of sum |G_i a_i|^2 df)",
        substituted="; ".join(f"{row.name} {show(size, 'm')}" for row, size in rows)
        + f"; slower than that, drift of {show(found.rms(found.total), 'm')} in all",
        proposal=f"start with {first}: without it {show(float(rest), 'm')}",
        requirement="Table 1: resolution" if along else "Table 1: smoothness",
    )


def stability(r: DesignInputs, sensor: str) -> Check:
    loop, held = position_loop(r, sensor), suspension(r)
    f = np.unique(np.concatenate([np.geomspace(1e-2 * loop.crossover, loop.sample_rate / 2, 4001), [held.resonance]]))
    peak = float(np.abs(loop.sensitivity(f)).max()) if loop.stable() else np.inf
    return Check(
        f"stability of the position loop with the {sensor}",
        at_most(peak, PEAK_SENSITIVITY, ""),
        source="largest sensitivity 6 dB; infinite where Nyquist's criterion is violated",
        formula="max |1/(1 + L)| <= 2, L = f_c/(i f) P F exp(-2 pi i f 1.5/f_s)",
        substituted=f"f_c = {show(loop.crossover, 'Hz')}, resonance {show(held.resonance, 'Hz')} with zeta = "
        f"{held.damping:.3g}, static gain {held.gain:.3g}: {peak:.4g}",
        proposal="a lower crossover, or a notch at the resonance",
        requirement="Table 1: resolution",
    )


def settling(r: DesignInputs) -> Check:
    """Time from the end of the drive: ring-down of the plate, then the controller over the range of the tip's lean."""
    held, loop, along = held_plate(r), position_loop(r, PROBE), suspension(r)
    force, smooth, resolution = tip_load(r), r("requirements.smoothness"), r("requirements.resolution_coarse")
    rings = held.ring_down(force, smooth)
    reach = along.gain * usable_ellipse(r)[0] / 2
    follows = float(np.log(max(reach / resolution, 1.0))) / (2 * np.pi * loop.crossover)
    first, damping = float(held.frequency[0]), float(held.damping[0])
    quicker = max(r("loop.settling") - follows, 0.0)
    return Check(
        "settling after a move",
        at_most(rings + follows, r("loop.settling"), "s"),
        source="modes of the plate on pads and tip after the load of the drive, as the sum of their envelopes, down to "
        "the smoothness; then the integral controller over the reach of the lean, down to the coarse resolution",
        formula="t_1 + ln(g X/(2 e))/(2 pi f_c), sum_m |phi_m(tip) phi_m(payload)| N/w_m^2 exp(-zeta_m w_m t_1) = s",
        substituted=f"N = {show(force, 'N')}, first mode {show(first, 'Hz')} with zeta = {damping:.3g}: "
        f"{show(rings, 's')}; reach {show(reach, 'm')}: {show(follows, 's')}",
        proposal=f"damping of the stage for a ring-down within {show(quicker, 's')}, or a slower end of the drive",
        requirement="Table 1: smoothness",
    )
