"""A solid in which no two faces or edges are copies of one another, so that each can be told by itself.

A pattern of holes is one hole placed many times: its faces share one description and differ by their place. OCCT's
STEP writer looks a face up without its place, and attaches what is said of the third hole to the first.
"""

# The kernel's Python bindings are compiled and carry no names that a type checker could see.
# pyright: reportAttributeAccessIssue=false, reportMissingImports=false

from __future__ import annotations

from typing import Any


class Unshared:
    """A solid rebuilt on the same surfaces and curves, each face, wire and edge with a description of its own.

    Attributes:
        solid: the rebuilt solid.
    """

    def __init__(self, solid: Any) -> None:
        from OCP.BRep import BRep_Builder
        from OCP.TopLoc import TopLoc_Location
        from OCP.TopTools import TopTools_DataMapOfShapeShape

        self._builder = BRep_Builder()
        self._own = TopTools_DataMapOfShapeShape()
        self.solid = self._rebuilt(solid, TopLoc_Location())

    def of(self, shape: Any) -> Any:
        """The rebuilt face or edge that stands for one of the solid's own."""
        return self._own.Find(shape)

    def _rebuilt(self, shape: Any, place: Any) -> Any:
        """The shape with its parts renewed, where it stands.

        Args:
            shape: told by its place within its parent.
            place: of the parent.
        """
        from OCP.TopAbs import TopAbs_Orientation, TopAbs_ShapeEnum
        from OCP.TopoDS import TopoDS_Iterator

        here = shape.Located(place * shape.Location())
        if shape.ShapeType() == TopAbs_ShapeEnum.TopAbs_VERTEX:
            return here
        if not self._own.IsBound(here):
            # Parts are added to a shape that is not turned round: adding to one that is would turn them too.
            renewed = here.EmptyCopied().Oriented(TopAbs_Orientation.TopAbs_FORWARD)
            parts = TopoDS_Iterator(shape, False, False)
            while parts.More():
                self._builder.Add(renewed, self._rebuilt(parts.Value(), here.Location()))
                parts.Next()
            renewed.Closed(shape.Closed())
            self._own.Bind(here, renewed)
        return self._own.Find(here).Oriented(shape.Orientation())
