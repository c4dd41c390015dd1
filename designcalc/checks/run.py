"""Run every design check on one design, evaluate the changes that failed checks propose; what a machine states."""

from collections.abc import Callable, Container, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import wraps
from pathlib import Path
from typing import Any

from designcalc.checks.chain import Chain
from designcalc.checks.check import (
    Change,
    Check,
    CheckFunction,
    DesignInputs,
    FormulaCheck,
    MissingNumberError,
    at_most,
)
from designcalc.drive.suspension import Suspension
from designcalc.errors.dynamic_budget import DynamicBudget
from designcalc.errors.error_budget import Budget
from stagecad.declared.own_part import run_file
from stagecad.parameters.design import Design
from stagecad.parameters.errors import InputError
from stagecad.parameters.machine import content
from stagecad.parameters.mass_properties import Masses
from stagecad.parameters.own_code import OwnCodeError, own_code
from stagecad.parameters.rules import violations

OWN: dict[str, tuple[str, CheckFunction]] = {}
"""Checks of the user's own that are known in this process, with their subjects, by file; they follow the others."""
CONTENTS: dict[str, bytes] = {}
"""What these files held when they were run."""


def own_check_files(params: Path | None) -> tuple[str, ...]:
    """The files beside a parameter file; none for the packaged design."""
    return () if params is None else tuple(map(str, sorted((params.parent / "checks").glob("*.py"))))


def register(files: Sequence[str], trust: bool = False, accepted: Mapping[str, bytes] | None = None) -> None:
    """Add the checks of these files to those of every design in this process. With the contents that another process
    has run they are all: a worker may have those of another project from before."""
    for name in OWN.keys() - accepted.keys() if accepted is not None else ():
        del OWN[name]
    for name in files:
        data = None if accepted is None else accepted.get(name)
        if name in OWN and not trust and data in (None, CONTENTS[name]):
            continue
        path = Path(name)
        module = run_file(path, trust, "this project", data)
        function = getattr(module, "check", None)
        if not callable(function):
            raise InputError(f"{path}: has no function check(r); `stagecad new check NAME` writes a file that has")
        CONTENTS[name] = module.__content__  # pyright: ignore[reportAttributeAccessIssue]
        OWN[name] = (str(getattr(module, "SUBJECT", "own checks")), _guarded(path, function))


def _guarded(path: Path, function: Callable[..., Any]) -> CheckFunction:
    """The function of a file, which gives a check or an error of the file."""

    @wraps(function)
    def check(inputs: Any) -> Check:
        with own_code(path):
            found = function(inputs)
        if not isinstance(found, Check):
            raise OwnCodeError(f"{path}: check(r) gives {type(found).__name__}; a Check is required")
        return found

    check.__name__ = path.stem
    return check


@dataclass(frozen=True)
class Studies:
    """What the report of the checks shows besides them."""

    suspensions: Sequence[Suspension] = ()  # alternatives by rank
    budgets: Sequence[Budget] = ()  # error budgets
    dynamic: Sequence[DynamicBudget] = ()  # dynamic error budgets


@dataclass(frozen=True)
class Subjects:
    """Checks of a kind of machine; without `changed_masses` those of the present solids serve: a result is verified
    with its own."""

    checks: Mapping[str, Callable[[Design], list[CheckFunction]]]  # of a design by subject, in the order of the report
    chains: Callable[[Design], tuple[Chain, ...]] = lambda design: ()  # tolerance chains of a design
    # masses of a design, given another one and that one's
    changed_masses: Callable[[Design, Design, Any], Any] = lambda design, base, masses: masses
    mass_keys: tuple[str, ...] = ()  # beginnings of the keys that these masses depend on
    requirements: Mapping[str, str] = field(default_factory=dict)  # names that checks refer to, with their text
    not_made: tuple[str, ...] = ()  # subjects of alternatives that are not made: their tolerances do not matter
    studies: Callable[[DesignInputs], Studies] = lambda r: Studies()  # for the report
    # calculated numbers of the assembly procedure
    procedure_values: Callable[[DesignInputs], dict[str, float | None]] = lambda r: {}
    # names of the figures of the checks (`workbench.figures.checks`) that a design has
    figures: Callable[[Design], tuple[str, ...]] = lambda design: ()
    # names of the friction experiments of the thesis that are run with the design's values
    experiments: tuple[str, ...] = ()


