"""One simulated motion of the stage, and its record with columns by name; the steps are those of `step_kernel.py`.

This module imports numba: import it only when something is simulated.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from sim.integration.compiled.views import Packed
from sim.integration.simulate import SimulationError
from sim.stage.constants import make_constants, make_state
from sim.stage.machine import StageMachine
from sim.stage.statics import Rest
from sim.stage.step_kernel import HEAD, PER_ACTUATOR, PER_PAD, Loads, advance


@dataclass(frozen=True)
class StageRun:
    """A simulated motion; arrays over time have shape (n,) unless said otherwise, SI."""

    # machine, rest: the simulated machine and its initial state
    machine: StageMachine
    rest: Rest
    rows: np.ndarray  # as the kernel writes them, shape (n, columns)

    @property
    def time(self) -> np.ndarray:
        return self.rows[:, 0]

    @cached_property
    def position(self) -> np.ndarray:
        """Motion of the middle of the drive surface (x, y) and yaw from the start, m, m, rad, shape (n, 3).

        The middle is below the centre of mass: the stage's pitch and roll move it.
        """
        centre = np.asarray(self.machine.stage.centre, dtype=float)
        q = self.rows[:, 1:7]
        start = self.rest.attitude
        x = q[:, 0] - (q[:, 4] - start[2]) * centre[2] + q[:, 5] * centre[1]
        y = q[:, 1] + (q[:, 3] - start[1]) * centre[2] - q[:, 5] * centre[0]
        return np.column_stack([x, y, q[:, 5]])

    @property
    def attitude(self) -> np.ndarray:
        """Heave of the centre of mass (m), roll about x, pitch about y (rad), from the unloaded pads, shape (n, 3)."""
        return self.rows[:, 3:6]

    @property
    def velocity(self) -> np.ndarray:
        """Velocity of the centre of mass, m/s, and angular velocity, rad/s, shape (n, 6)."""
        return self.rows[:, 7:13]

    @property
    def energy(self) -> dict[str, np.ndarray]:
        """`kept` (kinetic and potential), `drive` (work of the piezos' stretching), and the heats of pads, tip contacts
        and damping, J: kept - kept at the start = drive - heats."""
        names = ("kept", "drive", "pads", "contacts", "damping")
        return {name: self.rows[:, 13 + i] for i, name in enumerate(names)}

    def apex(self, actuator: int) -> np.ndarray:
        """Displacement of the apex of a tip from mid-stroke, m, shape (n, 3)."""
        return self._actuator(actuator)[:, 0:3]

    def tip_force(self, actuator: int) -> np.ndarray:
        """Force of a tip on the stage, N, shape (n, 3)."""
        return self._actuator(actuator)[:, 3:6]

    def tip_impulse(self, actuator: int) -> np.ndarray:
        """Integral of `tip_force` over every step, N s, shape (n, 3)."""
        return self._actuator(actuator)[:, 6:9]

    def contact_time(self, actuator: int) -> np.ndarray:
        """Time for which the tip has been in contact so far, s."""
        return self._actuator(actuator)[:, 9]

    def voltage(self, actuator: int) -> np.ndarray:
        """Across the stacks, V, shape (n, 3)."""
        return self._actuator(actuator)[:, 10:13]

    def pad_force(self, pad: int) -> np.ndarray:
        """Force of a pad on the stage, N, shape (n, 3)."""
        return self._pad(pad)[:, 0:3]

    def lifted_time(self, pad: int) -> np.ndarray:
        """Time for which the pad has been off its way so far, s."""
        return self._pad(pad)[:, 3]

    def mean_tip_load(self, start: float, end: float) -> float:
        """Mean force upwards of all tips between two times, N."""
        ends = [int(np.argmin(np.abs(self.time - t))) for t in (start, end)]
        gained = sum(float(np.diff(self.tip_impulse(k)[ends, 2])[0]) for k in range(len(self.machine.actuators)))
        return gained / float(np.diff(self.time[ends])[0])

    def mean_velocity(self, start: float, end: float) -> np.ndarray:
        """Mean velocity of the middle of the drive surface between two times, m/s, m/s, rad/s, shape (3,)."""
        ends = [int(np.argmin(np.abs(self.time - t))) for t in (start, end)]
        return np.diff(self.position[ends], axis=0)[0] / float(np.diff(self.time[ends])[0])

    def _actuator(self, actuator: int) -> np.ndarray:
        at = HEAD + PER_ACTUATOR * actuator
        return self.rows[:, at : at + PER_ACTUATOR]

    def _pad(self, pad: int) -> np.ndarray:
        at = HEAD + PER_ACTUATOR * len(self.machine.actuators) + PER_PAD * pad
        return self.rows[:, at : at + PER_PAD]


def columns(machine: StageMachine) -> int:
    """Number of columns of a row."""
    return HEAD + PER_ACTUATOR * len(machine.actuators) + PER_PAD * len(machine.pads.places)


class StageSimulation:
    """The stage from rest on, or with a velocity along x, m/s, under voltages given in successive pieces, in steps of
    some seconds (`sim.stage.constants.STEP`).

    Raises:
        InputError: a step too long for the machine.
    """

    def __init__(self, machine: StageMachine, rest: Rest, step: float, velocity: float = 0.0) -> None:
        self.machine, self.rest, self.step = machine, rest, step
        self.constants, self.state = make_constants(machine, rest, step), make_state(machine, rest)
        self.state.velocity[0] = velocity
        actuators, pads = len(machine.actuators), len(machine.pads.places)
        shapes = ((3,), (3,), (6,), (actuators, 3), (pads, 3), (actuators, 3), (1,), self.state.bend.shape)
        self._packed = Packed(self.constants), Packed(self.state), Packed(Loads(*map(np.zeros, shapes)))
        self._rows: list[np.ndarray] = []
        self._set_back = 0.0

    @property
    def time(self) -> float:
        """s."""
        return float(self.state.clock[0])

    @property
    def travel(self) -> float:
        """Motion of the middle of the drive surface along x since the start, m."""
        q, centre = self.state.position, self.machine.stage.centre
        return float(self._set_back + q[0] - (q[4] - self.rest.attitude[2]) * centre[2] + q[5] * centre[1])

    def set_back(self, distance: float) -> None:
        """Shift the stage back along its travel with velocities and contacts kept, to continue beyond the travel.

        `travel` and the record are not affected.
        """
        self.state.position[0] -= distance
        self._set_back += distance

    def advance(self, commands: np.ndarray, stride: int = 10) -> np.ndarray:
        """Continue under the commanded voltages.

        Args:
            commands: at the middle of each step, V, shape (steps, actuators, 3).
            stride: steps a row, which is written at the middle of its last step.

        Returns:
            the rows written, shape (steps / stride, columns); `record` has all of them by name.
        """
        rows = np.empty((commands.shape[0] // stride, columns(self.machine)))
        constants, state, loads = self._packed
        advance(constants, state, loads, np.ascontiguousarray(commands, dtype=float), rows, stride)
        if not np.isfinite(self.state.position).all():
            raise SimulationError(f"stage: no finite motion at {self.time:.6g} s")
        rows[:, 1] += self._set_back
        self._rows.append(rows)
        return rows

    def record(self) -> StageRun:
        """All that has been simulated so far."""
        return StageRun(self.machine, self.rest, np.concatenate(self._rows))


def drive_stage(
    machine: StageMachine, rest: Rest, commands: np.ndarray, step: float, stride: int = 10, velocity: float = 0.0
) -> StageRun:
    """Simulate the stage under voltages known beforehand; arguments as `StageSimulation` and its `advance`."""
    simulation = StageSimulation(machine, rest, step, velocity)
    simulation.advance(commands, stride)
    return simulation.record()
