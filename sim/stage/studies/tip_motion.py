"""The best motion of the tip within the limits of amplifier and stacks: phase, height, and overtones up to the third.

A motion is scaled until a voltage, a current or the tension of a stack is at its limit, or smaller. By a random search
about the best one so far it is chosen for each of the `GOALS`; the sinusoids of the thesis, which the amplifier clips
where they exceed its limits, are the comparison. What the search finds is the best of the motions that it has tried.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from sim.stage.drive_setting import (
    SETTLED,
    Ellipse,
    Overtone,
    Setting,
    Steady,
    TipDrive,
    ellipse_wave,
    steady,
    step_times,
    two_piezo_ellipse,
)
from sim.stage.machine import StageMachine
from sim.stage.studies import RunAll

ORDERS = (2, 3)
"""Of the overtones."""
PHASES = tuple(math.radians(degrees) for degrees in (70, 90, 110))
HEIGHTS = (0.25, 0.5, 0.75, 1.0)
"""Heights of the apex at mid-stroke over the drive surface of the sinusoids, in amplitudes of their height."""
ROUNDS, PLAIN, TRIALS = 8, 3, 8
"""Rounds of the search for each goal, the first ones without overtones, and motions tried in a round."""
SPREAD, OVERTONE = 0.3, 0.25
"""Deviation of what is tried from the best so far, relative, less in each round; and of overtones over the ellipse."""


@dataclass(frozen=True)
class Loads:
    """Greatest loads of a period of a motion, over their limits, and the heat of the stacks."""

    voltage: float
    current: float
    tension: float  # by the inertia of the tip
    heat: float  # dielectric, of all stacks, W

    @property
    def largest(self) -> float:
        return max(self.voltage, self.current, self.tension)


def loads(machine: StageMachine, path: Ellipse, frequency: float) -> Loads:
    """Loads of a motion by its commanded voltages."""
    piezo, tip, count = machine.piezo, machine.tip, 256
    volts = ellipse_wave(machine, path, frequency, step_times(count, 1.0 / (count * frequency)))[:, 0] - piezo.bias
    spectrum = np.fft.rfft(volts, axis=0)
    rates = 2j * math.pi * frequency * np.arange(len(spectrum))[:, None]
    rate, bend = (np.fft.irfft(rates**k * spectrum, count, axis=0) for k in (1, 2))
    acceleration = bend * piezo.stroke / piezo.highest_voltage
    # Rise and two tilts of the tip from its stacks; the stacks carry its inertia.
    kinematics = np.linalg.inv(np.column_stack([np.ones(3), tip.piezo_places]))
    inertia = np.diag([tip.mass, tip.inertia, tip.inertia])
    pull = -acceleration @ (kinematics.T @ inertia @ kinematics)
    powers = (np.arange(len(spectrum))[:, None] * np.abs(2.0 * spectrum / count) ** 2).sum()
    return Loads(
        voltage=float(np.max(np.abs(volts))) / min(piezo.bias, piezo.highest_voltage - piezo.bias),
        current=float(np.max(np.abs(rate))) / piezo.voltage_rate,
        tension=float(pull.max()) / piezo.tension,
        heat=math.pi * frequency * piezo.loss * float(powers),
    )


@dataclass(frozen=True)
class Motion:
    """A motion of the tip and the steady state that it drives."""

    path: Ellipse  # commanded
    height: float  # of the apex at mid-stroke over the drive surface, m
    loads: Loads
    steady: Steady = field(repr=False)

    @property
    def speed(self) -> float:
        return float(self.steady.velocity[0])

    @property
    def power(self) -> float:
        """Heat of the stacks and mechanical power, W."""
        return self.loads.heat + self.steady.power

    @property
    def slip_work(self) -> float:
        """Work of slip of the tip for a metre of travel, to which its wear is proportional, N."""
        return self.steady.slip_heat / self.speed if self.speed > 0.0 else math.inf


def _no_slower(measure: Callable[[Motion], float], motion: Motion, least: float) -> float:
    return -measure(motion) if motion.speed >= least else motion.speed - least - 1e9


GOALS: dict[str, Callable[[Motion, float], float]] = {
    "fastest": lambda motion, least: motion.speed,
    "per_watt": lambda motion, least: motion.speed / motion.power,
    "least_ripple": partial(_no_slower, lambda motion: motion.steady.ripple),
    "least_wear": partial(_no_slower, lambda motion: motion.slip_work),
}
"""Merit of a motion, to be made large, with the speed of the thesis's; the last two: no slower than it."""


