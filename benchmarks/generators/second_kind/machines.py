"""Machines of which records are made: sizes as found in practice, drawn anew for every case."""

from dataclasses import dataclass

import numpy as np

AXIS_RIGS = ("velocity-drive", "spring-pull", "force-drive")
RIGS = (*AXIS_RIGS, "actuator-tip")
RIG_SHARES = (0.3, 0.23, 0.27, 0.2)

# Highest speed (m/s or rad/s) and Coulomb friction (N or N m), each a range, and whether the axis rotates.
SIZES = {
    "tribometer": ((2e-3, 5e-2), (0.5, 15.0), False),
    "nano": ((1.5e-4, 4e-3), (0.15, 5.0), False),
    "cnc": ((0.03, 0.2), (25.0, 300.0), False),
    "joint": ((0.2, 2.5), (0.1, 17.0), True),
}
RATES = {
    "velocity-drive": (100.0, 125.0, 200.0, 400.0, 500.0, 1000.0),
    "spring-pull": (250.0, 400.0, 500.0, 1000.0, 2000.0),
    "force-drive": (250.0, 400.0, 500.0, 1000.0, 2000.0),
    "actuator-tip": (500.0, 1000.0, 2000.0, 5000.0),
}
FINEST, MOST_STEPS = 5e-4, 80_000
"""Largest time step of a driven axis (s), and how many of them a record may take."""
MOST_ROWS = {"velocity-drive": 30_000, "spring-pull": 24_000, "force-drive": 24_000, "actuator-tip": 60_000}


@dataclass(frozen=True)
class Machine:
    """One machine; SI, angles in rad and torques in N m on a rotary axis.

    `speed`, `slow`, `reach` and `acceleration` bound its motions; `curve_speed` and `curve_power` shape a Stribeck
    curve of the base model, exp(-(|v| / curve_speed)^curve_power), of height `curve`; `bandwidth` is the controller's;
    `stretch` is that of bristles in the base model.
    """

    rig: str
    name: str
    rotary: bool
    base: tuple[str, ...]
    rate: float
    rows: int
    speed: float
    slow: float
    reach: float
    acceleration: float
    mass: float
    stiffness: float
    coulomb: float
    viscous: float
    curve: float
    curve_speed: float
    curve_power: float
    bandwidth: float
    load: float
    temperature: float
    spacing: float = 0.0
    height: float = 0.0
    bias: float = 0.0
    gain: float = 0.0
    stretch: float = 0.0

    @property
    def step(self) -> float:
        """Time between rows."""
        return 1.0 / self.rate


def log_uniform(rng: np.random.Generator, low: float, high: float) -> float:
    """A number between `low` and `high`, uniform in its logarithm."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def draw_machine(rng: np.random.Generator, rig: str, *, curve: bool | None = None) -> Machine:
    """A machine of kind `rig`; `curve` says whether its base model has a Stribeck curve (by chance without it)."""
    rate = float(rng.choice(RATES[rig]))
    if rig == "actuator-tip":
        rows = min(int(log_uniform(rng, 10.0, 25.0) * rate), MOST_ROWS[rig])
        return Machine(
            rig, "piezo", False, (), rate, rows, *(0.0,) * 14,
            spacing=rng.uniform(0.03, 0.055), height=rng.uniform(9e-3, 29e-3),
            bias=float(rng.choice([0.0, 50.0, 60.0])), gain=log_uniform(rng, 3.5e-8, 1.2e-7),
        )  # fmt: skip
    name = str(rng.choice(list(SIZES)))
    speeds, forces, rotary = SIZES[name]
    speed, coulomb = log_uniform(rng, *speeds), log_uniform(rng, *forces)
    stroke = log_uniform(rng, 0.25, 2.0)
    reach = speed * stroke
    acceleration = speed / max(log_uniform(rng, 0.02, 0.25), 8.0 / rate)
    seconds = min(max(log_uniform(rng, 10.0, 120.0), 20.0 * stroke), MOST_ROWS[rig] / rate)
    if rig != "velocity-drive":
        seconds = min(seconds, MOST_STEPS * FINEST)
    curve = bool(rng.random() < 0.2) if curve is None else curve
    frequency = min(log_uniform(rng, 20.0, 150.0), 0.1 * rate)
    stiffness, mass, bandwidth = 0.0, 0.0, 0.0
    if rig == "spring-pull":
        stiffness = coulomb / reach * log_uniform(rng, 10.0, 100.0)
        mass = stiffness / frequency**2
    elif rig == "force-drive":
        mass = coulomb / acceleration * log_uniform(rng, 0.15, 2.0)
        wanted = float(np.sqrt(coulomb / (mass * reach) * log_uniform(rng, 10.0, 60.0)))
        bandwidth = min(max(wanted, 15.0), 0.15 * rate)
    return Machine(
        rig, name, rotary, ("coulomb", "viscous", "stribeck") if curve else ("coulomb", "viscous"),
        rate, int(seconds * rate), speed, speed / log_uniform(rng, 8.0, 60.0), reach, acceleration, mass, stiffness,
        coulomb, coulomb / speed * log_uniform(rng, 0.08, 1.2), coulomb * rng.uniform(0.15, 0.6) if curve else 0.0,
        speed * log_uniform(rng, 0.03, 0.15), float(rng.choice([2.0, 2.0, 1.0])), bandwidth,
        coulomb * log_uniform(rng, 0.8, 14.0), rng.uniform(18.0, 25.0),
    )  # fmt: skip
