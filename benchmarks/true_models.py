"""True models on records of independent simulators: is the error at the noise, and do the intervals hold?

    python -m benchmarks.true_models --cases 120 --seed 1

Each case is a rig, the law of its friction (of a tip and a stage driven by one: what acts beside it), a noise of the
position (0, 5, 50 or 500 nm), and what is known of the mass. Two records (fit and validate) follow from the simulators
in `benchmarks/generators`, which share neither a law nor an integrator with the program. The program is told the
effects of the true model, and fits all of their values. Printed by kind of rig: error over noise on the held-out record
(of the worst and of the best channel), coverage of the 95 % intervals, bias of the Stribeck curve at 50 nm, whether
starts wrong by a factor of 100 end at the same optimum (`--starts`), and the time of `compare`.
"""

import argparse
import itertools
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path

import numpy as np

from benchmarks.generators.driven_stage import truth as stage
from benchmarks.generators.driven_stage.voltages import MOTIONS
from benchmarks.generators.sliding_mass import CONTROLLED, IMPOSED, LAWS, OPEN_LOOP, SPRING, Drive, Friction, slide
from sysid.compare import compare
from sysid.estimation.covariance import intervals

MASSES = {
    "force-drive, closed loop": CONTROLLED,
    "force-drive, open loop": OPEN_LOOP,
    "spring-pull": SPRING,
    "velocity-drive": IMPOSED,
}
"""Rigs of a mass, and what moves it."""
BESIDE_TIP = ("gain_mismatch", "sensor_lag", "sensor_delay", "drive_lag")
BESIDE_STAGE = ("coulomb", "coulomb and viscous", "slipping contact")
NOISE = (0.0, 5e-9, 50e-9, 500e-9)
"""Standard deviations of the position's noise, m."""
LEAST_NOISE = 5e-11
"""In the place of no noise: a record has as many digits."""
MASS = ("stated", "uncertain", "unknown")
FORCE_NOISE = 5e-3
STEP, ROWS = 1e-3, 4000
PULL_STIFFNESS = 4000.0
LENGTHS = {"piezo_spacing": f"{stage.SPACING} m", "tip_height": f"{stage.HEIGHT} m", "bias_voltage": f"{stage.BIAS} V"}
UNITS = {
    "force": "N",
    "coefficient": "N*s/m",
    "velocity": "m/s",
    "stiffness": "N/m",
    "damping": "N*s/m",
    "stretch": "m",
    "memory_length": "m",
    "time_constant": "s",
    "delay": "s",
}


@dataclass(frozen=True)
class Case:
    """One case; `number` seeds the truth and the noise."""

    rig: str
    law: str
    noise: float
    mass: str
    number: int

    def __str__(self) -> str:
        mass = f", mass {self.mass}" if self.mass else ""
        return f"{self.rig}, {self.law}, {self.noise * 1e9:g} nm{mass}"


@dataclass(frozen=True)
class Truth:
    """A true model: its effects and values by key, SI; what is known of the rig; and the columns (n,) of a record
    without noise, by the number of the record, with the noise of each measured one."""

    effects: tuple[str, ...]
    values: dict[str, float]
    known: dict[str, str]
    columns: Callable[[int], dict[str, np.ndarray]]
    noise: dict[str, float]


@dataclass
class Outcome:
    """What `compare` found in one case: errors over noise of the worst channel on the records of the fit, and of the
    worst and the best one on the held-out record; whether each interval holds, and the relative error of each value."""

    case: Case
    over_noise: float
    held_out: float
    least: float
    held: dict[str, bool]
    errors: dict[str, float]
    seconds: float
    same_optimum: bool | None = None


def truth_of(case: Case) -> Truth:
    """The true model of a case; values differ by up to a fifth from case to case."""
    random = np.random.default_rng((case.number, 7))
    if case.rig in MASSES:
        return _mass_truth(case, random)
    return _tip_truth(case, random) if case.rig == "actuator-tip" else _stage_truth(case, random)


