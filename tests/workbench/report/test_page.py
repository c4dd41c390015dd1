"""Reports: figures that lose no spike, sections that belong together, a page that stands by itself; `stagecad make`
makes again what a change affects, and nothing else."""

import hashlib
import itertools
import json
import re
import shutil
import subprocess
import sys
from collections import Counter
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
from stagecad.parameters.errors import LostProcessError, PartError
from stagecad.parameters.load import load_design
from stagecad.parameters.mass_properties import BodyMasses, MassProperties
from stagecad.private import cache_root
from stagecad.solids.artefacts.key import ROOT, _file
from sysid.diagnosis.residual_maps import ResidualMap
from sysid.experiment.experiment import Experiment as StatedExperiment
from sysid.prediction.problem import Problem
from workbench.figures import plot
from workbench.figures.checks import FIGURES
from workbench.figures.curves import axis_scale, decimate, worst_stretch
from workbench.figures.identification import maps_figure
from workbench.operations.design import Design as StatedDesign
from workbench.operations.measurement.add import Ladder
from workbench.operations.measurement.experiment import Experiment
from workbench.operations.measurement.statements import summary_sentence
from workbench.report import make as make_module
from workbench.report.identification import ordered_sections, report_html, section_key, summary_of
from workbench.report.machine import write_check_files
from workbench.report.make import Kind, Making, Task

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


CHANGES = {
    "stage.thickness=12.5 mm": {"stage", "assembly", "drawing of stage", "picture of stage"},
    "actuator.tip_height=20.5 mm": {"tip", "base", "drawing of tip", "drawing of base", "simulation tip"},
    "actuator.piezo_spacing=47 mm": {"tip", "holder", "drawing of tip", "drawing of holder", "simulation tip"},
    "bearing.dynamic_friction=0.055": {"checks", "figure travel"},
}
"""A change, and some of the results that it affects; of parts, drawings and simulations all."""


def making(folder: Path, *overrides: str) -> Making:
    design = load_design(overrides=overrides)
    return Making(folder, design, design, StatedDesign(None, overrides), simulations=True)


def test_tasks_and_what_an_empty_store_lacks(tmp_path: Path) -> None:
    tasks = making(tmp_path).tasks
    for needed in tasks.values():
        assert set(needed) <= set(tasks)
    known = {task for task, needed in tasks.items() if not needed}
    while len(known) < len(tasks):
        following = {task for task, needed in tasks.items() if set(needed) <= known}
        assert following > known, "tasks that need each other"
        known = following
    whole = making(tmp_path)
    assert whole.absent == list(whole.tasks)
    whole = making(tmp_path)
    whole.__dict__["parts"] = {}
    assert not whole.has(Task(Kind.SHAPES))


def test_stored_checks_depend_on_the_files_that_state_them() -> None:
    stating = (_file(name) for name in make_module.checked_by(load_design()))
    assert ROOT / "designcalc" / "friction_stage" / "checks.toml" in {p.with_suffix(".toml") for p in stating if p}


def test_only_what_a_change_affects_is_absent(tmp_path: Path) -> None:
    buffer = [Task(Kind.PART, "buffer"), Task(Kind.RENDERING, "buffer")]
    tip = Task(Kind.SIMULATION, "tip")
    done = [*buffer, Task(Kind.PART, "mirror"), Task(Kind.RENDERING, "mirror"), tip]
    first = making(tmp_path)
    for task in done:
        first.run(task)
    assert set(done).isdisjoint(first.absent)
    assert set(done).isdisjoint(making(tmp_path, "bearing.dynamic_friction=0.055").absent)
    wider = making(tmp_path, "buffer.height=3.5 mm").absent
    assert [task for task in done if task in wider] == buffer
    higher = making(tmp_path, "actuator.tip_height=20.5 mm").absent
    assert [task for task in done if task in higher] == [tip]


@pytest.mark.parametrize(
    "error", [PartError("buffer", None, "no solid"), LostProcessError("", Task(Kind.PART, "buffer"))]
)
def test_a_solid_that_cannot_be_made_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise error

    monkeypatch.setattr(make_module, "parallel_map", refuse)
    with pytest.raises(PartError, match="buffer"):
        making(tmp_path).make([Task(Kind.PART, "buffer")])


def entry_names(cache: Path) -> Counter[str]:
    records = (json.loads(path.read_text()) for path in (cache / "entries").glob("*/entry.json"))
    return Counter(record["name"] for record in records)


def files_of(folder: Path) -> dict[str, str]:
    paths = [path for path in sorted(folder.rglob("*")) if path.is_file()]
    return {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest() for path in paths}


@pytest.mark.slow
@pytest.mark.parametrize("change", CHANGES)
def test_result_after_a_change_is_that_of_an_empty_cache(tmp_path: Path, change: str) -> None:
    def make(cache: str, *overrides: str) -> dict[str, str]:
        words = [sys.executable, "-m", "workbench.cli", "make", "--out", str(tmp_path / "out"), *overrides]
        monkeypatch.setenv("STAGECAD_CACHE", str(tmp_path / cache))
        subprocess.run(words, check=True, capture_output=True)
        made = files_of(tmp_path / "out")
        shutil.rmtree(tmp_path / "out")
        return made

    for cache in ("one", "other"):
        shutil.copytree(cache_root() / "kernels", tmp_path / cache / "kernels")
    with pytest.MonkeyPatch.context() as monkeypatch:
        make("one")
        before, incremental = entry_names(tmp_path / "one"), make("one", "--set", change)
        again = entry_names(tmp_path / "one") - before
        whole = make("other", "--set", change)
    assert incremental == whole
    assert again[max(again, key=again.__getitem__)] >= 1
    affected = CHANGES[change]
    assert affected <= set(again)
    for prefix in ("drawing of ", "simulation "):
        parts = {name for name in again if name.startswith(prefix)} - {"drawing of assembly", "drawing of procedure"}
        assert parts == {name for name in affected if name.startswith(prefix)}
    assert all(number == 1 for name, number in again.items() if name != "reduced sheet")
