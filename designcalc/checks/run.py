"""Run every design check on one design."""

from __future__ import annotations

from collections.abc import Container
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from designcalc.checks.check import Check, at_most
from designcalc.checks.inputs import DesignInputs
from designcalc.checks.own_checks import OWN
from designcalc.checks.subjects import subjects_of
from stagecad.parameters.errors import InputError

if TYPE_CHECKING:
    from stagecad.parameters.design import Design
    from stagecad.parameters.mass_properties import Masses


def run_checks(
    design: Design,
    masses: Masses | None = None,
    subjects: tuple[str, ...] | None = None,
    positions: Container[int] | None = None,
    advise: bool = True,
) -> list[Check]:
    """Run every check on one design.

    Args:
        design: the design.
        masses: of the solids; None estimates the stage from the plain volume of its plate and takes the tip at its
            limit, and the inputs of the checks concerned state it.
        subjects: names of subjects to run; all when left out.
        positions: of the checks to run, counted over all checks of the subjects; all when left out.
        advise: whether a failing check looks for a change that passes, where that takes long.

    Returns:
        the checks, in the order of the subjects. A calculator that refuses its arguments gives the verdict
        `out_of_range`, with its message as the note.
    """
    stated = subjects_of(design).checks
    chosen = [name for name in stated if subjects is None or name in subjects]
    functions = [(subject, function) for subject in chosen for function in stated[subject](design)]
    functions += [own for own in OWN.values() if subjects is None or own[0] in subjects]
    found: list[Check] = []
    memory: dict[Any, Any] = {}
    for position, (subject, function) in enumerate(functions):
        if positions is not None and position not in positions:
            continue
        inputs = DesignInputs(design, masses, memory, advise)
        try:
            check = function(inputs)
        except InputError as error:
            check = Check(
                f"{subject}: {getattr(function, 'func', function).__name__.replace('_', ' ')}",
                at_most(None, None, ""),
                source="the calculator's own range",
                formula="",
                note=str(error),
                trouble="out_of_range",
            )
        passes = check.verdict == "passes"
        found.append(
            replace(
                check,
                subject=subject,
                inputs=inputs.take(),
                proposal="" if passes else check.proposal,
                changes=() if passes else check.changes,
            )
        )
    return found


def subject_names(design: Design) -> tuple[str, ...]:
    """Subjects of the checks of a design, the user's own last."""
    return tuple(dict.fromkeys([*subjects_of(design).checks, *(subject for subject, _ in OWN.values())]))