def _mass_truth(case: Case, random: np.random.Generator) -> Truth:
    def near(value: float) -> float:
        return value * float(random.uniform(0.8, 1.2))

    name, of_rate = case.law, case.law == "rate_and_state"
    friction = Friction(LAWS.index(name), near(2.0), near(8.0), near(0.6), near(3e-3), near(1e5))
    values = {f"{name}.force": friction.level, "viscous.coefficient": friction.drag}
    if of_rate:
        friction = friction._replace(direct=near(0.02), evolution=near(0.03), memory=near(2e-5))
        values |= {f"{name}.direct": friction.direct, f"{name}.evolution": friction.evolution}
        values[f"{name}.memory_length"] = friction.memory
    else:
        values |= {"stribeck.force": friction.stribeck, "stribeck.velocity": friction.stribeck_velocity}
    if name == "presliding":
        friction = friction._replace(curvature=near(2.0))
        values[f"{name}.stretch"] = friction.level * friction.curvature / friction.stiffness
        values[f"{name}.curvature"] = friction.curvature
    elif name != "coulomb":
        values[f"{name}.stiffness"] = friction.stiffness
    if name in ("lugre", "lugre_causal", "elasto_plastic"):
        friction = friction._replace(damping=near(300.0))
        values[f"{name}.damping"] = friction.damping
    if name == "elasto_plastic":
        friction = friction._replace(breakaway=near(0.7))
        values[f"{name}.breakaway"] = friction.breakaway
    values["rig.mass"] = mass = near(1.0)
    known = {"stated": f"{mass} kg", "uncertain": f"{mass} +- {0.05 * mass} kg"}
    told = {"mass": known[case.mass]} if case.mass in known else {}
    if case.rig == "spring-pull":
        told["pull_stiffness"] = f"{PULL_STIFFNESS} N/m"
    channel = {IMPOSED: "friction_force", SPRING: "spring_force"}.get(MASSES[case.rig], "drive_force")

    def columns(record: int) -> dict[str, np.ndarray]:
        x, force, path = _slid(MASSES[case.rig], friction, mass, case.number, record)
        found = {"time [s]": STEP * np.arange(ROWS), "position [m]": x, f"{channel} [N]": force}
        return found | ({"pull_position [m]": path} if case.rig == "spring-pull" else {})

    effects = (name, "viscous") if of_rate else (name, "viscous", "stribeck")
    return Truth(effects, values, told, columns, {"position [m]": case.noise, f"{channel} [N]": FORCE_NOISE})


