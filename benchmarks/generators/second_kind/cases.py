"""Cases of the second kind: drawn, brought to a visible size, simulated, written, with a key."""

import json
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, replace
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from . import refit
from .hidden import LATE, NAMED, OFFSET, UNLISTED, Hidden, Setting
from .loggers import as_text, draw_logger, experiment, known
from .machines import RIG_SHARES, RIGS, Machine, draw_machine, log_uniform
from .records import Inputs, Logged, closure, draw_inputs, noise_levels, problem, simulate, table

CLASSES = {"named": 0.60, "two": 0.12, "none": 0.14, "unknown": 0.14}
VISIBLE = {"named": (3.0, 60.0), "two": (8.0, 40.0), "unknown": (4.0, 60.0)}
AXIS_NOISE, TIP_NOISE = (4e-4, 1.2e-2), (1e-4, 2e-3)
NOTHING_LEFT = 0.3
ATTEMPTS, SAME_EFFECT = 60, 12


@dataclass(frozen=True)
class Case:
    """A finished case: the text of experiment.toml, of both records, and its entry of the key."""

    toml: str
    csv: dict[str, str]
    key: dict[str, Any]

    def write(self, folder: Path) -> None:
        """experiment.toml, fit.csv and validate.csv in `folder`, which is made."""
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "experiment.toml").write_text(self.toml, encoding="utf-8")
        for role, text in self.csv.items():
            (folder / f"{role}.csv").write_text(text, encoding="utf-8")


class UnfitError(Exception):
    """A draw that gives no sound case; the next attempt is made."""


@dataclass
class Bench:
    """One machine with the inputs of both records, and how its records are judged."""

    m: Machine
    inputs: list[Inputs]
    rows: float
    mass_known: bool

    def problems(
        self, hide: Callable[[], Setting], sigma: float
    ) -> tuple[list[refit.Problem], list[float], list[Logged]]:
        """Least-squares problems, what the base model leaves of each record over `sigma`, and the records.

        The problems are empty where the spring's own law fails and not the balance of forces.
        """
        logged = [simulate(self.m, each, hide()) for each in self.inputs]
        for one in logged:
            if self.m.rig != "actuator-tip":
                reach, moving = np.ptp(one["position"]), float(np.mean(one["side"] != 0.0))
                if not (0.2 * self.m.reach < reach < 3.0 * self.m.reach) or moving < 0.12:
                    raise UnfitError("the axis hardly moves")
        problems = [problem(self.m, one, sigma, self.rows, self.mass_known) for one in logged]
        if min(p.target.size for p in problems) < 300:
            raise UnfitError("too few rows move")
        balance, spring = refit.left(problems), [closure(self.m, one, sigma) for one in logged]
        seen = [max(pair) for pair in zip(balance, spring, strict=True)]
        return [] if min(spring) > 2.0 * max(balance) else problems, seen, logged


def _choose(rng: np.random.Generator, klass: str) -> tuple[str, list[Hidden]]:
    """A rig and what is hidden on it."""
    rig = str(rng.choice(RIGS, p=RIG_SHARES))
    if klass == "none":
        return rig, []
    pool = [h for h in (UNLISTED if klass == "unknown" else NAMED) if rig in h.rigs]
    if klass != "two":
        return rig, [pool[int(rng.integers(len(pool)))]]
    pool = [h for h in pool if h.pairs]
    while True:
        a, b = (pool[int(k)] for k in rng.choice(len(pool), 2, replace=False))
        if not {a.name, b.name} <= set(OFFSET):
            return rig, [a, b]


def _machine(rng: np.random.Generator, rig: str, effects: list[Hidden]) -> Machine:
    """A machine on which the effects can show."""
    curve = next((h.curve for h in effects if h.curve is not None), None)
    rotary = next((h.rotary for h in effects if h.rotary is not None), None)
    speeds = next((h.curve_speed for h in effects if h.curve_speed is not None), None)
    while True:
        m = draw_machine(rng, rig, curve=curve)
        if speeds is not None:
            m = replace(m, curve_speed=m.speed * log_uniform(rng, *speeds))
        if rotary is None or (m.rotary == rotary and m.reach > 0.8):
            break
    if rig == "velocity-drive" and len(effects) == 1 and effects[0].pairs and not m.curve and rng.random() < 0.2:
        stretch = m.reach * log_uniform(rng, 3e-3, 0.02)
        m = replace(m, base=("presliding", "viscous"), stretch=stretch)
    return m


