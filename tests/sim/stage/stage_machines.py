"""A stage for the tests, close to the packaged design, every number by hand."""

import math
from dataclasses import replace
from typing import Any

import numpy as np

from sim.stage.machine import Contact, Pads, Piezo, Sensors, Stage, StageMachine, Tip

GRAVITY = 9.80665
RADIUS = 0.046 / math.sqrt(3.0)
PIEZOS = np.array([[-0.023, -RADIUS / 2], [0.023, -RADIUS / 2], [0.0, RADIUS]])
FOUR_PADS = np.array([[-0.025, 0.115], [0.025, 0.115], [-0.025, -0.115], [0.025, -0.115]])
THREE_PADS = np.array([[-0.025, 0.115], [0.025, 0.115], [0.0, -0.115]])
PAD_FRICTION = {"static_friction": 0.06, "dynamic_friction": 0.05, "stribeck_velocity": 1e-3, "presliding": 0.5e-6}
AMPLIFIER: Any = {"capacitance": 1.4e-6, "current": 2.0, "slew_rate": 20e6, "bandwidth": 50e3, "bits": 16}
FILTER = {"filter_frequency": 24.0, "filtered_range": 1e-6, "filtered_count": 0.244e-9}
PROBE = {"probe_noise": 25e-9, "probe_bandwidth": 5e3} | FILTER


def example() -> StageMachine:
    """One actuator under the middle of a stage on three pads, without teeth."""
    return StageMachine(
        stage=Stage(mass=3.0, centre=np.array([0.0, 0.0, 0.014]), inertia=np.diag([0.013, 0.0093, 0.021])),
        pads=Pads(THREE_PADS, 2e-3, contact_rate=1.2e11, damping=80.0, tangential_lag=6e-5, **PAD_FRICTION),
        tip=Tip(mass=0.032, inertia=1e-5, height=0.02, piezo_places=PIEZOS, stiffness=47e6, damping=28.0),
        contact=Contact(rate=7.3e9, damping=0.3, friction=0.3, tangential_ratio=0.8),
        piezo=Piezo(stroke=17e-6, highest_voltage=150.0, bias=75.0, hysteresis=0.12, creep=0.015, **AMPLIFIER),
        sensors=Sensors(interferometer_count=0.62e-9, lvdt_count=6.2e-6, lvdt_linearity_error=63.5e-6, **PROBE),
        actuators=np.zeros((1, 2)),
        travel=0.2,
        gravity=GRAVITY,
    )


def ideal_piezos(machine: StageMachine) -> StageMachine:
    """Stacks without hysteresis and creep on amplifiers without limits."""
    piezo = replace(machine.piezo, hysteresis=0.0, creep=0.0, current=math.inf, slew_rate=math.inf, bandwidth=10e6)
    return replace(machine, piezo=piezo)


def symmetric(machine: StageMachine) -> StageMachine:
    """On four pads."""
    return replace(machine, pads=replace(machine.pads, places=FOUR_PADS))
