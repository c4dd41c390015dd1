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
from stagecad.parameters.own_code import OwnCodeError

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
    """Run every check on one design."""
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
        except OwnCodeError:
            raise
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
