"""True models on records of an independent simulator: is the error at the noise, and do the intervals hold?

    python -m benchmarks.true_models --cases 24 --seed 1

Each case is a rig, a friction state model, a noise of the position (0, 5, 50 or 500 nm) and what is known of the mass.
Two records (fit and validate) of 4 s at 1 kHz are simulated by scipy's Radau method with the laws written out below:
neither a law nor an integrator is shared with the program, which is told the effects of the true model, and fits all of
their values. Printed by kind of rig: error over noise on the held-out record, coverage of the 95 % intervals, bias of
the Stribeck curve at 50 nm, whether starts wrong by a factor of 100 end at the same optimum, and the time of `compare`.
"""

import argparse
import itertools
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

from sysid.compare import compare
from sysid.estimation.covariance import intervals

RIGS = ("force-drive, closed loop", "force-drive, open loop", "spring-pull", "velocity-drive")
FRICTION = ("lugre", "lugre_causal", "dahl", "lugre_undamped", "coulomb")
NOISE = (0.0, 5e-9, 50e-9, 500e-9)
"""Standard deviations of the position's noise, m."""
MASS = ("stated", "uncertain", "unknown")
FORCE_NOISE = 5e-3
STEP, ROWS = 1e-3, 4000
PULL_STIFFNESS = 4000.0
UNITS = {"force": "N", "coefficient": "N*s/m", "velocity": "m/s", "stiffness": "N/m", "damping": "N*s/m"}
RIGID = 1e9
"""Stiffness of bristles that stand for rigid friction, N/m: they yield by 2 nm."""


@dataclass(frozen=True)
class Case:
    """One case; `number` seeds the truth and the noise."""

    rig: str
    friction: str
    noise: float
    mass: str
    number: int

    @property
    def effects(self) -> list[str]:
        """Effects of the true model."""
        return [self.friction, "viscous", "stribeck"]

    def __str__(self) -> str:
        mass = "" if self.rig == "velocity-drive" else f", mass {self.mass}"
        return f"{self.rig}, {self.friction}, {self.noise * 1e9:g} nm{mass}"


@dataclass
class Outcome:
    """What `compare` found in one case."""

    case: Case
    over_noise: float
    held_out: float
    held: dict[str, bool]
    errors: dict[str, float]
    seconds: float
    same_optimum: bool | None = None


def truth_of(case: Case) -> dict[str, float]:
    """The true values by key, SI; they differ by up to a fifth from case to case."""
    random = np.random.default_rng((case.number, 7))
    name, part = case.friction, lambda: float(random.uniform(0.8, 1.2))
    values = {f"{name}.force": 2.0 * part(), "viscous.coefficient": 8.0 * part()}
    values |= {"stribeck.force": 0.6 * part(), "stribeck.velocity": 3e-3 * part(), "rig.mass": part()}
    if name != "coulomb":
        values[f"{name}.stiffness"] = 1e5 * part()
    if name in ("lugre", "lugre_causal"):
        values[f"{name}.damping"] = 300.0 * part()
    return values


def friction_law(case: Case, truth: Mapping[str, float]) -> Callable[[float, float], tuple[float, float]]:
    """Rate of the bristles' deflection (m/s) and friction (N) by velocity and deflection."""
    level, drag = truth[f"{case.friction}.force"], truth["viscous.coefficient"]
    more, velocity = truth["stribeck.force"], truth["stribeck.velocity"]
    stiffness = truth.get(f"{case.friction}.stiffness", RIGID)
    damping = truth.get(f"{case.friction}.damping", 0.0)

    def law(v: float, z: float) -> tuple[float, float]:
        g = level + more * np.exp(-((v / velocity) ** 2))
        rate = v - stiffness * abs(v) * z / g
        if case.friction == "lugre_causal":
            rate /= 1.0 + damping * abs(v) / g
        return rate, stiffness * z + damping * rate + drag * v

    return law


