"""Make the pictures of the workbench in `docs/images`: python docs/make_workbench_pictures.py [machine]
[simulation] [import] [measurement] (needs Chromium).
"""

from __future__ import annotations

import io
import os
import re
import shutil
import subprocess
import sys
import tempfile
from contextlib import suppress
from pathlib import Path
from typing import Any

from PIL import Image

from stagecad.parameters.atomic import atomic_write_bytes

IMAGES = Path(__file__).parent / "images"
RECORDS = Path(__file__).parents[1] / "workbench" / "demo_records"
PROGRAMS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
FLAGS = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-sandbox"]
WIDTH, HEIGHT = 1440, 900
COLOURS = 200
PATIENCE = 180_000


def main() -> None:
    """Serve an empty folder, go through the views (those named, or all), and keep pictures of each."""
    views = {"machine": _machine, "simulation": _simulation, "import": _import, "measurement": _measurement}
    chosen = sys.argv[1:] or list(views)
    program = next((found for name in PROGRAMS if (found := shutil.which(name))), None)
    if program is None:
        sys.exit("no Chromium: apt-get install chromium")
    from playwright.sync_api import sync_playwright

    with tempfile.TemporaryDirectory() as above:
        folder = Path(above) / "stage"
        folder.mkdir()
        root = os.pathsep.join([str(Path(__file__).parents[1]), os.environ.get("PYTHONPATH", "")])
        command = [sys.executable, "-m", "workbench.cli", "workbench", "--no-browser", "--port", "0"]
        environment = {**os.environ, "PYTHONPATH": root}
        with subprocess.Popen(command, cwd=folder, env=environment, stderr=subprocess.PIPE, text=True) as server:
            assert server.stderr is not None
            address = re.search(r"http://\S+", server.stderr.readline())
            assert address is not None
            try:
                with sync_playwright() as started:
                    chromium = started.chromium.launch(executable_path=program, args=FLAGS)
                    page = chromium.new_page(viewport={"width": WIDTH, "height": HEIGHT})
                    page.set_default_timeout(PATIENCE)
                    for name in chosen:
                        views[name](page, address[0])
                    chromium.close()
            finally:
                server.terminate()
                with suppress(subprocess.TimeoutExpired):
                    server.wait(15.0)


def _machine(page: Any, address: str) -> None:
    _open(page, f"{address}#machine", "dark")
    page.locator("canvas[data-state=current]").wait_for()
    slider = page.get_by_label("stage.thickness, slider")
    slider.fill("14")
    slider.dispatch_event("change")
    page.locator("canvas[data-state=old]").wait_for()
    page.locator("canvas[data-state=current]").wait_for()
    page.locator(".row .name", has_text="thickness").first.click()
    page.locator(".check", has_text="tip stroke lost").click()
    page.locator("select[aria-label=section]").select_option("y")
    page.wait_for_timeout(1500)
    _keep(page, "workbench_machine")


def _simulation(page: Any, address: str) -> None:
    _open(page, f"{address}#simulation", "light")
    page.locator(".plot canvas").first.wait_for()
    page.wait_for_timeout(2000)
    _keep(page, "workbench_simulation")


def _import(page: Any, address: str) -> None:
    """The packaged records, dropped: a part of the first is chosen."""
    _open(page, f"{address}#measurement", "light")
    with page.expect_file_chooser() as chosen:
        page.locator(".dropzone").click()
    chosen.value.set_files([str(RECORDS / name) for name in ("fit.csv", "validate.csv")])
    dialog = page.get_by_role("dialog")
    dialog.get_by_label("name of the experiment").fill("slide")
    dialog.get_by_role("button", name="Upload").click()
    strip = dialog.locator(".strip").first
    strip.scroll_into_view_if_needed()
    box = strip.bounding_box()
    page.mouse.move(box["x"] + 0.1 * box["width"], box["y"] + 9)
    page.mouse.down()
    page.mouse.move(box["x"] + 0.8 * box["width"], box["y"] + 9, steps=5)
    page.mouse.up()
    page.wait_for_timeout(500)
    _keep(page, "workbench_import")
    dialog.get_by_role("button", name="Cancel").click()


def _measurement(page: Any, address: str) -> None:
    _open(page, f"{address}#measurement", "dark")
    page.locator(".offer", has_text="demo").click()
    page.locator(".map canvas").first.wait_for()
    for effect in ("stribeck", "magnetic cogging"):
        page.get_by_role("button", name="Diagnose", exact=True).click()
        # Both effects may be found at once; they are added one after another.
        page.locator(".verdict b", has_text=effect).wait_for()
        page.wait_for_timeout(1500)
        if effect == "stribeck":
            _keep(page, "workbench_diagnosis")
            _keep_small(page, "page_diagnosis")
        page.locator(f".candidate[data-effect='{effect.replace(' ', '_')}']").get_by_role("button", name="Add").click()
        page.locator(".rung", has_text=effect).wait_for()
        page.locator(".search progress").wait_for(state="detached")
    # Every rung of the ladder over the same record.
    for box in page.locator(".rung input.tick").all():
        box.check()
    page.wait_for_timeout(1500)
    _keep(page, "workbench_ladder")


def _open(page: Any, address: str, theme: str) -> None:
    page.goto(address)
    page.evaluate(f"() => localStorage.setItem('theme', '{theme}')")
    page.reload()


def _keep_small(page: Any, name: str) -> None:
    """Curves and candidates in a small window, whose letters can be read where README.md shows them smaller."""
    page.set_viewport_size({"width": 1240, "height": 620})
    page.wait_for_timeout(1500)
    box = page.locator("#measurement > .panel").nth(1).bounding_box()
    _keep(page, name, {"x": box["x"], "y": box["y"], "width": 1240 - box["x"], "height": box["height"]})
    page.set_viewport_size({"width": WIDTH, "height": HEIGHT})


def _keep(page: Any, name: str, clip: dict[str, float] | None = None) -> None:
    """Store what the page shows, or a part of it, as a PNG of few colours."""
    image = Image.open(io.BytesIO(page.screenshot(clip=clip))).convert("RGB")
    file = io.BytesIO()
    image.quantize(COLOURS, dither=Image.Dither.NONE).save(file, "PNG", optimize=True)
    atomic_write_bytes(IMAGES / f"{name}.png", file.getvalue())
    print(IMAGES / f"{name}.png")  # noqa: T201


if __name__ == "__main__":
    main()
