"""Effect of the dimensions' tolerances on the margins."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from designcalc.checks.check import Check
from designcalc.checks.run import changed_masses, run_checks, subject_names, subjects_of
from stagecad.parameters.design import Design
from stagecad.parameters.mass_properties import Masses
from stagecad.parameters.rules import present_entries, violations

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Spread:
    """Distribution of one check's margin over the tolerances."""

    name: str
    nominal: float
    low: float  # margin that 95 % of the machines exceed
    high: float  # margin that 5 % of the machines exceed
    failing: float  # share of the machines that fail
    leading: str  # the dimension with the largest effect


@dataclass(frozen=True)
class Influence:
    """Effect of one dimension's tolerance on the checks."""

    key: str
    tolerance: str
    plus_minus: float  # m
    share: float  # largest part of a margin that this tolerance alone uses up, over all checks
    check: str  # the check where it does


@dataclass(frozen=True)
class ToleranceStudy:
    """Spreads of all checks, and the dimensions by their influence, the largest first."""

    samples: int
    spreads: tuple[Spread, ...]
    influences: tuple[Influence, ...]
    # Three dimensions, of the tightest class first, whose next class fails no check and violates no rule
    could_be_loosened: tuple[Influence, ...] = ()

    @property
    def matter_most(self) -> tuple[Influence, ...]:
        """The three dimensions whose tolerance uses up most of a margin."""
        return self.influences[:3]

    def as_json(self) -> dict[str, Any]:
        """As a JSON document."""
        return {
            "samples": self.samples,
            "checks": [dict(vars(s)) for s in self.spreads],
            "matter_most": [_influence(i) for i in self.matter_most],
            "could_be_loosened": [_influence(i) for i in self.could_be_loosened],
        }


def _influence(item: Influence) -> dict[str, Any]:
    return {
        "key": item.key,
        "class": item.tolerance,
        "plus_minus": {"value": item.plus_minus, "unit": "m"},
        "share_of_margin": item.share,
        "check": item.check,
    }


def tolerance_study(
    design: Design,
    load: Callable[..., Design],
    masses: Masses | None,
    samples: int = 10_000,
    seed: int = 1,
    subjects: tuple[str, ...] | None = None,
    run_all: Callable[[Callable[[str], Any], Sequence[str]], list[Any]] = lambda job, keys: [job(key) for key in keys],
) -> ToleranceStudy:
    """Monte-Carlo of the margins over the tolerances of every dimension that a check reads.

    Each dimension is moved to both ends of its tolerance by itself, the checks that read it are run again, and the
    margins between are taken as separable parabolas ``m = m0 + sum(g_i x_i + h_i x_i^2)``; over hundredths of a
    millimetre their curvature is below that. The samples are drawn evenly between the ends, which is wider than a
    shop in control makes them.

    `load` gives the design with more overrides `KEY=VALUE`, without the rules across values; `masses` are those of its
    solids, or None; `subjects` of the checks to run: by default all but the alternative suspensions; `run_all` runs a
    job on every key, in order.
    """
    # Alternative suspensions are not made, so that their tolerances do not matter.
    left_out = subjects_of(design).not_made
    wanted = tuple(name for name in subjects or subject_names(design) if name not in left_out)
    base = run_checks(design, masses, wanted)
    named = {check.name: check.margin for check in base if check.margin is not None}
    readers: dict[str, set[str]] = {}
    for check in base:
        for key in check.inputs if check.name in named else ():
            readers.setdefault(key, set()).add(check.subject)
    keys = [entry.key for entry in design.entries if entry.key in readers and design.plus_minus(entry.key) > 0]
    names = list(named)
    nominal = np.array([named[n] for n in names], float)
    slope, curvature = np.zeros((len(keys), len(names))), np.zeros((len(keys), len(names)))
    for row, ends in enumerate(run_all(partial(_ends, design, load, masses, readers, named), keys)):
        slope[row] = (ends[1] - ends[0]) / 2
        curvature[row] = (ends[1] + ends[0]) / 2 - nominal
    x = np.random.default_rng(seed).uniform(-1, 1, (samples, len(keys)))
    margins = nominal + x @ slope + x**2 @ curvature
    low, high = np.quantile(margins, [0.05, 0.95], axis=0)
    reach = np.maximum(np.abs(slope + curvature), np.abs(slope - curvature))
    used = reach / np.maximum(np.abs(nominal), 0.01)
    leading = [keys[int(np.argmax(reaches))] if reaches.any() else "" for reaches in reach.T]
    numbers = np.stack([nominal, low, high, np.mean(margins < -1e-9, axis=0)], axis=1).tolist()
    spreads = tuple(Spread(name, *of, leading=key) for name, of, key in zip(names, numbers, leading, strict=True))
    influences = [
        Influence(key, design.tolerance(key) or "", design.plus_minus(key) * 1e-3, float(of.max()), names[of.argmax()])
        for key, of in zip(keys, used, strict=True)
    ]
    influences.sort(key=lambda i: -i.share)
    return ToleranceStudy(samples, spreads, tuple(influences), _loosened(design, masses, base, influences))


def _loosened(
    design: Design, masses: Any, base: Sequence[Check], influences: Sequence[Influence]
) -> tuple[Influence, ...]:
    """Dimensions besides the three that matter most, of the tightest class first, whose next class fails no check.
    Every check that reads the dimension is run with the next class, the chains among them, and the rules; fits and
    assembly may still need a tolerance that none of them reads."""
    rules = {one.message for one in violations(design)}
    found: list[Influence] = []
    for one in sorted(influences[3:], key=lambda i: (i.plus_minus, i.share)):
        looser = _NEXT.get(one.tolerance)
        if looser is None:
            continue
        entries = (replace(entry, tolerance=looser) if entry.key == one.key else entry for entry in design.entries)
        changed = replace(design, entries=tuple(entries))
        if any(violation.message not in rules for violation in violations(changed)):
            continue
        reading = [check for check in base if one.key in check.inputs]
        after = {
            c.name: c for c in run_checks(changed, masses, tuple({check.subject for check in reading}), advise=False)
        }
        if all(c.verdict != "passes" or (c.name in after and after[c.name].verdict == "passes") for c in reading):
            found.append(one)
        if len(found) == 3:
            break
    return tuple(found)


_NEXT = {"X.XX": "X.X", "X.X": "X"}
"""The next looser class of a general tolerance; a fit is not loosened."""


def _ends(
    design: Design,
    load: Callable[..., Design],
    masses: Masses | None,
    readers: Mapping[str, set[str]],
    nominal: Mapping[str, float],
    key: str,
) -> list[Array]:
    """Margins with one dimension at either end of its tolerance; those of checks that do not read it are unchanged."""
    ends = []
    # The deviation of one part changes no other part, as its nominal value would by a formula.
    kept = [f"{one.key}={one.text}" for one in present_entries(design) if one.formula and one.key != key]
    for deviation in design.deviations(key):
        # geometry is kept in mm, and so is its tolerance; an angle's class is read as millimetres, and left out
        value = float(design.value(key)) + deviation
        changed = load(*kept, f"{key}={value:.12g} {design.entry(key).unit}".rstrip())
        checks = run_checks(changed, changed_masses(changed, design, masses), tuple(sorted(readers[key])))
        found = {check.name: check.margin for check in checks}
        values = [(found.get(name), base) for name, base in nominal.items()]
        ends.append(np.array([base if value is None else value for value, base in values], float))
    return ends
