"""Convergence of the simulations and finite elements, written to docs/convergence.md.

    python -m benchmarks.convergence

Each table varies one number of the discretisation; the rows in bold are the setting that is used. The last column is
the difference from the finest row. A column is printed with the digits in which the row in use and the finest row
agree, five at most. A minute of processor time.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import fields, replace
from pathlib import Path

import numpy as np

from benchmarks import convergence_of_studies as of
from designcalc.bearing.plate import SupportedPlate
from designcalc.checks.check import DesignInputs
from designcalc.drive.magnetic_teeth import teeth_field
from designcalc.friction_stage.physics import stage_plate as vibration
from designcalc.friction_stage.physics.loads import CIRCUITS, circuit, tip_load
from designcalc.friction_stage.physics.stage_plate import DRIVEN_MODES, MODES, TIP, payload_places, stage_plate
from sim.effects.catalogue import compose
from sim.experiments.friction_models import Friction
from sim.experiments.limit_cycles import cycle
from sim.friction_stage.stage_machine import BENDING_MODES, driven_alone, flexible_machine
from sim.friction_stage.studies import stage_drive
from sim.integration import drive
from sim.integration.simulate import simulate
from sim.stage.constants import STEP
from sim.stage.drive_setting import ellipse_wave, step_times, two_piezo_ellipse
from sim.stage.machine import StageMachine
from sim.stage.simulation import drive_stage
from sim.stage.statics import over_drive_surface
from stagecad.parameters.design import Design
from stagecad.parameters.load import load_design
from stagecad.parameters.mass_properties import BodyMasses
from stagecad.solids.assembly.built_machine import body_masses

TEETH = ("pitch", "width", "gap", "groove_depth")
PAGE = Path(__file__).parents[1] / "docs" / "convergence.md"
Numbers = Sequence[float]


def shown(value: float, digits: int) -> str:
    """A number with some significant digits, without an exponent."""
    rounded = float(f"{value:.{digits - 1}e}")
    return f"{rounded:.{max(digits - 1 - math.floor(math.log10(abs(rounded))), 0)}f}"


def converged_digits(used: float, finest: float) -> int:
    """Number of significant digits, up to five, in which two numbers agree; one at least."""
    return next((n for n in (5, 4, 3, 2) if shown(used, n) == shown(finest, n)), 1)


def table(
    heading: str, used: float, rows: Sequence[float], names: Sequence[str], run: Callable[[float], Numbers]
) -> str:
    """A table over a number of the discretisation; the last row is the finest."""
    found = [list(run(row)) for row in rows]
    bold = next(k for k, row in enumerate(rows) if math.isclose(row, used))
    digits = [converged_digits(*pair) for pair in zip(found[bold], found[-1], strict=True)]
    lines = [
        f"| {heading} | {' | '.join(names)} | largest difference |",
        f"| --- |{' ---: |' * (len(names) + 1)}",
    ]
    for k, (row, values) in enumerate(zip(rows, found, strict=True)):
        off = max(abs(a / b - 1.0) for a, b in zip(values, found[-1], strict=True))
        cells = " | ".join(shown(*pair) for pair in zip(values, digits, strict=True))
        lines.append(f"| {f'**{row:g}**' if k == bold else f'{row:g}'} | {cells} | {off:.1e} |")
    return "\n".join(lines)


def driven(
    machine: StageMachine, step: float, frequency: float, height: float = 0.5, rise: float = 2e-3, longer: float = 0.03
) -> tuple[float, float]:
    """Speed, mm/s, and peak tip force, N, with ideal amplifiers; height of the tip in amplitudes of its ellipse, time
    in which the ellipse grows, s, and of the run beyond thirty cycles, s."""
    free = replace(machine.piezo, hysteresis=0.0, creep=0.0, current=math.inf, slew_rate=math.inf, bandwidth=1e7)
    machine = replace(machine, piezo=free)
    ellipse = two_piezo_ellipse(machine, 8.5e-6, math.pi / 2)
    begin, duration = 1.5 * ellipse.along * frequency, 30.0 / frequency + longer
    time = step_times(round(duration / step / 40) * 40, step)
    wave = ellipse_wave(machine, ellipse, frequency, time, np.minimum(time / rise, 1.0))
    run = drive_stage(machine, over_drive_surface(machine, 0.0, height * ellipse.normal), wave, step, 1, begin)
    late = run.time > 0.6 * duration
    return float(run.mean_velocity(0.6 * duration, duration)[0]) * 1e3, float(run.tip_force(0)[late, 2].max())


def high(machine: StageMachine, step: float) -> tuple[float, float]:
    """The regular one of the two limit cycles at 6 kHz with the tip raised by a whole amplitude, entered slowly."""
    return driven(machine, step, 6000.0, 1.0, 2e-2, 0.115)


def energy_error(tolerance: float) -> tuple[float, float]:
    """Position after a stick-slip of 20 s, m, and heat of the friction, J."""
    model = compose(["lugre_causal", "stribeck", "viscous"], {"stribeck.velocity": 2e-3})
    pull = drive.pulled_spring([0.0, 20.0], [0.0, 2.0], stiffness=2.0)
    run = simulate(model, pull, np.linspace(0.0, 20.0, 2001), mass=1.0, tolerance=tolerance, energy=True)
    return float(run.position[-1]), float(run.core_work[-1])


def page() -> str:
    """The page's text."""
    design = load_design(None, ())
    masses = body_masses(design)
    r = DesignInputs(design, masses)
    supported = stage_plate(r)
    body = supported.bodies

    def plate(elements: float) -> tuple[float, ...]:
        one = SupportedPlate(supported.plate, supported._springs, (), body, int(elements))
        f = one.modes(15).frequency
        return float(f[0]), float(f[2]), float(f[14]), float(one.compliance([TIP], payload_places(r)[:1])[0, 0]) * 1e9

    friction = Friction(**{one.name: getattr(design.friction, one.name) for one in fields(Friction)})

    def limit_cycle(tolerance: float) -> tuple[float, float]:
        found = cycle(friction, "lugre_causal", 3.5e-3, 2.0, 1.0, tolerance)
        return found.size, found.top

    def pulses(modes: float) -> tuple[float, float]:
        vibration.DRIVEN_MODES = int(modes)
        fresh = DesignInputs(design, masses)
        above, feet = vibration.above_tip(fresh, tip_load(fresh)), vibration.at_feet(fresh, 20.0)
        vibration.DRIVEN_MODES = DRIVEN_MODES
        return float(above.vibration[0]) * 1e9, float(feet.vibration.max()) * 1e9

    def attraction(refinement: float) -> tuple[float, float]:
        found = circuit(r).forces(refinement)
        return CIRCUITS * found.attraction, 1e3 * found.gap_flux_density

    def teeth(functions: float) -> tuple[float, float]:
        found = teeth_field(*(r(f"teeth.{key}") for key in TEETH), functions=int(functions))
        return float(found.normal_stiffness), float(found.lateral_over_normal)

    def machine(modes: float) -> StageMachine:
        return driven_alone(design, flexible_machine(design, masses, int(modes)))

    fine = machine(BENDING_MODES)
    parts = [
        "# Convergence\n",
        "Written by `python -m benchmarks.convergence`. Each table varies one number of the discretisation; the row in "
        "bold is used. The last column is the largest difference from the last, finest row. A column has the digits in "
        "which the row in use and the finest one agree, five at most. The calculators `hertz`, `rail`, `drive`, "
        "`stack`, `tip-over`, `pads`, `wedge`, `screw`, `probe`, `wear`, `smoothness` (of a given profile), "
        "`levitation`, `suspensions`, `bow`, `vibration`, `alignment` and `budget` are sums, closed forms, and "
        "roots to rounding.\n",
        "## Plate of the stage on its pads, by the number of elements along its shorter side\n",
        table("elements", 20, (10, 14, 20, 30, 40), ("mode 1 (Hz)", "mode 3", "mode 15", "compliance (nm/N)"), plate),
        "\n## Vibration of the stage by the pulses of the tip, by the number of modes on its pads\n",
        table("modes on pads", DRIVEN_MODES, (10, 20, 40, 80), ("above the tip (nm)", "worst foot (nm)"), pulses),
        "\n## Magnets over their bars, by the refinement of the grid\n",
        table("refinement", 1.0, (0.5, 1.0, 2.0, 4.0), ("attraction (N)", "gap field (mT)"), attraction),
        "\n## Field of the teeth, `calc teeth`, by the number of functions at a mouth\n",
        table("functions", 14, (6, 10, 14, 20, 28), ("normal stiffness", "lateral over normal"), teeth),
        "\n## Driven stage, by the number of natural bending modes\n",
        "Ideal amplifiers, 3 kHz and 6 kHz, the tip raised by half an amplitude; last, high: 6 kHz, raised by a whole "
        "one, the stroke growing within 20 ms.\n",
        table(
            "modes",
            BENDING_MODES,
            (10, 20, 40, 60),
            ("3 kHz (mm/s)", "peak (N)", "6 kHz (mm/s)", "peak (N)", "high (mm/s)", "peak (N)"),
            lambda n: (*driven(machine(n), STEP, 3000.0), *driven(machine(n), STEP, 6000.0), *high(machine(n), STEP)),
        ),
        "\n## Driven stage, by the step\n",
        table(
            "step (us)",
            1.0,
            (1.0, 0.5, 0.25),
            ("3 kHz (mm/s)", "peak (N)"),
            lambda us: driven(fine, us * 1e-6, 3000.0),
        ),
        "\n",
        table("step, high (us)", 1.0, (1.0, 0.5, 0.25), ("6 kHz (mm/s)", "peak (N)"), lambda us: high(fine, us * 1e-6)),
        "\n## One axis, by the tolerance: stick-slip of 20 s, causal friction\n",
        table("tolerance", 1e-8, (1e-4, 1e-6, 1e-8, 1e-10, 1e-12), ("position (m)", "heat (J)"), energy_error),
        "\n## Limit cycle of stick-slip at 3.5 mm/s and 2 N/m, by the tolerance\n",
        table("tolerance of the cycle", 1e-8, (1e-4, 1e-6, 1e-8, 1e-10), ("size (N)", "break-away (N)"), limit_cycle),
        *of_studies(design, masses),
    ]
    return "\n".join(parts) + "\n"