def _to_size(
    bench: Bench, build: Callable[[float], Setting], strength: float, target: float, noise: tuple[float, float]
) -> tuple[float, float]:
    """Strength and noise at which the base model leaves `target` noise deviations.

    The noise is what the drawn strength calls for where it lies between the limits `noise`; otherwise the limit, and
    the strength is sought.
    """

    def seen_at(value: float) -> float:
        return max(min(bench.problems(partial(build, value), 1.0)[1]), 1e-30)

    low, high = noise
    seen = seen_at(strength)
    if low <= seen / target <= high:
        return strength, seen / target
    sigma, slope = low if seen < low * target else high, 1.0
    for _ in range(6):
        other = strength * float(np.clip((sigma * target / seen) ** (1.0 / slope), 0.02, 3.0))
        if other > 1.0:
            raise UnfitError("too small beside the noise")
        now = seen_at(other)
        if abs(now / (sigma * target) - 1.0) < 0.12:
            return other, sigma
        # The slope in logarithms: sizes of memory effects are no straight line of the strength.
        slope = float(np.clip(np.log(now / seen) / np.log(other / strength), 0.4, 2.5)) if other != strength else slope
        strength, seen = other, now
    raise UnfitError("size not reached")


def _own(h: Hidden, rig: str) -> str:
    """The shape of an effect among those of `refit.rivals`."""
    if rig == "actuator-tip" and h.name in LATE:
        return "rate"
    late = "drive_lag" if rig == "force-drive" else "sensor_lag"
    return late if h.name in LATE else h.name


def _accepted(effects: list[Hidden], rig: str, base: tuple[str, ...], left: dict[str, float], seen: float) -> list[str]:
    """Every right answer; raises UnfitError where records cannot tell."""
    if not effects:
        if seen > NOTHING_LEFT:
            raise UnfitError("the base model does not suffice")
        return ["adequate"]
    if effects[0] in UNLISTED:
        if min(left.values(), default=seen) < 0.6 * seen:
            raise UnfitError("an effect of a library explains it")
        return [effects[0].name, "unexplained"]
    accept = {name for h in effects for name in (h.accept or (h.name,))}
    own = [_own(h, rig) for h in effects]
    if len(effects) == 2:
        apart = min(left[name] for name in own)
        if apart < 4.0 or left["both"] > 0.5 * apart:
            raise UnfitError("one of two is hardly there, or both together do not suffice")
        return sorted(accept)
    if own[0] not in left:
        if min(left.values(), default=seen) < 0.3 * seen:
            raise UnfitError("another effect explains it")
        return sorted(accept)
    if left[own[0]] > 0.6 * seen:
        raise UnfitError("its own shape does not explain it")
    simple = {n for n in left if refit.PARAMETERS.get(n, 2) <= refit.PARAMETERS.get(own[0], 2)} - {*base, "rate"}
    alike = {n for n in simple if left[n] <= max(1.1 * left[own[0]], 0.3)}
    if len(alike - accept) > 2:
        raise UnfitError("too many effects explain it")
    return sorted(accept | alike)


def _joined(builds: list[Callable[[float], Setting]], strengths: list[float]) -> Setting:
    """Everything hidden, with fresh states."""
    setting = Setting()
    for build, strength in zip(builds, strengths, strict=True):
        setting.join(build(strength))
    return setting


