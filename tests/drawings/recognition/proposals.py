"""Proposals of dimensions for bodies that a test makes."""

from pathlib import Path
from typing import Any

import cadquery as cq

from drawings.dimensions.definition import Notes, centred_axes, definition
from drawings.recognition.part_file import Proposal, Proposed, as_dimension, in_position
from drawings.recognition.proposal import propose
from stagecad.solids.modelling.verification import DimensionVerifier
from workbench.operations.design import Design
from workbench.operations.drawings import propose_sheet

W = cq.Workplane


def verifier_of(body: cq.Workplane) -> DimensionVerifier:
    return DimensionVerifier(in_position(body.solids().val()))  # pyright: ignore[reportArgumentType]


def proposal_of(body: cq.Workplane) -> Proposal:
    """The proposal for a body, which leaves nothing open."""
    found = propose(verifier_of(body))
    assert not found.open
    return found


def sheet_of(body: cq.Workplane, name: str, folder: Path) -> dict[str, Any]:
    """The only sheet that is drawn of the proposal for a body, without hits."""
    (sheet,) = propose_sheet(name, body.solids().val(), f"{name}.py", Design(), folder)["sheets"]
    assert sheet["hits"] == []
    return sheet


def values(found: Proposal, method: str) -> list[tuple[float, int]]:
    rows = ((round(one.value, 6), one.fields.get("count", 1)) for one in found.dimensions if one.method == method)
    return sorted(rows)


def problems(verifier: DimensionVerifier, dimensions: list[Proposed]) -> tuple[str, ...]:
    notes = Notes(centred_axes(verifier), packaged=False, model=True)
    return definition(verifier, [as_dimension(one) for one in dimensions], (), notes).problems
