"""The report of the loop: figures that lose no spike, sections that belong together, a page that stands by itself."""

import itertools
import json
import re
from html.parser import HTMLParser
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.text import Text

from designcalc.checks.run import run_checks
from stagecad.parameters.design import Design
from stagecad.parameters.load import load_design
from stagecad.parameters.mass_properties import BodyMasses, MassProperties
from sysid.diagnosis.residual_maps import ResidualMap
from sysid.experiment.experiment import Experiment as StatedExperiment
from sysid.prediction.problem import Problem
from workbench.figures import plot
from workbench.figures.checks import FIGURES
from workbench.figures.curves import axis_scale, decimate, worst_stretch
from workbench.figures.identification import maps_figure
from workbench.operations.measurement.add import Ladder
from workbench.operations.measurement.experiment import Experiment
from workbench.operations.measurement.statements import summary_sentence
from workbench.report.identification import ordered_sections, report_html, section_key, summary_of
from workbench.report.machine import write_check_files

NOW = {"text": "", "effects": ["coulomb"]}
STAGE = MassProperties(9e-4, 2.4, (0, 0, -0.008), [[0.02, 0, 0], [0, 0.01, 0], [0, 0, 0.03]], [[-0.1] * 3, [0.1] * 3])
TIP = MassProperties(1e-6, 0.01, (0, 0, 0.01), [[1e-6, 0, 0], [0, 1e-6, 0], [0, 0, 1e-6]], [[-0.01] * 3, [0.01] * 3])


def test_decimation_keeps_spikes_and_gaps_and_the_worst_stretch_is_no_wild_sample() -> None:
    time = np.arange(100_000) * 1e-3
    values = np.sin(time)
    values[54_321] = 9.0
    t, v = decimate(time, values, 500)
    assert v.size == 1000 and v.max() == 9.0
    assert t[int(np.argmax(v))] == time[54_321] and np.all(np.diff(t) >= 0.0)
    values = np.ones(10_000)
    values[2000:6000] = np.nan
    t, v = decimate(np.arange(10_000.0), values, 100)
    assert np.isnan(v[(t > 2100) & (t < 5900)]).all() and np.isfinite(v[(t < 1900) | (t > 6100)]).all()
    residual = np.random.default_rng(0).normal(0, 1, 20_000)
    residual[3000] = 1e4
    residual[12_000:12_600] += 4.0
    found = worst_stretch(residual)
    assert found.start <= 12_300 <= found.stop and not found.start <= 3000 < found.stop


@pytest.mark.parametrize("largest,unit,factor,shown", [
    (0.004, "N", 1e3, "mN"), (2e-7, "m", 1e9, "nm"), (0.03, "m/s", 1e3, "mm/s"), (0.02, "N*m", 1e3, "mN·m"),
    (24.0, "degC", 1.0, "°C"), (0.01, "1", 1.0, ""), (0.0, "N", 1.0, "N"),
])  # fmt: skip
def test_axes_carry_a_readable_unit(largest: float, unit: str, factor: float, shown: str) -> None:
    found, label = axis_scale(np.array([np.nan, -largest]), unit)
    assert found == pytest.approx(factor)
    assert label == shown


def rung(number: int, effects: list[str], added: list[str], over: float) -> dict:
    entry = {"rms": {"value": 0.01 * over, "unit": "N"}, "over_noise": over, "fit_percent": 50.0}
    before = {"fit": {"friction_force": entry}, "validate": {"friction_force": entry}}
    model = {"effects": effects, "added": added, "parameters": {}, "noise": {}}
    return {"rung": number, **model, "before": before}


def ladder(name: str, rungs: list[dict]) -> Ladder:
    """The ladder of an experiment of which nothing but the name is read."""
    return Ladder(
        Experiment(cast(StatedExperiment, SimpleNamespace(folder=name, revisions=(), text="", effects=()))),
        rungs,
        False,
    )


class Links(HTMLParser):
    """Whatever the page would fetch or run."""

    def __init__(self) -> None:
        super().__init__()
        self.found: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag in ("script", "link", "iframe", "img"):
            self.found.append(tag)
        for key, value in attrs:
            if key in ("src", "href", "xlink:href") and value and not value.startswith("#"):
                self.found.append(value)


def test_the_ladder_is_a_page_that_fetches_nothing_and_is_the_same_twice(tmp_path: Path) -> None:
    rungs = [rung(0, ["coulomb"], [], 74.0), rung(1, ["coulomb", "stribeck"], ["stribeck"], 1.1)]
    report = ladder("a rig <b>", rungs).write_report(tmp_path)
    page, parser = report.read_text(encoding="utf-8"), Links()
    parser.feed(page)
    assert parser.found == []
    assert "a_rig__b_" in page and "74 ×" in page and "1.10 ×" in page
    figures = sorted(p.name for p in report.parent.iterdir())
    assert figures == ["ladder.png", "ladder.svg", "report.html", "sections"]
    before = {p.name: p.read_bytes() for p in report.parent.glob("*.*")}
    ladder("a rig <b>", rungs).write_report(tmp_path)
    assert before == {p.name: p.read_bytes() for p in report.parent.glob("*.*")}


def section(kind: str, effects: list[str], sha: str, number: int) -> dict:
    return {"kind": kind, "effects": effects, "records": {"fit": sha}, "number_in_report": number}


