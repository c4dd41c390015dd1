"""Interface of a part definition: the contract between the parts, their cache, the assembly and the drawings.

A part is one module named after it (or an object in a module for several parts, as the screws); a file of the user's
own states its ``NAME``. It has

- ``build(design) -> cadquery.Solid``: the solid, one valid closed solid, millimetres, in part coordinates.
- ``material(design) -> str``: name of its material in the parameter file's ``materials``; for a part of the packaged
  machine it is that of its table there.
- ``datums(design) -> dict[str, Datum]``: named places others refer to (below).
- ``dimensions(design) -> tuple[Dimension, ...]``: every dimension a maker needs (purchased parts have none).

A part that is manufactured also has, where its function needs them, ``requirements(design) -> tuple[FaceRequirement,
...]``: datum letters, geometrical tolerances and surface texture of its faces; ``NOTES``, texts for its sheet, or
``notes(design)``; ``TREATMENT``, its coating for the title block; ``SYMMETRIC``, the axes whose middle plane is a plane
of symmetry; and ``TURNED``, its number of equal sectors about z.

A part also has ``part_number(design)`` and ``description(design)`` as text for the bill of materials, which the
packaged machine gives to each of its own; a purchased one may have ``mass(design)`` in kilograms where the catalogue's
value is closer than that of the simplified solid.

**Coordinates.** Millimetres; x along the travel, y across it, z up, as the part is oriented in the assembly; the part's
origin is given in its docstring. A turned part that is used in more than one direction (screws, pins, spring) has its
axis along z.

**Reading the design.** `design` may be the `Design` itself or a `TrackedDesign`
(`stagecad.parameters.tracking`) that records what is read. The cache key covers only the recorded parameters, so a
part must read all its numbers from its argument `design`, as attributes (``design.stage.thickness``), and neither
from a module global nor by walking over all fields. Functions of other modules may be called with the same `design`.

**Imports.** The cache follows a module's imports within `stagecad` to find its sources. A part takes ``cq`` from
`stagecad.solids.modelling.kernel`: ``material``, ``datums``, ``dimensions`` then need no loading time.

**Datums.** A datum is a right-handed frame: origin, unit normal, and a unit x direction at right angles to it.

- On a face, the normal points out of the material; in a hole, pocket or bore, out of the opening towards the air.
- On the end of a part that goes into a hole or rests on a face (a screw's bearing face under the head, a pin's end,
  a piezo's foot, a way's underside), it points out of the material as well.
- So a mate is always the same: origins together, normals opposed, x directions parallel.

The assembly (`stagecad.friction_stage.assembly`) relies on these names, in part coordinates. On base, way,
stage and holder a datum named after another part and a number or side (``way_screw_3``, ``magnet_1``,
``tooth_bar_left``) is the seat of one of that part: there are as many in the assembly as there are such datums.

=============  =======================================================================================================
part           datums (numbers count from 1)
=============  =======================================================================================================
base           ``top``: at actuator 1, x along the travel; ``bearing_way_left`` (y > 0), ``bearing_way_right``: seats of
               the ways' undersides, at the middle of the footprint, x as the way's own x will point;
               ``pocket_K``: mouth of actuator pocket K, on its axis, normal up, x as the holder's x will point;
               ``pin_1_bore_K``: where the axes of the two pin bores meet, normal along the horizontal bore towards its
               side face, x up; ``pin_2_bore_K``: mouth of the vertical bore in the pocket's floor, normal up, x towards
               that side face; ``spring_K``: end of the bore where the spring rests, normal towards the pin;
               ``clamp_screw_long_1`` .., ``clamp_screw_short_1`` ..: counterbore floors, normal out; K where it serves
               pocket K is in the order of the pockets; ``tooth_bar_left``, ``tooth_bar_right``: seats of the bars
bearing_way    ``bottom``: middle of the footprint, normal down, x as the part's x; ``top``: middle of the bearing
               face, normal up; ``way_screw_1`` ..: bearing faces of the heads on the ledge, normal up
stage          ``pad_1`` ..: crown of each pad, normal down; ``pads``: plane of the crowns under the middle of the
               stage, normal down, x along the travel; ``top``: payload face; ``drive_surface``: at its middle,
               normal down; ``tooth_iron_1`` .., ``magnet_1`` ..: their seats, normal down
holder         ``bottom``: at its axis, normal down, x as the part's x; ``top``; ``piezo_1`` .. ``piezo_3``: bore floors
tip            ``apex``: normal up; ``piezo_1`` .. ``piezo_3``: seats of the piezos' ends, normal down, x as part's x
height_pin_1   ``axis``: where the wedge face is taken at mid-stroke, on the axis; normal along the axis away from the
               set screw, x towards the wedge face; ``wedge``: on the wedge face over that point, normal out of it;
               ``screw_end``: normal towards the screw; ``spring_end``: shoulder the spring rests on
height_pin_2   ``axis``: on the axis at the sloping end, normal down, x towards the set screw; ``wedge``: same point,
               normal out of the sloping face; ``top``: apex of the upper end, normal up
magnet         ``seat``: face on its pocket's floor; ``face``: the opposite one
tooth_iron     ``seat``: face on the stage; ``teeth``: plane of the tooth crests
tooth_bar      ``seat``: face on the base; ``teeth``: plane of the crests; ``bar_screw_1`` ..: under the heads
purchased      ``piezo``: ``foot`` (normal down), ``end`` (apex of its rounded end); screws: ``seat`` (under the head,
               normal towards the shank), ``end``; ``set_screw``: ``end`` (pushes the pin), ``socket``; ``spring``:
               ``end_1``, ``end_2``
=============  =======================================================================================================
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

from stagecad.parameters.dimension import Datum, Dimension
from stagecad.parameters.errors import InputError, nearest
from stagecad.parameters.machine import content, packaged_machine
from stagecad.solids.modelling.frame import Frame
from stagecad.solids.modelling.kernel import cq

if TYPE_CHECKING:
    from stagecad.parameters.design import Design
    from stagecad.parameters.mass_properties import Masses


@runtime_checkable
class Part(Protocol):
    """A part definition that follows the contract above. `design` is a `Design` or a `TrackedDesign` of one."""

    def build(self, design: Any) -> cq.Solid: ...

    def material(self, design: Any) -> str: ...

    def datums(self, design: Any) -> dict[str, Datum]: ...

    def dimensions(self, design: Any) -> tuple[Dimension, ...]: ...


def notes_of(part: Any, design: Any) -> tuple[str, ...]:
    """The notes of a part's sheet: of its function ``notes``, else its ``NOTES``; no coating of other materials."""
    notes = getattr(part, "notes", None)
    material = design.materials[part.material(design)]
    return tuple(text for text in (notes(design) if notes else getattr(part, "NOTES", ())) if takes(material, text))