@lru_cache(maxsize=64)
def _slid(
    drive: int, friction: Friction, mass: float, number: int, record: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Position, force and path of one record, each (n,)."""
    random = np.random.default_rng((number, record))
    rates, phases = 2.0 * np.pi * np.array([0.4, 0.9, 1.7, 3.1]), random.uniform(0.0, 2.0 * np.pi, 4)
    if drive == OPEN_LOOP:
        moves = Drive(drive, 3.0 * rates, phases, 1.6 * np.array([1.4, 1.0, 0.8, 0.6]))
    else:
        moves = Drive(drive, rates, phases, np.array([3e-3, 1.2e-3, 5e-4, 1.5e-4]))
    if drive == SPRING:
        moves = moves._replace(stiffness=PULL_STIFFNESS, damping=0.0)
    return slide(friction, moves, mass, ROWS, STEP)


def _tip_truth(case: Case, random: np.random.Generator) -> Truth:
    late = float(random.uniform(2e-3, 8e-3))
    parts = {"gain_mismatch": ("mismatch", 0.1), "sensor_delay": ("delay", late)}
    parameter, value = parts.get(case.law, ("time_constant", late))
    gain = 1.1e-7 * float(random.uniform(0.8, 1.2))

    def columns(record: int) -> dict[str, np.ndarray]:
        return _tip(case, gain, value, np.random.default_rng((case.number, record)))

    values = {f"{case.law}.{parameter}": value, "rig.gain": gain}
    noise = {"tip_x [m]": case.noise, "tip_y [m]": case.noise}
    return Truth((case.law,), values, dict(LENGTHS), columns, noise)


PER_ROW = 50
"""Steps per row in which lags are integrated."""


def _tip(case: Case, gain: float, value: float, random: np.random.Generator) -> dict[str, np.ndarray]:
    """Voltages that go straight from row to row, and the tip's motion."""
    rows = np.arange(ROWS)
    fine = np.arange((ROWS - 1) * PER_ROW + 1) / PER_ROW
    volts, stretches = [], []
    for k in range(2):
        rates, phases = 2e-3 * np.pi * np.array([1.1, 2.7, 7.3, 13.0]), random.uniform(0.0, 6.0, 4)
        volts.append(stage.BIAS + np.sin(np.multiply.outer(rows, rates) + phases) @ np.array([20.0, 10.0, 6.0, 3.0]))
        u = np.interp(fine, rows, volts[k]) - stage.BIAS
        u = _late(u, value) if case.law == "drive_lag" else u
        stretches.append(gain * (1.0 + value * k if case.law == "gain_mismatch" else 1.0) * u)
    tip = {
        "tip_x [m]": -stage.HEIGHT / stage.SPACING * (stretches[1] - stretches[0]),
        "tip_y [m]": 0.5 * (stretches[0] + stretches[1]),
    }
    for name, y in tip.items():
        seen = _late(y, value) if case.law == "sensor_lag" else y
        at = np.maximum(rows - value / STEP, 0.0) if case.law == "sensor_delay" else rows
        tip[name] = np.interp(at, fine, seen) + float(random.uniform(-2e-6, 2e-6))
    return {"time [s]": STEP * rows, "voltage_1 [V]": volts[0], "voltage_2 [V]": volts[1], **tip}


def _late(u: np.ndarray, lag: float) -> np.ndarray:
    """A signal (n,), straight from one step to the next, after a first-order lag: the exact solution of each step."""
    h = STEP / PER_ROW / lag
    kept = float(np.exp(-h))
    out, state = np.empty_like(u), float(u[0])
    out[0] = state
    for i, (before, now) in enumerate(zip(u[:-1].tolist(), u[1:].tolist(), strict=True)):
        slope = (now - before) / h
        state = now - slope + (state - before + slope) * kept
        out[i + 1] = state
    return out


def _stage_truth(case: Case, random: np.random.Generator) -> Truth:
    slips = case.law == "slipping contact"
    true = stage.Truth(pads=float(random.uniform(0.8, 1.5)), gain=1.1e-7 * float(random.uniform(0.8, 1.2)))
    values = {"coulomb.force": true.pads, "rig.gain": true.gain, "rig.contact_stiffness": true.stiffness}
    if slips:
        true = true._replace(slip=float(random.uniform(2.0, 4.0)))
        values["contact.coulomb.force"] = true.slip
    if case.law.endswith("viscous"):
        true = true._replace(viscous=float(random.uniform(500.0, 1500.0)))
        values["viscous.coefficient"] = true.viscous
    true = true._replace(damping=0.1 * float(np.sqrt(true.stiffness * true.mass)))

    def columns(record: int) -> dict[str, np.ndarray]:
        step, none = 0.5 * STEP, np.zeros(ROWS)
        time = step * np.arange(ROWS)
        volts = MOTIONS["sawtooth" if slips else "lean"](np.random.default_rng((case.number, record)), time)
        x = stage.motion(true, step, volts[0], volts[1], none, none + 1.0, none)
        return {"time [s]": time, "voltage_1 [V]": volts[0], "voltage_2 [V]": volts[1], "position [m]": x}

    effects = {BESIDE_STAGE[1]: ("coulomb", "viscous"), BESIDE_STAGE[2]: ("coulomb", "contact.coulomb")}
    known = {**LENGTHS, "mass": f"{true.mass} kg"}
    return Truth(effects.get(case.law, ("coulomb",)), values, known, columns, {"position [m]": case.noise})


def write_experiment(case: Case, truth: Truth, folder: Path, starts: Mapping[str, float] | None = None) -> Path:
    """The experiment of a case, with its two records."""
    for record in (0, 1):
        random = np.random.default_rng((case.number, record, round(case.noise * 1e9)))
        columns = dict(truth.columns(record))
        for name, std in truth.noise.items():
            columns[name] = columns[name] + max(std, LEAST_NOISE) * random.standard_normal(ROWS)
        table = np.column_stack(list(columns.values()))
        np.savetxt(folder / f"{record}.csv", table, "%.12g", ",", header=",".join(columns), comments="")
    kind = case.rig.partition(",")[0]
    given = [
        f'"{key}" = {{ start = "{value} {UNITS.get(key.rpartition(".")[2], "")}" }}'
        for key, value in (starts or {}).items()
    ]
    lines = ["schema = 1", "[rig]", f'kind = "{kind}"', 'input_hold = "linear"' if kind == "force-drive" else ""]
    lines += ["[rig.known]", *(f'{key} = "{value}"' for key, value in truth.known.items())]
    lines += ["[model]", f"effects = {list(truth.effects)}".replace("'", '"')]
    lines += ["[model.parameters]", *given] if given else []
    for record, role in enumerate(("fit", "validate")):
        lines += ["[[record]]", f'file = "{record}.csv"', f'role = "{role}"']
    lines.append("[noise]")
    for name, std in truth.noise.items():
        channel, _, unit = name.partition(" ")
        lines.append(f'{channel} = "{max(std, LEAST_NOISE)} {unit.strip("[]")}"')
    (folder / "experiment.toml").write_text("\n".join(lines), "utf-8")
    return folder


def run(case: Case, starts: bool = False) -> Outcome:
    """Compare the true model of a case with its records; with `starts` also from starts wrong by a factor of 100."""
    truth = truth_of(case)
    with tempfile.TemporaryDirectory() as name:
        found = compare(write_experiment(case, truth, Path(name)))
        known = intervals(found.base.fitted, found.problem.fit_records)
        held, errors = {}, {}
        for key, one in known.by_key.items():
            plain = key.partition(":")[0] + "." + key.rpartition(".")[2] if ":" in key else key
            if plain in truth.values:
                true = truth.values[plain]
                held[plain] = one.low <= true <= one.high
                errors[plain] = one.value / true - 1.0
        over = [one.over_noise for one in found.validate.values()]
        worst = max(one.over_noise for one in found.fit.values())
        outcome = Outcome(case, worst, max(over), min(over), held, errors, found.seconds)
        if starts:
            random = np.random.default_rng((case.number, 9))
            wrong = {
                key: value * 100.0 ** float(random.choice((-1.0, 1.0)))
                for key, value in truth.values.items()
                if key.rpartition(".")[2] in UNITS and not key.startswith("rig.")
            }
            again = compare(write_experiment(case, truth, Path(name), wrong))
            error = max(one.over_noise for one in again.fit.values())
            outcome.same_optimum = error < 1.02 * worst + 0.02
    return outcome


def every_case() -> list[Case]:
    """All cases, numbered 0."""
    product = itertools.product
    found = [Case(rig, law, noise, mass, 0) for rig, law, noise, mass in product([*MASSES][:3], LAWS, NOISE, MASS)]
    found += [Case("velocity-drive", law, noise, "", 0) for law, noise in product(LAWS, NOISE)]
    found += [Case("actuator-tip", law, noise, "", 0) for law, noise in product(BESIDE_TIP, NOISE)]
    # More noise than 50 nm hides the motion of such a stage.
    return found + [Case("friction-drive", law, noise, "", 0) for law, noise in product(BESIDE_STAGE, NOISE[1:3])]


def cases(count: int, seed: int, only: str = "") -> list[Case]:
    """`count` of all cases whose text contains `only`, in an order that `seed` draws."""
    every = [case for case in every_case() if only in str(case)]
    order = np.random.default_rng(seed).permutation(len(every))[:count]
    return [Case(c.rig, c.law, c.noise, c.mass, seed) for c in (every[k] for k in order)]


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
        every = [one for found in self.rows.values() for one in found]
        for rig, found in (*self.rows.items(), ("all", every)):
            over, least = np.array([one.held_out for one in found]), min(one.least for one in found)
            held = [inside for one in found for inside in one.held.values()]
            lines.append(
                f"| {rig} | {len(found)} | {np.mean(over <= 1.1):.0%} | {least:.2f} .. {over.max():.2f} | "
                f"{np.mean(held):.0%} of {len(held)} | {np.median([one.seconds for one in found]):.1f} |"
            )
        for key in ("stribeck.force", "stribeck.velocity"):
            bias = [one.errors[key] for one in every if one.case.noise == NOISE[2] and key in one.errors]
            if bias:
                lines.append(f"median relative error of {key} at 50 nm: {np.median(bias):+.2%} ({len(bias)} cases)")
        tried = [one.same_optimum for one in every if one.same_optimum is not None]
        if tried:
            lines.append(f"starts wrong by a factor of 100: same optimum in {sum(tried)} of {len(tried)}")
        return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", type=int, default=120)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--starts", action="store_true", help="also from starts wrong by a factor of 100")
    parser.add_argument("--only", default="", help="cases whose text contains this")
    options = parser.parse_args()
    table = Table()
    for case in cases(options.cases, options.seed, options.only):
        outcome = run(case, options.starts)
        table.add(outcome)
        outside = [f"{key} {outcome.errors[key]:+.1%}" for key, inside in outcome.held.items() if not inside]
        least = f" ({outcome.least:.2f} at least)" if outcome.least < outcome.held_out else ""
        print(
            f"{case}: {outcome.over_noise:.2f} / {outcome.held_out:.2f} x{least}, {outcome.seconds:.1f} s"
            + (f"; outside: {', '.join(outside)}" if outside else "")
            + ("" if outcome.same_optimum is not False else "; another optimum from wrong starts"),
            flush=True,
        )
    print(table.text())


if __name__ == "__main__":
    main()
