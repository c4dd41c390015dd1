"""STEP AP242 file of a part with product and manufacturing information (PMI) associated with its faces.

Sizes, distances and angles with limits, datums, form and orientation tolerances (ISO 10303-242, semantic
representation), material and density. Threads, counts and notes are a `dimensional note` of their dimension, or a named
property of the product. There is no graphical representation.

Declarations that AP242 can represent become dimensions, datums and tolerances; all others become texts, of the
dimension of the same feature or of the product. Millimetres and degrees.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

from drawings.dimensions.text import AXIAL, dimension_text, general_tolerance, number
from drawings.pmi.faces import FaceAssociation, face_association, faces_at
from stagecad.parameters.dimension import DatumFeature, Dimension, GeometricTolerance, Kind, Point, SurfaceTexture
from stagecad.solids.export.step import constant_text, new_document, set_name, step_text
from stagecad.solids.modelling.kernel import cq, occ
from stagecad.solids.modelling.part import Part, notes_of
from stagecad.solids.modelling.verification import DimensionVerifier

TEXT_ONLY: tuple[Kind, ...] = ("count", "callout", "thread_depth", "sag", "pitch_circle")
"""Kinds of declaration that are no distance, angle or size of the solid: they become texts."""


@dataclass(frozen=True)
class TolerancedDimension:
    """One dimension."""

    declaration: Dimension
    limits: tuple[float, float] | None  # lower and upper limit deviation, mm; None without a class, and for angles
    decimals: int | None  # as printed on the sheet; None without a class
    notes: tuple[str, ...]  # count, designation and note


@dataclass(frozen=True)
class PartPmi:
    """The information of one part."""

    dimensions: tuple[TolerancedDimension, ...]
    datums: tuple[DatumFeature, ...]
    tolerances: tuple[GeometricTolerance, ...]
    general: GeometricTolerance  # of all faces without one of their own (ISO 22081)
    texts: dict[str, str]  # of the product, by name


def pmi_of(module: Part, design: Any) -> PartPmi:
    """The product and manufacturing information of a part, by its declarations."""
    dimensions = module.dimensions(design)
    requirements = getattr(module, "requirements", lambda design: ())(design)
    tolerated = [_tolerated(design, dimension) for dimension in dimensions if dimension.kind not in TEXT_ONLY]
    texts: dict[str, str] = {}
    for dimension in (d for d in dimensions if d.kind in TEXT_ONLY):
        same = (n for n, other in enumerate(tolerated) if other.declaration.feature == dimension.feature)
        place = next(same, None) if dimension.feature else None
        if place is None:
            texts[dimension.name] = _as_text(design, dimension)
        else:
            text = f"{dimension.name} {_as_text(design, dimension)}"
            tolerated[place] = replace(tolerated[place], notes=(*tolerated[place].notes, text))
    for requirement in requirements:
        if isinstance(requirement, SurfaceTexture):
            process = f"{requirement.process}, " if requirement.process else ""
            texts[f"surface texture of {requirement.name}"] = f"{process}Ra {requirement.roughness:g} um"
    for index, note in enumerate(notes_of(module, design), start=1):
        texts[f"note {index}"] = note
    return PartPmi(
        tuple(tolerated),
        tuple(r for r in requirements if isinstance(r, DatumFeature)),
        tuple(r for r in requirements if isinstance(r, GeometricTolerance)),
        general_tolerance(design, requirements),
        texts,
    )


def _tolerated(design: Any, dimension: Dimension) -> TolerancedDimension:
    notes = [f"{dimension.count}x"] if dimension.count > 1 else []
    if dimension.kind == "slope":
        notes.append(f"slope {dimension.value:g}")
    if dimension.kind == "chamfer":
        notes.append("45 deg")
    if dimension.exact:
        notes.append("theoretically exact")
    if dimension.note:
        notes.append(dimension.note)
    if dimension.kind == "pitch":
        # The file has the distance of the first and last feature.
        notes = [dimension_text(dimension, _plus_minus(design, dimension) or 0.0), *notes[1:]]
        dimension = replace(dimension, kind="linear", value=dimension.value * dimension.count, count=1)
    plus_minus = _plus_minus(design, dimension)
    printed = number(dimension.value, dimension.tolerance, plus_minus or 0.0).partition(" ")[0]
    decimals = len(printed.partition(".")[2]) if dimension.tolerance and not dimension.exact else None
    limits = dimension.deviations or (None if plus_minus is None else (-plus_minus, plus_minus))
    return TolerancedDimension(dimension, limits, decimals, tuple(notes))


def _plus_minus(design: Any, dimension: Dimension) -> float | None:
    # The tolerance classes apply to lengths only.
    if dimension.tolerance is None or dimension.reference or dimension.exact or dimension.kind in ("angle", "slope"):
        return None
    if dimension.deviations is not None:
        low, high = dimension.deviations
        return (high - low) / 2
    names = {"X": "tolerance_x", "X.X": "tolerance_x_x", "X.XX": "tolerance_x_xx"}
    return getattr(design.drawing, names[dimension.tolerance])


def _as_text(design: Any, dimension: Dimension) -> str:
    if dimension.kind in ("callout", "sag", "pitch_circle"):
        return dimension_text(dimension, 0.0).replace("±", "+-")
    plus_minus = _plus_minus(design, dimension)
    text = number(dimension.value, dimension.tolerance, plus_minus or 0.0).partition(" ")[0]
    if plus_minus:
        text += f" +-{plus_minus:g}"
    return f"{text}, {dimension.note}" if dimension.note else text


_LIMIT = re.compile(r"(#\d+ = )MEASURE_WITH_UNIT\((-?[\d.E+-]+),\s*(#\d+)\)")
"""A limit of a plus-minus tolerance, which OCCT 7.9 writes as a bare number: `value_component` is a select type, whose
values need the name of their type (section 11.1.8)."""


def directed_distances(text: str) -> str:
    """Distances with a direction of their own, with the name and the placement that readers need.

    OCCT 7.9 writes an empty name, and a placement without a second direction, which its own reader rejects.
    """
    number = _last_number(text)
    added: list[str] = []

    def completed(found: re.Match[str]) -> str:
        nonlocal number
        number += 1
        direction = re.search(rf"{found[2]} = DIRECTION\('',\(([^)]*)\)\)", text)
        if direction is None:
            raise ValueError(f"the STEP file has no direction {found[2]}")
        x, y, z = (float(part) for part in direction[1].split(","))
        # Normal to it: the axis with the smallest component, made orthogonal.
        side = min(range(3), key=lambda k: abs((x, y, z)[k]))
        square = [(1.0 if k == side else 0.0) - (x, y, z)[side] * (x, y, z)[k] for k in range(3)]
        size = sum(part * part for part in square) ** 0.5
        added.append(f"#{number} = DIRECTION('',({','.join(_real(part / size) for part in square)}));\n")
        return f"{found[1]}{found[2]},#{number})"

    text = re.sub(r"(AXIS2_PLACEMENT_3D\('orientation',#\d+,)(#\d+),\$\)", completed, text)
    text = text.replace("DIMENSIONAL_LOCATION('',", "DIMENSIONAL_LOCATION('linear distance',")
    end = text.rindex("ENDSEC;")
    return text[:end] + "".join(added) + text[end:]


def with_properties(text: str, properties: dict[str, str]) -> str:
    """The file of one product with named texts as user-defined attributes.

    Entities and names follow the recommended practice of the CAx Implementor Forum.
    """
    product = re.search(r"(#\d+) = PRODUCT_DEFINITION\(", text)
    context = re.search(r"ADVANCED_BREP_SHAPE_REPRESENTATION\('[^']*',\([^)]*\),(#\d+)\)", text)
    # Readers based on OCCT take the last text of a product as its material.
    material = re.search(r"^#\d+ = REPRESENTATION\('material name'", text, flags=re.MULTILINE)
    if product is None or context is None or material is None:
        raise ValueError("the STEP file has no product with a shape and a material")
    number = _last_number(text)
    lines = []
    for name, value in properties.items():
        general, association, definition, link, representation, item = (f"#{number + k}" for k in range(1, 7))
        number += 6
        lines += [
            f"{general} = GENERAL_PROPERTY('',{_string(name)},$);",
            f"{association} = GENERAL_PROPERTY_ASSOCIATION('user defined attribute','',{general},{definition});",
            f"{definition} = PROPERTY_DEFINITION({_string(name)},'',{product[1]});",
            f"{link} = PROPERTY_DEFINITION_REPRESENTATION({definition},{representation});",
            f"{representation} = REPRESENTATION('',({item}),{context[1]});",
            f"{item} = DESCRIPTIVE_REPRESENTATION_ITEM({_string(name)},{_string(value)});",
        ]
    place = material.start()
    return text[:place] + "".join(f"{line}\n" for line in lines) + text[place:]


def _last_number(text: str) -> int:
    return max(int(number) for number in re.findall(r"^#(\d+) =", text, flags=re.MULTILINE))


def _real(value: float) -> str:
    """A real number with a decimal point (section 6.4.2)."""
    shown = f"{value + 0.0:.15G}"
    return shown if "." in shown else shown.replace("E", ".E") if "E" in shown else f"{shown}."


def _string(text: str) -> str:
    """A string with quotes doubled and characters outside ASCII as UCS-2 (section 6.4.3)."""

    def wide(found: re.Match[str]) -> str:
        return f"\\X2\\{found[0].encode('utf-16-be').hex().upper()}\\X0\\"

    return "'" + re.sub(r"[^ -~]+", wide, text.replace("\\", "\\\\").replace("'", "''")) + "'"


NAME, NOTE = "dimension name", "dimensional note"
"""Names of the texts of a dimension: its name, and its notes on the sheet."""
TYPES = {"profile": "ProfileOfSurface"}
"""The kernel's names of characteristics that differ from ours."""


