"""Setting of a run of the stage: start, height of the tip, and run-up to its speed.

A voltage wave is an array of shape (steps, actuators, 3): the voltages at the middle of each step. Stretches are turned
into volts by the stack's mean gain (stroke over highest voltage), as for a drive without feedback.
"""

import math
from dataclasses import dataclass

import numpy as np

from sim.stage.constants import STEP
from sim.stage.machine import StageMachine
from sim.stage.simulation import StageRun, StageSimulation, drive_stage
from sim.stage.statics import over_drive_surface


@dataclass(frozen=True)
class Overtone:
    """A harmonic of a path: real part of the complex amplitudes times ``exp(i order turn)``."""

    order: int  # 2 or more
    along: complex  # in the direction of motion, m
    normal: complex  # up, m


@dataclass(frozen=True)
class Ellipse:
    """A path of one tip: an ellipse, with overtones any closed path."""

    along: float  # amplitude in the direction of motion, m
    normal: float  # amplitude up, m
    lag: float = 0.0  # of the motion along behind a quarter turn against the motion up, rad: 0 is an upright ellipse
    direction: float = 0.0  # of the stage's motion, rad from x
    overtones: tuple[Overtone, ...] = ()

    def at(self, turn: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Displacement in the direction of motion and up, m, at turns (n,), rad."""
        along, up = -self.along * np.cos(turn + self.lag), self.normal * np.sin(turn)
        for tone in self.overtones:
            wave = np.exp(1j * tone.order * turn)
            along, up = along + (tone.along * wave).real, up + (tone.normal * wave).real
        return along, up


def two_piezo_ellipse(machine: StageMachine, amplitude: float, phase: float) -> Ellipse:
    """The path for strokes A sin(wt), A sin(wt + phase) of piezos 1 and 2, the third half-way: the thesis's drive.

    along = 2 A (h/D) sin(phase/2), normal = A cos(phase/2). With the second piezo ahead by `phase`, 0 to pi, the tip
    moves towards +x at its apex.
    """
    spacing = float(machine.tip.piezo_places[1, 0] - machine.tip.piezo_places[0, 0])
    lever = machine.tip.height / spacing
    return Ellipse(2.0 * amplitude * lever * math.sin(0.5 * phase), amplitude * math.cos(0.5 * phase))


@dataclass(frozen=True)
class TipDrive:
    """A machine driven by the strokes of `two_piezo_ellipse`."""

    machine: StageMachine  # the driven machine
    amplitude: float  # of a piezo, m
    phase: float  # between piezos 1 and 2, rad
    frequency: float  # Hz

    @property
    def path(self) -> Ellipse:
        """The path of the tip."""
        return two_piezo_ellipse(self.machine, self.amplitude, self.phase)


def largest_stroke(machine: StageMachine, ellipse: Ellipse) -> float:
    """Largest amplitude of a piezo over the ellipse, m."""
    c, s = math.cos(ellipse.direction), math.sin(ellipse.direction)
    reach = (machine.tip.piezo_places @ [c, s]) / machine.tip.height
    # Stretch i: normal sin(p) + reach_i along cos(p + lag); amplitude of the sum of two phasors.
    real = -reach * ellipse.along * math.sin(ellipse.lag) + ellipse.normal
    imaginary = reach * ellipse.along * math.cos(ellipse.lag)
    return float(np.max(np.hypot(real, imaginary)))


def scaled_to(machine: StageMachine, ellipse: Ellipse, amplitude: float) -> Ellipse:
    """The ellipse enlarged until its most active piezo has `amplitude`, m."""
    factor = amplitude / largest_stroke(machine, ellipse)
    return Ellipse(ellipse.along * factor, ellipse.normal * factor, ellipse.lag, ellipse.direction)


def volts_for(machine: StageMachine, x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Voltages (n, 3) that bring an unloaded apex to (x, y, z) from mid-stroke, m, by the stacks' mean gain."""
    places, height = machine.tip.piezo_places, machine.tip.height
    stretch = z[:, None] - (x[:, None] * places[:, 0] + y[:, None] * places[:, 1]) / height
    return machine.piezo.bias + stretch * (machine.piezo.highest_voltage / machine.piezo.stroke)


def step_times(count: int, step: float, start: float = 0.0) -> np.ndarray:
    """Middles of `count` steps, s."""
    return start + (np.arange(count) + 0.5) * step


def ellipse_wave(
    machine: StageMachine,
    ellipses: Ellipse | list[Ellipse],
    frequency: float,
    time: np.ndarray,
    envelope: np.ndarray | float = 1.0,
    phases: np.ndarray | None = None,
) -> np.ndarray:
    """Voltages (n, actuators, 3) at times (n,), s, for ellipses (one for all actuators, or one each) run through at
    `frequency`, Hz.

    The `envelope` (n,) scales the ellipse; `phases`: of each actuator's turn, rad.
    """
    actuators = len(machine.actuators)
    paths = [ellipses] * actuators if isinstance(ellipses, Ellipse) else ellipses
    out = np.empty((time.size, actuators, 3))
    for k, path in enumerate(paths):
        turn = 2.0 * math.pi * frequency * time + (0.0 if phases is None else phases[k])
        along, up = path.at(turn)
        along, up = along * envelope, up * envelope
        out[:, k] = volts_for(machine, along * math.cos(path.direction), along * math.sin(path.direction), up)
    return out


def knots_wave(machine: StageMachine, time: np.ndarray, knots: np.ndarray, apex: np.ndarray) -> np.ndarray:
    """Voltages (n, actuators, 3) at times (n,), s, for unloaded apexes led along straight lines through `apex` (m, 3),
    m, at `knots` (m,), s."""
    x, y, z = (np.interp(time, knots, apex[:, i]) for i in range(3))
    return np.repeat(volts_for(machine, x, y, z)[:, None, :], len(machine.actuators), axis=1)


class Actuation:
    """Voltages of one period of a drive with one actuator: an ellipse with a part of its travel, a lift and a lean."""

    def __init__(self, drive: TipDrive) -> None:
        self.machine, self.path = drive.machine, drive.path
        self.steps = round(1.0 / drive.frequency / STEP)
        turn = 2.0 * math.pi * (np.arange(self.steps) + 0.5) / self.steps
        self.along, self.up = -np.cos(turn) * self.path.along, np.sin(turn) * self.path.normal
        self.ramp = (np.arange(self.steps) + 0.5) / self.steps
        self.last = np.zeros(4)

    def commands(self, along: float, rise: float, lift: float, lean: float) -> np.ndarray:
        """Voltages (steps, 1, 3) for an ellipse of signed amplitude along the travel, -1 to 1, and amplitude of its
        height, 0 to 1, its middle lifted, and along x, m; each changes linearly over the period from its last value.
        """
        new = np.array([along, rise, lift, lean])
        now = self.last + self.ramp[:, None] * (new - self.last)
        self.last = new
        x = now[:, 0] * self.along + now[:, 3]
        z = now[:, 1] * self.up + now[:, 2]
        volts = volts_for(self.machine, x, np.zeros(self.steps), z)
        count = self.machine.piezo.highest_voltage / 2**self.machine.piezo.bits
        return (np.round(volts / count) * count)[:, None, :]


RISE_CYCLES = 10
SHORTEST_RISE, LONGEST_RISE = 2e-3, 20e-3
"""s: the ellipse grows over ten periods within these."""
GUESS = 1.8
"""Steady speed over X f, with which a first run begins."""
SETTLED = 0.01
"""A speed is steady when it changes by less than this part of X f in a fifth of the run."""
PIECES = 10
"""Pieces of the shortest run; before each the stage is set back, so that it stays near mid-travel."""
LOOKED_AT = (1, 2, 4, 8)
"""Shortest runs after which it is checked whether the speed is steady: the fifths grow, and
fluctuations average out."""
STRIDE, STEADY_STRIDE = 20, 10
"""Steps to a row, and where a swing is read off the rows."""


@dataclass(frozen=True)
class Setting:
    """A drive with elliptical tips."""

    ellipse: Ellipse  # of every tip
    frequency: float  # Hz
    height: float  # of the apex at mid-stroke over the drive surface without tips, m
    position: float = 0.0  # of the stage's middle at the start, m
    velocity: float = 0.0  # of the stage along x at the start, m/s
    phases: tuple[float, ...] | None = None  # of each actuator's turn, rad; none when all turn together


def run_setting(
    machine: StageMachine, setting: Setting, duration: float, step: float = STEP, stride: int = STRIDE
) -> StageRun:
    """Drive the stage at a setting for `duration`, s, its ellipse grown over the first periods."""
    time = step_times(round(duration / step / stride) * stride, step)
    rest = over_drive_surface(machine, setting.position, setting.height)
    return drive_stage(machine, rest, grown_wave(machine, setting, time), step, stride, setting.velocity)


def grown_wave(machine: StageMachine, setting: Setting, time: np.ndarray, cycles: float = RISE_CYCLES) -> np.ndarray:
    """Voltages (n, actuators, 3) at times since the start, s, shape (n,): the ellipse grows, then stays."""
    rise = min(max(cycles / setting.frequency, SHORTEST_RISE * min(cycles / RISE_CYCLES, 1.0)), LONGEST_RISE)
    phases = None if setting.phases is None else np.array(setting.phases)
    return ellipse_wave(machine, setting.ellipse, setting.frequency, time, np.minimum(time / rise, 1.0), phases)


@dataclass(frozen=True)
class Steady:
    """A drive at its steady speed, averaged over whole periods at the end of a run."""

    velocity: np.ndarray  # along x, across it (m/s) and of yaw (rad/s), shape (3,)
    changed: float  # velocity along x in the last fifth of the run less that in the fifth before, m/s
    swing: float  # of the first tip's apex along x, peak to peak, m
    tip_load: float  # mean force of the tips on the stage, N
    contact_share: float  # part of the time that the first tip touches
    lifted_share: float  # part of the time that the pad most often lifted is off its way
    largest_tip_force: float  # N
    ripple: float  # of the velocity along x, m/s rms
    power: float  # mechanical, that the stacks put in, W
    slip_heat: float  # of the tips on the stage, W


def steady(
    machine: StageMachine, setting: Setting, shortest: float, guess: float = GUESS, cycles: float = RISE_CYCLES
) -> Steady:
    """Steady speed at a setting, whose position and velocity are chosen here, about mid-travel.

    The run continues until its last two fifths are equally fast: pads may take a second to bring a stage to rest
    that its tip drives too weakly, and a speed on the way down is not steady. The shortest run has five periods, within
    `shortest` and 0.5 s. Another `guess` of the speed over X f, or fewer `cycles` of growth, may find another cycle.
    """
    duration = min(max(shortest, 5.0 / setting.frequency), 0.5) / PIECES
    steps = round(duration / STEP / STEADY_STRIDE) * STEADY_STRIDE
    full = 2.0 * setting.ellipse.along * setting.frequency
    begin = -0.5 * guess * full * duration
    simulation = StageSimulation(machine, over_drive_surface(machine, begin, setting.height), STEP, guess * full)
    piece, changed = 0, math.inf
    while abs(changed) > SETTLED * full and piece < LOOKED_AT[-1] * PIECES:
        before = simulation.travel
        time = step_times(steps, STEP, simulation.time)
        simulation.advance(grown_wave(machine, setting, time, cycles), STEADY_STRIDE)
        gone = simulation.travel - before
        simulation.set_back(begin + 1.5 * gone)
        begin = -0.5 * gone
        piece += 1
        if piece in [runs * PIECES for runs in LOOKED_AT]:
            changed = _averaged(simulation.record(), setting.frequency).changed
    return _averaged(simulation.record(), setting.frequency)


def _averaged(run: StageRun, frequency: float) -> Steady:
    """Averages over the last fifth of a run."""
    end = float(run.time[-1])
    window = max(1, math.floor(0.2 * end * frequency)) / frequency
    last, before = run.mean_velocity(end - window, end), run.mean_velocity(end - 2 * window, end - window)
    late = run.time >= end - window
    share = float(np.ptp(run.contact_time(0)[late])) / window
    lifted = max(float(np.ptp(run.lifted_time(k)[late])) for k in range(len(run.machine.pads.places))) / window
    return Steady(
        velocity=last,
        changed=float(last[0] - before[0]),
        swing=float(np.ptp(run.apex(0)[late, 0])),
        tip_load=run.mean_tip_load(end - window, end),
        contact_share=share,
        lifted_share=lifted,
        largest_tip_force=float(run.tip_force(0)[late, 2].max()),
        ripple=float(np.std(run.velocity[late, 0])),
        power=float(np.ptp(run.energy["drive"][late])) / window,
        slip_heat=float(np.ptp(run.energy["contacts"][late])) / window,
    )
