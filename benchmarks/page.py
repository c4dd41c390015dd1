"""Speed of the workbench in a headless Chromium: opening, margins while a slider moves, curves of 10^6 samples.

    python -m benchmarks.page

Each time is the median of several. Opening: from the request to all checks with their margins on the page, with the
browser's cache warm. Margins: from the event of the slider to the first changed margin. Curves: from the call to drawn
plots of measurement, prediction and residual, whole record and zoomed.
"""

import json
import statistics
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from tests.workbench.page.served_page import browsing, serving
from workbench.page.curves import write_curves
from workbench.page.jobs import SCHEMA, Job

SAMPLES = 1_000_000
CANVAS = "--disable-accelerated-2d-canvas"
"""The browser without a display has no graphics processor: an emulated one is slower than none."""
LIMITS = {"opening": 1500.0, "margins": 100.0, "whole record": 200.0, "zoom": 200.0}
"""Targets, ms."""

OPENED = """() => new Promise((done) => {
  const look = () => document.querySelectorAll('.check .margin:not(:empty)').length > 100
    ? done(performance.now()) : requestAnimationFrame(look);
  look();
})"""

MARGINS = """(value) => new Promise((done) => {
  const slider = document.querySelector('[aria-label="stage.thickness, slider"]');
  const list = document.querySelector('.checks');
  const began = performance.now();
  const watch = new MutationObserver(() => {
    watch.disconnect();
    requestAnimationFrame(() => done(performance.now() - began));
  });
  watch.observe(list, { subtree: true, characterData: true, childList: true });
  slider.value = value;
  slider.dispatchEvent(new Event('input'));
})"""

OVERLAY = """async (one) => {
  const { Overlay } = await import('/overlay.js');
  const overlay = new Overlay();
  Object.assign(overlay.element.style, { position: 'fixed', inset: '10px', zIndex: 9 });
  document.body.append(overlay.element);
  overlay.show(1, [one]);
  await new Promise((done) => setTimeout(done, 1500));
  const timed = async (act) => {
    const began = performance.now();
    await act();
    await new Promise((done) => requestAnimationFrame(done));
    return performance.now() - began;
  };
  const found = { 'whole record': [], zoom: [] };
  for (let k = 0; k < 7; k++) {
    overlay.range = null;
    found['whole record'].push(await timed(() => overlay.build()));
    overlay.range = [one.to * (0.2 + 0.01 * k), one.to * (0.6 + 0.01 * k)];
    found.zoom.push(await timed(() => overlay.load()));
  }
  return found;
}"""


def job_with_curves(folder: Path) -> dict[str, Any]:
    """A finished job in the folder of a project, whose curves have 10^6 samples; its overlay."""
    time = np.arange(SAMPLES) * 1e-4
    random = np.random.default_rng(1)
    predicted = np.sin(time) + 0.1 * np.sign(np.cos(5.0 * time))
    measured = predicted + random.normal(0.0, 0.01, SAMPLES)
    place = folder / "build" / "workbench" / "jobs" / "00001"
    series = {"time": time, "measured": measured, "model": predicted, "residual:model": measured - predicted}
    stored = write_curves(place, 0, series)
    job = Job(1, "identification", "compare", "Compare", "rig", {}, state="done")
    (place / "job.json").write_text(json.dumps({"schema": SCHEMA, **job.as_json(), "arguments": {}}))
    (place / "result.json").write_text("{}")
    names = {"record": "long", "role": "fit", "channel": "friction_force", "unit": "N", "noise": 0.01}
    names |= {"largest": 1.1, "usual": 0.022}
    return {**stored, **names, "models": ["model"], "motion": {}}


def measured() -> dict[str, list[float]]:
    """Times by what is measured, ms."""
    found: dict[str, list[float]] = {}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        overlay = job_with_curves(folder)
        with serving(folder) as address, browsing(address, CANVAS) as browser:
            page = browser.page
            # Solids are made in a process of their own, and take the processor from what is measured.
            page.route("**/api/machine/solids", lambda route: route.fulfill(status=422, json={"error": "not here"}))
            times = []
            for _ in range(5):
                page.goto(f"{address}#machine")
                times.append(float(page.evaluate(OPENED)))
                page.reload()
                times.append(float(page.evaluate(OPENED)))
            found["opening"] = times[1:]
            page.wait_for_timeout(2000)
            found["margins"] = []
            for step in range(12):
                found["margins"].append(float(page.evaluate(MARGINS, f"{12.1 + 0.1 * step:.1f}")))
                page.wait_for_timeout(400)
            found |= page.evaluate(OVERLAY, overlay)
            browser.errors = [text for text in browser.errors if "422" not in text]
    return found


def main() -> None:
    """Print median and largest time of each, and the targets."""
    print(f"{'':14s} {'median':>9s} {'largest':>9s} {'target':>9s}")
    for name, times in measured().items():
        print(f"{name:14s} {statistics.median(times):6.0f} ms {max(times):6.0f} ms {LIMITS[name]:6.0f} ms")


if __name__ == "__main__":
    main()
