"""Drawing sheets: views, annotations, notes and tables in place, from which the files are written."""

from dataclasses import dataclass

from drawings.annotations.annotation import Annotation, Note
from drawings.annotations.primitives import TEXT_HEIGHT, Primitive
from drawings.annotations.symbols import symbol_text_width
from drawings.placement.views import SheetArea
from drawings.sheets.frame import CENTRING, MARGIN, PAPERS, Paper, TitleBlock, drawing_space, title_box
from drawings.views.view import Box2, View


@dataclass(frozen=True)
class Sheet:
    """One drawing sheet."""

    name: str  # of its files, `base_1`
    part: str  # the part, or `assembly`
    paper: Paper  # size of the paper
    scale: float  # of the main views, paper over part
    title: TitleBlock  # fields of the title block
    views: tuple[View, ...]  # placed
    annotations: tuple[Annotation, ...]  # placed
    notes: tuple[Note, ...] = ()  # placed
    tables: tuple[Primitive, ...] = ()  # primitives outside the views: parts list, table of steps, hole table
    tabulated: tuple[str, ...] = ()  # declarations that a hole table shows
    unapplied: tuple[str, ...] = ()  # manual changes that do not apply any more, a line each

    def view(self, name: str) -> View:
        """The view of that name."""
        return next(view for view in self.views if view.name == name)


def sheet_area(paper: Paper, taken: tuple[Box2, ...] = ()) -> SheetArea:
    """The area of a sheet for views, without the title block, the centring marks and other boxes, mm."""
    x0, y0, x1, y1 = drawing_space(paper)
    width, height = PAPERS[paper]
    u, v = width / 2, height / 2
    marks = ((x0, v, x0 + CENTRING, v), (x1 - CENTRING, v, x1, v), (u, y0, u, y0 + CENTRING), (u, y1 - CENTRING, u, y1))
    clear = MARGIN / 2
    return SheetArea((x0 + clear, y0 + clear, x1 - clear, y1 - clear), (title_box(paper), *marks, *taken))


def scale_text(scale: float) -> str:
    """A scale as printed: `1:5`, `2:1`, or the factor if neither side is 1."""
    for over, under in ((scale, 1.0), (1.0, 1.0 / scale)):
        if abs(over - round(over)) < 1e-9 and abs(under - round(under)) < 1e-9:
            return f"{round(over)}:{round(under)}"
    return f"{scale:.3f}"


def wrapped(text: str, width: float, height: float = TEXT_HEIGHT, indent: str = "") -> list[str]:
    """A text, its capitals of a height, broken at spaces into lines no wider than `width`, mm, all but the first with
    an indent; a wider word is a line by itself."""
    lines: list[str] = []
    for word in text.split(" "):
        if lines and symbol_text_width(f"{lines[-1]} {word}", height) <= width:
            lines[-1] += f" {word}"
        else:
            lines.append(f"{indent}{word}" if lines else word)
    return lines
