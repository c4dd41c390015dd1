"""What a machine states of its construction: parts, assembly, intended contacts. Found by the machine's name."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from stagecad.parameters.errors import InputError, nearest
from stagecad.parameters.machine import content, packaged_machine
from stagecad.solids.modelling.frame import Frame
from stagecad.solids.modelling.part import Part

if TYPE_CHECKING:
    from stagecad.parameters.design import Design
    from stagecad.parameters.mass_properties import Masses


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
    counts: dict[str, int] = {}
    for instance in instances:
        counts[instance.part] = counts.get(instance.part, 0) + 1
    return counts


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
