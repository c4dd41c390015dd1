"""Fine motion by the lean of the pressed tip: response of the held stage, gain by its stability margin, tracking.

Open loop of an integral controller of rate w in periods T, with the response P of the held stage to a lean over its
static gain, notches N at its resonances and the filter F of the sensor:

    L(z) = w T/(1 - 1/z) P(z) N(z) F(z)/z

P is measured by a small step in the simulated machine: the modes of stage, tip and contact and the delay of the
converter are in it. The largest rate is that at which |1/(1 + L)| reaches `MARGIN` (Skogestad, Postlethwaite,
Multivariable Feedback Control (2005), section 2.4).
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from sim.stage.constants import STEP, make_constants, piezo_response
from sim.stage.drive_setting import Actuation, TipDrive, knots_wave, step_times
from sim.stage.machine import StageMachine
from sim.stage.sensors import Interferometer
from sim.stage.simulation import StageRun, StageSimulation, drive_stage
from sim.stage.statics import Rest, rest_with_load
from sim.stage.studies import RunAll
from sim.stage.studies.feedforward import feedforward, static_stiffnesses

SIZES = {"1_count": None, "10nm": 10e-9, "100nm": 100e-9}
"""Commanded steps of the unloaded apex, m; none: one count of the converter on the two piezos, opposed."""
HOLD = 0.02
RISE = 0.002
STEPS_EACH_WAY = 6
LOAD_SHARE = 0.3
"""Part of weight and preload that the tip carries in fine motion: its friction holds the pads' fivefold."""


@dataclass(frozen=True)
class Staircase:
    """Steps up and down again."""

    run: StageRun  # the motion
    commanded_step: float  # of the unloaded apex by the stacks' mean gain, m a step
    levels: np.ndarray  # position along x at the end of each hold, m, shape (2 n + 1,)

    @property
    def mean_step(self) -> float:
        """Mean of the steps up after the first, m."""
        return float(np.mean(np.diff(self.levels)[1:STEPS_EACH_WAY]))


@dataclass(frozen=True)
class StepStudy:
    """Staircases by name, and what a count comes to."""

    staircases: dict[str, Staircase]  # by the names of `SIZES`
    count: float  # motion of the apex for one count of the converter on two piezos, opposed, by the mean gain, m
    static: float  # step of the stage over step of the free apex, in closed form, small signal

    def features(self) -> dict[str, tuple[float, str] | None]:
        found: dict[str, tuple[float, str] | None] = {"count": (self.count, "m"), "static_ratio": (self.static, "1")}
        for name, stairs in self.staircases.items():
            steps = np.diff(stairs.levels)
            found[f"step_{name}"] = (stairs.mean_step, "m")
            found[f"spread_{name}"] = (float(np.ptp(steps[1:STEPS_EACH_WAY])), "m")
            found[f"lost_{name}"] = (stairs.mean_step + float(steps[STEPS_EACH_WAY]), "m")
            found[f"left_{name}"] = (float(np.sum(steps)), "m")
        return found


def small_signal_gain(machine: StageMachine, rest: Rest) -> float:
    """Motion of the stage over that commanded by the stacks' mean gain, for steps well within presliding."""
    mean = machine.piezo.stroke / machine.piezo.highest_voltage
    series, pads = static_stiffnesses(make_constants(machine, rest), rest)
    return series / (series + pads) * piezo_response(machine.piezo).small_signal_gain / mean


def converter_count(machine: StageMachine) -> float:
    """Motion of the apex along x for one count on piezos 1 and 2, opposed, by the mean gain, m."""
    volts = machine.piezo.highest_voltage / 2**machine.piezo.bits
    spacing = float(machine.tip.piezo_places[1, 0] - machine.tip.piezo_places[0, 0])
    return 2.0 * machine.tip.height / spacing * volts * machine.piezo.stroke / machine.piezo.highest_voltage


def staircase(machine: StageMachine, size: float | None) -> Staircase:
    """Steps of one size (m; none: a count) up and down; each rises in 2 ms and is held for 20 ms."""
    commanded_step = converter_count(machine) if size is None else size
    rest = rest_with_load(machine, 0.0, LOAD_SHARE * machine.load)
    ups = np.concatenate([np.arange(STEPS_EACH_WAY + 1), np.arange(STEPS_EACH_WAY - 1, -1, -1)]) * commanded_step
    starts = HOLD * np.arange(ups.size)
    knots = np.column_stack([starts, starts + HOLD - RISE]).ravel()
    apex = np.zeros((knots.size, 3))
    apex[:, 0] = np.repeat(ups, 2)
    wave = knots_wave(machine, step_times(round(HOLD * ups.size / STEP), STEP), knots, apex)
    volt = machine.piezo.highest_voltage / 2**machine.piezo.bits
    run = drive_stage(machine, rest, np.round(wave / volt) * volt, STEP, 50)
    ends = starts + HOLD - RISE
    levels = [float(np.mean(run.position[(run.time > end - 0.25 * HOLD) & (run.time < end), 0])) for end in ends]
    return Staircase(run, commanded_step, np.array(levels))


