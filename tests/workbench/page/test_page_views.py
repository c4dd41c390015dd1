"""The page as a user finds it: what it opens on, records before a fit, several models over one record, addresses."""

import csv
import re
import time
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from served_page import NEEDS_CHROMIUM, Browser, chromium, faults_of_access, looking, serving, until

pytestmark = [NEEDS_CHROMIUM, pytest.mark.slow]


@pytest.fixture(scope="module")
def launched() -> Iterator[Any]:
    with chromium() as one:
        yield one


def _logged(path: Path, seed: int) -> None:
    """A log with a setpoint beside the position, of an axis with a Stribeck peak that a current drives."""
    t = np.arange(1500) * 2e-3
    velocity = 0.02 * np.sin(5.0 * t + seed) + 0.006 * np.sin(17.0 * t)
    force = np.sign(velocity) * (1.0 + 0.8 * np.exp(-((velocity / 0.004) ** 2))) + 6.0 * velocity
    force += 0.01 * np.random.default_rng(seed).standard_normal(t.size)
    position = np.cumsum(velocity) * 2e-3
    columns = np.column_stack([1e3 * t, 1e3 * position + 0.01, 1e3 * position, velocity, force])
    rows = "".join(";".join(f"{value:.6f}" for value in row) + "\n" for row in columns).replace(".", ",")
    path.write_text(f"Zeit [ms];Sollweg [mm];Istweg [mm];Geschwindigkeit [m/s];Reibkraft [N]\n{rows}", "utf-8")


def test_an_empty_folder_has_three_doors_and_the_demo(launched: Any, tmp_path: Path) -> None:
    with serving(tmp_path) as address, looking(launched, address) as browser:
        page = browser.page
        page.goto(address)
        until(page, lambda: page.locator(".door h2").count() == 3)
        assert faults_of_access(page) == []
        page.get_by_role("button", name="Try the demo").click()
        page.locator(".experiment[data-name=demo]").wait_for()
        until(page, lambda: page.url.endswith("#measurement/demo"))
        # Now the folder holds an experiment, and the page opens on it.
        page.goto(address)
        page.locator(".experiment[data-name=demo][aria-pressed=true]").wait_for()


@pytest.fixture(scope="module")
def rig(launched: Any, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    """A user whose folder holds two records."""
    folder = tmp_path_factory.mktemp("rig")
    for name, seed in (("fit", 1), ("validate", 2)):
        _logged(folder / f"{name}.csv", seed)
    with serving(folder) as address, looking(launched, address) as browser:
        browser.folder = folder  # type: ignore[attr-defined]
        browser.page.goto(address)
        browser.address = address.partition("?")[0]
        yield browser


def test_records_of_the_folder_are_seen_and_cut_before_the_fit(rig: Browser) -> None:
    page = rig.page
    page.get_by_role("button", name="Make an experiment of 2 records").click()
    dialog = page.get_by_role("dialog")
    dialog.get_by_label("name of the experiment").fill("slide")
    dialog.get_by_role("button", name="Upload").click()
    dialog.locator(".columns tbody").wait_for()
    # The setpoint is not the position; what is uncertain is asked, counted, and answered here.
    until(page, lambda: dialog.get_by_label("channel of Istweg").input_value() == "position")
    assert dialog.get_by_label("channel of Sollweg").input_value() == ""
    create = dialog.locator(".actions .main")
    opened = int(re.search(r"(\d+) open", create.inner_text())[1])  # type: ignore[index]
    assert opened == dialog.locator(".question:visible").count() > 0
    assert faults_of_access(page) == []
    create.click()
    dialog.get_by_role("alert").filter(has_text=re.compile(r"\w")).wait_for()
    dialog.get_by_role("button", name="Take all as proposed").click()
    until(page, lambda: create.inner_text() == "Create")
    strip = dialog.locator(".strip").first
    strip.scroll_into_view_if_needed()
    box = strip.bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + 0.2 * box["width"], box["y"] + 5)
    page.mouse.down()
    page.mouse.move(box["x"] + 0.8 * box["width"], box["y"] + 5, steps=4)
    page.mouse.up()
    create.click()
    page.locator(".map canvas").first.wait_for()
    document = tomllib.loads((rig.folder / "slide" / "experiment.toml").read_text("utf-8"))  # type: ignore[attr-defined]
    first, second = document["record"]
    low, high = (float(first[end].removeprefix("+").removesuffix(" ms")) for end in ("from", "to"))
    assert low == pytest.approx(0.2 * 2998.0, rel=0.02) and high == pytest.approx(0.8 * 2998.0, rel=0.02)
    assert "from" not in second and "Sollweg" not in str(document["channels"])


def test_models_over_one_record_their_maps_and_the_address(rig: Browser) -> None:
    page = rig.page
    page.get_by_role("button", name="Diagnose", exact=True).click()
    page.locator(".verdict b", has_text="stribeck is missing").wait_for()
    chosen = page.get_by_label("model whose residual is shown")
    until(page, lambda: chosen.input_value() == "stribeck")
    assert faults_of_access(page) == []
    of_candidate = page.locator(".map figcaption").all_inner_texts()
    page.locator(".candidate:not(.named) input.tick").first.check()
    legend = page.locator(".overlay .legend button")
    until(page, lambda: legend.count() == 4)
    assert all("×" in text for text in legend.all_inner_texts()[2:])
    chosen.select_option("")
    until(page, lambda: page.locator(".map figcaption").all_inner_texts() != of_candidate)
    # The address has all of it: another window shows the same.
    page.get_by_label("abscissa").select_option("velocity")
    until(page, lambda: "over=velocity" in page.url)
    other = page.context.new_page()
    other.goto(page.url)
    other.locator(".overlay canvas.xy").first.wait_for()
    until(other, lambda: other.locator(".overlay .legend button").count() == 3)
    other.close()
    # The model of the rung before is drawn beside that of the present one, with the error that the ladder states.
    page.get_by_label("abscissa").select_option("")
    page.locator(".candidate.named").get_by_role("button", name="Add").click()
    page.locator(".rung input.tick[data-model='rung 0']").check()
    until(page, lambda: any("rung 0" in text for text in legend.all_inner_texts()))
    stated = page.locator(".rung .num").first.inner_text()
    assert any(text.endswith(stated) for text in legend.all_inner_texts())


