"""The driven stage, simulated in successive pieces, so that a controller can act between them."""

from __future__ import annotations

import numpy as np

from sim.integration.simulate import SimulationError
from sim.stage.machine import StageMachine
from sim.stage.run import StageRun, columns
from sim.stage.statics import Rest


class StageSimulation:
    """The stage from rest on, under voltages given in successive pieces.

    Args:
        machine: the driven machine.
        rest: initial state.
        step: s; see `sim.stage.constants.STEP`.
        velocity: of the stage along x at the start, m/s.

    Raises:
        InputError: a step too long for the machine.
    """

    def __init__(self, machine: StageMachine, rest: Rest, step: float, velocity: float = 0.0) -> None:
        from sim.stage.constants import make_constants, make_state

        self.machine, self.rest, self.step = machine, rest, step
        self.constants, self.state = make_constants(machine, rest, step), make_state(machine, rest)
        self.state.velocity[0] = velocity
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

        Returns:
            the rows written, shape (steps / stride, columns); `record` has all of them by name.
        """
        from sim.stage.dynamics import advance

        rows = np.empty((commands.shape[0] // stride, columns(self.machine)))
        advance(self.constants, self.state, np.ascontiguousarray(commands, dtype=float), rows, stride)
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
