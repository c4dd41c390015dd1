"""Convergence of what `stagecad simulate` and `stagecad calc` print, for `benchmarks.convergence`."""

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import fields
from types import ModuleType
from typing import Any

import numpy as np

from designcalc.bearing import porous_air
from designcalc.checks.check import DesignInputs
from designcalc.contact import pulsed
from designcalc.drive import clamp
from designcalc.errors import dynamic_budget
from designcalc.friction_stage.physics import clamp as machine_clamp
from designcalc.friction_stage.physics import position_loop, tip_dynamics
from designcalc.friction_stage.physics import stage_plate as vibration
from designcalc.friction_stage.physics.loads import tip_load
from sim.experiments.friction_models import Friction
from sim.experiments.hysteresis import hysteresis
from sim.experiments.passivity import audit
from sim.experiments.presliding import presliding
from sim.experiments.stick_slip import stick_slip
from sim.friction_stage.studies import StageDrive
from sim.stage import drive_setting
from sim.stage.drive_setting import Setting, run_setting, steady, two_piezo_ellipse
from sim.stage.studies import coupling, fine_motion, hunting, planar, positioning, travel_map
from stagecad.parameters.design import Design
from stagecad.parameters.mass_properties import BodyMasses

Numbers = Sequence[float]


@contextmanager
def changed(name: str, value: Any, *modules: ModuleType) -> Iterator[None]:
    """A constant of modules at another value."""
    before = [getattr(module, name) for module in modules]
    for module in modules:
        setattr(module, name, value)
    try:
        yield
    finally:
        for module, old in zip(modules, before, strict=True):
            setattr(module, name, old)


def experiments(design: Design) -> Callable[[float], Numbers]:
    """Numbers of the thesis's experiments with causal friction, of a tolerance."""
    friction = Friction(**{one.name: getattr(design.friction, one.name) for one in fields(Friction)})

    def run(tolerance: float) -> Numbers:
        slips = stick_slip(friction, "lugre_causal", tolerance=tolerance).features()
        return [
            feature[0] * scale
            for feature, scale in (
                (presliding(friction, "lugre_causal", tolerance=tolerance).features()["position_end"], 1e9),
                (hysteresis(friction, "lugre_causal", "w10_v0_0", tolerance).features()["peak_force"], 1.0),
                (slips["period"], 1.0),
                (slips["peak_force"], 1.0),
                (audit(friction, "lugre_causal", "start", tolerance).features()["heat"], 1e6),
                (audit(friction, "lugre_causal", "tip", tolerance).features()["peak_force"], 1.0),
            )
            if feature is not None
        ]

    return run


def fine(drive: StageDrive) -> Callable[[float], Numbers]:
    """Numbers of the studies of fine motion, of a step in us."""
    single = drive.single

    def run(us: float) -> Numbers:
        with changed("STEP", us * 1e-6, fine_motion, positioning, hunting):
            stairs = fine_motion.staircase(single.machine, 10e-9)
            held = fine_motion.held_stage(single)
            return (
                stairs.mean_step * 1e9,
                held.gain * fine_motion.LEAN_HIGHEST * 1e9,
                fine_motion.FineController(held, 1.0).rate,
                fine_motion.tracked(single, held, fine_motion.sine, "gain").rms * 1e9,
                fine_motion.tracked(single, held, fine_motion.sine, "friction").rms * 1e9,
                hunting.held(single, hunting.HOLDS["lean_fast"]).cycle()[0] * 1e9,
            )

    return run


def moves(drive: StageDrive) -> Callable[[float], Numbers]:
    """Numbers of the studies of the moving stage, of a step in us."""
    single, triple = drive.single, drive.triple
    path = two_piezo_ellipse(single.machine, single.amplitude, 0.5 * math.pi)
    slow = min(single.frequency, planar.WITHIN_CURRENT * single.machine.piezo.unclipped_frequency(single.amplitude))
    turned = planar.directed(triple.machine, triple.amplitude, triple.phase, math.radians(30.0))

    def run(us: float) -> Numbers:
        with changed("STEP", us * 1e-6, drive_setting, coupling, travel_map):
            late = coupling.faulty_run(single, coupling.FAULTS["ample_current"]).position[-1]
            setting = Setting(turned, slow, planar.HEIGHT * turned.normal)
            x, y = run_setting(triple.machine, setting, planar.DURATION, us * 1e-6, 50).position[-1, :2]
            return (
                steady(single.machine, Setting(path, single.frequency, 0.5 * path.normal), 0.15).velocity[0] * 1e3,
                late[0] * 1e3,
                math.degrees(math.atan2(y, x)),
                travel_map.pushed_over(single.machine, 0.0),
            )

    return run


def rule(points: float) -> Numbers:
    """Load, N, and share of the supply of an air bearing, with a number of points of Gauss's rule."""
    nodes, weights = np.polynomial.legendre.leggauss(int(points))
    radii = 0.5 * (nodes + 1)
    with changed("_RADII", radii, porous_air), changed("_AREAS", radii * weights, porous_air):
        return [float(porous_air.load_of_feed(feed, 50e-3, 5e5)) for feed in (0.1, 10.0)]


def pulse(r: DesignInputs) -> Callable[[float], Numbers]:
    """Largest force of the tip's pulses, N, of the number of points of Gauss's rule."""
    rise, rate = tip_dynamics.usable_ellipse(r)[1], tip_dynamics.contact_stiffness(r, tip_load(r)).rate
    stiffness = tip_dynamics.PIEZOS * tip_dynamics.stack_stiffness(r)

    def run(points: float) -> Numbers:
        nodes, weights = np.polynomial.legendre.leggauss(int(points))
        with changed("_NODES", nodes, pulsed), changed("_WEIGHTS", weights, pulsed):
            return [pulsed.peak_of_mean(tip_load(r), rise, rate, stiffness)]

    return run


def neck(design: Design, masses: BodyMasses) -> Callable[[float], Numbers]:
    """Stress of the clamp's neck, MPa, with the actuator and without, of the number of points through its depth."""

    def run(points: float) -> Numbers:
        with changed("_POINTS", int(points), clamp):
            found = machine_clamp.grip(DesignInputs(design, masses))
            return [found.stress * 1e-6, found.free_stress * 1e-6]

    return run


def budget(design: Design, masses: BodyMasses) -> Callable[[float], Numbers]:
    """Floor and sensor along the travel, floor and amplifiers normal to it, nm rms, by the parts of an interval of
    the grid of frequencies."""
    grid = dynamic_budget.frequencies

    def run(points: float) -> Numbers:
        def finer(*of: Any) -> Any:
            f = grid(*of)
            return np.interp(np.arange(0.0, f.size - 1 + 1e-9, 1.0 / points), np.arange(f.size), f)

        with changed("frequencies", finer, position_loop):
            r = DesignInputs(design, masses)
            along, normal = position_loop.dynamic_budget(r, 0), position_loop.dynamic_budget(r, 2)
            return [1e9 * found.rms(row) for found in (along, normal) for row in found.rows[:2]]

    return run


def held_modes(design: Design, masses: BodyMasses) -> Callable[[float], Numbers]:
    """Floor and amplifiers normal to the surface, nm rms, and the time of ringing down, s, by the number of modes."""

    def run(modes: float) -> Numbers:
        with changed("MODES", int(modes), vibration):
            r = DesignInputs(design, masses)
            normal = position_loop.dynamic_budget(r, 2)
            down = vibration.held_plate(r).ring_down(tip_load(r), r("requirements.smoothness"))
            return [1e9 * normal.rms(normal.rows[0]), 1e9 * normal.rms(normal.rows[1]), down]

    return run