def step_study(drive: TipDrive, run_all: RunAll) -> StepStudy:
    """Staircases of every size."""
    machine = drive.machine
    found = run_all(partial(staircase, machine), list(SIZES.values()))
    rest = rest_with_load(machine, 0.0, LOAD_SHARE * machine.load)
    return StepStudy(dict(zip(SIZES, found)), converter_count(machine), small_signal_gain(machine, rest))


LEAN_HIGHEST = 4e-6
MARGIN = 1.3
"""Largest sensitivity |1/(1 + L)|: a gain margin of at least 1.3/0.3 = 4.3, since the resonances are higher while the
stage still vibrates by more than the measured step."""
STEP_LEAN, STEP_PERIODS, STILL_PERIODS = 0.2e-6, 1000, 250
"""Lean (m) of the measured step, periods that are measured, and before them."""
NOTCH_ABOVE, NOTCH_QUALITY = 3.0, 1.0
"""A resonance gets a notch where the response is this many times the static one; frequency over width of the notch."""
TRACKED, TRACKED_FREQUENCY, TRACKED_PERIODS = 60e-9, 20.0, 4
"""Amplitude (m) and frequency (Hz) of the sine that is tracked, and its periods; the second half is judged."""
MOVE_TIME, MOVE_HOLD = 0.02, 0.1
"""s, in which the stage moves by `TRACKED`, and for which it is held there."""


@dataclass(frozen=True)
class HeldStage:
    """The stage held by its pressed tip, as a controller sees it."""

    period: float  # of the controller, s
    gain: float  # static motion over the commanded lean
    frequency: np.ndarray  # Hz, above zero, (n,)
    response: np.ndarray  # of the motion to a lean over `gain`, (n,), complex

    @property
    def resonances(self) -> np.ndarray:
        """Frequencies at which the response has a peak above `NOTCH_ABOVE`, Hz."""
        size = np.abs(self.response)
        peaks = (size[1:-1] > size[:-2]) & (size[1:-1] > size[2:]) & (size[1:-1] > NOTCH_ABOVE)
        return self.frequency[1:-1][peaks]

    def notches(self) -> np.ndarray:
        """Second-order sections (k, 6) of notches at the resonances."""
        from scipy.signal import iirnotch, tf2sos

        sections = [tf2sos(*iirnotch(one, NOTCH_QUALITY, 1.0 / self.period)) for one in self.resonances]
        return np.concatenate(sections) if sections else np.empty((0, 6))

    def open_loop(self, rate: float, share: float, sections: np.ndarray) -> np.ndarray:
        """L (n,) with a sensor that takes up a `share` of what it sees in a period."""
        back = np.exp(-2j * math.pi * self.frequency * self.period)
        loop = rate * self.period / (1.0 - back) * back * self.response * share / (1.0 - (1.0 - share) * back)
        for b0, b1, b2, a0, a1, a2 in sections:
            loop = loop * (b0 + b1 * back + b2 * back**2) / (a0 + a1 * back + a2 * back**2)
        return loop

    def margins(self, rate: float, share: float, sections: np.ndarray) -> dict[str, tuple[float, str]]:
        """Largest sensitivity |1/(1 + L)|; gain and phase that L leaves to -1 where it crosses the negative axis and
        the unit circle, between neighbouring frequencies by their chord."""
        loop = self.open_loop(rate, share, sections)
        step = np.diff(loop)
        at_axis, at_circle = np.imag(loop)[:-1] / -np.imag(step), (1.0 - np.abs(loop[:-1])) / np.diff(np.abs(loop))
        real = (loop[:-1] + at_axis * step).real[(at_axis >= 0.0) & (at_axis < 1.0)]
        unit = (loop[:-1] + at_circle * step)[(at_circle >= 0.0) & (at_circle < 1.0)]
        return {
            "sensitivity": (float(np.max(1.0 / np.abs(1.0 + loop))), "1"),
            "gain_margin": (float(-1.0 / min(real.min(initial=-1e-9), loop[-1].real)), "1"),
            "phase_margin": (float(np.abs(np.angle(-unit)).min(initial=math.pi)), "rad"),
        }

    def largest_rate(self, share: float, sections: np.ndarray) -> float:
        """Rate (1/s) at which the largest sensitivity first reaches `MARGIN`."""
        rates = np.geomspace(1.0, 1.0 / self.period, 400)
        loop = self.open_loop(1.0, share, sections)
        beyond = [np.max(1.0 / np.abs(1.0 + rate * loop)) > MARGIN for rate in rates]
        return float(rates[max(int(np.argmax(beyond)) - 1, 0)])