def takes(material: Any, text: str) -> bool:
    """Whether a material has the coating that a text asks for: only aluminium is anodised."""
    return "anodi" not in text.lower() or "anodi" in material.coating


def treatment_of(part: Any, design: Any, material: str) -> str:
    """Treatment for the title block: of the material, and of the part's own (``TREATMENT``: its coatings)."""
    made_of = design.materials[material]
    coating = ", ".join(text for text in getattr(part, "TREATMENT", "").split(", ") if takes(made_of, text))
    return "; ".join(text for text in (made_of.treatment, coating) if text not in ("", "none", "-")) or "none"


@dataclass(frozen=True)
class Instance:
    """One instance of a part in the assembly."""

    name: str  # unique: the part's, with a number or side if there are several
    part: str  # name of the part
    frame: Frame  # position in the assembly
    exploded: Frame  # position in the exploded view
    compression: float = 0.0  # of a spring, relative to its installed length at mid-adjustment, mm
    # name of the instance that it is put on, which in the exploded view is elsewhere too; empty for none
    carrier: str = ""

    @property
    def shape(self) -> str:
        """Name of its shape: that of the part; for a compressed spring with the compression."""
        return self.part if abs(self.compression) < 1e-6 else f"{self.part}@{self.compression:.6f}"


def count(instances: Iterable[Instance]) -> dict[str, int]:
    """Number of each part, in the order of their first appearance."""
    return Counter(instance.part for instance in instances)


