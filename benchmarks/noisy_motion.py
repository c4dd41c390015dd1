"""Estimation of a driven mass from a noisy position: bias and scatter of four methods on the same records.

    python -m benchmarks.noisy_motion --draws 8

A mass in closed loop, with LuGre's bristles, Stribeck's curve and viscous friction, slides in a simulator that shares
neither a law nor an integrator with the program (`benchmarks/generators/sliding_mass.py`). The noise of its position is
drawn anew for each record. Compared are

- balance: the fit of the force balance along the filtered motion, whose noise biases the values;
- SIMEX: the same with noise added at several levels, extrapolated by a parabola to none (Cook and Stefanski, J. Am.
  Stat. Assoc. 89 (1994) 1314);
- shooting: short horizons of a simulation of the model, each from a state of its own that is estimated with the values
  (H. G. Bock, in Modelling of Chemical Reaction Systems, 1981);
- compare: what the program reports, along the motion of a state observer where the balance is above the noise.

Printed by noise and value: mean relative error and standard deviation over the draws, percent; and seconds of a fit.
"""

import argparse
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

import numpy as np

from benchmarks.true_models import FORCE_NOISE, ROWS, Case, Truth, truth_of
from sim.effects.catalogue import Model as SimulatedModel
from sim.integration.drive import Drive
from sim.integration.simulate import SimulationError, simulate
from sysid.compare import compare, load_problem
from sysid.estimation.reference_fit import fit_stated_model
from sysid.prediction.effect_terms import values_of
from sysid.prediction.force_balance.record import ForceBalanceRecord
from sysid.prediction.model import Model
from sysid.prediction.problem import Problem

CHANNELS = ("time [s]", "position [m]", "drive_force [N]")
LEVELS, PER_LEVEL = (0.5, 1.0, 1.5, 2.0), 2
"""Variances of the noise that SIMEX adds, over that of the records, and draws of each."""
STEPS, SETTLING, STEP = 10, 3, 1e-4
"""Gauss-Newton steps of the values and of the states after each, and relative step of a derivative."""


