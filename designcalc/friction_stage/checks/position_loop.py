"""Dynamic error budgets: spectra of disturbances through the position loop to the payload, and the loop's margin."""

from functools import partial

import numpy as np

from designcalc.checks.check import Check, CheckFunction, DesignInputs, FormulaCheck
from designcalc.errors.dynamic_budget import DynamicBudget
from designcalc.friction_stage.physics.loads import tip_load
from designcalc.friction_stage.physics.position_loop import (
    INTERFEROMETER,
    PROBE,
    dynamic_budget,
    position_loop,
    suspension,
)
from designcalc.friction_stage.physics.stage_plate import held_plate
from designcalc.friction_stage.physics.tip_dynamics import usable_ellipse
from designcalc.friction_stage.quantities import quantity_key, stated
from stagecad.parameters.design import Design

_SOURCE = "Schmidt, Schitter, Rankers (2020), section 8.2: densities through the closed loop, added as powers"
NAMES = (f"along, {PROBE}", f"along, {INTERFEROMETER}", "normal")
PEAK_SENSITIVITY = 2.0
"""Usual limit of the largest sensitivity, 6 dB."""


def checks(design: Design) -> list[CheckFunction]:
    """One check for each budget, one for the loop with each sensor, and the time to settle."""
    return [
        *(partial(total, position=k) for k in range(len(NAMES))),
        *(stability(sensor) for sensor in (PROBE, INTERFEROMETER)),
        settling,
    ]


def limit_key(found: DynamicBudget) -> str:
    """Key of the requirement that a budget is compared with."""
    return "requirements.smoothness" if found.name == "normal" else "requirements.resolution_coarse"


def total(r: DesignInputs, position: int) -> Check:
    found = dynamic_budget(r, position)
    sizes = found.largest_first(1 / r("loop.observation"))
    rows = {quantity_key("rms", row.name): size for row, size in sizes}
    rest = np.sqrt(sum(size**2 for _, size in sizes[1:]))
    first = sizes[0][0].name
    return stated(
        f"dynamic error budget at the payload: {found.name}",
        f"sqrt({' + '.join(f'{name}^2' for name in rows)}) <= {limit_key(found)}",
        given={
            **{name: (size, "m") for name, size in rows.items()},
            "rms.without_first": (float(rest), "m"),
            "rms.with_drift": (found.rms(found.total), "m"),
        },
        source=_SOURCE + "; at rest, over {loop.observation: s}",
        proposal=f"start with {first}: without it {{rms.without_first}}",
        requirement="Table 1: smoothness" if found.name == "normal" else "Table 1: resolution",
        note="with slower drift {rms.with_drift}",
    )(r)


def stability(sensor: str) -> FormulaCheck:
    def largest(r: DesignInputs) -> float:
        loop, low = position_loop(r, sensor), 1e-2 * r("loop.crossover")
        f = np.unique(np.append(np.geomspace(low, loop.sample_rate / 2, 4001), suspension(r).resonance))
        return float(np.abs(loop.sensitivity(f)).max()) if loop.stable() else np.inf

    return stated(
        f"stability of the position loop with the {sensor}",
        f"sensitivity.largest <= {PEAK_SENSITIVITY:g}",
        given={"sensitivity.largest": (largest, "")},
        source="largest sensitivity 6 dB, max |1/(1 + L)| with L of integral controller, delay of 1.5 samples, "
        "stage on tip and pads, filter; infinite where Nyquist's criterion is violated",
        proposal="a lower crossover, or a notch at the resonance",
        requirement="Table 1: resolution",
        note="crossover {loop.crossover}, resonance {frequency.of_loop} with zeta = {bearing.damping_ratio}, static "
        "gain {gain.of_loop}",
    )


def _ring_down(r: DesignInputs) -> float:
    return held_plate(r).ring_down(tip_load(r), r("requirements.smoothness"))


def _control(r: DesignInputs) -> float:
    """Time of the integral controller over the reach of the tip's lean, down to the coarse resolution, s."""
    reach = suspension(r).gain * usable_ellipse(r)[0] / 2 / r("requirements.resolution_coarse")
    return float(np.log(max(reach, 1.0))) / (2 * np.pi * r("loop.crossover"))


# From the end of the drive: ring-down of the plate, then the controller over the range of the tip's lean.
settling = stated(
    "settling after a move",
    "time.of_ringing + time.of_control <= loop.settling",
    given={
        "time.of_ringing": (_ring_down, "s"),
        "time.of_control": (_control, "s"),
        "mode.held": (lambda r: float(held_plate(r).frequency[0]), "Hz"),
        "damping.held": (lambda r: float(held_plate(r).damping[0]), ""),
    },
    source="modes of the plate on pads and tip after the load of the drive, as the sum of their envelopes, down to "
    "the smoothness; then the integral controller over the reach of the lean, down to the coarse resolution",
    proposal="damping of the stage for a ring-down within {max(loop.settling - time.of_control, 0 s)}, or a slower end "
    "of the drive",
    requirement="Table 1: smoothness",
    note="first mode {mode.held} with zeta = {damping.held}",
)
