"""The page in a headless Chromium: what a user sees and does. One server and one browser serve all stories."""

import io
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from served_page import NEEDS_CHROMIUM, Browser, chromium, enter, faults_of_access, looking, serving, until

from sysid.add import add_effects
from sysid.experiment.experiment import load_experiment
from sysid.experiment.ladder import read_history
from tests.sysid.axis_with_pitch import write

pytestmark = NEEDS_CHROMIUM


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("project")


@pytest.fixture(scope="module")
def launched(folder: Path) -> Iterator[tuple[Any, str]]:
    """A browser, and the address of a server with a token."""
    with chromium() as one, serving(folder, "--token", "a-token-for-the-test") as address:
        yield one, address


@pytest.fixture
def browser(launched: tuple[Any, str]) -> Iterator[Browser]:
    """A user who has opened the page by the printed address."""
    with looking(*launched) as one:
        one.leave_out_solids()
        one.page.goto(one.address)
        one.page.wait_for_url(re.compile(r"/(#.*)?$"))
        # What an earlier story left is not the beginning of this one.
        opened = one.page.request.post(one.address.partition("?")[0] + "api/machine/open", data={"name": None})
        assert opened.json()["changes"] == {} and opened.json()["undo"] == 0
        one.address = one.address.partition("?")[0]
        one.open("machine")
        one.page.reload()
        yield one


def _margin(browser: Browser, name: str) -> str:
    row = browser.page.locator(".check", has=browser.page.get_by_text(name, exact=True))
    return row.locator(".margin").inner_text()


def _drag(browser: Browser, key: str, value: float) -> None:
    """Move a slider as a hand does: Playwright sends an event for the drag, and one for its end."""
    browser.page.get_by_label(f"{key}, slider").fill(str(value))


def _picture(browser: Browser) -> np.ndarray:
    """The three-dimensional view as pixels (h, w, 3), 0 to 255."""
    return _pixels(browser.page.locator(".canvas canvas"))


def _pixels(place: Any) -> np.ndarray:
    return np.asarray(Image.open(io.BytesIO(place.screenshot())).convert("RGB"), float)


