"""Volume, centre of mass, inertia and bounding box of a solid; mass properties from them and a density."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from stagecad.parameters.mass_properties import MassProperties
from stagecad.solids.modelling.frame import Frame, add, scaled, transformed_box
from stagecad.solids.modelling.kernel import cq, occ

MM = 1e-3


@dataclass(frozen=True)
class Geometry:
    """Volume properties of a solid, in millimetres and part coordinates."""

    volume: float  # mm^3
    centre: tuple[float, float, float]  # centre of volume, mm
    # inertia tensor about the centre for a density of 1 per mm^3, mm^5
    second_moments: tuple[tuple[float, float, float], ...]
    bounding_box: tuple[tuple[float, float, float], tuple[float, float, float]]  # lowest and highest x, y, z; mm


def geometry_of(solid: cq.Shape) -> Geometry:
    """Volume properties of an exact solid; to be computed before a mesh is made, which would loosen the box."""
    box = occ.Bnd_Box()
    occ.BRepBndLib.AddOptimal_s(solid.wrapped, box, False, False)
    box.SetGap(0.0)
    x0, y0, z0, x1, y1, z1 = box.Get()
    # Integrated about the middle of the box: the shift to the centre is then a difference of small numbers.
    properties = occ.GProp_GProps(occ.gp_Pnt((x0 + x1) / 2, (y0 + y1) / 2, (z0 + z1) / 2))
    occ.BRepGProp.VolumeProperties_s(solid.wrapped, properties, 1e-9, True)
    centre = properties.CentreOfMass()
    matrix = properties.MatrixOfInertia()
    return Geometry(
        properties.Mass(),
        (centre.X(), centre.Y(), centre.Z()),
        tuple(tuple(matrix.Value(row, column) for column in (1, 2, 3)) for row in (1, 2, 3)),
        ((x0, y0, z0), (x1, y1, z1)),
    )


def mass_properties(geometry: Geometry, density: float) -> MassProperties:
    """Mass properties in SI and part coordinates, of a solid in mm and a density in kg/m^3."""
    low, high = geometry.bounding_box
    return MassProperties(
        volume=geometry.volume * MM**3,
        mass=geometry.volume * MM**3 * density,
        centre_of_mass=tuple(value * MM for value in geometry.centre),
        inertia=tuple(tuple(value * MM**5 * density for value in row) for row in geometry.second_moments),
        bounding_box=(tuple(value * MM for value in low), tuple(value * MM for value in high)),
    )


def density_of(design: Any, material: str) -> float:
    """Density of a material of the parameter file, kg/m^3."""
    return design.materials[material].density


def placed(properties: MassProperties, frame: Frame) -> MassProperties:
    """The same body, SI, after a transformation with a shift in mm; the box encloses the transformed box."""
    rotation = frame.rotation
    shift = scaled(frame.shift, MM)
    inertia = tuple(
        tuple(
            sum(rotation[i][a] * properties.inertia[a][b] * rotation[j][b] for a in range(3) for b in range(3))
            for j in range(3)
        )
        for i in range(3)
    )
    box = transformed_box(Frame(rotation, shift), properties.bounding_box)
    centre = add(frame.direction(properties.centre_of_mass), shift)
    return MassProperties(properties.volume, properties.mass, centre, inertia, box)
