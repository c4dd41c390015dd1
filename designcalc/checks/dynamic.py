"""Dynamic error budgets: spectra of disturbances through the position loop to the payload, and the loop's margin."""

from __future__ import annotations

from functools import partial

import numpy as np

from designcalc.checks.check import Check, CheckFunction, at_most, show
from designcalc.errors.dynamic_budget import DynamicBudget
from designcalc.machine.inputs import DesignInputs
from designcalc.machine.position_loop import INTERFEROMETER, PROBE, dynamic_budget, position_loop, suspension
from stagecad.parameters.design import Design

_SOURCE = "Schmidt, Schitter, Rankers (2020), section 8.2: densities through the closed loop, added as powers"
NAMES = (f"along, {PROBE}", f"along, {INTERFEROMETER}", "normal")
PEAK_SENSITIVITY = 2.0
"""Usual limit of the largest sensitivity, 6 dB."""


def checks(design: Design) -> list[CheckFunction]:
    """One check for each budget, and one for the loop with each sensor."""
    return [
        *(partial(total, position=k) for k in range(len(NAMES))),
        *(partial(stability, sensor=sensor) for sensor in (PROBE, INTERFEROMETER)),
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
