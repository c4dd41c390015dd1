"""A server that is killed while a job runs, and started again: the page recovers, and nothing saved is lost."""

import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from served_page import NEEDS_CHROMIUM, Browser, chromium, ended, enter, killed, looking, started, until

from sysid.experiment.experiment import load_experiment
from tests.process_state import running, wait_until
from tests.sysid.slide import SIGN, VELOCITY, slide

pytestmark = [NEEDS_CHROMIUM, pytest.mark.skipif(sys.platform != "linux", reason="looks up processes in /proc")]


def _descendants(process: int) -> set[int]:
    """Process ids of what a process has started, and of what those have."""
    parents: dict[int, int] = {}
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                parents[int(entry.name)] = int((entry / "stat").read_text().rpartition(")")[2].split()[1])
            except OSError:
                continue
    found, last = {process}, 0
    while len(found) != last:
        last = len(found)
        found |= {child for child, parent in parents.items() if parent in found}
    return found - {process}


@contextmanager
def _page(folder: Path) -> Iterator[tuple[Browser, list[subprocess.Popen[str]]]]:
    """A user who looks at the checks, and the server, to which the one is added that takes its place."""
    server, address = started(folder, "--port", "0")
    servers = [server]
    try:
        with chromium() as launched, looking(launched, address) as browser:
            browser.leave_out_solids()
            browser.open_checks()
            yield browser, servers
            # What the browser says of requests to a server that is not there.
            browser.expect_errors("net::ERR")
    finally:
        if servers[-1].poll() is None:
            ended(servers[-1])


@pytest.mark.slow
def test_a_killed_server_loses_nothing_saved_and_leaves_no_process(tmp_path: Path) -> None:
    folder = tmp_path / "project"
    force = SIGN * (1.3 + 0.6 * (abs(VELOCITY) < 0.004)) + 20.0 * VELOCITY
    slide(folder / "rig", force, "coulomb", held_out=True)
    with _page(folder) as (browser, servers):
        page, port = browser.page, str(urlsplit(browser.address).port)
        # Work that is saved: a file, a change of it that is not in the file yet, a rung of the ladder, a result.
        thickness = page.get_by_label("stage.thickness", exact=True)
        enter(thickness, "13 mm")
        page.get_by_role("button", name="Save as").click()
        page.get_by_label("name of the new file").fill("thick")
        page.get_by_role("button", name="Save", exact=True).click()
        page.locator("#message", has_text="saved as thick.toml").wait_for()
        enter(thickness, "14 mm")
        page.get_by_role("button", name="Difference (1)").wait_for()
        page.evaluate("location.hash = 'measurement'")
        page.locator(".map canvas").first.wait_for()
        page.get_by_role("button", name="Diagnose", exact=True).click()
        page.locator(".candidate", has_text="viscous").get_by_role("button", name="Add").click()
        page.locator(".rung", has_text="viscous").wait_for()
        page.locator(".search progress").wait_for(state="detached")
        rungs, statement = page.locator(".ladder").inner_text(), page.locator(".statement").inner_text()

        page.get_by_role("button", name="Diagnose", exact=True).click()
        page.locator(".search .step", has_text=re.compile(r"\w+")).wait_for()
        page.locator("#jobs .job").wait_for()
        workers = _descendants(servers[0].pid)
        assert workers
        killed(servers[0])
        page.locator("#message.bad", has_text="connection to the server lost").wait_for()
        wait_until(lambda: not any(map(running, workers)))

        servers.append(started(folder, "--port", port)[0])
        page.locator("#message:not(.bad)", has_text="Diagnose: the server ended").wait_for()
        # The job that was running has ended; what was shown stays, and the next job runs.
        page.locator("#jobs .job").wait_for(state="detached")
        page.locator(".search progress").wait_for(state="detached")
        until(page, lambda: page.locator(".ladder").inner_text() == rungs)
        until(page, lambda: page.locator(".statement").inner_text() == statement)
        page.get_by_label("coulomb.force, slider").fill("150")
        page.locator(".moved", has_text="× the noise").wait_for()

        # So it is for who opens the page anew.
        page.reload()
        page.locator(".map canvas").first.wait_for()
        until(page, lambda: page.locator(".statement").inner_text() == statement)
        until(page, lambda: page.locator(".ladder").inner_text() == rungs)
        page.evaluate("location.hash = 'machine'")
        page.get_by_role("button", name="Difference (1)").wait_for()
        until(page, lambda: page.get_by_label("parameter file").input_value() == "thick.toml")
        until(page, lambda: thickness.input_value() == "14 mm")
        page.get_by_role("button", name="Undo").click()
        page.get_by_role("button", name="Difference", exact=True).wait_for()
        until(page, lambda: thickness.input_value() == "13 mm")
    assert load_experiment(folder / "rig").effects == ("coulomb", "viscous")
    assert "13 mm" in (folder / "thick.toml").read_text("utf-8")
    assert not [path for path in folder.rglob("*") if path.name.startswith(".") and path.suffix != ".lock"]


@pytest.mark.slow
def test_a_page_that_is_used_while_the_server_is_away_says_so(tmp_path: Path) -> None:
    with _page(tmp_path) as (browser, servers):
        page = browser.page
        killed(servers[0])
        page.locator("#message.bad", has_text="connection to the server lost").wait_for()
        thickness = page.get_by_label("stage.thickness", exact=True)
        enter(thickness, "13 mm")
        page.locator("#message.bad", has_text='is "stagecad workbench" still running?').wait_for()
        # The value that the server does not know is not shown as if it were there.
        until(page, lambda: thickness.input_value() == "12 mm")
        servers.append(started(tmp_path, "--port", str(urlsplit(browser.address).port))[0])
        page.locator("#message:not(.bad)").wait_for(state="attached")
        enter(thickness, "13 mm")
        page.get_by_role("button", name="Difference (1)").wait_for()