def draw_case(rng: np.random.Generator, klass: str, rig: str, effects: list[Hidden]) -> Case:
    """One draw of a case; raises UnfitError."""
    m = _machine(rng, rig, effects)
    how = draw_logger(rng, m)
    axis = rig != "actuator-tip"
    scale = m.coulomb if axis else 50.0 * m.gain
    bench = Bench(m, draw_inputs(rng, m, effects), log_uniform(rng, 1.5, 4.0), how.mass == "known")
    low, high = (limit * scale for limit in (AXIS_NOISE if axis else TIP_NOISE))
    low *= log_uniform(rng, 1.0, 3.0)
    sigma, strengths, limits = log_uniform(rng, low, high), [], (low, high)
    builds = [h.draw(rng, m) for h in effects]
    counting = bool(effects) and effects[0].name == "sensor_quantisation"
    if counting:
        strengths = [log_uniform(rng, *VISIBLE[klass]) * float(np.sqrt(12.0))]
    else:
        for build in builds:
            target = log_uniform(rng, *VISIBLE[klass])
            strength, sigma = _to_size(bench, build, log_uniform(rng, 0.1, 1.0), target, limits)
            strengths.append(strength)
            limits = (sigma, sigma)
    problems, seen, logged = bench.problems(lambda: _joined(builds, strengths), sigma)
    if counting:
        seen = [strengths[0] / float(np.sqrt(12.0))] * 2
    beside = {h.channel for h in effects if h.channel}
    beside |= {name for name in ("normal_load", "temperature") if axis and rng.random() < 0.25}
    left: dict[str, float] = {}
    if effects and problems and not counting:
        left = refit.rivals(m, problems, beside)
    if klass == "two":
        left["both"] = refit.both(m, problems, (_own(effects[0], rig), _own(effects[1], rig)))
    accept = _accepted(effects, rig, m.base, left, max(seen))
    if counting and not how.given:
        # Without a stated noise the steps are part of the estimated one: nothing is missing.
        accept = [*accept, "adequate"]
    levels = noise_levels(m, sigma, bench.rows)
    counts = _joined(builds, strengths).counts
    tables = [table(rng, m, one, how, levels, beside, counts) for one in logged]
    toml = experiment(m, how, known(rng, m, how), tables[0], levels)
    csv = {role: as_text(rng, one, how, m) for role, one in zip(("fit", "validate"), tables, strict=True)}
    key = {
        "effect": "+".join(h.name for h in effects) or "none",
        "rig": rig,
        "base": list(m.base),
        "size": _size(min(seen)) if effects else "none",
        "klass": klass,
        "noise": levels,
        "machine": m.name,
        "rotary": m.rotary,
        "excitation": [list(each.kind) if m.name == "piezo" else each.kind[0] for each in bench.inputs],
        "fs": m.rate,
        "seconds": m.rows * m.step,
        "rows": m.rows,
        "visible": min(seen),
        "visible_fit": seen[0],
        "visible_validate": seen[1],
        "noise_over_scale": sigma / scale,
        "filter_rows": bench.rows if rig in ("spring-pull", "force-drive") else 0.0,
        "rivals_left": {name: round(value, 3) for name, value in left.items()},
        "how": asdict(how),
        "strength": strengths[0] if len(strengths) == 1 else strengths,
        "truth": asdict(m),
        "accept": accept,
    }
    if klass == "unknown":
        key["where"] = list(effects[0].where)
    return Case(toml, csv, key)


def _size(visible: float) -> str:
    """The level of what is visible, as text."""
    return "1-3" if visible < 3.0 else "3-10" if visible < 10.0 else "10-60"


def make_case(seed: int, index: int, klass: str) -> Case:
    """The case of a seed, an index and a class; the same arguments give the same case."""
    for attempt in range(ATTEMPTS):
        rig, effects = _choose(np.random.default_rng([seed, index, attempt // SAME_EFFECT]), klass)
        try:
            case = draw_case(np.random.default_rng([seed, index, 1000 + attempt]), klass, rig, effects)
        except UnfitError:
            continue
        case.key["attempt"] = attempt
        return case
    raise RuntimeError(f"seed {seed}, case {index}: no sound {klass} case in {ATTEMPTS} attempts")


def classes(seed: int, cases: int) -> list[str]:
    """The class of every case, in shares of CLASSES, in an order of the seed."""
    ends = np.round(np.cumsum(list(CLASSES.values())) * cases).astype(int)
    names = list(CLASSES)
    listed = [names[int(np.searchsorted(ends, k, side="right"))] for k in range(cases)]
    return [listed[int(k)] for k in np.random.default_rng(seed).permutation(cases)]


def _write(task: tuple[Path, int, int, str]) -> tuple[str, dict[str, Any]]:
    folder, seed, index, klass = task
    case = make_case(seed, index, klass)
    name = f"case{index:03d}"
    case.write(folder / name)
    return name, case.key


def make_cases(folder: Path, seed: int, cases: int, jobs: int = 1) -> None:
    """Write `cases` cases and key.json in `folder`."""
    folder.mkdir(parents=True, exist_ok=True)
    tasks = [(folder, seed, k, klass) for k, klass in enumerate(classes(seed, cases))]
    if jobs == 1:
        rows = [_write(task) for task in tasks]
    else:
        with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
            rows = list(pool.map(_write, tasks))
    (folder / "key.json").write_text(json.dumps(dict(rows), indent=1), encoding="utf-8")
