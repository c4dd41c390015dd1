"""Answers that come late do not replace those of newer requests: each is held until the newer one is shown."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from served_page import NEEDS_CHROMIUM, Browser, chromium, enter, looking, serving, until

from tests.sysid.slide import SIGN, VELOCITY, slide

pytestmark = [NEEDS_CHROMIUM, pytest.mark.slow]
FORCE = 1.3 * SIGN + 20.0 * VELOCITY
FIELDS = """() => [...document.querySelectorAll('#simulation .row input[type=text]')]
  .filter((one) => one.scrollWidth > one.clientWidth).map((one) => one.value)"""
"""Values of the simulation that are wider than their field."""
SVG = '<svg xmlns="http://www.w3.org/2000/svg" width="420" height="297"/>'


@pytest.fixture(scope="module")
def launched(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Any, str]]:
    """A browser, and a server in a folder with two experiments and two parameter files."""
    folder = tmp_path_factory.mktemp("project")
    slide(folder / "one", FORCE, "coulomb", held_out=True)
    slide(folder / "two", FORCE, "coulomb", "viscous", held_out=True)
    for name, free in (("thin", "10 mm..14 mm"), ("thick", "14 mm..20 mm")):
        thickness = f'thickness = {{value = "14 mm", origin = "assumed: a test", free = "{free}"}}'
        (folder / f"{name}.toml").write_text(f'extends = "thesis"\n[stage]\n{thickness}\n')
    with chromium() as one, serving(folder) as address:
        yield one, address


@pytest.fixture
def browser(launched: tuple[Any, str]) -> Iterator[Browser]:
    with looking(*launched) as one:
        one.leave_out_solids()
        yield one


class Held:
    """The first answers to requests of a pattern, made by the server at once and handed to the page by `release`."""

    def __init__(self, page: Any, pattern: str, count: int = 1) -> None:
        self.page, self.pattern, self.count, self.taken = page, pattern, count, 0
        self.answers: list[tuple[Any, Any]] = []
        page.route(pattern, self._take)

    def _take(self, route: Any) -> None:
        # The next request may come while the answer to this one is fetched.
        if self.taken < self.count:
            self.taken += 1
            self.answers.append((route, route.fetch()))
        else:
            route.continue_()

    def wait(self) -> None:
        until(self.page, lambda: len(self.answers) == self.count)

    def release(self) -> None:
        """Hand over the answers, and give the page the time to act on them."""
        self.wait()
        for route, response in self.answers:
            with self.page.expect_response(lambda found, url=route.request.url: found.url == url):
                route.fulfill(response=response)
        self.page.unroute(self.pattern, self._take)
        self.page.wait_for_timeout(150)


def _experiments(browser: Browser) -> Any:
    browser.open("measurement")
    browser.page.locator(".experiment").nth(1).wait_for()
    return browser.page


def _choose(page: Any, name: str, compared: bool = True) -> None:
    """Choose an experiment and wait until its comparison is shown and nothing is under way."""
    page.locator(f".experiment[data-name={name}]").click()
    if compared:
        page.locator("#measurement .panel:not(.blank) .map canvas").first.wait_for()
        page.locator("#measurement details.raw:not([hidden])").wait_for()
        page.locator(".search progress").wait_for(state="detached")
        page.locator("#measurement button.main:not([disabled])", has_text="Diagnose").wait_for()


def test_a_slider_that_is_dragged_again_keeps_its_value(browser: Browser) -> None:
    """The answer to the first release comes while the slider is at its second place, and not released there."""
    page = browser.page
    browser.open_checks()
    slider = page.get_by_label("stage.thickness, slider")
    field = page.get_by_label("stage.thickness", exact=True)
    first = Held(page, "**/api/machine/commit")
    slider.fill("14")
    first.wait()
    slider.evaluate("(slider) => { slider.value = '6'; slider.dispatchEvent(new Event('input', { bubbles: true })); }")
    page.get_by_text("cannot be built").wait_for()
    first.release()
    page.get_by_role("button", name="Difference (1)").wait_for()
    assert (slider.input_value(), field.input_value()) == ("6", "6 mm")
    with page.expect_response("**/api/machine/commit") as committed:
        slider.dispatch_event("change")
    assert committed.value.json()["changes"] == {"stage.thickness": "6 mm"} and committed.value.json()["undo"] == 2
    undo = page.get_by_role("button", name="Undo")
    undo.click()
    until(page, lambda: field.input_value() == "14 mm")
    # A slider that is brought back to its place makes no step; an undo after it is shown all the same.
    slider.evaluate("(slider) => slider.dispatchEvent(new Event('input', { bubbles: true }))")
    undo.click()
    page.get_by_role("button", name="Difference", exact=True).wait_for()
    until(page, lambda: field.input_value() == "12 mm" and slider.input_value() == "12")
    page.get_by_text("cannot be built").wait_for(state="hidden")


def test_margins_that_come_again_clear_no_message_but_their_own(browser: Browser) -> None:
    page = browser.page
    browser.open_checks()
    refused = page.locator("#message.bad", has_text="no margins")
    preview = "**/api/machine/preview"
    slider = page.get_by_label("stage.thickness, slider")
    page.route(preview, lambda route: route.fulfill(status=422, json={"error": "no margins"}))
    slider.fill("14")
    refused.wait_for()
    page.unroute(preview)
    slider.fill("15")
    refused.wait_for(state="detached")
    page.route(preview, lambda route: route.fulfill(status=422, json={"error": "no margins"}))
    slider.evaluate("(slider) => { slider.value = '16'; slider.dispatchEvent(new Event('input', { bubbles: true })); }")
    refused.wait_for()
    page.unroute(preview)
    undone = page.locator("#message", has_text="undone")
    with page.expect_response(preview):
        page.get_by_role("button", name="Undo").click()
        # An answer to the former values may come first.
        undone.wait_for()
    page.wait_for_timeout(150)
    assert undone.is_visible()
    browser.expect_errors("422")


def test_an_experiment_that_was_left_changes_nothing(browser: Browser) -> None:
    page = _experiments(browser)
    for name in ("one", "two", "one"):
        _choose(page, name)
    # The ladder of the first arrives after that of the second.
    ladder = Held(page, "**/api/experiment/one/ladder")
    _choose(page, "two")
    _choose(page, "one", compared=False)
    ladder.wait()
    _choose(page, "two")
    shown = page.locator("#measurement").inner_text()
    until(page, lambda: "coulomb, viscous" in page.locator(".ladder").inner_text())
    ladder.release()
    assert page.locator("#measurement").inner_text() == shown
    # So does the answer that begins a job of the first: its progress is not that of the second.
    _choose(page, "one")
    begun = Held(page, "**/api/experiment/one/diagnose")
    page.get_by_role("button", name="Diagnose", exact=True).click()
    begun.wait()
    _choose(page, "two")
    begun.release()
    assert page.locator(".search progress").count() == 0
    until(page, lambda: page.get_by_role("button", name="Diagnose", exact=True).is_enabled())
    # Nor is its result.
    page.locator("#jobs .job").wait_for(state="detached")
    page.wait_for_timeout(150)
    assert page.locator("#measurement").inner_text() == shown
    _choose(page, "one", compared=False)
    page.locator(".verdict b", has_text="viscous is missing").wait_for()


def test_a_prediction_of_former_values_is_not_drawn(browser: Browser) -> None:
    page = _experiments(browser)
    _choose(page, "two")
    changed = page.locator(".overlay .legend", has_text="changed")
    slider = page.get_by_label("coulomb.force, slider")
    slider.fill("150")
    changed.wait_for()
    page.locator(".moved", has_text="× the noise").wait_for()
    answer = Held(page, "**/api/jobs/*/result")
    slider.fill("30")
    answer.wait()
    slider.dblclick()
    answer.release()
    # The slider is back at the fitted value.
    page.locator(".moved", has_text="The fitted values.").wait_for()
    assert changed.count() == 0
    answer = Held(page, "**/api/jobs/*/result")
    slider.fill("40")
    answer.wait()
    _choose(page, "one")
    answer.release()
    assert changed.count() == 0
    assert "With these values" not in page.locator(".moved").inner_text()
    assert page.locator("#message.bad").count() == 0


def test_curves_over_a_motion_that_was_left_are_not_drawn(browser: Browser) -> None:
    page = _experiments(browser)
    _choose(page, "two")
    curves = Held(page, "**/curves/*pairs=true*")
    abscissa = page.get_by_label("abscissa")
    abscissa.select_option("velocity")
    curves.wait()
    abscissa.select_option("")
    page.locator(".overlay .uplot").nth(1).wait_for()
    curves.release()
    # The plots over time stay, and none over the velocity is beside them.
    assert page.locator(".overlay .uplot").count() == 2 and page.locator(".overlay canvas.xy").count() == 0


def test_a_former_kind_of_rig_proposes_nothing(browser: Browser, tmp_path: Path) -> None:
    page = _experiments(browser)
    times = np.arange(500) * 1e-3
    rows = "".join(f"{t:.3f},{np.sin(9.0 * t):.5f},{np.cos(9.0 * t):.5f}\n" for t in times)
    (tmp_path / "run.csv").write_text("time [s],position [m],force [N]\n" + rows)
    with page.expect_file_chooser() as chosen:
        page.locator(".dropzone").click()
    chosen.value.set_files([str(tmp_path / "run.csv")])
    dialog = page.get_by_role("dialog")
    dialog.get_by_label("name of the experiment").fill("dropped")
    dialog.get_by_role("button", name="Upload").click()
    kind = dialog.get_by_label("kind of rig")
    kind.wait_for()
    first = Held(page, "**/api/propose")
    kind.select_option("force-drive")
    first.wait()
    with page.expect_response("**/api/propose"):
        kind.select_option("spring-pull")
    dialog.get_by_label("channel of force [N]").locator("option[value=spring_force]").wait_for(state="attached")
    first.release()
    until(page, lambda: kind.input_value() == "spring-pull")
    until(page, lambda: dialog.get_by_label("channel of force [N]").locator("option[value=spring_force]").count() == 1)
    dialog.get_by_role("button", name="Cancel").click()


def test_a_former_simulation_is_not_drawn(browser: Browser) -> None:
    page = browser.page
    browser.open("simulation")
    features = page.locator("#simulation .panel").nth(2)
    features.locator("td.num").first.wait_for()
    choice = page.get_by_label("experiment", exact=True)
    choice.select_option("presliding")
    page.locator("h2", has_text="presliding").wait_for()
    # At 1280 pixels every value is seen as a whole.
    assert page.evaluate(FIELDS) == []
    field = page.get_by_label("friction.mass", exact=True)
    answer, before = Held(page, "**/api/jobs/*/result"), features.inner_text()
    enter(field, "3 kg")
    answer.wait()
    enter(field, "1.5 kg")
    until(page, lambda: features.inner_text() != before)
    shown = features.inner_text()
    answer.release()
    assert features.inner_text() == shown
    # Nor is that of another experiment.
    answer = Held(page, "**/api/jobs/*/result")
    enter(field, "2.5 kg")
    answer.wait()
    choice.select_option("tip")
    page.locator("h2", has_text="Path of the tip").wait_for()
    answer.release()
    until(page, lambda: page.locator("h2", has_text="Path of the tip").is_visible())
    assert page.locator("#simulation .uplot").count() == 0
    # A design that was read before another is not that of the sliders.
    design = Held(page, "**/api/simulation")
    page.evaluate("location.hash = 'machine'")
    page.evaluate("location.hash = 'simulation'")
    design.wait()
    post = """() => fetch('/api/machine/commit', { method: 'POST', headers: { 'content-type': 'application/json' },
        body: JSON.stringify({ changes: { 'actuator.tip_height': '21 mm' } }) })"""
    page.evaluate(post)
    page.evaluate("location.hash = 'machine'")
    page.evaluate("location.hash = 'simulation'")
    tip = page.get_by_label("actuator.tip_height", exact=True)
    until(page, lambda: tip.input_value() == "21 mm")
    design.release()
    assert tip.input_value() == "21 mm"


def test_a_search_of_a_file_that_was_left_is_not_shown(browser: Browser) -> None:
    page = browser.page
    browser.open_checks()
    file = page.get_by_label("parameter file")
    with page.expect_response("**/api/machine/parameters"):
        file.select_option("thin.toml")
    # What is free in the file that was open before.
    ranges = Held(page, "**/api/machine/optimize")
    page.get_by_role("button", name="Optimize", exact=True).first.click()
    ranges.wait()
    row = page.get_by_label("range of stage.thickness")
    file.select_option("thick.toml")
    row.wait_for()
    until(page, lambda: row.input_value() == "14 mm:20 mm")
    ranges.release()
    assert row.input_value() == "14 mm:20 mm"
    file.select_option("thin.toml")
    until(page, lambda: row.input_value() == "10 mm:14 mm")
    # A search that the server begins while another file is opened.
    document = {"feasible": True, "evaluations": 20, "changes": [], "conflicts": [], "margins": [], "relax": []}
    found = {"document": document, "changes": {}, "required": 1, "unverified": [], "fronts": []}
    job = _job("optimize", 9001)
    asked: list[Any] = []
    page.route("**/api/jobs/9001/result", _answered(found))

    def begin(route: Any) -> None:
        if route.request.method == "GET":
            route.continue_()
        else:
            asked.append(route)

    page.route("**/api/machine/optimize", begin)
    start = page.locator(".optimize .actions").get_by_role("button", name="Optimize")
    start.click()
    until(page, lambda: bool(asked))
    file.select_option("thick.toml")
    until(page, lambda: row.input_value() == "14 mm:20 mm")
    asked.pop().fulfill(json=job)
    page.wait_for_timeout(150)
    assert page.locator(".optimum .verdict").count() == 0
    # Without a change of the file it is shown.
    start.click()
    until(page, lambda: bool(asked))
    asked.pop().fulfill(json={**job, "number": 9001})
    page.locator(".optimum .verdict.good").wait_for()


def test_a_sheet_that_was_left_is_not_drawn(browser: Browser) -> None:
    page = browser.page
    numbers = {"tip": 9011, "magnet": 9012}
    for name, number in numbers.items():
        sheet = {"name": name, "paper": f"paper of the {name}", "scale": "1:1"}
        sheet |= {"views": [], "hits": [], "key": "0" * 64}
        page.route(f"**/api/machine/drawings/{name}", _answered(_job("drawings", number)))
        page.route(f"**/api/jobs/{number}/result", _answered({"subject": name, "sheets": [sheet]}))
    page.route("**/*.svg", lambda route: route.fulfill(body=SVG, content_type="image/svg+xml"))
    browser.open("machine")
    page.get_by_role("button", name="Drawings").click()
    held: list[Any] = []
    page.route("**/api/jobs/9011/result", lambda route: held.append(route))
    page.get_by_role("button", name="tip", exact=True).click()
    until(page, lambda: bool(held))
    page.get_by_role("button", name="magnet", exact=True).click()
    note = page.locator(".sheet-note", has_text="paper of the magnet")
    note.wait_for()
    held.pop().fallback()
    page.wait_for_timeout(150)
    until(page, lambda: note.is_visible())
    assert (page.locator(".paper").get_attribute("src") or "").endswith("/magnet.svg")
    assert page.get_by_role("button", name="magnet", exact=True).get_attribute("aria-pressed") == "true"


def _job(task: str, number: int) -> dict[str, Any]:
    """A finished job, as the server describes it."""
    state = {"state": "done", "step": "", "done": 0, "total": 0, "error": "", "details": "", "passing": False}
    return {"number": number, "lane": "solids", "task": task, "title": task, "subject": "", **state}


def _answered(document: Any) -> Callable[[Any], None]:
    return lambda route: route.fulfill(json=document)
