"""Field and forces of the toothed irons of the design, with one magnet over each bar."""

from __future__ import annotations

from dataclasses import dataclass

from designcalc.drive.magnetic_teeth import MagnetCircuit, MagnetWorkingPoint, TeethField, teeth_field, working_point
from designcalc.machine.inputs import DesignInputs

CIRCUITS = 2
"""Magnetic circuits: one pocket with its magnet over each of the two bars."""


@dataclass(frozen=True)
class TeethModel:
    """The tooth field of the design, and the working point of one magnet (of two, one over each bar)."""

    field: TeethField
    circuit: MagnetCircuit
    point: MagnetWorkingPoint
    pitch: float
    width: float
    gap: float
    depth: float


def teeth(r: DesignInputs) -> TeethModel:
    """Field and forces of the toothed irons of the design."""
    pitch, width, gap, depth = (r(f"teeth.{name}") for name in ("pitch", "width", "gap", "groove_depth"))
    field = teeth_field(pitch, width, gap, depth)
    circuit = MagnetCircuit(
        remanence=r("magnet.remanence"),
        thickness=r("magnet.thickness"),
        area=r("magnet.length") * r("magnet.height"),
        recoil_permeability=r("magnet.recoil_permeability"),
        gap_area=r("tooth_iron.length") * r("teeth.per_iron") * pitch,
        gaps=2,  # down through one iron of a pocket, along the bar, up through the other
    )
    return TeethModel(field, circuit, working_point(field, circuit, pitch, width), pitch, width, gap, depth)