def test_sections_of_other_records_are_left_out_and_unreadable_ones_written_again(tmp_path: Path) -> None:
    old = section("compare", ["coulomb"], "old", 1)
    first, second = section("diagnose", ["coulomb"], "new", 2), section("diagnose", ["coulomb", "viscous"], "new", 3)
    rungs = {"kind": "ladder", "effects": ["coulomb", "viscous"], "number_in_report": 4}
    assert ordered_sections([old, second, rungs, first]) == [rungs, first, second]
    assert section_key(first) != section_key(second)
    sections = tmp_path / "rig" / "sections"
    sections.mkdir(parents=True)
    (sections / "ladder.json").write_text("{broken", encoding="utf-8")
    ladder("rig", [rung(0, [], [], 3.0), rung(1, ["viscous"], ["viscous"], 1.0)]).write_report(tmp_path)
    assert json.loads((sections / "ladder.json").read_text(encoding="utf-8"))["kind"] == "ladder"


def test_names_are_text_and_warnings_stand_above_the_headline() -> None:
    page = report_html("<script>alert(1)</script>", [], NOW)
    assert "<script>" not in page
    section = rung(0, ["coulomb"], [], 2.0) | {"kind": "suggest", "title": "Title", "state": "good", "number": "1"}
    section |= {"headline": "The headline.", "number_in_report": 1, "motions": {"rows": [], "title": "", "note": ""}}
    page = report_html("rig", [section | {"warnings": ["one <column> is wrong"]}], NOW)
    assert page.index("Warning: one &lt;column&gt; is wrong") < page.index("The headline.")
    assert "Warning:" not in report_html("rig", [section], NOW)


def test_grounds_of_the_pages_are_those_of_the_scheme() -> None:
    """Text that is light in the dark scheme stands on no ground that stays white."""
    for file in (Path(__file__).parents[3] / "workbench" / "templates").glob("*.html"):
        rules = [line for line in file.read_text("utf-8").splitlines() if not line.startswith("@media print")]
        assert not re.search(r"background(-color)?: *(#|white)", "\n".join(rules)), file.name


def test_titles_of_neighbouring_maps_do_not_overlap() -> None:
    names = ("distance_since_reversal", "time", "normal_load", "distance_travelled", "acceleration", "temperature")
    centres = np.linspace(0.1, 1.0, 12)
    maps = [ResidualMap(name, 0.28, 0.0005, centres, centres, -centres) for name in names]
    problem = SimpleNamespace(kind="velocity-drive", experiment=SimpleNamespace(rig=SimpleNamespace(rotary=False)))
    figure = maps_figure(maps, cast(Problem, problem))
    figure.canvas.draw()
    titles = [text for panel in figure.axes for text in panel.findobj(Text) if text.get_text().endswith("p < 0.001")]
    boxes = [text.get_window_extent() for text in titles]
    assert len(boxes) == 6 and not any(a.overlaps(b) for a, b in itertools.combinations(boxes, 2))
    # Directions have colours of their own, those of the page, which mean neither a model nor what was before.
    legend: Any = figure.axes[0].get_legend_handles_labels()
    colours = {label: handle.lines[0].get_color() for handle, label in zip(*legend)}
    style = (Path(plot.__file__).parents[1] / "page" / "static" / "style.css").read_text("utf-8")
    assert all(f"--map-{name}: {colour}" in style for name, colour in colours.items()) and len(colours) == 2
    assert not {*colours.values()} & {plot.MODEL, plot.BEFORE, plot.AFTER}


@pytest.mark.parametrize(("fit_percent", "said"), [
    (90.0, "explains 99 % of the variance of the friction force"),
    (-300.0, "does not yet explain the friction force"),
])  # fmt: skip
def test_the_report_begins_with_the_state_of_the_present_model_in_a_sentence(fit_percent: float, said: str) -> None:
    """A fit of 90 % leaves a tenth of the deviation, a hundredth of the variance."""
    errors = {"validate": {"friction_force": {"over_noise": 1.2, "fit_percent": fit_percent}}}
    present = section("diagnose", ["coulomb", "stribeck"], "sha", 1) | {"summary": summary_sentence(errors, "Add it.")}
    older = section("compare", ["coulomb"], "sha", 2) | {"summary": "Of another model."}
    ladder = {"kind": "ladder", "effects": ["coulomb", "stribeck"], "number_in_report": 3, "summary": "Of the ladder."}
    sentence = summary_of([ladder, present, older], ["coulomb", "stribeck:rational"])
    assert said in sentence and "1.20 × the noise. Add it." in sentence
    # After an undo.
    assert summary_of([present, older], ["coulomb"]) == "Of another model."
    assert summary_of([present], ["coulomb"]) == ""


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


@pytest.mark.parametrize("override", ["drawing.drawn=somebody", "teeth.fitted=false", "preload.force=200 N"])
def test_the_checks_as_markdown_name_every_check_and_study(tmp_path: Path, override: str) -> None:
    design = load_design(overrides=[override], rules=False)
    checks = run_checks(design)
    write_check_files(checks, design, None, tmp_path)
    text = (tmp_path / "checks.md").read_text("utf-8")
    for check in checks:
        assert f"\n| {check.name} |" in text and f"\n### {check.name}: {check.verdict}\n" in text
    for heading in ("Suspensions by rank", "Error budget: smoothness, normal", "Differences from the thesis"):
        assert f"\n\n## {heading}" in text
    rows = [line.count(" | ") for line in text.split("## Requirements")[0].splitlines() if line.startswith("| ")]
    assert len(rows) == len(checks) + 2 and set(rows) == {5}