@lru_cache(maxsize=64)
def motion(case: Case, record: int) -> tuple[np.ndarray, ...]:
    """Position (m) and force (N) of a record without noise, and the end of the pulling spring (m), each (n,)."""
    random, truth = np.random.default_rng((case.number, record)), truth_of(case)
    mass, law, time = truth["rig.mass"], friction_law(case, truth), STEP * np.arange(ROWS)
    rates, phases = 2.0 * np.pi * np.array([0.4, 0.9, 1.7, 3.1]), random.uniform(0.0, 2.0 * np.pi, 4)
    sizes = np.array([3e-3, 1.2e-3, 5e-4, 1.5e-4])

    def path(t: float | np.ndarray, order: int = 0) -> np.ndarray:
        angle = np.multiply.outer(t, rates) + phases + 0.5 * np.pi * order
        return np.asarray(np.sin(angle) @ (sizes * rates**order))

    if case.rig == "velocity-drive":
        found = solve_ivp(
            lambda t, z: [law(float(path(t, 1)), z[0])[0]], (0.0, time[-1]), [0.0], "Radau", time, rtol=1e-8, atol=1e-13
        )
        force = np.array([law(float(v), float(z))[1] for v, z in zip(path(time, 1), found.y[0], strict=True)])
        return np.asarray(path(time)), force, np.empty(0)

    def push(t: float, x: float, v: float) -> float:
        if case.rig == "spring-pull":
            return PULL_STIFFNESS * (float(path(t)) - x)
        if case.rig.endswith("open loop"):
            return 1.6 * float(np.sin(np.multiply.outer(t, 3.0 * rates) + phases) @ np.array([1.4, 1.0, 0.8, 0.6]))
        return 4e4 * (float(path(t)) - x) + 300.0 * (float(path(t, 1)) - v)

    def slope(t: float, y: np.ndarray) -> list[float]:
        rate, friction = law(y[1], y[2])
        return [y[1], (push(t, y[0], y[1]) - friction) / mass, rate]

    start = [float(path(0.0)), 0.0 if case.rig != RIGS[0] else float(path(0.0, 1)), 0.0]
    atol = [1e-12, 1e-9, 1e-12 if case.friction != "coulomb" else 1e-14]
    found = solve_ivp(slope, (0.0, time[-1]), start, "Radau", time, rtol=1e-8, atol=atol)
    force = np.array([push(t, x, v) for t, x, v in zip(time, found.y[0], found.y[1], strict=True)])
    return found.y[0], force, np.asarray(path(time)) if case.rig == "spring-pull" else np.empty(0)


def write_experiment(case: Case, folder: Path, starts: Mapping[str, float] | None = None) -> Path:
    """The experiment of a case, with its two records."""
    truth, kind = truth_of(case), case.rig.partition(",")[0]
    simulated = Case(case.rig, case.friction, 0.0, "", case.number)
    force_name = {"velocity-drive": "friction_force", "spring-pull": "spring_force"}.get(kind, "drive_force")
    for record in (0, 1):
        position, force, pull = motion(simulated, record)
        random = np.random.default_rng((case.number, record, round(case.noise * 1e9)))
        columns = {
            "time [s]": STEP * np.arange(ROWS),
            "position [m]": position + case.noise * random.standard_normal(ROWS),
            f"{force_name} [N]": force + FORCE_NOISE * random.standard_normal(ROWS),
        } | ({"pull_position [m]": pull} if pull.size else {})
        table = np.column_stack(list(columns.values()))
        np.savetxt(folder / f"{record}.csv", table, "%.12g", ",", header=",".join(columns), comments="")
    mass = truth["rig.mass"]
    known = {"stated": f'mass = "{mass} kg"', "uncertain": f'mass = "{mass} +- {0.05 * mass} kg"'}.get(case.mass, "")
    known = "" if kind == "velocity-drive" else known
    known += f'\npull_stiffness = "{PULL_STIFFNESS} N/m"' if kind == "spring-pull" else ""
    hold = 'input_hold = "linear"' if kind == "force-drive" else ""
    given = [
        f'"{key}" = {{ start = "{value} {UNITS[key.rpartition(".")[2]]}" }}' for key, value in (starts or {}).items()
    ]
    lines = ["schema = 1", "[rig]", f'kind = "{kind}"', hold, "[rig.known]", known, "[model]"]
    lines += [f"effects = {case.effects!r}".replace("'", '"'), *(["[model.parameters]", *given] if given else [])]
    for record, role in enumerate(("fit", "validate")):
        lines += ["[[record]]", f'file = "{record}.csv"', f'role = "{role}"']
    lines += ["[noise]", f'position = "{max(case.noise, 5e-11)} m"', f'{force_name} = "{FORCE_NOISE} N"']
    (folder / "experiment.toml").write_text("\n".join(lines), "utf-8")
    return folder


