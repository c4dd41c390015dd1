"""What a part module is: the contract between the parts, their cache, the assembly and the drawings.

A part is one module of `stagecad.solids` (or `stagecad.solids.purchased`), named after the part, that has

- ``NAME``: the part's name everywhere (files, tables, command line).
- ``build(design) -> cadquery.Solid``: the solid, one valid closed solid, millimetres, in part coordinates.
- ``material(design) -> str``: name of its material in the parameter file's ``materials``.
- ``datums(design) -> dict[str, Datum]``: named places others refer to (below).
- ``dimensions(design) -> tuple[Dimension, ...]``: every dimension a maker needs (purchased parts have none).

A purchased part has besides ``part_number(design)`` and ``description(design)`` as text for the bill of materials,
and may have ``mass(design)`` in kilograms where the catalogue knows it better than the simplified solid.

**Coordinates.** Millimetres; x along the travel, y across it, z up, as the part stands in the assembly, with the part's
own origin said in its docstring. A turned part that is used in more than one direction (screws, pins, spring) has its
axis along z.

**Reading the design.** `design` may be the `Design` itself or a `Reading` of it (`stagecad.solids.reading`) that notes
what is read. The cache key covers just what was noted, so a part must read all its numbers from the `design` it is
handed, as attributes (``design.stage.thickness``), and neither from a module global nor by walking over all fields.
Functions of other modules may be called with the same `design`.

**Imports.** The cache follows a module's imports within `stagecad` to know its source. Prefer to leave ``import
cadquery`` to the functions that make geometry: ``material``, ``datums``, ``dimensions`` then cost no second of loading.

**Datums.** A datum is a right-handed frame: origin, unit normal, and a unit x direction at right angles to it.

- On a face, the normal points out of the material; in a hole, pocket or bore, out of the opening towards the air.
- On the end of something that goes into a hole or stands on a face (a screw's bearing face under the head, a pin's end,
  a piezo's foot, a way's underside), it points out of the material as well.
- So a mate is always the same: origins together, normals opposed, x directions parallel.

The assembly (`stagecad.solids.assembly`) relies on these names, all in part coordinates:

==================  ==================================================================================================
part                datums (numbers in a pattern count from 1, in the order of rising x, then rising y)
==================  ==================================================================================================
base                ``top`` (at actuator 1, x along the travel); ``way_left`` (y > 0), ``way_right`` (y < 0): seats of
                    the ways' undersides, at the middle of the footprint, x as the way's own x will point;
                    ``way_left_hole_1`` .. and ``way_right_hole_1`` ..: mouths of the tapped holes;
                    ``pocket_1``, ``pocket_2``, ``pocket_3``: axis of each actuator pocket at the base's top, normal up;
                    ``pin_2_bore_K``: mouth of the vertical bore in the floor of pocket K, normal up;
                    ``pin_1_bore_K``: axis of the horizontal bore of pocket K, where the axis of ``pin_2_bore_K`` meets
                    it, normal along the bore towards the side face from which it is reached;
                    ``set_screw_K``: mouth of the set screw's thread on that side face, normal out of it;
                    ``spring_K``: closed end of the bore, where the spring rests, normal towards the pin;
                    ``clamp_screw_K``: bearing face (counterbore floor) of the clamp screw of pocket K, normal out;
                    ``tooth_bar_left`` (y > 0), ``tooth_bar_right``: seats of the tooth bars, x along the travel
stage               ``pad_1``, ``pad_2``, ``pad_3`` (``pad_4``): crown of each pad, normal down; ``pads``: plane of
                    the crowns under the middle of the stage, normal down; ``top``: payload face; ``sea``: face of
                    the sea at the middle, normal down; ``tooth_iron_left``, ``tooth_iron_right``: seats of the irons,
                    normal down; ``magnet_K``: floors of the magnets' pockets, normal out of the pocket
bearing_way         ``bottom``: middle of the footprint, normal down, x as the part's x (its +y is the outer side);
                    ``top``: middle of the lapped bearing face, normal up; ``screw_1`` .. : bearing faces of the
                    heads on the ledge, normal up. (The right way is the same part turned half a turn about z.)
holder              ``bottom``: normal down, at its axis; ``axis_top``: top at its axis, normal up; ``piezo_1``,
                    ``piezo_2``, ``piezo_3``: floors of the bores, normal up
tip                 ``apex``: normal up; ``piezo_1`` .. ``piezo_3``: seats of the piezos' ends, normal down
height_pin_1        ``axis``: middle of the wedge face's line on the axis, normal along the axis towards the set screw;
                    ``wedge``: the wedge face over that point, normal out of it, x along the slope; ``screw_end``,
                    ``spring_end``: the ends, normals out (``spring_end`` at the floor of the spring's seat)
height_pin_2        ``wedge``: middle of the sloping end, normal out; ``top``: the end that carries the holder, normal
                    up; ``axis``: on the axis at the sloping end, normal up
magnet              ``seat``: the face that goes to the floor of its pocket; ``face``: the other one
tooth_iron          ``seat``: the face on the stage, normal up; ``teeth``: plane of the tooth crests, normal down
tooth_bar           ``seat``: the face on the base, normal down; ``teeth``: plane of the crests, normal up
purchased           ``piezo``: ``foot`` (normal down), ``end`` (apex of its rounded end, normal up); screws: ``seat``
                    (under the head, normal towards the shank), ``end``; ``set_screw``: ``socket``, ``end``; ``spring``:
                    ``end_1``, ``end_2`` (as installed)
==================  ==================================================================================================
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

if TYPE_CHECKING:
    import cadquery as cq

    from stagecad.parameters.dimension import Datum, Dimension


@runtime_checkable
class PartModule(Protocol):
    """A module that follows the contract above. `design` is a `Design` or a `Reading` of one."""

    NAME: str

    def build(self, design: Any) -> cq.Solid: ...

    def material(self, design: Any) -> str: ...

    def datums(self, design: Any) -> dict[str, Datum]: ...

    def dimensions(self, design: Any) -> tuple[Dimension, ...]: ...
