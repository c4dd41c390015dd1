"""Figures for print: a column or a page wide, 8 pt letters, colours that all readers distinguish."""

from __future__ import annotations

import io
from typing import Any

from matplotlib import rc_context
from matplotlib.figure import Figure

WIDTH = 7.0
"""Inches of a figure over two columns (178 mm)."""
COLUMN = 3.4
"""Inches of a figure over one column (86 mm)."""

STYLE: Any = {
    "font.family": "sans-serif",
    "font.sans-serif": ["Arial", "Helvetica", "Liberation Sans", "DejaVu Sans"],
    "font.size": 8.0,
    "axes.titlesize": 8.0,
    "axes.titlelocation": "left",
    "axes.labelsize": 8.0,
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#e3e7eb",
    "grid.linewidth": 0.5,
    "xtick.labelsize": 7.5,
    "ytick.labelsize": 7.5,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "xtick.minor.size": 1.5,
    "ytick.minor.size": 1.5,
    "legend.fontsize": 7.5,
    "legend.frameon": False,
    "legend.handlelength": 1.6,
    "lines.linewidth": 0.9,
    "axes.formatter.useoffset": False,
    "figure.constrained_layout.use": True,
    "savefig.dpi": 300,
    "savefig.bbox": None,
    "pdf.fonttype": 42,
    "ps.fonttype": 42,
    "svg.fonttype": "none",
}


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

    def _repr_png_(self) -> bytes:
        out = io.BytesIO()
        self.savefig(out, format="png", dpi=120, metadata={"Software": None})
        return out.getvalue()


def new_plot(
    rows: int = 1, columns: int = 1, width: float = WIDTH, height: float = 2.4, **options: Any
) -> tuple[Plot, Any]:
    """A figure in inches, and its axes as an array (rows, columns)."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    with rc_context(STYLE):
        figure = Plot(figsize=(width, height))
        FigureCanvasAgg(figure)
        return figure, figure.subplots(rows, columns, squeeze=False, **options)


def style() -> Any:
    """Context in which artists take the style."""
    return rc_context(STYLE)
