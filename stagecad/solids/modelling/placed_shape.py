"""One part somewhere in an assembly, as exports and pictures need it."""

from __future__ import annotations

from dataclasses import dataclass

from stagecad.solids.modelling.colours import Colour
from stagecad.solids.modelling.frame import UNMOVED, Frame


@dataclass(frozen=True)
class Piece:
    """What stands where, in which colour.

    Attributes:
        name: of this instance.
        part: name of its shape; a part alone has both equal.
        colour: sRGB, 0 to 1.
        frame: where it stands.
    """

    name: str
    part: str
    colour: Colour
    frame: Frame = UNMOVED