def ap242_bytes(
    part: str, module: Part, design: Any, solid: cq.Shape, verifier: DimensionVerifier | None = None
) -> bytes:
    """The STEP file as bytes, the same for the same solid and declarations."""
    pmi = pmi_of(module, design)
    material = design.materials[module.material(design)]
    text = constant_text(_written(part, solid, verifier or DimensionVerifier(solid), pmi, material), part)
    text = _LIMIT.sub(r"\1LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(\2),\3)", text)
    return with_properties(directed_distances(text), pmi.texts).encode()


def _written(part: str, solid: cq.Shape, verifier: DimensionVerifier, pmi: PartPmi, material: Any) -> str:
    document = new_document()
    shapes = occ.XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
    # Features of a pattern share their faces up to the place, and the writer looks up faces without their place: in a
    # copy each face and edge is a separate shape.
    unique = occ.BRepBuilderAPI_Copy(solid.wrapped, False, False)
    label = shapes.AddShape(unique.Shape(), False)
    set_name(label, part)
    # The kernel always writes g/cm^3 as the unit of the density.
    occ.XCAFDoc_DocumentTool.MaterialTool_s(document.Main()).SetMaterial(
        label,
        _ascii(material.description),
        _ascii(material.description),
        material.density * 1e-3,
        _ascii("density measure"),
        _ascii("POSITIVE_RATIO_MEASURE"),
    )
    _Annotated(document, label, unique).add(verifier, pmi)
    return step_text(document, part, "AP242DIS", ("DimTol", "Material"))