ASSEMBLY = "assembly"

CONTACT = "contact"
FIT = "clearance fit"
THREAD = "thread engagement"
SLIDING = "sliding contact"
DRIVE = "drive contact"
OVERLAP = "overlap"
GAP = "gap"
OPEN = "not stated"
CLASH = "clash"
"""Relations of two parts: `DRIVE` and `OVERLAP` may share volume; `GAP`: close to each other without contact; `OPEN`:
what their distance shows."""

Position = tuple[float, float]
"""Position of a machine's travel and of its height adjustment, from -1 to 1."""


@dataclass(frozen=True)
class PartSource:
    """Where a part of a machine comes from."""

    name: str  # in the machine, of its files and artefacts
    kind: str  # name of its definition
    modules: tuple[str, ...]  # dotted names of the modules that define it
    definition: Callable[[], Part]  # gives the definition
    purchased: bool = False  # whether it is bought
    depends: tuple[str, ...] = ()  # what else it is made of than modules and parameters
    own_design: Callable[[Any], Any] | None = None  # the design as this part reads it

    def design_of(self, design: Any) -> Any:
        """The design as this part reads it: with its own values in a machine of the user's own."""
        return self.own_design(design) if self.own_design else design


def _nothing(design: Any) -> tuple[Any, ...]:
    return ()


@dataclass(frozen=True)
class Construction:
    """Parts and assembly of a kind of machine."""

    sources: Callable[[Any], Mapping[str, PartSource]]  # the parts of a design by name, in the order of the parts list
    relations: Callable[[Any], Mapping[frozenset[str], str]]  # intended relation of two kinds of part, given the design
    modules: tuple[str, ...]  # dotted names of the modules that assemble it
    # all instances, of the built parts at a position
    assemble: Callable[[Mapping[str, Any], Any, Position], tuple[Instance, ...]]
    masses: Callable[[Any], Masses]  # mass properties that checks and simulation read, from as few parts as they need
    machine_masses: Callable[[Any], Masses]  # the same of a built machine
    documents: Callable[[Any], dict[str, Any]]  # what the command `parts` says of a built machine besides its parts
    depends: Callable[[Any], tuple[str, ...]] = _nothing  # what the assembly depends on besides parts and parameters
    positions: tuple[Position, ...] = ((0.0, 0.0),)  # at which interference is looked for, that at rest among them
    moving: tuple[str, ...] = ()  # parts that move
    carried: tuple[str, ...] = ()  # parts that move with them
    below: tuple[str, ...] = ()  # parts that are pictured from below as well
    accessories: Callable[[Any], tuple[Any, ...]] = _nothing  # what is needed besides the parts
    # why a design lacks a part of this name; empty where there is none such
    refusal: Callable[[str, Any], str] = lambda name, design: ""


def construction(design: Any) -> Construction:
    """The construction of a design's machine."""
    return content("stagecad", design.machine, "construction").CONSTRUCTION


def packaged() -> Construction:
    """The construction of the packaged machine, whose parts any machine may have."""
    return content("stagecad", packaged_machine(), "construction").CONSTRUCTION


def part_names(design: Any) -> tuple[str, ...]:
    """Names of the parts that a design has, made ones first."""
    return tuple(construction(design).sources(design))


def part_source(name: str, design: Any) -> PartSource:
    """Where a part of a design comes from."""
    return construction(design).sources(design)[name]


def chosen(names: Sequence[str], design: Design) -> tuple[str, ...]:
    """The named parts (`assembly` possibly among them), or all parts when none is named."""
    known = (*part_names(design), ASSEMBLY)
    for name in names:
        if name not in known:
            reason = construction(design).refusal(name, design)
            raise InputError(f"part '{name}': {reason}" if reason else f"no part '{name}'{nearest(name, known)}")
    return tuple(name for name in known if name in names) if names else known