def run(case: Case, starts: bool = False) -> Outcome:
    """Compare the true model of a case with its records; with `starts` also from starts wrong by a factor of 100."""
    truth = truth_of(case)
    with tempfile.TemporaryDirectory() as name:
        found = compare(write_experiment(case, Path(name)))
        fitted = found.base.fitted
        known = intervals(fitted, found.problem.fit_records)
        channel = next(iter(found.validate))
        held, errors = {}, {}
        for key, one in known.by_key.items():
            plain = key.partition(":")[0] + "." + key.rpartition(".")[2] if ":" in key else key
            if plain in truth:
                held[plain] = one.low <= truth[plain] <= one.high
                errors[plain] = one.value / truth[plain] - 1.0
        outcome = Outcome(
            case, found.fit[channel].over_noise, found.validate[channel].over_noise, held, errors, found.seconds
        )
        if starts:
            random = np.random.default_rng((case.number, 9))
            wrong = {k: v * 100.0 ** float(random.choice((-1.0, 1.0))) for k, v in truth.items() if k != "rig.mass"}
            again = compare(write_experiment(case, Path(name), wrong))
            outcome.same_optimum = again.fit[channel].over_noise < 1.02 * outcome.over_noise + 0.02
    return outcome


def cases(count: int, seed: int, only: str = "") -> list[Case]:
    """`count` of all cases whose text contains `only`, in an order that `seed` draws."""
    every = [
        Case(rig, friction, noise, mass, 0)
        for rig, friction, noise, mass in itertools.product(RIGS, FRICTION, NOISE, MASS)
        if rig != "velocity-drive" or mass == "stated"
    ]
    every = [case for case in every if only in str(case)]
    order = np.random.default_rng(seed).permutation(len(every))[:count]
    return [Case(c.rig, c.friction, c.noise, c.mass, seed) for c in (every[k] for k in order)]


@dataclass
class Table:
    """Outcomes by kind of rig."""

    rows: dict[str, list[Outcome]] = field(default_factory=dict)

    def add(self, outcome: Outcome) -> None:
        """Enter an outcome."""
        self.rows.setdefault(outcome.case.rig, []).append(outcome)

    def text(self) -> str:
        """The acceptance table."""
        lines = ["| rig | cases | held out <= 1.10 | least .. largest | intervals hold | seconds |", "|" + " --- |" * 6]
        for rig, found in self.rows.items():
            over = np.array([one.held_out for one in found])
            held = [inside for one in found for inside in one.held.values()]
            lines.append(
                f"| {rig} | {len(found)} | {np.mean(over <= 1.1):.0%} | {over.min():.2f} .. {over.max():.2f} | "
                f"{np.mean(held):.0%} of {len(held)} | {np.median([one.seconds for one in found]):.1f} |"
            )
        every = [one for found in self.rows.values() for one in found]
        for key in ("stribeck.force", "stribeck.velocity"):
            bias = [one.errors[key] for one in every if one.case.noise == NOISE[2] and key in one.errors]
            if bias:
                lines.append(f"median relative error of {key} at 50 nm: {np.median(bias):+.2%} ({len(bias)} cases)")
        tried = [one.same_optimum for one in every if one.same_optimum is not None]
        if tried:
            lines.append(f"starts wrong by a factor of 100: same optimum in {sum(tried)} of {len(tried)}")
        return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description="True models on records of an independent simulator.")
    parser.add_argument("--cases", type=int, default=24)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--starts", action="store_true", help="also from starts wrong by a factor of 100")
    parser.add_argument("--only", default="", help="cases whose text contains this")
    options = parser.parse_args()
    table = Table()
    for case in cases(options.cases, options.seed, options.only):
        outcome = run(case, options.starts)
        table.add(outcome)
        outside = [f"{key} {outcome.errors[key]:+.1%}" for key, inside in outcome.held.items() if not inside]
        print(
            f"{case}: {outcome.over_noise:.2f} / {outcome.held_out:.2f} x, {outcome.seconds:.1f} s"
            + (f"; outside: {', '.join(outside)}" if outside else "")
            + ("" if outcome.same_optimum is not False else "; another optimum from wrong starts"),
            flush=True,
        )
    print(table.text())


if __name__ == "__main__":
    main()
