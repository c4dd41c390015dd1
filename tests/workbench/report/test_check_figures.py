"""Figures of the checks: what they write stands inside the picture, and clear of the other panels."""

from __future__ import annotations

from pathlib import Path

import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from stagecad.parameters.design import Design
from stagecad.parameters.mass_properties import BodyMasses, MassProperties
from workbench.report import check_figures

STAGE = MassProperties(9e-4, 2.4, (0, 0, -0.008), [[0.02, 0, 0], [0, 0.01, 0], [0, 0, 0.03]], [[-0.1] * 3, [0.1] * 3])
TIP = MassProperties(1e-6, 0.01, (0, 0, 0.01), [[1e-6, 0, 0], [0, 1e-6, 0], [0, 0, 1e-6]], [[-0.01] * 3, [0.01] * 3])


@pytest.mark.parametrize("title", ["error budgets", "dynamic error budgets"])
def test_margins_hold_labels_and_titles(
    title: str, design: Design, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn: list[Figure] = []
    monkeypatch.setattr(check_figures, "_save", lambda figure, path: drawn.append(figure))
    check_figures.FIGURES[title][1](design, BodyMasses(STAGE, TIP), tmp_path / "figure.png")
    renderer = FigureCanvasAgg(drawn[0]).get_renderer()
    width, height = drawn[0].get_size_inches() * drawn[0].dpi
    boxes = [box for axes in drawn[0].axes if (box := axes.get_tightbbox(renderer))]
    assert len(boxes) >= 4
    for number, box in enumerate(boxes):
        assert box.x0 >= 0 and box.y0 >= 0 and box.x1 <= width and box.y1 <= height
        assert not any(box.overlaps(other) for other in boxes[number + 1 :])
