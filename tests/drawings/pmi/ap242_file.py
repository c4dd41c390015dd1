"""Reads a STEP AP242 file back: what is said of which faces. Shares no code with what writes it."""

# pyright: reportAttributeAccessIssue=false, reportMissingImports=false

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cadquery as cq
from OCP import XCAFDoc
from OCP.IFSelect import IFSelect_RetDone
from OCP.STEPCAFControl import STEPCAFControl_Reader
from OCP.TCollection import TCollection_ExtendedString
from OCP.TDataStd import TDataStd_Name, TDataStd_NamedData
from OCP.TDF import TDF_AttributeIterator, TDF_Label, TDF_LabelSequence
from OCP.TDocStd import TDocStd_Document
from OCP.XCAFApp import XCAFApp_Application
from OCP.XCAFDimTolObjects import XCAFDimTolObjects_GeomToleranceModif
from OCP.XCAFDimTolObjects import XCAFDimTolObjects_GeomToleranceTypeValue as GeomToleranceTypeValue

COMMON_ZONE = XCAFDimTolObjects_GeomToleranceModif.XCAFDimTolObjects_GeomToleranceModif_Common_Zone


@dataclass(frozen=True)
class ReadDimension:
    """A dimension: its kind as the kernel names it, its value in mm or degrees, and its faces and edges."""

    kind: str
    value: float
    limits: tuple[float, float] | None
    texts: tuple[tuple[str, str], ...]
    first: tuple[cq.Shape, ...]
    second: tuple[cq.Shape, ...]
    range: tuple[float, float] | None = None


@dataclass(frozen=True)
class ReadTolerance:
    kind: str
    value: float
    letters: tuple[str, ...]
    combined: bool
    cylinder: bool
    """whether its zone is a cylinder"""
    faces: tuple[cq.Shape, ...]


@dataclass(frozen=True)
class Ap242File:
    """All that a file says."""

    name: str
    solid: cq.Shape
    material: str
    density: float
    dimensions: tuple[ReadDimension, ...]
    tolerances: tuple[ReadTolerance, ...]
    datums: dict[str, tuple[cq.Shape, ...]]
    targets: dict[str, tuple[float, float, float]]
    """places of datum targets by letter and number"""
    texts: dict[str, str]


def read_ap242(path: Path, names: Iterable[str] = ()) -> Ap242File:
    """What a file says; of its named texts those with the names, which must be all."""
    document = TDocStd_Document(TCollection_ExtendedString("XmlXCAF"))
    XCAFApp_Application.GetApplication_s().InitDocument(document)
    reader = STEPCAFControl_Reader()
    for switch in ("Name", "GDT", "Mat", "Meta"):
        getattr(reader, f"Set{switch}Mode")(True)
    assert reader.ReadFile(str(path)) == IFSelect_RetDone and reader.Transfer(document)
    tool = XCAFDoc.XCAFDoc_DocumentTool.DimTolTool_s(document.Main())
    free = TDF_LabelSequence()
    XCAFDoc.XCAFDoc_DocumentTool.ShapeTool_s(document.Main()).GetFreeShapes(free)
    (root,) = _each(free)
    material = _labels(XCAFDoc.XCAFDoc_DocumentTool.MaterialTool_s(document.Main()).GetMaterialLabels)
    (of,) = [attribute for label in material for attribute in _attributes(label, XCAFDoc.XCAFDoc_Material)]
    datums = _labels(tool.GetDatumLabels)
    places = {}
    for label in datums:
        if (datum := _datum(label)).IsDatumTarget():
            at = datum.GetDatumTargetAxis().Location()
            places[f"{_letter(label)}{datum.GetDatumTargetNumber()}"] = (at.X(), at.Y(), at.Z())
    return Ap242File(
        _attributes(root, TDataStd_Name)[0].Get().ToExtString(),
        cq.Shape.cast(XCAFDoc.XCAFDoc_ShapeTool.GetShape_s(root)),
        of.GetName().ToCString(),
        of.GetDensity(),
        tuple(_dimension(label) for label in _labels(tool.GetDimensionLabels)),
        tuple(_tolerance(label) for label in _labels(tool.GetGeomToleranceLabels)),
        {_letter(label): _shapes(label)[0] for label in datums if not _datum(label).IsDatumTarget()},
        places,
        _texts(root, names),
    )