class _Annotated:
    """A part in an XCAF document, with dimensions, datums and tolerances on its faces."""

    def __init__(self, document: Any, label: Any, unique: Any) -> None:
        self._label, self._unique = label, unique
        self._shapes = occ.XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
        self._tool = occ.XCAFDoc_DocumentTool.DimTolTool_s(document.Main())

    def add(self, verifier: DimensionVerifier, pmi: PartPmi) -> None:
        for dimension in pmi.dimensions:
            # The depth of a slanting hole ends at no plane that it is normal to: it is on the sheet alone.
            with suppress(LookupError):
                self._add_dimension(dimension, face_association(verifier, dimension.declaration))
        datums = {datum.letter: faces_at(verifier, datum.points, datum.normal) for datum in pmi.datums}
        own: list[cq.Face] = []
        for tolerance in pmi.tolerances:
            faces = faces_at(verifier, tolerance.points, tolerance.normal)
            self._add_tolerance(tolerance, faces, datums)
            own += faces
        rest = (s.face for s in verifier.surfaces if not any(s.face is face for face in own))
        self._add_tolerance(pmi.general, tuple(rest), datums)
        referred = {letter for tolerance in (*pmi.tolerances, pmi.general) for letter in tolerance.datums}
        for letter, faces in datums.items():
            if letter not in referred:
                self._add_datum(letter, faces, 0)
        for datum in pmi.datums:
            for index, (point, face) in enumerate(zip(datum.points, datums[datum.letter], strict=True), start=1):
                if datum.targets:
                    self._add_datum(datum.letter, (face,), 0, (index, point, datum.normal))

    def _labels(self, shapes: Iterable[cq.Shape]) -> Any:
        sequence = occ.TDF_LabelSequence()
        for shape in shapes:
            sequence.Append(self._shapes.AddSubShape(self._label, self._unique.ModifiedShape(shape.wrapped)))
        return sequence

    def _add_dimension(self, dimension: TolerancedDimension, attached: FaceAssociation) -> None:
        declaration = dimension.declaration
        label = self._tool.AddDimension()
        self._tool.SetDimension(self._labels(attached.first), self._labels(attached.second), label)
        content = occ.XCAFDimTolObjects_DimensionObject()
        content.SetType(_dimension_type(declaration, attached))
        # In the unit of the kernel's data: mm; radians for an angle.
        value = {"angle": math.radians, "slope": math.atan}.get(declaration.kind, float)(declaration.value)
        limits = [value]
        if dimension.limits is not None:
            low, high = dimension.limits
            # The kernel takes the lower deviation with the opposite sign, and reads deviations on one side of zero
            # wrongly: these become the limits of size.
            limits = [value + low, value + high] if low * high > 0.0 else [value, -low, high]
        values = occ.TColStd_HArray1OfReal(1, len(limits))
        for index, limit in enumerate(limits, start=1):
            values.SetValue(index, limit)
        content.SetValues(values)
        # OCCT reads an angle with a number of decimals as degrees, although it is written in radians.
        if dimension.decimals is not None and declaration.kind != "angle":
            content.SetNbOfDecimalPlaces(len(str(int(abs(declaration.value)))), dimension.decimals)
        notes = list(dimension.notes)
        if attached.from_middle:
            notes.append("from the middle of the two faces")
        if attached.oriented and declaration.direction:
            content.SetDirection(occ.gp_Dir(*declaration.direction))
            notes.append(f"along {_direction(declaration.direction)}")
        content.SetSemanticName(_aspect_name(declaration.name))
        content.AddDescription(_ascii(declaration.name), _ascii(NAME))
        for note in notes:
            content.AddDescription(_ascii(note), _ascii(NOTE))
        occ.XCAFDoc_Dimension.Set_s(label).SetObject(content)

    def _add_tolerance(
        self, tolerance: GeometricTolerance, faces: tuple[cq.Face, ...], datums: dict[str, tuple[cq.Face, ...]]
    ) -> None:
        label = self._tool.AddGeomTolerance()
        self._tool.SetGeomTolerance(self._labels(faces), label)
        content = occ.XCAFDimTolObjects_GeomToleranceObject()
        kind = TYPES.get(tolerance.characteristic, tolerance.characteristic.title())
        content.SetType(getattr(occ.XCAFDimTolObjects_GeomToleranceType, f"XCAFDimTolObjects_GeomToleranceType_{kind}"))
        # The axis of a round face is inside a cylinder; everything else between two faces.
        zone = "Diameter" if tolerance.round and tolerance.characteristic in AXIAL else "None"
        content.SetTypeOfValue(
            getattr(occ.XCAFDimTolObjects_GeomToleranceTypeValue, f"XCAFDimTolObjects_GeomToleranceTypeValue_{zone}")
        )
        content.SetValue(tolerance.value)
        content.SetSemanticName(_aspect_name(tolerance.name))
        if tolerance.combined:
            content.AddModifier(
                occ.XCAFDimTolObjects_GeomToleranceModif.XCAFDimTolObjects_GeomToleranceModif_Common_Zone
            )
        occ.XCAFDoc_GeomTolerance.Set_s(label).SetObject(content)
        # OCCT needs a datum for each reference; the writer merges those of one letter.
        for position, letter in enumerate(tolerance.datums, start=1):
            self._tool.SetDatumToGeomTol(self._add_datum(letter, datums[letter], position), label)

    def _add_datum(
        self, letter: str, faces: tuple[cq.Face, ...], position: int, target: tuple[int, Point, Point] | None = None
    ) -> Any:
        """Add a datum, or with number, place and normal a target of one."""
        label = self._tool.AddDatum()
        self._tool.SetDatum(self._labels(faces), label)
        content = occ.XCAFDimTolObjects_DatumObject()
        content.SetName(_ascii(letter))
        content.SetPosition(position)
        if target:
            index, point, normal = target
            content.IsDatumTarget(True)
            content.SetDatumTargetType(occ.XCAFDimTolObjects_DatumTargetType.XCAFDimTolObjects_DatumTargetType_Point)
            content.SetDatumTargetNumber(index)
            content.SetDatumTargetAxis(occ.gp_Ax2(occ.gp_Pnt(*point), occ.gp_Dir(*normal)))
        occ.XCAFDoc_Datum.Set_s(label).SetObject(content)
        return label


