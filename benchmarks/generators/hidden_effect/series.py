"""A whole set of cases, decided by one seed."""

import json
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np

from .case import make_case
from .drawn import Plan
from .hidden import HIDDEN

RIGS = ("velocity-drive", "spring-pull", "force-drive", "actuator-tip")
KINDS = ("single", "none", "unexplained", "pair")


def _names(rig: str, *, unlisted: bool) -> list[str]:
    return [name for name, entry in HIDDEN.items() if rig in entry.rigs and entry.unlisted == unlisted]


def _plan(
    rng: np.random.Generator,
    turn: int,
    kind: str,
    *,
    hard: bool,
    levels: Sequence[str],
    rows: int,
    effects: Sequence[str] | None,
    same_form: bool,
) -> Plan:
    rig = str(rng.choice(RIGS, p=[0.28, 0.27, 0.27, 0.18]))
    level = str(rng.choice(levels))
    nuisance = "plain"
    if kind == "none":
        rig = RIGS[turn % 4]
        nuisance = str(rng.choice(["plain", "outliers", "spread"], p=[0.4, 0.3, 0.3]))
        return Plan(rig, (), level, nuisance, hard, idle=bool(rng.random() < 0.6), rows=rows)
    if kind == "unexplained":
        effects = [name for name, entry in HIDDEN.items() if entry.unlisted]
        level = "moderate" if level == "weak" else level
    if kind in ("unexplained", "single"):
        listed = effects or [name for name, entry in HIDDEN.items() if not entry.unlisted]
        name = listed[turn % len(listed)]
        return Plan(str(rng.choice(HIDDEN[name].rigs)), (name,), level, nuisance, hard, rows=rows, same_form=same_form)
    names = _names(rig, unlisted=False)
    level = "strong" if level == "weak" else level
    while True:
        first, second = (HIDDEN[str(n)] for n in rng.choice(names, 2, replace=False))
        both = {first.name, second.name}
        clash = set(first.accept) & set(second.accept) or both & {"coulomb", "bristle_damping"}
        # A spring at rest elsewhere is a spring and a bias; so, over a small angle, is gravity.
        leaning = both & {"cable_spring", "gravity_torque"} and "constant_bias" in {*first.accept, *second.accept}
        clash = clash or leaning
        bases = [entry.base for entry in (first, second) if entry.base is not None]
        if not clash and len(bases) < 2:
            return Plan(rig, (first.name, second.name), level, nuisance, hard, rows=rows)


def _one(job: tuple[Path, int, int, int, str, dict]) -> tuple[str, dict]:
    folder, seed, index, turn, kind, options = job
    name = f"case{index:04d}"
    for attempt in range(20):
        rng = np.random.default_rng([seed, index, attempt])
        try:
            case = make_case(_plan(rng, turn, kind, **options), rng)
        except ValueError:
            continue
        case.write(folder / name)
        return name, case.key | {"kind": kind, "seed": [seed, index, attempt]}
    raise RuntimeError(f"case {index} of seed {seed} could not be made in 20 draws")


def make_cases(
    folder: Path,
    seed: int,
    count: int,
    kinds: dict[str, float] | None = None,
    *,
    hard: float = 0.35,
    levels: Sequence[str] = ("strong", "moderate", "weak"),
    rows: int = 20000,
    effects: Sequence[str] | None = None,
    jobs: int = 1,
    same_form: bool = False,
) -> dict[str, dict]:
    """Write `count` cases below `folder` with `key.json`, and return the key. The seed decides everything.

    `kinds` maps single, none, unexplained and pair to their shares (default 0.5, 0.2, 0.17, 0.13); `hard` is the share
    with coloured noise, gaps, odd units and rates, and rotary axes; `effects` restricts what single cases hide; with
    `same_form` the laws are those a model library writes, for the coverage of intervals.
    """
    for given, allowed in ((kinds or {}, KINDS), (effects or (), HIDDEN)):
        for name in given:
            if name not in allowed:
                raise ValueError(f"unknown {name!r}; one of {', '.join(allowed)}")
    shares = kinds or {"single": 0.5, "none": 0.2, "unexplained": 0.17, "pair": 0.13}
    rng = np.random.default_rng([seed, 977])
    total = sum(shares.values())
    drawn = rng.choice(list(shares), count, p=[value / total for value in shares.values()])
    tough = rng.random(count) < hard
    work = [
        (
            Path(folder),
            seed,
            index,
            int((drawn[:index] == drawn[index]).sum()),
            str(drawn[index]),
            {
                "hard": bool(tough[index]),
                "levels": tuple(levels),
                "rows": rows,
                "effects": effects,
                "same_form": same_form,
            },
        )
        for index in range(count)
    ]
    Path(folder).mkdir(parents=True, exist_ok=True)
    if jobs > 1:
        with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
            done = list(pool.map(_one, work, chunksize=4))
    else:
        done = [_one(job) for job in work]
    key = dict(done)
    (Path(folder) / "key.json").write_text(json.dumps(key, indent=1), encoding="utf-8")
    return key
