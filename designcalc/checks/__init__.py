"""Every design check: the choices of the parameter file held against the calculators."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import TYPE_CHECKING

from designcalc.checks import budget, candidates, contact, drive, heat, height, pads, sensing, teeth, ways
from designcalc.checks.check import Check, Input, Verdict
from designcalc.checks.reading import Reading
from stagecad.parameters.errors import InputError

if TYPE_CHECKING:
    from stagecad.parameters.design import Design
    from stagecad.parameters.mass_properties import MassProperties

__all__ = ["SUBJECTS", "Check", "Input", "Verdict", "run_checks"]

SUBJECTS: dict[str, Callable[[Reading], Iterator[partial[Check]]]] = {
    "tip on stage": contact.checks,
    "bearing ways": ways.checks,
    "magnetic teeth": teeth.checks,
    "friction drive": drive.checks,
    "sliding bearing": pads.checks,
    "heat and surroundings": heat.checks,
    "sensors": sensing.checks,
    "height adjustment": height.checks,
    "candidates": candidates.checks,
    "error budget": budget.checks,
}
"""Checks by subject, in the order of the report."""


def run_checks(
    design: Design, moving_body: MassProperties | None = None, subjects: tuple[str, ...] | None = None
) -> list[Check]:
    """Run every check on one design.

    Args:
        design: the design.
        moving_body: mass properties of stage and all that rides on it, from the solids; None estimates the mass from
            the plain volume of the stage's plate, and the inputs of the checks concerned say so.
        subjects: names of `SUBJECTS` to run; all when left out.

    Returns:
        the checks, in the order of the subjects. A calculator that refuses its arguments gives the verdict
        `out_of_range`, with its message as the note.
    """
    made: list[Check] = []
    for subject, checks in SUBJECTS.items():
        if subjects is not None and subject not in subjects:
            continue
        reading = Reading(design, moving_body, subject)
        for step in checks(reading):
            try:
                made.append(step())
            except InputError as error:
                made.append(
                    reading.check(
                        f"{subject}: {step.func.__name__.replace('_', ' ')}",
                        None,
                        None,
                        "",
                        "at most",
                        "the calculator's own range",
                        "",
                        note=str(error),
                        trouble="out_of_range",
                    )
                )
    return made