def subjects_of(design: Design) -> Subjects:
    """The checks of a design's machine."""
    return content("designcalc", design.machine, "checks").SUBJECTS


def changed_masses(design: Design, base: Design, masses: Any) -> Any:
    """Masses of a design, without its solids, from those of the solids of another one; None without these."""
    return None if masses is None else subjects_of(design).changed_masses(design, base, masses)


def run_checks(
    design: Design,
    masses: Masses | None = None,
    subjects: tuple[str, ...] | None = None,
    positions: Container[int] | None = None,
    advise: bool = True,
    files: Container[str] | None = None,
) -> list[Check]:
    """Run every check on one design; of the user's own those of `files`, or all that are known in this process."""
    stated = subjects_of(design).checks
    chosen = [name for name in stated if subjects is None or name in subjects]
    functions = [(subject, function) for subject in chosen for function in stated[subject](design)]
    kept = [own for file, own in OWN.items() if files is None or file in files]
    functions += [own for own in kept if subjects is None or own[0] in subjects]
    found: list[Check] = []
    memory: dict[Any, Any] = {}
    for position, (subject, function) in enumerate(functions):
        if positions is not None and position not in positions:
            continue
        inputs = DesignInputs(design, masses, memory, advise)
        try:
            check = function(inputs)
        except OwnCodeError:
            raise
        except InputError as error:
            if isinstance(function, FormulaCheck):
                name = function.name
            else:
                name = f"{subject}: {getattr(function, 'func', function).__name__.replace('_', ' ')}"
            check = Check(
                name,
                at_most(None, None, ""),
                source="the calculator's own range",
                formula="",
                note=str(error),
                trouble="undecidable" if isinstance(error, MissingNumberError) else "out_of_range",
            )
        advice = {"proposal": "", "changes": ()} if check.verdict == "passes" else {}
        found.append(replace(check, subject=subject, inputs=inputs.inputs, **advice))
    return found


def subject_names(design: Design) -> tuple[str, ...]:
    """Subjects of the checks of a design, the user's own last."""
    return tuple(dict.fromkeys([*subjects_of(design).checks, *(subject for subject, _ in OWN.values())]))


_NAMED = 2
"""Largest number of checks that are named among those that a change makes fail."""


def evaluate_proposals(
    checks: list[Check], design: Design, masses: Masses | None, load: Callable[[str], Design]
) -> list[Check]:
    """The checks of a design with their proposed changes evaluated, and what that shows in their proposals.

    A change is made on the design by `load`, without regard to rules; then its rules are checked, and every check that
    reads a value which differs. Changes that pass without side effect come first, those of values that `--set` gives
    last.
    """

    def evaluated(one: Change, name: str) -> Change:
        try:
            changed = load(one.override)
        except InputError as error:
            return replace(one, result=f"is refused: {error}")
        broken = violations(changed)
        if broken:
            return replace(one, result=f"cannot be built: {broken[0].message}")
        differ = {key for key in (entry.key for entry in design.entries) if design.value(key) != changed.value(key)}
        positions = {k for k, check in enumerate(checks) if not differ.isdisjoint(check.inputs)}
        before = {checks[k].name: checks[k].verdict for k in positions}
        after = {
            check.name: check
            for check in run_checks(changed, changed_masses(changed, design, masses), None, positions, advise=False)
        }
        if name in after and after[name].verdict != "passes":
            return replace(one, result="is not enough")
        worse = [other for other, check in after.items() if check.verdict != "passes" and before.get(other) == "passes"]
        if worse:
            more = f" and {len(worse) - _NAMED} more" if len(worse) > _NAMED else ""
            return replace(one, result=f"passes, but fails {', '.join(repr(other) for other in worse[:_NAMED])}{more}")
        return one

    found = []
    for check in checks:
        changes = tuple(evaluated(one, check.name) for one in check.changes)
        # What the user asked for with `--set` is not undone while another change passes.
        changes = tuple(sorted(changes, key=lambda one: (bool(one.result), design.is_overridden(one.key))))
        found.append(replace(check, changes=changes, proposal=_text(check.proposal, changes, design)))
    return found


def _text(words: str, changes: tuple[Change, ...], design: Design) -> str:
    usable = [one for one in changes if not one.result and not design.is_overridden(one.key)]
    if usable:
        return f"{words}; {usable[0].key} = {usable[0].text} passes, and no other check then fails"
    return "; ".join([words, *(f"{one.key} = {one.text} {one.result}" for one in changes)])
