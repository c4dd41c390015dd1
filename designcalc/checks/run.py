"""Run every design check on one design."""

from __future__ import annotations

from collections.abc import Callable, Container
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from designcalc.checks.check import Check, CheckFunction, at_most
from designcalc.checks.inputs import DesignInputs
from designcalc.friction_stage.checks import (
    actuator,
    alternatives,
    budget,
    chains,
    clamp,
    contact,
    drive,
    height,
    layout,
    position_loop,
    sensing,
    teeth,
    thermal,
)
from designcalc.friction_stage.checks.bearing import pads, plate, smoothness, ways, wear
from stagecad.parameters.errors import InputError

if TYPE_CHECKING:
    from stagecad.parameters.design import Design
    from stagecad.parameters.mass_properties import BodyMasses

SUBJECTS: dict[str, Callable[[Design], list[CheckFunction]]] = {
    "tip on stage": contact.checks,
    "bearing ways": ways.checks,
    "magnetic teeth": teeth.checks,
    "friction drive": drive.checks,
    "piezo actuator": actuator.checks,
    "sliding bearing": pads.checks,
    "stage plate": plate.checks,
    "smoothness": smoothness.checks,
    "wear and heat of the pads": wear.checks,
    "heat and surroundings": thermal.checks,
    "sensors": sensing.checks,
    "height adjustment": height.checks,
    "clamp": clamp.checks,
    "tolerance chains": chains.checks,
    "layout": layout.checks,
    "candidates": alternatives.checks,
    "error budget": budget.checks,
    "dynamic error budget": position_loop.checks,
}
"""Checks by subject, in the order of the report."""

OWN: dict[str, tuple[str, CheckFunction]] = {}
"""Checks of the user's own, with their subjects, by file; they follow the others."""


def run_checks(
    design: Design,
    masses: BodyMasses | None = None,
    subjects: tuple[str, ...] | None = None,
    positions: Container[int] | None = None,
    advise: bool = True,
) -> list[Check]:
    """Run every check on one design.

    Args:
        design: the design.
        masses: of the solids; None estimates the stage from the plain volume of its plate and takes the tip at its
            limit, and the inputs of the checks concerned state it.
        subjects: names of `SUBJECTS` to run; all when left out.
        positions: of the checks to run, counted over all checks of the subjects; all when left out.
        advise: whether a failing check looks for a change that passes, where that takes long.

    Returns:
        the checks, in the order of the subjects. A calculator that refuses its arguments gives the verdict
        `out_of_range`, with its message as the note.
    """
    chosen = [name for name in SUBJECTS if subjects is None or name in subjects]
    functions = [(subject, function) for subject in chosen for function in SUBJECTS[subject](design)]
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
