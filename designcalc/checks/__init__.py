"""Every design check: the choices of the parameter file held against the calculators."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import TYPE_CHECKING

from designcalc.checks import (
    actuator,
    alternatives,
    budget,
    contact,
    drive,
    height,
    layout,
    pads,
    sensing,
    smoothness,
    teeth,
    thermal,
    ways,
    wear,
)
from designcalc.checks.check import Check, Input, Verdict
from designcalc.checks.inputs import Reading, Weighed
from stagecad.parameters.errors import InputError

if TYPE_CHECKING:
    from stagecad.parameters.design import Design

__all__ = ["SUBJECTS", "Check", "Input", "Verdict", "Weighed", "run_checks"]

SUBJECTS: dict[str, Callable[[Reading], Iterator[partial[Check]]]] = {
    "tip on stage": contact.checks,
    "bearing ways": ways.checks,
    "magnetic teeth": teeth.checks,
    "friction drive": drive.checks,
    "piezo actuator": actuator.checks,
    "sliding bearing": pads.checks,
    "smoothness": smoothness.checks,
    "wear and heat of the pads": wear.checks,
    "heat and surroundings": thermal.checks,
    "sensors": sensing.checks,
    "height adjustment": height.checks,
    "layout": layout.checks,
    "candidates": alternatives.checks,
    "error budget": budget.checks,
}
"""Checks by subject, in the order of the report."""


def run_checks(design: Design, weighed: Weighed | None = None, subjects: tuple[str, ...] | None = None) -> list[Check]:
    """Run every check on one design.

    Args:
        design: the design.
        weighed: what the solids weigh; None estimates the stage from the plain volume of its plate and takes the tip at
            its limit, and the inputs of the checks concerned say so.
        subjects: names of `SUBJECTS` to run; all when left out.

    Returns:
        the checks, in the order of the subjects. A calculator that refuses its arguments gives the verdict
        `out_of_range`, with its message as the note.
    """
    made: list[Check] = []
    for subject, checks in SUBJECTS.items():
        if subjects is not None and subject not in subjects:
            continue
        reading = Reading(design, weighed, subject)
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
