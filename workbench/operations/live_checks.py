"""Design checks while a parameter is dragged: only those that read a changed value, the quick ones first.

A check states its inputs, so a change concerns the checks that read a value which differs from that of their last
evaluation. Most take less than a millisecond, a few (resonances of the plate, field of the teeth) a quarter of a
second: each answer is given within a time limit, and names the checks that are still out of date.
"""

import threading
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Any

from designcalc.checks.check import Check
from designcalc.checks.report import shown, shown_limit, shown_margin
from designcalc.checks.run import changed_masses, own_check_files, register, run_checks, subjects_of
from stagecad.parameters.design import Design
from stagecad.parameters.mass_properties import Masses
from stagecad.parameters.units import attributes

QUICK = 0.004
"""Checks below this time are evaluated together, s."""


@dataclass
class _Evaluated:
    check: Check
    values: dict[str, float]
    masses: str
    version: int


@dataclass(frozen=True)
class LiveResult:
    """Checks by position that are new to the page, and the positions of those that are out of date."""

    count: int
    version: int  # counts the evaluations; a page that names it is answered with later ones only
    checks: dict[int, Check]
    pending: tuple[int, ...]
    seconds: float


class LiveChecks:
    """The checks of the last design that was shown; safe to call from several threads."""

    def __init__(self) -> None:
        self._own: tuple[str, ...] = ()
        self._lock = threading.Lock()
        self._known: dict[int, _Evaluated] = {}
        self._functions: tuple[int, ...] = ()
        self._version = 0
        self._costs: dict[int, float] = {}
        self._words: dict[str, Any] | None = None
        self._base: tuple[Design, Masses] | None = None

    def set_file(self, params: Path | None) -> None:
        """The parameter file; the user's own checks beside it follow the others. InputError: no consent to run one."""
        self._own, files = (), own_check_files(params)
        register(files)
        with self._lock:
            self._own, self._functions = files, ()

    def set_masses(self, design: Design, masses: Masses) -> None:
        """Masses of the solids of `design`, from which those of a changed design are scaled."""
        self._base = design, masses

    def update(self, design: Design, limit: float, since: int = 0) -> LiveResult:
        """Evaluate the checks that are out of date, the quickest first, until `limit` seconds have passed.

        Returns those evaluated after version `since` that are up to date.
        """
        began = perf_counter()
        with self._lock:
            counts = (*(len(functions(design)) for functions in subjects_of(design).checks.values()), len(self._own))
            by_key = {entry.key: entry.value for entry in design.entries}
            words = {key: value for key, value in by_key.items() if isinstance(value, bool | str)}
            if counts != self._functions or words != self._words:
                # Other parts have other checks, and a check does not state the words that it reads (a material).
                self._functions, self._words, self._known = counts, words, {}
            count = sum(counts)
            masses = changed_masses(design, *self._base) if self._base is not None else None
            mark = "" if masses is None else repr(masses)
            stale = [k for k in range(count) if self._is_stale(k, by_key, mark)]
            stale.sort(key=self._cost)
            evaluated: set[int] = set()
            for group in self._groups(stale, limit):
                expected = sum(self._cost(k) for k in group)
                if evaluated and perf_counter() - began + expected > limit:
                    break
                self._evaluate(group, design, masses, mark)
                evaluated |= set(group)
            pending = tuple(k for k in stale if k not in evaluated)
            since = 0 if since > self._version else since
            late = set(pending)
            newer = {k: one.check for k, one in sorted(self._known.items()) if one.version > since and k not in late}
            return LiveResult(count, self._version, newer, pending, perf_counter() - began)

    def all_known(self) -> dict[int, Check]:
        """Every check as last evaluated, by position."""
        with self._lock:
            return {k: one.check for k, one in sorted(self._known.items())}

    def _is_stale(self, position: int, by_key: Mapping[str, Any], mark: str) -> bool:
        known = self._known.get(position)
        if known is None:
            return True
        if any(by_key[key] != value for key, value in known.values.items()):
            return True
        if known.masses == mark:
            return False
        # What is measured on the solids is not a parameter; without solids, parameters stand in for it.
        return not known.masses or not mark or len(known.values) < len(known.check.inputs)

    def _cost(self, position: int) -> float:
        return self._costs.get(position, 0.01)

    def _groups(self, stale: Sequence[int], limit: float) -> Iterator[list[int]]:
        """The quick checks that half of the limit is enough for, in one group; then each of the others by itself."""
        first: list[int] = []
        for position in stale:
            if self._cost(position) > QUICK or sum(map(self._cost, first)) > 0.5 * limit:
                break
            first.append(position)
        if first:
            yield first
        for position in stale[len(first) :]:
            yield [position]

    def _evaluate(self, group: list[int], design: Design, masses: Masses | None, mark: str) -> None:
        began = perf_counter()
        found = dict(zip(sorted(group), run_checks(design, masses, None, set(group), files=self._own)))
        seconds = (perf_counter() - began) / len(group)
        keys = {entry.key for entry in design.entries}
        self._version += 1
        for position, check in found.items():
            values = {key: design.value(key) for key in check.inputs if key in keys}
            self._known[position] = _Evaluated(check, values, mark, self._version)
            if len(group) == 1:
                # The first evaluation also loads what later ones find loaded.
                self._costs[position] = min(seconds, self._costs.get(position, seconds))


def check_row(position: int, check: Check) -> dict[str, Any]:
    """What the list of the page shows of a check; the whole document is `Check.as_json`."""
    return {
        "position": position,
        **attributes(check, "name", "subject", "verdict", "margin"),
        "value": shown(check.value, check.unit),
        "limit": shown_limit(check),
        "shown_margin": shown_margin(check),
    }
