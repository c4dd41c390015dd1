"""A server of the page as its user starts it, and a Chromium that looks at it."""

import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import pytest

PROGRAMS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
PROGRAM = next((found for name in PROGRAMS if (found := shutil.which(name))), None)
NEEDS_CHROMIUM = pytest.mark.skipif(PROGRAM is None, reason="no Chromium: apt-get install chromium")
PATIENCE = 240.0
"""Longest wait for anything in the page, s: it ends a test of a page that waits for ever, on a busy machine too."""

SOLIDS = "**/api/machine/solids"

FLAGS = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-sandbox"]
FLAGS += ["--disable-gpu-compositing"]
"""Three-dimensional views are drawn by SwiftShader; the page itself without it, which saves a quarter of the time."""
ROOT = Path(__file__).parents[3]


@contextmanager
def client_of(folder: Path, base: str = "http://127.0.0.1:8321", **options: Any) -> Iterator[Any]:
    """Requests to the routes of a project, without a server."""
    from starlette.testclient import TestClient

    from workbench.page.project import Project
    from workbench.page.security import Guard
    from workbench.page.server import create_app

    guarded: Any = Guard(create_app(Project(folder, Path("build"))), frozenset({"127.0.0.1:8321"}))
    with TestClient(guarded, base_url=base, **options) as made:
        yield made


def refused(answer: Any, words: str) -> None:
    """A request is refused in one line that has these words."""
    error = answer.json()["error"]
    assert answer.status_code == 422 and words in error and "\n" not in error, answer.text


def result_of(client: Any, path: str, **body: Any) -> tuple[dict[str, Any], Any]:
    """A job that a route begins, once it is done, and its result."""
    answer = client.post(path, json=body)
    assert answer.status_code == 200, answer.text
    job, deadline = answer.json(), time.monotonic() + PATIENCE
    while job["state"] in ("waiting", "running"):
        assert time.monotonic() < deadline, job
        time.sleep(0.05)
        job = next(one for one in client.get("/api/jobs").json() if one["number"] == job["number"])
    assert (job["state"], job["error"]) == ("done", ""), job
    return job, client.get(f"/api/jobs/{job['number']}/result").json()


def started(folder: Path, *options: str) -> tuple[subprocess.Popen[str], str]:
    """A server of `stagecad workbench` in a folder, and its address."""
    command = [sys.executable, "-m", "workbench.cli", "workbench", "--no-browser", *options]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])}
    # What a shell starts in the background ignores Ctrl-C, and so would the server.
    heed = partial(signal.signal, signal.SIGINT, signal.SIG_DFL)
    server = subprocess.Popen(command, cwd=folder, env=environment, stderr=subprocess.PIPE, text=True, preexec_fn=heed)
    assert server.stderr is not None
    line = server.stderr.readline()
    found = re.search(r"http://\S+", line)
    assert found, line + server.stderr.read()
    return server, found[0]


def ended(server: subprocess.Popen[str]) -> None:
    """End a server with Ctrl-C."""
    server.send_signal(signal.SIGINT)
    try:
        server.wait(120.0)
    except subprocess.TimeoutExpired:
        server.kill()
        raise
    finally:
        assert server.stderr is not None
        server.stderr.close()


def killed(server: subprocess.Popen[str]) -> None:
    """End a server as a power cut does."""
    server.kill()
    server.wait()
    assert server.stderr is not None
    server.stderr.close()


@contextmanager
def serving(folder: Path, *options: str) -> Iterator[str]:
    """Address of `stagecad workbench` in a folder, at any free port; the server is ended with Ctrl-C."""
    server, address = started(folder, "--port", "0", *options)
    try:
        yield address
    finally:
        ended(server)


class Browser:
    """A page, with what went wrong in it and what it asked other servers for."""

    def __init__(self, page: Any, address: str) -> None:
        self.page, self.address, self.without_solids = page, address, False
        self.errors: list[str] = []
        self.outside: list[str] = []
        page.on("console", self._note_error)
        page.on("pageerror", lambda error: self.errors.append(str(error)))
        page.on("request", self._note)
        page.set_default_timeout(1e3 * PATIENCE)

    def leave_out_solids(self) -> None:
        """No solids: to make them takes longer than all the rest of most stories."""
        self.without_solids = True
        self.page.route(SOLIDS, lambda route: route.fulfill(status=422, json={"error": "not here"}))

    def with_solids(self) -> None:
        """Solids again."""
        self.without_solids = False
        self.page.unroute(SOLIDS)

    def _note_error(self, message: Any) -> None:
        refused = self.without_solids and message.location["url"].endswith("/api/machine/solids")
        if message.type == "error" and not refused:
            self.errors.append(message.text)

    def _note(self, request: Any) -> None:
        if not request.url.startswith((self.address.split("?")[0], "data:", "blob:")):
            self.outside.append(request.url)

    def open(self, view: str) -> None:
        self.page.goto(f"{self.address}#{view}")

    def open_checks(self) -> None:
        self.open("machine")
        self.page.wait_for_selector(".check >> nth=100")

    def expect_errors(self, text: str) -> None:
        """Errors of the console that have this text are no faults of the page."""
        self.errors = [error for error in self.errors if text not in error]


def enter(field: Any, text: str) -> None:
    field.fill(text)
    field.press("Enter")


def until(page: Any, holds: Callable[[], bool]) -> None:
    """Wait for a condition; the content policy of the page forbids Playwright's own way."""
    deadline = time.monotonic() + PATIENCE
    while not holds():
        assert time.monotonic() < deadline
        page.wait_for_timeout(20)


def faults_of_access(page: Any) -> list[Any]:
    """Rules of accessibility that the page breaks as it is shown now, in light and in dark."""
    axe = pytest.importorskip("axe_playwright_python", reason="pip install axe-playwright-python")
    page.evaluate((Path(axe.__file__).parent / "axe.min.js").read_text("utf-8"))
    found = []
    for theme in ("dark", "light"):
        page.evaluate("(theme) => { document.documentElement.dataset.theme = theme; }", theme)
        found += page.evaluate("async () => (await axe.run()).violations.map((one) => [one.id, one.nodes[0].html])")
    return found


@contextmanager
def chromium(*flags: str) -> Iterator[Any]:
    """A headless Chromium, with further flags."""
    playwright = pytest.importorskip("playwright.sync_api", reason="pip install playwright")
    with playwright.sync_playwright() as started:
        launched = started.chromium.launch(executable_path=PROGRAM, args=[*FLAGS, *flags])
        try:
            yield launched
        finally:
            launched.close()


@contextmanager
def looking(launched: Any, address: str) -> Iterator[Browser]:
    """A new user of a browser at an address; at the end nothing went wrong in the page."""
    context = launched.new_context(viewport={"width": 1280, "height": 800}, reduced_motion="reduce")
    try:
        page = context.new_page()
        browser = Browser(page, address)
        yield browser
        status = page.locator(".status").inner_text()
        assert not browser.errors, f"status bar: {status!r}; errors: {browser.errors}"
        assert not browser.outside, browser.outside
    finally:
        context.close()


@contextmanager
def browsing(address: str, *flags: str) -> Iterator[Browser]:
    """A headless Chromium of its own at an address."""
    with chromium(*flags) as launched, looking(launched, address) as browser:
        yield browser