def _ascii(text: str) -> Any:
    return occ.TCollection_HAsciiString(text)


def _aspect_name(name: str) -> Any:
    """Name of the associated faces; the writer drops the first word."""
    return _ascii(f"of {name}")


def _direction(direction: Point) -> str:
    """A direction as text: the name of an axis of the part, or the components."""
    for axis, component in zip("xyz", direction, strict=True):
        if abs(abs(component) - 1) < 1e-9:
            return axis
    return "(" + ", ".join(f"{component:.4f}" for component in direction) + ")"


def _dimension_type(declaration: Dimension, attached: FaceAssociation) -> Any:
    match declaration.kind:
        case "diameter" | "tap_drill" | "thread":
            name = "Size_Diameter"
        case "radius":
            of = attached.first[0].geomType()
            name = {"SPHERE": "Size_SphericalRadius", "TORUS": "Size_ToroidalMinorRadius"}.get(of, "Size_Radius")
        case "angle" | "slope":
            name = "Location_Angular"
        case _ if attached.sides != ("centre", "centre"):
            start, end = (side.replace("centre", "center").capitalize() for side in attached.sides)
            name = f"Location_LinearDistance_From{start}To{end}"
        case _ if attached.oriented:
            name = "Location_Oriented"
        case _:
            name = "Location_LinearDistance"
    return getattr(occ.XCAFDimTolObjects_DimensionType, f"XCAFDimTolObjects_DimensionType_{name}")
