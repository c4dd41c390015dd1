"""The style of all figures, for print: 8 pt letters, colours that all readers distinguish; and how they are saved."""

import functools
import io
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

from matplotlib import rc_context, rc_params_from_file
from matplotlib.figure import Figure

from stagecad.parameters.atomic import atomic_path

WIDTH = 7.0
"""Inches of a figure over two columns (178 mm)."""
COLUMN = 3.4
"""Inches of a figure over one column (86 mm)."""

MEASURED, MODEL, BEFORE, AFTER, FAINT, GREY = "#8a939c", "#0072b2", "#d55e00", "#009e73", "#c9d6df", "#5d6d7e"
"""Colours that readers with deficient colour vision distinguish (Okabe and Ito, 2008)."""
FORWARD, BACKWARD = "#7b4ea3", "#96682f"
"""Directions of motion: the colours of the page's residual maps."""
INK = ("#1b4f72", "#b03a2e", "#1e8449", "#7d6608")
"""Colours of curves that are equal in rank."""

STYLE: Any = rc_params_from_file(Path(__file__).with_name("print.mplstyle"), use_default_template=False)


class Plot(Figure):
    """A figure that keeps its style wherever it is drawn, and that a notebook shows by itself.

    `savefig("name.pdf")` writes it for print; the axes are matplotlib's, and may be changed.
    """

    def draw(self, renderer: Any) -> None:
        with rc_context(STYLE):
            super().draw(renderer)

    def savefig(self, fname: Any, **options: Any) -> None:
        with rc_context(STYLE):
            super().savefig(fname, **options)

    def svg(self, name: str) -> str:
        """As the text of an SVG without background; `name` makes the identifiers of its parts."""
        from matplotlib.backends.backend_svg import FigureCanvasSVG

        out = io.StringIO()
        self.patch.set_visible(False)
        with rc_context({**STYLE, "svg.hashsalt": name}):
            # `savefig` would draw everything once more to learn its size.
            FigureCanvasSVG(self).print_svg(out, metadata={"Date": None, "Creator": None})
        self.patch.set_visible(True)
        text = out.getvalue()
        # Verdana has the widths of DejaVu Sans, for readers without it.
        return text[text.index("<svg") :].replace("'DejaVu Sans'", "'DejaVu Sans', Verdana")

    def _repr_png_(self) -> bytes:
        out = io.BytesIO()
        self.savefig(out, format="png", dpi=120, metadata={"Software": None})
        return out.getvalue()


Drawn = TypeVar("Drawn")


def styled(draw: Callable[..., Drawn]) -> Callable[..., Drawn]:
    """Decorator: draw in the style of this module, and leave matplotlib's own settings alone."""

    @functools.wraps(draw)
    def drawn(*arguments: Any, **options: Any) -> Drawn:
        with rc_context(STYLE):
            return draw(*arguments, **options)

    return drawn


def new_plot(
    rows: int = 1, columns: int = 1, width: float = WIDTH, height: float = 2.4, **options: Any
) -> tuple[Plot, Any]:
    """A figure in inches, and its axes as an array (rows, columns)."""
    # Not of pyplot: no window system, and nothing global that outlives the figure.
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    with rc_context(STYLE):
        figure = Plot(figsize=(width, height))
        FigureCanvasAgg(figure)
        return figure, figure.subplots(rows, columns, squeeze=False, **options)


def save_figures(folder: Path, figures: Mapping[str, Figure]) -> list[Path]:
    """Write figures as `NAME.png` into a folder; returns the files."""
    files = {folder / f"{name}.png": figure for name, figure in figures.items()}
    for file, figure in files.items():
        save(figure, file)
    return list(files)


def save(figure: Figure, path: Path) -> None:
    """Write a figure as PNG."""
    with atomic_path(path) as temporary:
        figure.savefig(temporary, dpi=150, format="png", metadata={"Software": None})