def decimals(text: str) -> dict[str, int | None]:
    """Decimals of each dimension by its name, from the text of the file: OCCT's reader passes them over."""
    entities = dict(re.findall(r"^(#\d+) = (.*?);$", text, flags=re.MULTILINE | re.DOTALL))
    found: dict[str, int | None] = {}
    for entity in entities.values():
        if not entity.startswith("SHAPE_DIMENSION_REPRESENTATION"):
            continue
        items = [entities[number] for number in re.findall(r"#\d+", entity)]
        (name,) = [m[1] for item in items if (m := re.search(r"ITEM\('dimension name',\s*'(.*)'\s*\)", item))]
        (value,) = [item for item in items if "'nominal value'" in item]
        style = re.search(r"QUALIFIED_REPRESENTATION_ITEM\(\((#\d+)\)\)", value)
        form = re.search(r"NR2 \d+\.(\d+)", entities[style[1]]) if style else None
        found[name.replace("''", "'")] = int(form[1]) if form else None
    return found


def _dimension(label: Any) -> ReadDimension:
    (attribute,) = _attributes(label, XCAFDoc.XCAFDoc_Dimension)
    content = attribute.GetObject()
    limits = None
    if content.IsDimWithPlusMinusTolerance():
        limits = (content.GetLowerTolValue(), content.GetUpperTolValue())
    texts = tuple(
        (content.GetDescriptionName(index).ToCString(), content.GetDescription(index).ToCString())
        for index in range(content.NbDescriptions())
    )
    kind = content.GetType().name.removeprefix("XCAFDimTolObjects_DimensionType_")
    size = (content.GetLowerBound(), content.GetUpperBound()) if content.IsDimWithRange() else None
    return ReadDimension(kind, content.GetValue(), limits, texts, *_shapes(label), size)


def _tolerance(label: Any) -> ReadTolerance:
    (attribute,) = _attributes(label, XCAFDoc.XCAFDoc_GeomTolerance)
    content, datums = attribute.GetObject(), TDF_LabelSequence()
    XCAFDoc.XCAFDoc_DimTolTool.GetDatumWithObjectOfTolerLabels_s(label, datums)
    modifiers = content.GetModifiers()
    combined = any(modifiers.Value(k) == COMMON_ZONE for k in range(1, modifiers.Length() + 1))
    kind = content.GetType().name.removeprefix("XCAFDimTolObjects_GeomToleranceType_").lower()
    letters = tuple(_letter(datum) for datum in _each(datums))
    cylinder = content.GetTypeOfValue() == GeomToleranceTypeValue.XCAFDimTolObjects_GeomToleranceTypeValue_Diameter
    return ReadTolerance(kind, content.GetValue(), letters, combined, cylinder, _shapes(label)[0])


def _datum(label: Any) -> Any:
    (attribute,) = _attributes(label, XCAFDoc.XCAFDoc_Datum)
    return attribute.GetObject()


def _letter(label: Any) -> str:
    return _datum(label).GetName().ToCString()


def _texts(root: Any, names: Iterable[str]) -> dict[str, str]:
    """Named texts of the product; those bindings that walk over them give the texts without their names."""
    texts = {}
    for attribute in _attributes(root, TDataStd_NamedData):
        attribute.LoadDeferredData()
        for name in names:
            key = TCollection_ExtendedString(name, True)
            if attribute.HasString(key):
                texts[name] = _decoded(attribute.GetString(key))
        assert sorted(_decoded(text) for text in attribute.GetStringsContainer()) == sorted(texts.values())
    return texts


def _decoded(text: Any) -> str:
    # OCCT hands the bytes of UTF-8 on as if each were a sign.
    return text.ToExtString().encode("latin-1").decode("utf-8")


def _shapes(label: Any) -> tuple[tuple[cq.Shape, ...], tuple[cq.Shape, ...]]:
    first, second = TDF_LabelSequence(), TDF_LabelSequence()
    XCAFDoc.XCAFDoc_DimTolTool.GetRefShapeLabel_s(label, first, second)
    return tuple(_shape(one) for one in _each(first)), tuple(_shape(one) for one in _each(second))


def _shape(label: Any) -> cq.Shape:
    return cq.Shape.cast(XCAFDoc.XCAFDoc_ShapeTool.GetShape_s(label))


def _labels(get: Any) -> list[TDF_Label]:
    sequence = TDF_LabelSequence()
    get(sequence)
    return list(_each(sequence))


def _each(sequence: Any) -> Iterator[TDF_Label]:
    for index in range(1, sequence.Length() + 1):
        yield sequence.Value(index)


def _attributes(label: Any, kind: type) -> list[Any]:
    # `FindAttribute` of these bindings gives back no attribute of a dimension; walking over all of them does.
    found, walk = [], TDF_AttributeIterator(label)
    while walk.More():
        if isinstance(walk.Value(), kind):
            found.append(walk.Value())
        walk.Next()
    return found