def test_a_plot_is_saved_measured_and_its_border_moved(rig: Browser, tmp_path: Path) -> None:
    page = rig.page
    plot = page.locator(".overlay .plot").first
    for kind in ("PNG", "CSV"):
        with page.expect_download() as saved:
            plot.get_by_role("button", name="Picture" if kind == "PNG" else "numbers").dispatch_event("click")
        saved.value.save_as(tmp_path / saved.value.suggested_filename)
    assert (tmp_path / "friction_force.png").stat().st_size > 2000
    header, *rows = csv.reader((tmp_path / "friction_force.csv").read_text("utf-8").splitlines())
    assert header[:3] == ["time (s)", "measured (N)", "model (N)"]
    numbers = np.array([[float(cell or "nan") for cell in row[:3]] for row in rows])
    assert np.all(np.diff(numbers[:, 0]) >= 0.0) and np.nanmax(np.abs(numbers[:, 1:])) < 3.0
    panel = page.locator("#measurement > .panel").first
    before, border = panel.bounding_box(), panel.get_by_role("separator")
    border.focus()
    for _ in range(3):
        border.press("ArrowRight")
    after = panel.bounding_box()
    assert before is not None and after is not None and after["width"] == pytest.approx(before["width"] + 48.0, abs=2.0)
    page.reload()
    until(page, lambda: (panel.bounding_box() or {"width": 0.0})["width"] == pytest.approx(after["width"], abs=1.0))
    panel.get_by_role("separator").dblclick()
    until(page, lambda: (panel.bounding_box() or {"width": 0.0})["width"] == pytest.approx(before["width"], abs=1.0))
    rim, corner, edge, nothing = rig.page.evaluate(SNAPPED)
    centre = rim["round"]["centre"]
    assert [centre[axis] for axis in "xyz"] == pytest.approx([5.0, 2.0, 7.0], abs=1e-3)
    assert rim["round"]["radius"] == pytest.approx(3.0, abs=1e-3)
    assert corner["corner"] == [20, 10, 7] and corner["round"] is None
    assert edge["corner"] is None and edge["point"] == pytest.approx([3.0, -10.0, 7.0])
    assert nothing is None


SNAPPED = """async () => {
  const { BufferGeometry, Vector3 } = await import('/vendor/three.min.js');
  const { Edges } = await import('/snap.js');
  const angles = Array.from({ length: 24 }, (_, k) => k * Math.PI / 12);
  const ring = angles.map((a) => new Vector3(5 + 3 * Math.cos(a), 2 + 3 * Math.sin(a), 7));
  const plate = [[-10, -10], [20, -10], [20, 10], [-10, 10]].map(([x, y]) => new Vector3(x, y, 7));
  const closed = (points) => points.flatMap((point, k) => [point, points[(k + 1) % points.length]]);
  const edges = new Edges(new BufferGeometry().setFromPoints([...closed(ring), ...closed(plate)]));
  const at = (x, y) => {
    const found = edges.nearest(new Vector3(x, y, 7), 0.5);
    if (!found) return null;
    const { corner, point, segment } = found;
    return { corner: corner?.toArray() ?? null, point: point.toArray(), round: edges.circle(segment) };
  };
  return [at(8.05, 2.3), at(19.8, 9.9), at(3, -9.9), at(0, 0)];
}"""


def test_a_search_shows_its_best_design_and_ends_by_its_time(rig: Browser) -> None:
    """All checks of the packaged design, whose rules are violated: no solids are made."""
    page = rig.page
    page.goto(f"{rig.address}#machine/optimize")
    page.route("**/api/machine/solids", lambda route: route.fulfill(status=422, json={"error": "not here"}))
    page.wait_for_selector(".check >> nth=100")
    page.get_by_label("stage.thickness, slider").fill("6.1")
    page.locator(".violations:visible").wait_for()
    page.get_by_label("minutes of the search").fill("0.25")
    start = page.locator(".optimize .actions").get_by_role("button", name="Optimize")
    began = time.monotonic()
    start.click()
    page.locator(".best p", has_text="requirements met").wait_for()
    page.locator(".optimum .verdict", has_text="out of time").wait_for()
    assert faults_of_access(page) == []
    # The first search loads what the process needs.
    (job,) = (one for one in page.request.get(f"{rig.address}api/jobs").json() if one["task"] == "optimize")
    assert job["ended"] - job["began"] < 15.0 + 3.0 and time.monotonic() - began < 60.0
    page.get_by_label("minutes of the search").fill("30")
    start.click()
    page.locator(".best p", has_text="requirements met").wait_for()
    page.locator(".optimize .search").get_by_role("button", name="Stop").click()
    page.locator(".optimum .verdict", has_text="stopped").wait_for()
    rig.expect_errors("422")