def of_studies(design: Design, masses: BodyMasses) -> list[str]:
    """Tables of the experiments, the studies of the stage, the budgets and the calculators by quadrature."""
    drive, r = stage_drive(design, masses), DesignInputs(design, masses)
    forces = "end of presliding (nm)", "peak of hysteresis (N)", "period of stick-slip (s)", "its peak (N)"
    steps = "step of 10 nm (nm)", "reach (nm)", "rate (1/s)", "tracking, gain (nm)", "with friction (nm)", "cycle (nm)"
    speeds = "ellipse at 5 kHz (mm/s)", "coupling, along (mm)", "plane (deg)", "lift-off (1)"
    budgets = "floor, along (nm)", "sensor, along (nm)", "floor, normal (nm)", "amplifiers (nm)"
    return [
        "\n## Experiments `presliding`, `hysteresis`, `stick-slip`, `passivity`, causal friction, by the tolerance\n",
        "`tip` is a closed form, `limit-cycles` the cycle above at other speeds and springs.\n",
        table(
            "tolerance of a run",
            1e-10,
            (1e-6, 1e-8, 1e-10, 1e-12),
            (*forces, "heat of a start (uJ)", "peak of a tip (N)"),
            of.experiments(design),
        ),
        "\n## Studies `steps`, `positioning` and `hunting` of the driven stage, by the step\n",
        table("step, held (us)", 1.0, (1.0, 0.5, 0.25), steps, of.fine(drive)),
        "\n## Studies `ellipse`, `coupling`, `planar` and `travel_map` of the driven stage, by the step\n",
        "At 5 kHz, beside a bending mode, impacts alternate and the speed scatters. Of `speed` and `tip_motion` see "
        "the driven stage above.\n",
        table("step, moving (us)", 1.0, (1.0, 0.5, 0.25), speeds, of.moves(drive)),
        "\n## Dynamic error budgets, `calc dynamic-budget`, by the parts of an interval of frequency\n",
        table("parts", 1.0, (1.0, 2.0, 4.0), budgets, of.budget(design, masses)),
        "\n## The same normal to the surface, by the number of modes on pads and tip\n",
        table("modes held", MODES, (10, 20, 40, 80), (*budgets[2:], "ring-down (s)"), of.held_modes(design, masses)),
        "\n## `calc clamp`, by the points through its depth\n",
        table("points", 121, (61, 121, 241, 2401), ("neck (MPa)", "without actuator (MPa)"), of.neck(design, masses)),
        "\n## `calc air-bearing` and the pulses of the tip, by the points of Gauss's rule\n",
        table("points of the rule", 80, (20, 40, 80, 160), ("starved (N)", "rich (N)"), of.rule),
        "\n",
        table("points of a pulse", 24, (12, 24, 48), ("peak (N)",), of.pulse(r)),
    ]


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
    print(PAGE)
