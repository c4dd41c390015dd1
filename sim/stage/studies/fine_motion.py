"""Fine motion by the lean of the pressed tip: response of the held stage, gain by its stability margin, feedforward.

Open loop of an integral controller of rate w in periods T, with the response P of the held stage to a lean over its
static gain, notches N at its resonances and the filter F of the sensor:

    L(z) = w T/(1 - 1/z) P(z) N(z) F(z)/z

P is measured by a small step in the simulated machine: the modes of stage, tip and contact and the delay of the
converter are in it. The largest rate is that at which |1/(1 + L)| reaches `MARGIN` (Skogestad, Postlethwaite,
Multivariable Feedback Control (2005), section 2.4).

The lean for a wanted motion x balances the pads: lean = g (x + F(x)/k), k of tip and contact in series, F of the pads'
presliding elements, 1/g the gain of the stacks. Their hysteresis is inverted: the voltage whose play operators give
the stretch (Kuhnen, European J. Control 9 (2003) 407).
"""

import math
from dataclasses import dataclass

import numpy as np

from sim.numerics.elasto_plastic import elements_along, force_along
from sim.stage.constants import STEP, make_constants
from sim.stage.drive_setting import Actuation, TipDrive
from sim.stage.machine import Piezo, StageMachine
from sim.stage.run import StageSimulation
from sim.stage.sensors import Interferometer
from sim.stage.slip_elements import KNOTS, parabola
from sim.stage.state import piezo_response
from sim.stage.statics import Rest, rest_with_load
from sim.stage.studies.steps import LOAD_SHARE, static_stiffnesses

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
FEEDFORWARD = ("none", "gain", "friction", "hysteresis")
"""Feedforward of the lean: none; by the static gain; with the pads' friction; with the stacks' hysteresis besides."""


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

    def largest_rate(self, share: float, sections: np.ndarray) -> float:
        """Rate (1/s) at which the largest sensitivity first reaches `MARGIN`."""
        rates = np.geomspace(1.0, 1.0 / self.period, 400)
        loop = self.open_loop(1.0, share, sections)
        beyond = [np.max(1.0 / np.abs(1.0 + rate * loop)) > MARGIN for rate in rates]
        return float(rates[max(int(np.argmax(beyond)) - 1, 0)])


def held_stage(drive: TipDrive) -> HeldStage:
    """The response of a pressed stage, measured by a step of the lean."""
    actuation = Actuation(drive, STEP)
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
        self.rate, self.sections = max(
            ((held.largest_rate(share, one), one) for one in choices), key=lambda one: one[0]
        )
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


def inverse_hysteresis(piezo: Piezo, stretch: np.ndarray) -> np.ndarray:
    """Voltages about the bias (n,) that give stretches (n,), m, in turn, from rest at the bias."""
    response = piezo_response(piezo)
    play, out = np.zeros(response.thresholds.size), np.empty(stretch.size)
    for n, wanted in enumerate(stretch / response.gain):
        low, high = -0.5 * piezo.highest_voltage, 0.5 * piezo.highest_voltage
        for _ in range(40):
            # The sum of the operators rises with the voltage.
            volts = 0.5 * (low + high)
            moved = np.clip(play, volts - response.thresholds, volts + response.thresholds)
            short = volts + response.strength * float(response.weights @ (moved - volts)) < wanted
            low, high = (volts, high) if short else (low, volts)
        play, out[n] = moved, volts
    return out


def feedforward(machine: StageMachine, rest: Rest, kind: str, wanted: np.ndarray) -> np.ndarray:
    """Lean (n,) to command for a wanted motion (n,), m, from rest; `kind`: one of `FEEDFORWARD`."""
    if kind == "none":
        return np.zeros_like(wanted)
    series, pads = static_stiffnesses(make_constants(machine, rest), rest)
    mean = machine.piezo.stroke / machine.piezo.highest_voltage
    small = piezo_response(machine.piezo).small_signal_gain / mean
    if kind == "gain":
        return wanted * (1.0 + pads / series) / small
    limit = machine.pads.static_friction * float(rest.pad_loads.sum())
    elements = elements_along(KNOTS * machine.pads.presliding, parabola(KNOTS), limit)
    # A first row at rest leaves the elements without force.
    friction = force_along(np.append([0.0, 0.0], wanted), np.full(wanted.size + 2, limit), elements)[2:]
    lean = wanted + friction / series
    if kind == "friction":
        return lean / small
    lever = float(machine.tip.piezo_places[1, 0]) / machine.tip.height
    return inverse_hysteresis(machine.piezo, lean * lever) * mean / lever


def tracking_error(drive: TipDrive, held: HeldStage, kind: str) -> float:
    """Rms error, m, of a sine that the held stage follows by interferometer in a quiet place."""
    machine, actuation = drive.machine, Actuation(drive, STEP)
    rest = rest_with_load(machine, 0.0, LOAD_SHARE * machine.load)
    time = held.period * np.arange(1, round(TRACKED_PERIODS / TRACKED_FREQUENCY / held.period) + 1)
    wanted = TRACKED * np.sin(2.0 * math.pi * TRACKED_FREQUENCY * time)
    ahead = feedforward(machine, rest, kind, wanted)
    simulation, sensor = StageSimulation(machine, rest, STEP), Interferometer(machine.sensors, held.period)
    controller, lean, errors = FineController(held, sensor.share), 0.0, np.empty(time.size)
    for k in range(time.size):
        simulation.advance(actuation.commands(0.0, 0.0, 0.0, ahead[k] + lean), actuation.steps)
        errors[k] = wanted[k] - simulation.travel
        lean = controller.lean(wanted[k] - sensor.read(simulation.travel))
    return float(np.sqrt(np.mean(errors[time.size // 2 :] ** 2)))