@dataclass(frozen=True)
class TipMotions:
    """The thesis's sinusoids, the best ones of each goal with sinusoids alone, and with overtones."""

    frequency: float  # Hz
    thesis: Motion
    sinusoids: dict[str, Motion]
    best: dict[str, Motion]

    @property
    def motions(self) -> dict[str, Motion]:
        """All by name."""
        plain = {f"{goal}_sinusoid": motion for goal, motion in self.sinusoids.items()}
        return {"thesis": self.thesis, **plain, **self.best}

    def features(self) -> dict[str, tuple[float, str] | None]:
        found: dict[str, tuple[float, str] | None] = {}
        for name, motion in self.motions.items():
            found[f"{name}_speed"] = (motion.speed, "m/s")
            found[f"{name}_power"] = (motion.power, "W")
            found[f"{name}_ripple"] = (motion.steady.ripple, "m/s")
            found[f"{name}_slip_work"] = (motion.slip_work, "N")
            found[f"{name}_largest_load"] = (motion.loads.largest, "1")
        return found


def tip_motions(drive: TipDrive, run_all: RunAll) -> TipMotions:
    """Search at the frequency of the drive."""
    machine, random = drive.machine, np.random.default_rng(1)
    thesis = run_all(partial(_run, drive, False), [_vector(drive.path, 0.5)])[0]
    starts = [two_piezo_ellipse(machine, drive.amplitude, phase) for phase in PHASES]
    run = partial(_run, drive, True)
    vectors = [_vector(path, height) for path in starts for height in HEIGHTS]
    tried = list(zip(vectors, run_all(run, vectors), strict=True))
    least, sinusoids = thesis.speed, {}

    def best(goal: str) -> tuple[np.ndarray, Motion]:
        limit = SETTLED * 2.0 * drive.frequency
        steady_ones = [one for one in tried if abs(one[1].steady.changed) <= limit * one[1].path.along]
        return max(steady_ones or tried, key=lambda one: GOALS[goal](one[1], least))

    for turn in range(ROUNDS):
        if turn == PLAIN:
            sinusoids = {goal: best(goal)[1] for goal in GOALS}
        vectors = []
        for goal in GOALS:
            near, _ = best(goal)
            step = random.normal(size=(TRIALS, near.size)) * SPREAD * 0.8**turn
            step[:, 4:] *= OVERTONE if turn >= PLAIN else 0.0
            vectors += list(near + step * np.concatenate([np.maximum(np.abs(near[:4]), 0.3), np.ones(near.size - 4)]))
        tried += zip(vectors, run_all(run, vectors), strict=True)
    return TipMotions(drive.frequency, thesis, sinusoids, {goal: best(goal)[1] for goal in GOALS})


def _vector(path: Ellipse, height: float) -> np.ndarray:
    """Numbers of a motion: size, height over width, lag, height over the surface; then the overtones over the width."""
    return np.concatenate([[1.0, path.normal / path.along, path.lag, height], np.zeros(4 * len(ORDERS))])


def _run(drive: TipDrive, scaled: bool, vector: np.ndarray) -> Motion:
    """The motion of a vector; scaled to the limits where asked for, else of the size of the drive."""
    machine, width = drive.machine, drive.path.along
    size, ratio, lag, height = vector[:4].tolist()
    parts = vector[4:].reshape(len(ORDERS), 4)
    factor = 1.0

    def path() -> Ellipse:
        along = factor * width
        tones = tuple(
            Overtone(order, complex(a, b) * along, complex(c, d) * along)
            for order, (a, b, c, d) in zip(ORDERS, parts.tolist(), strict=True)
            if any((a, b, c, d))
        )
        return Ellipse(along, abs(ratio) * along, lag, 0.0, tones)

    if scaled:
        factor = min(max(abs(size), 0.2), 1.0) / loads(machine, path(), drive.frequency).largest
    made = path()
    over = height * made.normal
    setting = Setting(made, drive.frequency, over)
    return Motion(made, over, loads(machine, made, drive.frequency), steady(machine, setting, shortest=0.1))