def problem_of(truth: Truth, columns: Sequence[dict[str, np.ndarray]], noise: float) -> Problem:
    """The problem of two records of these columns, with the standard deviation of the position's noise stated."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        lines = ["schema = 1", "[rig]", 'kind = "force-drive"', 'input_hold = "linear"', "[rig.known]"]
        lines += [f'mass = "{truth.known["mass"]}"', "[model]", f"effects = {list(truth.effects)}".replace("'", '"')]
        for number, (table, role) in enumerate(zip(columns, ("fit", "validate"), strict=True)):
            rows = np.column_stack([table[channel] for channel in CHANNELS])
            np.savetxt(folder / f"{number}.csv", rows, "%.12g", ",", header=",".join(CHANNELS), comments="")
            lines += ["[[record]]", f'file = "{number}.csv"', f'role = "{role}"']
        lines += ["[noise]", f'position = "{noise} m"', f'drive_force = "{FORCE_NOISE} N"']
        (folder / "experiment.toml").write_text("\n".join(lines), "utf-8")
        return load_problem(folder)


def noisy(columns: dict[str, np.ndarray], random: np.random.Generator, **stds: float) -> dict[str, np.ndarray]:
    """The columns with white noise of these standard deviations added, by the name of the channel."""
    added = {channel: stds.get(channel.partition(" ")[0], 0.0) for channel in columns}
    return {channel: y + added[channel] * random.standard_normal(y.size) for channel, y in columns.items()}


def by_balance(truth: Truth, columns: Sequence[dict[str, np.ndarray]], noise: float) -> dict[str, float]:
    """Values of the fit along the filtered motion."""
    return dict(fit_stated_model(problem_of(truth, columns, noise)).fitted.model.values)


def by_simex(truth: Truth, columns: Sequence[dict[str, np.ndarray]], noise: float) -> dict[str, float]:
    """Values extrapolated from fits with more noise."""
    random, found = np.random.default_rng(1), {0.0: by_balance(truth, columns, noise)}
    for level in LEVELS:
        draws = [
            by_balance(
                truth,
                [noisy(one, random, position=np.sqrt(level) * noise) for one in columns],
                np.sqrt(1 + level) * noise,
            )
            for _ in range(PER_LEVEL)
        ]
        found[level] = {key: float(np.mean([one[key] for one in draws])) for key in draws[0]}
    return {
        key: float(np.polyval(np.polyfit(list(found), [one[key] for one in found.values()], 2), -1.0))
        for key in found[0.0]
    }


def by_compare(truth: Truth, columns: Sequence[dict[str, np.ndarray]], noise: float) -> dict[str, float]:
    """Values that the program reports."""
    return dict(compare(problem_of(truth, columns, noise)).base.fitted.model.values)


@dataclass
class Horizons:
    """Simulations of a few rows of the record of the fit, each from a state of its own.

    After n rows of step h the noise s_F of the force has moved the mass m by s_F h^2 sqrt(n^3 / 3) / m: a horizon ends
    where that is the noise of the position.
    """

    model: Model
    time: np.ndarray  # (n,)
    position: np.ndarray  # measured, (n,)
    force: np.ndarray  # measured, (n,)
    noise: float  # of the position, m
    mass: float

    @property
    def rows(self) -> int:
        """Rows of a horizon, more than the values of a state."""
        moved = FORCE_NOISE * (self.time[1] - self.time[0]) ** 2 / self.mass
        return max(6, round((np.sqrt(3.0) * self.noise / moved) ** (2.0 / 3.0)))

    def residual(self, values: dict[str, float], states: np.ndarray) -> np.ndarray:
        """Measured less simulated positions in standard deviations, (horizons, rows), from states (horizons, 3)."""
        effects = self.model.effects
        laws = SimulatedModel(effects, tuple(values_of(effect, values) for effect in effects))
        out = np.empty((states.shape[0], self.rows))
        for k, (position, velocity, bristle) in enumerate(states):
            rows = slice(k * self.rows, (k + 1) * self.rows)
            rates = np.append(np.diff(self.force[rows]) / np.diff(self.time[rows]), 0.0)
            drive = Drive(self.time[rows], self.force[rows], rates)
            run = simulate(
                laws,
                drive,
                self.time[rows],
                mass=values["rig.mass"],
                position=position,
                velocity=velocity,
                bristle=np.array([bristle]),
                tolerance=1e-9,
            )
            out[k] = (self.position[rows] - run.position) / self.noise
        return out

    def settled(self, values: dict[str, float], states: np.ndarray, sizes: np.ndarray, steps: int) -> np.ndarray:
        """States (horizons, 3) after damped Gauss-Newton steps of each horizon by itself."""
        residual, damping = self.residual(values, states), np.full(states.shape[0], 1e-3)
        for _ in range(steps):
            columns = self.sensitivity(values, states, sizes, residual)
            normal, right = columns.transpose(0, 2, 1) @ columns, np.einsum("kij,ki->kj", columns, residual)
            scaled = normal * (1.0 + damping[:, None, None] * np.eye(3)) + 1e-12 * np.eye(3)
            trial = states - np.linalg.solve(scaled, right[:, :, None])[:, :, 0] * sizes
            new = self.residual(values, trial)
            lower = np.sum(new**2, axis=1) < np.sum(residual**2, axis=1)
            states, residual = np.where(lower[:, None], trial, states), np.where(lower[:, None], new, residual)
            damping = np.where(lower, 0.1 * damping, 10.0 * damping)
        return states

    def sensitivity(
        self, values: dict[str, float], states: np.ndarray, sizes: np.ndarray, residual: np.ndarray
    ) -> np.ndarray:
        """Derivatives (horizons, rows, 3) of the residual by the states over their sizes."""
        shifts = STEP * sizes * np.eye(3)
        return np.stack([(self.residual(values, states + shift) - residual) / STEP for shift in shifts], axis=2)


def by_shooting(truth: Truth, columns: Sequence[dict[str, np.ndarray]], noise: float) -> dict[str, float]:
    """Values by Gauss-Newton steps with the states of the horizons projected out (G. H. Golub and V. Pereyra, SIAM J.
    Numer. Anal. 10 (1973) 413)."""
    problem = problem_of(truth, columns, noise)
    start = fit_stated_model(problem).fitted.model
    record = problem.records[0]
    position, force = record.channels["position"], record.channels["drive_force"]
    horizons = Horizons(start, record.time, position, force, noise, start.values["rig.mass"])
    keys, values = [u.key for u in start.unknowns], dict(start.values)
    prepared = problem.fit_records[0]
    assert isinstance(prepared, ForceBalanceRecord)
    axis, first = prepared.axis, np.arange(ROWS // horizons.rows) * horizons.rows
    friction = horizons.force - values["rig.mass"] * axis.acceleration
    level, stiffness = values["lugre.force"], values["lugre.stiffness"]
    stretch = np.clip(friction, -level, level) / stiffness
    states = np.column_stack([horizons.position[first], axis.velocity[first], stretch[first]])
    sizes = np.array([noise, float(np.std(axis.velocity)), level / stiffness])
    states = horizons.settled(values, states, sizes, 3 * SETTLING)
    residual, damping = horizons.residual(values, states), 1e-3
    for _ in range(STEPS):
        moved = [horizons.residual({**values, key: values[key] * (1.0 + STEP)}, states) for key in keys]
        of_values = np.stack([(one - residual) / STEP for one in moved], axis=2)
        basis = [np.linalg.qr(one)[0] for one in horizons.sensitivity(values, states, sizes, residual)]
        left = np.concatenate([r - q @ (q.T @ r) for r, q in zip(residual, basis, strict=True)])
        projected = np.concatenate([j - q @ (q.T @ j) for j, q in zip(of_values, basis, strict=True)])
        normal = projected.T @ projected
        change = np.linalg.solve(normal + damping * np.diag(np.diag(normal)), -projected.T @ left)
        trial = {**values, **{key: values[key] * float(np.exp(c)) for key, c in zip(keys, change, strict=True)}}
        try:
            trial_states = horizons.settled(trial, states, sizes, SETTLING)
            new = horizons.residual(trial, trial_states)
        except SimulationError:
            new = np.full_like(residual, np.inf)
        if np.sum(new**2) >= np.sum(residual**2):
            damping *= 10.0
            continue
        last = np.sum(new**2) > (1.0 - 1e-4) * np.sum(residual**2)
        values, states, residual, damping = trial, trial_states, new, 0.1 * damping
        if last:
            break
    return values


def _plain(key: str) -> str:
    """A key under the public name of its effect, whose variant the program may have chosen."""
    return f"{key.partition(':')[0]}.{key.rpartition('.')[2]}" if ":" in key else key


Method = Callable[[Truth, Sequence[dict[str, np.ndarray]], float], dict[str, float]]
METHODS: dict[str, Method] = {"balance": by_balance, "SIMEX": by_simex, "shooting": by_shooting, "compare": by_compare}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--draws", type=int, default=8)
    parser.add_argument("--noise", type=float, nargs="*", default=[50.0, 500.0], help="of the position, nm")
    parser.add_argument("--seed", type=int, default=1, help="of the true values")
    options = parser.parse_args()
    truth = truth_of(Case("force-drive, closed loop", "lugre", 0.0, "stated", options.seed))
    exact = [truth.columns(record) for record in (0, 1)]
    keys = [key for key in truth.values if key != "rig.mass"]
    print(f"| noise, nm | method | {' | '.join(keys)} | seconds |\n|{' --- |' * (len(keys) + 3)}", flush=True)
    for nanometres in options.noise:
        noise = 1e-9 * nanometres
        for name, method in METHODS.items():
            errors, began = [], perf_counter()
            for draw in range(options.draws):
                random = np.random.default_rng((options.seed, draw))
                columns = [noisy(one, random, position=noise, drive_force=FORCE_NOISE) for one in exact]
                found = {_plain(key): value for key, value in method(truth, columns, noise).items()}
                errors.append([100.0 * (found[key] / truth.values[key] - 1.0) for key in keys])
            seconds = (perf_counter() - began) / options.draws
            shown = [f"{m:+.1f} +- {s:.1f}" for m, s in zip(np.mean(errors, axis=0), np.std(errors, axis=0))]
            print(f"| {nanometres:g} | {name} | {' | '.join(shown)} | {seconds:.1f} |", flush=True)


if __name__ == "__main__":
    main()
