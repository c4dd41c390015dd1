"""Jobs of the page as functions, and curves whose decimation loses no spike."""

import shutil
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.refusals import refused
from workbench.page.curves import extremes, read_curves, sampled, write_curves
from workbench.page.tasks import measurement

EXAMPLE = Path(__file__).parents[3] / "examples" / "own_rig"


@pytest.fixture(scope="module")
def rig(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return Path(shutil.copytree(EXAMPLE, tmp_path_factory.mktemp("project") / "rig"))


def _common(rig: Path, folder: str) -> dict[str, Any]:
    places = {"experiment": str(rig), "out": str(rig.parent / "build"), "folder": str(rig.parent / folder)}
    return {**places, "params": None, "report": lambda *step: None}


def test_a_slider_changes_the_prediction_as_the_law_says(rig: Path, monkeypatch) -> None:
    # The figures of the report take longer than all the rest.
    written = "workbench.operations.measurement.compare.Comparison.write_report"
    monkeypatch.setattr(written, lambda *rest: rig / "report.html")
    compared = measurement.compare(**_common(rig, "compare"))
    force = {one["key"]: one for one in compared["sliders"]}["coulomb.force"]
    assert force["low"] == pytest.approx(0.5 * force["value"]) and force["high"] == pytest.approx(1.5 * force["value"])
    first = compared["overlays"][0]
    where = {"record": first["record"], "channel": first["channel"]}
    same = measurement.predict(values={}, **where, **_common(rig, "same"))
    before = compared["document"]["before"]["fit"]["drive_force"]["over_noise"]
    assert same["over_noise"]["fit"]["drive_force"] == pytest.approx(before, rel=1e-6)
    wider = {"coulomb.force": force["value"] + 0.1, "unknown.key": 3.0}
    found = measurement.predict(values=wider, **where, **_common(rig, "moved"))
    (overlay,) = found["overlays"]
    series = dict(zip(overlay["series"], read_curves(rig.parent / "moved", overlay["curves"]), strict=True))
    change = (series["moved"] - series["model"])[np.isfinite(series["moved"])]
    # Coulomb friction of 0.1 N more has the sign of the velocity; filtering smooths its reversals.
    assert np.quantile(np.abs(change), 0.5) == pytest.approx(0.1, rel=0.05)
    assert change.min() < -0.09 and change.max() > 0.09
    assert found["over_noise"]["fit"]["drive_force"] > 2.0 * same["over_noise"]["fit"]["drive_force"]


def test_curves_by_extremes_samples_and_pairs(tmp_path: Path) -> None:
    time = np.linspace(0.0, 100.0, 1_000_000)
    values = np.sin(time)
    values[123_456], values[765_432] = 50.0, -40.0
    described = write_curves(tmp_path, 0, {"time": time, "force": values})
    assert described["rows"] == 1_000_000 and described["series"] == ["time", "force"]
    curves = read_curves(tmp_path, 0)
    found = extremes(curves, [1], None, None, 1200)
    assert found.shape == (2, 2400) and found[1].max() == 50.0 and found[1].min() == -40.0
    assert np.all(np.diff(found[0]) > 0.0)
    random = np.random.default_rng(4)
    time, values = np.arange(400_001.0), random.normal(size=400_001)
    values[1000:9000] = np.nan
    write_curves(tmp_path, 0, {"time": time, "force": values})
    curves = read_curves(tmp_path, 0)
    found = extremes(curves, [1], 100_000.5, 399_000.0, 300)
    ends = np.append(found[0, 0::2], 399_002.0).astype(int)
    assert ends[0] == 100_000
    for k, (a, b) in enumerate(pairwise(ends)):
        assert (found[1, 2 * k], found[1, 2 * k + 1]) == (values[a:b].min(), values[a:b].max())
    whole = extremes(curves, [1], None, None, 400)
    assert np.nanmin(whole[1]) == np.nanmin(values) and np.nanmax(whole[1]) == np.nanmax(values)
    assert np.isnan(whole[1]).any()
    refused("curves 3", read_curves, tmp_path, 3)
    time = np.arange(100_000.0)
    values = time.copy()
    values[50_010:50_020] = np.nan
    found = extremes(np.vstack([time, values]), [1], 50_000.0, 50_100.0, 800)
    assert found[0][0] == 49_999.0 and found[0][-1] == 50_101.0 and np.isnan(found[1]).sum() == 10
    coarse = extremes(np.vstack([time, np.full(time.size, np.nan)]), [1], None, None, 100)
    assert np.isnan(coarse[1]).all()
    time = np.linspace(0.0, 1.0, 5001)
    found = sampled(np.vstack([time, time**2, time**3]), [1, 2], 0.2, 0.8, 400)
    assert found.shape[1] <= 400 and found[0][0] >= 0.2 and found[0][-1] <= 0.8
    assert found[1] == pytest.approx(found[0] ** 2) and found[2] == pytest.approx(found[0] ** 3)
