"""Evaluation of the changes that failed checks propose: rules of the design, the check itself, and all other checks."""

from collections.abc import Callable, Sequence
from dataclasses import replace

from designcalc.checks.check import Change, Check
from designcalc.checks.run import changed_masses, run_checks
from stagecad.parameters.design import Design
from stagecad.parameters.errors import InputError
from stagecad.parameters.mass_properties import Masses
from stagecad.parameters.rules import violations

_NAMED = 2
"""Largest number of checks that are named among those that a change makes fail."""


def evaluate_proposals(
    checks: Sequence[Check], design: Design, masses: Masses | None, load: Callable[[str], Design]
) -> list[Check]:
    """The checks of a design with their proposed changes evaluated, and what that shows in their proposals.

    A change is made on the design by `load`, without regard to rules; then its rules are checked, and every check that
    reads a value which differs. Changes that pass without side effect come first, those of values that `--set` gives
    last.
    """
    found = []
    for check in checks:
        changes = tuple(_evaluated(one, check.name, checks, design, masses, load) for one in check.changes)
        # What the user asked for with `--set` is not undone while another change passes.
        changes = tuple(sorted(changes, key=lambda one: (bool(one.result), design.is_overridden(one.key))))
        found.append(replace(check, changes=changes, proposal=_text(check.proposal, changes, design)))
    return found


def _text(words: str, changes: tuple[Change, ...], design: Design) -> str:
    usable = [one for one in changes if not one.result and not design.is_overridden(one.key)]
    if usable:
        return f"{words}; {usable[0].key} = {usable[0].text} passes, and no other check then fails"
    return "; ".join([words, *(f"{one.key} = {one.text} {one.result}" for one in changes)])


def _evaluated(
    one: Change,
    name: str,
    checks: Sequence[Check],
    design: Design,
    masses: Masses | None,
    load: Callable[[str], Design],
) -> Change:
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
