"""A sheet with one of everything: a plate in two scales, and an annotation of each kind."""

from drawings.annotations import annotation
from drawings.sheets.frame import TitleBlock
from drawings.sheets.sheet import Sheet
from drawings.views.view import PROJECTIONS, Arc, Polyline, Segment, View

LIMITS = (("X.", "±0.1"), ("X.X", "±0.1"), ("X.XX", "±0.01"), ("ANGLE", "±0.5°"))
NAMES = {"title": "plate", "supplement": "Machine", "number": "FILE_NAME", "material": "Al 6061-T651"}
REST = {"revision": "0.1.0", "parameters": "a1b2c3d4", "kind": "Part drawing", "finish": "Ra 3.2", "tolerances": LIMITS}
TITLE = TitleBlock(**NAMES, mass="1.25 kg", scale="1:2", sheet=2, sheets=3, **REST)


def plate(scale: float, place: tuple[float, float], name: str = "top") -> View:
    corners = [(-40.0, -20.0), (40.0, -20.0), (40.0, 20.0), (-40.0, 20.0)]
    outline = tuple(Segment(a, b) for a, b in zip(corners, [*corners[1:], corners[0]], strict=True))
    curves = {
        "VISIBLE": (*outline, Arc((10.0, 0.0), 8.0), Polyline(((-30.0, 0.0), (-25.0, 5.0), (-20.0, 0.0)))),
        "HIDDEN": (Segment((-40.0, 10.0), (40.0, 10.0)),),
        "CENTRE": (Segment((-45.0, 0.0), (45.0, 0.0)), Segment((10.0, -10.0), (10.0, 10.0))),
    }
    return View(name, PROJECTIONS["top"], curves, scale, place, label="X (2:1)" if scale == 2.0 else "")


def sheet() -> Sheet:
    annotations: tuple[annotation.Annotation, ...] = (
        annotation.LinearDimension("top", (-40, -20), (40, -20), 0.0, (100, 160), "80.00", 80.0, ("length",)),
        annotation.LinearDimension("top", (40, -20), (40, 20), 90.0, (140, 180), "2x 40.0", 40.0, ("width",)),
        annotation.LinearDimension("top", (10, -8), (10, 8), 90.0, (90, 180), "⌀16", 16.0, ("hole",), (86, 200)),
        annotation.RadialDimension("top", "diameter", (10, 0), 8.0, 45.0, "⌀16.0", (130, 230), 16.0, ("hole",)),
        annotation.RadialDimension("detail", "radius", (10, 0), 8.0, 135.0, "R8.0", (230, 240), 8.0, ("round",)),
        annotation.AngularDimension("top", (-40, -20), (-20, -20), (-20, 0), (72, 172), "45°", 45.0, ("angle",)),
        annotation.Callout(
            "top", (10, 0), (150, 210), ("4x ⌀6.6 {depth} 12.0", "{counterbore} ⌀11.0"), ("screw hole",)
        ),
        annotation.FeatureControlFrame("top", (0, 20), (110, 215), "parallelism", "0.01", ("A",)),
        annotation.DatumSymbol("top", (-40, 0), (60, 180), "A"),
        annotation.Balloon("detail", (0, 0), (330, 250), 12),
        annotation.SectionMark("top", (70, 180), (135, 180), (0, 1), "B"),
        annotation.DetailMark("top", (30, 10), 6.0, (125, 195), "X"),
    )
    views = (plate(0.5, (100, 180)), plate(2.0, (300, 200), "detail"))
    notes = (annotation.Note((30, 40), ("NOTES", "lapped to {surface} Ra 1")),)
    return Sheet("plate", "plate", "A3", 0.5, TITLE, views, annotations, notes)