def _drawn(picture: np.ndarray) -> float:
    """Share of the pixels in the middle that differ from the ground in the corner."""
    height, width, _ = picture.shape
    middle = picture[height // 5 : -height // 5, width // 6 : -width // 6]
    return float(np.mean(np.abs(middle - picture[height // 2, 3]).max(axis=2) > 12.0))


def _changed(one: np.ndarray, other: np.ndarray) -> float:
    return float(np.mean(np.abs(one - other).max(axis=2) > 12.0))


def test_a_slider_moves_the_margins_and_undo_brings_them_back(browser: Browser) -> None:
    page = browser.page
    page.wait_for_selector(".check >> nth=100")
    name = "thread for the payload from above"
    before = _margin(browser, name)
    assert re.fullmatch(r"[+−]?\d+ %", before)
    _drag(browser, "stage.thickness", 14.1)
    fresh = page.locator(".check:not(.stale)", has=page.get_by_text(name, exact=True))
    fresh.locator(".margin", has_not_text=before).wait_for()
    until(page, lambda: page.get_by_label("stage.thickness", exact=True).input_value() == "14.1 mm")
    until(page, lambda: page.get_by_role("button", name="Difference (1)").is_visible())
    _drag(browser, "stage.thickness", 6.1)
    page.get_by_text("cannot be built").wait_for()
    page.get_by_role("button", name="Undo").click()
    page.get_by_role("button", name="Undo").click()
    fresh.locator(".margin", has_text=before).wait_for()
    # The answer for an earlier position of the slider may arrive between its last movement and its release.
    field = page.get_by_label("stage.thickness", exact=True)
    slider = page.get_by_label("stage.thickness, slider").element_handle()
    release = """([slider, field]) => {
        slider.value = '13'; slider.dispatchEvent(new Event('input', { bubbles: true }));
        field.value = '12.5 mm'; slider.dispatchEvent(new Event('change', { bubbles: true })); }"""
    with page.expect_response("**/api/machine/commit") as committed:
        page.evaluate(release, [slider, field.element_handle()])
    assert committed.value.json()["changes"] == {"stage.thickness": "13 mm"}
    page.get_by_role("button", name="Undo").click()
    fresh.locator(".margin", has_text=before).wait_for()
    # A key that is held is one step; Escape leaves the value as it was.
    field.focus()
    for _ in range(3):
        page.keyboard.down("ArrowUp")
    with page.expect_response("**/api/machine/commit") as committed:
        page.keyboard.up("ArrowUp")
    assert set(committed.value.json()["changes"]) == {"stage.thickness"} and committed.value.json()["undo"] == 1
    field.press("Control+z")
    page.get_by_role("button", name="Difference", exact=True).wait_for()
    field.fill("99 mm")
    field.press("Escape")
    assert field.input_value() == "12 mm"
    # A value of the wrong dimension is refused in words, and the old one stays.
    enter(field, "3 kg")
    page.locator("#message.bad", has_text="stage.thickness").wait_for()
    assert field.input_value() == "12 mm"
    # What is not allowed leaves nothing behind.
    until(page, lambda: page.get_by_role("button", name="Difference", exact=True).is_visible())
    browser.expect_errors("422")


@pytest.mark.slow
def test_solids_that_arrive_while_they_are_hidden_are_seen(browser: Browser) -> None:
    page = browser.page
    browser.with_solids()
    page.reload()
    page.get_by_role("button", name="Drawings").click()
    page.locator("canvas[data-state=current]").wait_for(state="attached")
    page.get_by_role("button", name="Solids").click()
    page.wait_for_timeout(500)
    assert _drawn(_picture(browser)) > 0.2


@pytest.mark.slow
def test_the_machine_is_drawn_turned_and_built_again(browser: Browser) -> None:
    page = browser.page
    browser.with_solids()
    page.reload()
    page.locator("canvas[data-state=current]").wait_for()
    first = _picture(browser)
    assert _drawn(first) > 0.2

    box = page.locator(".canvas canvas").bounding_box()
    middle = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(*middle)
    page.mouse.down()
    page.mouse.move(middle[0] + 150, middle[1] + 20, steps=4)
    page.mouse.up()
    turned = _picture(browser)
    assert _changed(first, turned) > 0.1

    page.get_by_role("button", name="Oblique").click()
    page.wait_for_timeout(200)
    straight = _picture(browser)
    assert _changed(straight, turned) > 0.1
    _drag(browser, "stage.thickness", 17.0)
    page.locator("canvas[data-state=old]").wait_for()
    page.locator("canvas[data-state=current]").wait_for()
    page.wait_for_timeout(200)
    assert _changed(straight, _picture(browser)) > 0.005

    # The tree finds a part in the view, hides it, and names its files.
    page.get_by_role("button", name="Parts").click()
    row = page.locator(".tree li", has_text=re.compile(r"^stage"))
    before = _picture(browser)
    row.locator("input").uncheck()
    page.wait_for_timeout(200)
    assert _changed(before, _picture(browser)) > 0.02
    row.locator("input").check()
    row.locator(".part-name").click()
    assert page.url.endswith("#machine/solids?part=stage")
    assert page.request.get(row.get_by_text("STL").evaluate("(link) => link.href")).ok
    row.locator(".part-name").click()
    page.get_by_role("button", name="Parts").click()
    page.mouse.move(*middle)
    page.locator(".hovered-part", has_text="stage").wait_for()

    # Two points are marked above the solids, in the colour of the label between them.
    page.get_by_role("button", name="Measure").click()
    marked = [_pixels(page.locator(".canvas canvas"))]
    for across in (-40, 40):
        page.mouse.click(middle[0] + across, middle[1])
        page.wait_for_timeout(200)
        marked.append(_picture(browser))
    assert "mm" in page.locator(".measured b").inner_text()
    ink = page.evaluate("getComputedStyle(document.documentElement).getPropertyValue('--bad').trim()")
    red = np.array([int(ink[k : k + 2], 16) for k in (1, 3, 5)], float)
    none, point, line = (int(np.sum(np.abs(picture - red).max(axis=2) < 40.0)) for picture in marked)
    assert none < 5 and point > 20 and line > point + 60
    page.get_by_role("button", name="Measure").click()

    page.locator("select[aria-label=section]").select_option("y")
    page.wait_for_timeout(200)
    assert _changed(straight, _picture(browser)) > 0.05
    page.mouse.click(*middle)
    page.locator(".part-card").wait_for()
    until(page, lambda: "mass" in page.locator(".part-card").inner_text())

    # After a reload the change is still there, and so are the solids.
    page.reload()
    page.locator("canvas[data-state=current]").wait_for()
    until(page, lambda: page.get_by_label("stage.thickness", exact=True).input_value() == "17 mm")
    page.get_by_role("button", name="Drawings").click()
    page.get_by_role("button", name="tip", exact=True).click()
    page.get_by_text("no lint hits").wait_for()
    assert page.locator(".paper").evaluate("(paper) => paper.naturalWidth") > 100
    page.get_by_role("button", name="Undo").click()
    page.get_by_role("button", name="Difference", exact=True).wait_for()
    browser.expect_errors("422")


@pytest.mark.slow
def test_requirements_that_contradict_each_other_are_drawn_over_each_other(browser: Browser) -> None:
    """A light stage against a stiff one, over its thickness: no design, the Pareto front, and what to relax."""
    page = browser.page
    page.wait_for_selector(".check >> nth=100")
    # A design that violates a rule has no solids, whose masses would take longer than the search.
    _drag(browser, "stage.thickness", 6.1)
    page.get_by_text("cannot be built").wait_for()
    page.get_by_role("button", name="Optimize", exact=True).click()
    row = page.locator(".free-row", has_text="stage.thickness")
    row.wait_for()
    page.get_by_role("button", name="None", exact=True).click()
    row.get_by_role("checkbox").check()
    required = "acceleration of 1 G without lift-off, bending of the stage above the tip"
    page.get_by_label("required checks").fill(required)
    page.get_by_label("designs of the search").fill("20")
    page.locator(".optimize .actions").get_by_role("button", name="Optimize").click()
    page.locator(".optimum .verdict.unexplained", has_text="No design").wait_for()
    figure = page.locator(".front .plot")
    figure.scroll_into_view_if_needed()
    red, green, blue = _pixels(figure).reshape(-1, 3).T
    # The front in vermilion, the present design in blue, the compromise in green.
    assert np.sum((red > 180) & (green < 160) & (blue < 110)) > 100
    assert np.sum((blue > 160) & (red < 120)) > 20 and np.sum((green > blue + 20) & (red < 90)) > 20
    heading = page.get_by_role("heading", name="Contradicting requirements", exact=True)
    both = page.locator(".optimum .card", has=heading)
    until(page, lambda: all(name.strip() in both.inner_text() for name in required.split(",")))
    until(page, lambda: page.locator(".optimum .card", has_text="What to relax").locator("tbody tr").count() == 2)
    for width in (1280, 960, 700):
        page.set_viewport_size({"width": width, "height": 800})
        assert page.evaluate(WIDER) == [], width
    page.set_viewport_size({"width": 1280, "height": 800})
    # The result is that of one design: with another value it is marked, and its changes cannot be made.
    apply, old = page.get_by_role("button", name="Apply"), page.locator(".optimize .search", has_text="Out of date")
    until(page, lambda: apply.is_enabled() and old.count() == 0)
    _drag(browser, "stage.thickness", 6.2)
    old.wait_for()
    until(page, lambda: apply.is_disabled())
    page.reload()
    page.get_by_role("button", name="Optimize", exact=True).click()
    old.wait_for()
    until(page, lambda: apply.is_disabled())
    page.get_by_role("button", name="Undo").click()
    old.wait_for(state="detached")
    until(page, lambda: apply.is_enabled())
    page.get_by_role("button", name="Undo").click()
    page.get_by_role("button", name="Difference", exact=True).wait_for()
    browser.expect_errors("422")


def test_an_axis_keeps_its_unit_when_the_letters_change_their_size(browser: Browser) -> None:
    """What is written on the canvases, since a plot has no text of its own: ticks beside the label of their unit."""
    page = browser.page
    page.add_init_script("""window.written = []; const fillText = CanvasRenderingContext2D.prototype.fillText;
        CanvasRenderingContext2D.prototype.fillText = function (text, ...at) {
            window.written.push(String(text)); return fillText.call(this, text, ...at); };""")
    browser.open("simulation")
    page.reload()
    page.get_by_label("experiment", exact=True).select_option("presliding")
    page.locator("#simulation .plot canvas").first.wait_for()
    until(page, lambda: any("(mm/s)" in text or "(µm)" in text for text in page.evaluate("window.written")))
    page.wait_for_timeout(500)

    def redrawn(width: int, height: int) -> set[str]:
        page.evaluate("window.written = []")
        page.set_viewport_size({"width": width, "height": height})
        page.wait_for_timeout(1500)
        return {text for text in page.evaluate("window.written") if "(" in text or text.replace("−", "").isdigit()}

    small, large = redrawn(1270, 800), redrawn(1920, 1080)
    units = {text for text in small if "(" in text}
    assert any("µm" in text for text in units) and units == {text for text in large if "(" in text}
    largest = [max(abs(int(t.replace("−", "-"))) for t in texts if "(" not in t) for texts in (small, large)]
    assert largest[1] <= 10 * largest[0] and largest[0] <= 10 * largest[1]
    page.set_viewport_size({"width": 1280, "height": 800})


UPRIGHT = """window.upright = []; const fillText = CanvasRenderingContext2D.prototype.fillText;
    CanvasRenderingContext2D.prototype.fillText = function (text, x, y, ...rest) {
        const { b, d, e, f } = this.getTransform();
        if (Math.abs(b) > 0.9 * Math.abs(this.getTransform().c) && Math.abs(d) < 1e-6) {
            const middle = this.getTransform().transformPoint(new DOMPoint(x, y)).y;
            const half = 0.5 * this.measureText(text).width * Math.abs(b);
            const cut = Math.min(middle - half, this.canvas.height - middle - half);
            window.upright.push({ text: String(text), cut });
        }
        return fillText.call(this, text, x, y, ...rest); };"""
"""Labels that are drawn upright, with the distance of their ends from the edge of the canvas, px."""


def test_labels_of_plots_are_whole_at_every_size(browser: Browser) -> None:
    page = browser.page
    page.add_init_script(UPRIGHT)
    browser.open("simulation")
    page.reload()
    page.get_by_label("experiment", exact=True).select_option("presliding")
    page.locator("#simulation .plot canvas").first.wait_for()
    until(page, lambda: page.evaluate("window.upright.length") > 0)
    for width, height in ((1273, 800), (953, 800), (953, 540), (1273, 420)):
        page.set_viewport_size({"width": width, "height": height})
        page.wait_for_timeout(1000)
        page.evaluate("window.upright = []; dispatchEvent(new Event('themechange'))")
        page.wait_for_timeout(1000)
        drawn = page.evaluate("window.upright")
        assert drawn or height < 500
        assert not [label for label in drawn if label["cut"] < -1.0], (width, height)


def test_a_wrong_value_of_a_simulation_is_refused_and_the_one_before_stays(browser: Browser) -> None:
    page = browser.page
    browser.open("simulation")
    page.get_by_label("experiment", exact=True).select_option("presliding")
    page.locator("#simulation .plot canvas").first.wait_for()
    force = page.get_by_label("friction.coulomb", exact=True)
    before = force.input_value()
    for wrong in ("3 kg", "much"):
        enter(force, wrong)
        page.locator("#message.bad", has_text="friction.coulomb").wait_for()
        until(page, lambda: force.input_value() == before)
    # A number without a unit is one in the unit of the field.
    force.fill("1.1")
    with page.expect_request("**/api/simulation/run") as asked:
        force.press("Enter")
    assert asked.value.post_data_json["changes"] == {"friction.coulomb": "1.1 N"}
    page.get_by_label("experiment", exact=True).select_option("tip")
    height = page.get_by_label("actuator.tip_height", exact=True)
    enter(height, "2 cm")
    page.locator("#message.bad", has_text="a number in mm").wait_for()
    until(page, lambda: height.input_value() == "20 mm")
    browser.expect_errors("422")


def test_dropped_files_become_an_experiment_and_its_ladder_reaches_the_noise(browser: Browser, folder: Path) -> None:
    """Protects the way from dropped files to a model at the noise by clicks alone."""
    page = browser.page
    for name, seed in (("fit", 1), ("validate", 2)):
        (folder / f"{name}.csv").write_text(_rows(seed))
    (folder / "empty.csv").write_text("time [s];velocity [m/s]\n")
    browser.open("measurement")
    _drop(page, folder / "empty.csv")
    dialog = page.get_by_role("dialog")
    dialog.get_by_role("button", name="Upload").click()
    dialog.get_by_role("alert").filter(has_text="empty.csv").wait_for()
    dialog.get_by_role("button", name="Cancel").click()

    _drop(page, folder / "fit.csv", folder / "validate.csv")
    dialog.get_by_label("name of the experiment").fill("slide")
    dialog.get_by_label("name of the experiment").press("Enter")
    dialog.get_by_text("read as: semicolon, decimal comma").wait_for()
    until(page, lambda: dialog.get_by_label("kind of rig").input_value() == "velocity-drive")
    until(page, lambda: dialog.get_by_label("role of validate.csv").input_value() == "validate")
    column = dialog.get_by_label("channel of velocity")
    column.select_option("friction_force")
    dialog.get_by_text("no column is taken for position or velocity").wait_for()
    dialog.get_by_role("button", name="Create").click()
    dialog.get_by_role("alert").filter(has_text="two columns are taken for friction force").wait_for()
    column.select_option("velocity")
    dialog.get_by_text("no column is taken").wait_for(state="hidden")
    dialog.get_by_role("button", name="Take all as proposed").click()
    dialog.get_by_role("button", name="Create").click()
    page.locator(".map canvas").first.wait_for()

    page.locator(".overlay .u-over").first.hover()
    page.locator(".under-cursor", has_text=re.compile(r"\d s: .*N.*residual .*N")).wait_for()

    # A slider of a fitted value moves the prediction; a double click brings it back.
    slider = page.get_by_label("coulomb.force, slider")
    slider.fill("150")
    page.locator(".legend", has_text="changed").wait_for()
    page.locator(".moved", has_text="× the noise").wait_for()
    slider.dblclick()
    page.locator(".overlay .legend:not(:has-text('changed'))").wait_for()

    page.get_by_role("button", name="Diagnose", exact=True).click()
    page.locator(".verdict b", has_text="stribeck is missing").wait_for()
    # The candidate is drawn over the record before it is added; the search is there after a reload.
    page.locator(".legend", has_text="with stribeck").wait_for()
    page.reload()
    page.locator(".verdict b", has_text="stribeck is missing").wait_for()
    page.locator(".candidate.named").get_by_role("button", name="Add").click()
    page.locator(".rung", has_text="stribeck").wait_for()
    page.locator(".search progress").wait_for(state="detached")
    before, after = (float(text.strip("× \n")) for text in page.locator(".rung .num").all_inner_texts())
    assert before > 5.0 and after < 1.2

    page.get_by_role("button", name="Diagnose", exact=True).click()
    page.locator(".verdict b", has_text="Nothing is missing").wait_for()
    page.get_by_role("button", name="Undo").click()
    page.locator(".rung >> nth=1").wait_for(state="detached")
    page.locator(".search progress").wait_for(state="detached")
    page.get_by_role("button", name="Diagnose", exact=True).click()
    page.locator(".search").get_by_role("button", name="Cancel").dispatch_event("click")
    page.locator("#message", has_text="cancelled").wait_for()
    assert page.locator(".candidate").count() == 0
    # What was found is shown after a reload, but not once the file of the experiment is another.
    asked: list[str] = []
    page.on("request", lambda request: asked.append(request.url) if request.url.endswith("/compare") else None)
    page.reload()
    page.locator(".map canvas").first.wait_for()
    assert asked == []
    with (folder / "slide" / "experiment.toml").open("a", encoding="utf-8") as file:
        file.write("\n[noise]\nfriction_force = '0.01 N'\n")
    page.reload()
    page.locator(".map canvas").first.wait_for()
    until(page, lambda: len(asked) == 1)
    browser.expect_errors("422")


@pytest.mark.slow
def test_an_effect_that_is_not_needed_is_removed_by_a_button(browser: Browser, folder: Path) -> None:
    page = browser.page
    (folder / "axis").mkdir()
    add_effects(write(folder / "axis", lambda x, v: 1.5 * np.sign(v) + 12.0 * v), ["quadratic_drag"])
    browser.open("measurement")
    page.locator(".experiment[data-name='axis']").click()
    page.get_by_role("button", name="Diagnose", exact=True).click()
    page.get_by_role("button", name="Remove quadratic drag").click()
    page.locator(".rung", has_text="quadratic").wait_for()
    page.locator(".rung >> nth=2").wait_for()
    page.locator(".search progress").wait_for(state="detached")
    assert [list(one.effects) for one in read_history(load_experiment(folder / "axis"))][-1] == ["coulomb", "viscous"]
    browser.expect_errors("422")


def _rows(seed: int) -> str:
    """Friction with a Stribeck peak, as a spreadsheet writes it: semicolons and decimal commas."""
    time = np.arange(1200) * 2e-3
    velocity = 0.02 * np.sin(5.0 * time + seed) + 0.006 * np.sin(17.0 * time)
    level = 1.0 + 0.8 * np.exp(-((velocity / 0.004) ** 2))
    force = np.sign(velocity) * level + 6.0 * velocity + 0.01 * np.random.default_rng(seed).standard_normal(time.size)
    rows = "".join(";".join(f"{value:.6f}" for value in row) + "\n" for row in zip(time, velocity, force))
    return "time [s];velocity [m/s];friction_force [N]\n" + rows.replace(".", ",")


def _drop(page: Any, *paths: Path) -> None:
    with page.expect_file_chooser() as chosen:
        page.locator(".dropzone").click()
    chosen.value.set_files([str(path) for path in paths])


WIDER = """() => [...document.querySelectorAll('.optimum table')].filter((one) => one.offsetWidth
  > one.parentElement.clientWidth).map((one) => one.innerText)"""
"""Tables of a search that are wider than their place."""

OUTSIDE = """() => [...document.querySelectorAll('button, select, a, input')].filter((one) => one.offsetParent
  && one.getBoundingClientRect().right > innerWidth + 1).map((one) => `${one.className} ${one.textContent}`)"""
"""Controls that reach beyond the right edge of the window."""


CUT = """() => [...document.querySelectorAll('.row .name, .check .name')].filter((one) => one.offsetParent
  && (one.scrollWidth > one.clientWidth + 1 || one.scrollHeight > one.clientHeight + 2)).map((one) => one.innerText)"""
"""Names of parameters and checks that are not shown whole."""

FIVE_JOBS = """() => document.getElementById('jobs').append(...[1, 2, 3, 4, 5].map(() => {
  const job = document.createElement('span');
  job.className = 'job';
  job.innerHTML = '<b>Drawing tip</b><span class="step">each check 3/58</span>'
    + '<progress aria-label="Drawing"></progress><button class="icon" aria-label="Cancel">x</button>';
  return job;
}))"""
"""Jobs in the bar below, as api.js shows them."""


@pytest.mark.parametrize("view", ["machine", "simulation", "measurement"])
def test_a_narrow_window_has_every_control_and_axe_finds_no_fault(browser: Browser, view: str) -> None:
    page = browser.page
    browser.open(view)
    page.locator(f"#{view}:not([hidden]) .panel").last.wait_for()
    page.evaluate(FIVE_JOBS)
    for width in (1280, 1150, 960, 700):
        page.set_viewport_size({"width": width, "height": 800})
        page.wait_for_timeout(200)
        assert page.evaluate(OUTSIDE) == [] == page.evaluate(CUT), width
    assert faults_of_access(page) == []


def test_a_bare_number_takes_the_unit_of_its_field(browser: Browser) -> None:
    page = browser.page
    browser.open("machine")
    field = page.get_by_label("stage.thickness", exact=True)
    enter(field, "14")
    page.locator(".row.set[data-key='stage.thickness']").wait_for()
    assert field.input_value() == "14 mm"
    assert page.locator(".violations").is_hidden()
