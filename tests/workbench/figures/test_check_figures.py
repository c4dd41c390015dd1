"""Figures of the checks: what they write stands inside the picture, and clear of the other panels."""

import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from stagecad.parameters.design import Design
from stagecad.parameters.mass_properties import BodyMasses, MassProperties
from workbench.figures.checks import FIGURES

STAGE = MassProperties(9e-4, 2.4, (0, 0, -0.008), [[0.02, 0, 0], [0, 0.01, 0], [0, 0, 0.03]], [[-0.1] * 3, [0.1] * 3])
TIP = MassProperties(1e-6, 0.01, (0, 0, 0.01), [[1e-6, 0, 0], [0, 1e-6, 0], [0, 0, 1e-6]], [[-0.01] * 3, [0.01] * 3])


@pytest.mark.parametrize("title", ["error budgets", "dynamic error budgets"])
def test_margins_hold_labels_and_titles(title: str, design: Design) -> None:
    drawn = FIGURES[title][1](design, BodyMasses(STAGE, TIP))
    assert drawn is not None
    renderer = FigureCanvasAgg(drawn).get_renderer()
    drawn.draw_without_rendering()
    width, height = drawn.get_size_inches() * drawn.dpi
    boxes = [box for axes in drawn.axes if (box := axes.get_tightbbox(renderer))]
    assert len(boxes) >= 4
    for number, box in enumerate(boxes):
        assert box.x0 >= 0 and box.y0 >= 0 and box.x1 <= width and box.y1 <= height
        assert not any(box.overlaps(other) for other in boxes[number + 1 :])
