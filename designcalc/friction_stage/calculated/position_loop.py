"""Dynamic error budgets: spectra of disturbances through the position loop to the payload, the loop's margin,
and its sensors."""

from functools import partial

import numpy as np

from designcalc.checks.check import Check, CheckFunction, DesignInputs, Quantities
from designcalc.errors.dynamic_budget import DynamicBudget
from designcalc.friction_stage.physics import loads, position_loop, stage_plate, tip_dynamics
from designcalc.friction_stage.quantities import quantity_key, stated

_SOURCE = "Schmidt, Schitter, Rankers (2020), section 8.2: densities through the closed loop, added as powers"


def limit_key(found: DynamicBudget) -> str:
    """Key of the requirement that a budget is compared with."""
    return "requirements.smoothness" if found.name == "normal" else "requirements.resolution_coarse"


def total(r: DesignInputs, position: int) -> Check:
    found = position_loop.dynamic_budget(r, position)
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


def _largest_sensitivity(sensor: str, r: DesignInputs) -> float:
    loop, low = position_loop.position_loop(r, sensor), 1e-2 * r("loop.crossover")
    f = np.unique(np.append(np.geomspace(low, loop.sample_rate / 2, 4001), position_loop.suspension(r).resonance))
    return float(np.abs(loop.sensitivity(f)).max()) if loop.stable() else np.inf


OF_SENSORS: dict[str, Quantities] = {
    sensor: {"sensitivity.largest": (partial(_largest_sensitivity, sensor), "")}
    for sensor in (position_loop.PROBE, position_loop.INTERFEROMETER)
}
"""Quantities of the check of the loop with a sensor."""


def _control(r: DesignInputs) -> float:
    """Time of the integral controller over the reach of the tip's lean, down to the coarse resolution, s."""
    reach = (
        position_loop.suspension(r).gain * tip_dynamics.usable_ellipse(r)[0] / 2 / r("requirements.resolution_coarse")
    )
    return float(np.log(max(reach, 1.0))) / (2 * np.pi * r("loop.crossover"))


QUANTITIES: Quantities = {
    "time.of_ringing": (
        lambda r: stage_plate.held_plate(r).ring_down(loads.tip_load(r), r("requirements.smoothness")),
        "s",
    ),
    "time.of_control": (_control, "s"),
    "mode.held": (lambda r: float(stage_plate.held_plate(r).frequency[0]), "Hz"),
    "damping.held": (lambda r: float(stage_plate.held_plate(r).damping[0]), ""),
}
CHECKS: list[CheckFunction] = [partial(total, position=k) for k in range(3)]
"""One check for each of `dynamic_budgets`."""


def contactless(r: DesignInputs) -> Check:
    """The sensors that reach over the travel and do not touch the stage."""
    travel, sensors = r("requirements.sensor_range"), r.design.sensors
    reach = {
        "LVDT": (r("sensors.lvdt.range"), sensors.lvdt.contactless),
        "interferometer": (2 * r("sensors.interferometer.range"), sensors.interferometer.contactless),
    }
    fit = [name for name, (length, free) in reach.items() if free and length >= travel]
    wanted = int(r.design.requirements.sensor_contactless)
    return stated(
        "sensors over the travel that do not touch",
        "sensors.that_fit >= sensors.wanted",
        given={"sensors.that_fit": (len(fit), ""), "sensors.wanted": (wanted, "")},
        source="thesis 2.3.4, data sheets; number of sensors that reach over the travel and let the stage move across "
        "their axis",
        proposal="an interferometer, or a grid encoder",
        requirement="Table 2: sensor without contact",
        note=", ".join(fit) or "none",
    )(r)