def held_stage(drive: TipDrive) -> HeldStage:
    """The response of a pressed stage, measured by a step of the lean."""
    actuation = Actuation(drive)
    simulation = StageSimulation(
        drive.machine, rest_with_load(drive.machine, 0.0, LOAD_SHARE * drive.machine.load), STEP
    )
    motion = []
    for k in range(STILL_PERIODS + STEP_PERIODS):
        lean = STEP_LEAN if k >= STILL_PERIODS else 0.0
        simulation.advance(actuation.commands(0.0, 0.0, 0.0, lean), actuation.steps)
        motion.append(simulation.travel)
    period = actuation.steps * STEP
    impulse = np.diff(motion[STILL_PERIODS - 1 :]) / STEP_LEAN
    response, frequency = np.fft.rfft(impulse), np.fft.rfftfreq(impulse.size, period)
    return HeldStage(period, float(np.sum(impulse)), frequency[1:], response[1:] / np.sum(impulse))


class FineController:
    """Integral controller of the lean with the largest rate that the margin allows. `share` is what the sensor takes up
    in a period; `notched`: whether notches at the resonances may be used; they are where they allow a larger rate."""

    def __init__(self, held: HeldStage, share: float, notched: bool = True) -> None:
        choices = [np.empty((0, 6)), *([held.notches()] if notched else [])]
        rates = ((held.largest_rate(share, one), one) for one in choices)
        self.rate, self.sections = max(rates, key=lambda one: one[0])
        self.margins = held.margins(self.rate, share, self.sections)
        self.per_error, self.total = self.rate / held.gain * held.period, 0.0
        self.state = np.zeros((len(self.sections), 2))

    def lean(self, error: float) -> float:
        """Lean of the next period, m, after an error, m."""
        self.total = lean = min(max(self.total + self.per_error * error, -LEAN_HIGHEST), LEAN_HIGHEST)
        for (b0, b1, b2, _, a1, a2), state in zip(self.sections, self.state, strict=True):
            # Transposed direct form of a second-order section.
            before, lean = lean, b0 * lean + state[0]
            state[0], state[1] = b1 * before - a1 * lean + state[1], b2 * before - a2 * lean
        return lean


@dataclass(frozen=True)
class Tracked:
    """A motion that the held stage follows."""

    time: np.ndarray  # s, (n,)
    wanted: np.ndarray  # m, (n,)
    error: np.ndarray  # m, (n,)

    @property
    def rms(self) -> float:
        """Rms error of the second half, m."""
        return float(np.sqrt(np.mean(self.error[self.time.size // 2 :] ** 2)))

    @property
    def largest(self) -> float:
        """Largest error, m."""
        return float(np.abs(self.error).max())

    def settled(self, limit: float) -> float | None:
        """Time after the end of a move from which the error stays within a limit (m), s; None if never."""
        outside = self.time[np.abs(self.error) > limit]
        if outside.size and outside[-1] == self.time[-1]:
            return None
        return max(float(outside[-1]) - MOVE_TIME, 0.0) if outside.size else 0.0


def sine(held: HeldStage) -> tuple[np.ndarray, np.ndarray]:
    """Times (n,) of the periods, s, and a sine there, m."""
    time = held.period * np.arange(1, round(TRACKED_PERIODS / TRACKED_FREQUENCY / held.period) + 1)
    return time, TRACKED * np.sin(2.0 * math.pi * TRACKED_FREQUENCY * time)


def short_move(held: HeldStage) -> tuple[np.ndarray, np.ndarray]:
    """Times (n,) of the periods, s, and a move of least jerk that is held there, m (Flash, Hogan, J. Neuroscience 5
    (1985) 1688)."""
    time = held.period * np.arange(1, round((MOVE_TIME + MOVE_HOLD) / held.period) + 1)
    part = np.minimum(time / MOVE_TIME, 1.0)
    return time, TRACKED * part**3 * (10.0 - 15.0 * part + 6.0 * part**2)


def tracked(
    drive: TipDrive, held: HeldStage, motion: Callable[[HeldStage], tuple[np.ndarray, np.ndarray]], kind: str
) -> Tracked:
    """A motion that the held stage follows by interferometer in a quiet place, with a feedforward of `FEEDFORWARD`."""
    machine, actuation = drive.machine, Actuation(drive)
    rest = rest_with_load(machine, 0.0, LOAD_SHARE * machine.load)
    time, wanted = motion(held)
    ahead = feedforward(machine, rest, kind, wanted)
    simulation, sensor = StageSimulation(machine, rest, STEP), Interferometer(machine.sensors, held.period)
    controller, lean, errors = FineController(held, sensor.share), 0.0, np.empty(time.size)
    for k in range(time.size):
        simulation.advance(actuation.commands(0.0, 0.0, 0.0, ahead[k] + lean), actuation.steps)
        errors[k] = wanted[k] - simulation.travel
        lean = controller.lean(wanted[k] - sensor.read(simulation.travel))
    return Tracked(time, wanted, errors)
