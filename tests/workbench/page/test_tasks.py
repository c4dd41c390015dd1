"""Jobs of the page as functions: a prediction with other values, and an optimisation."""

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from workbench.page.curves import read_curves
from workbench.page.tasks import measurement
from workbench.page.tasks.optimisation import optimize

EXAMPLE = Path(__file__).parents[3] / "examples" / "own_rig"


def _said(*step: Any) -> None:
    pass


@pytest.fixture(scope="module")
def rig(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return Path(shutil.copytree(EXAMPLE, tmp_path_factory.mktemp("project") / "rig"))


def _common(rig: Path, folder: str) -> dict[str, Any]:
    return {
        "experiment": str(rig),
        "params": None,
        "out": str(rig.parent / "build"),
        "folder": str(rig.parent / folder),
        "report": _said,
    }


def test_a_slider_changes_the_prediction_as_the_law_says(rig: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # The figures of the report take longer than all the rest.
    monkeypatch.setattr(
        "workbench.operations.measurement.compare.Comparison.write_report", lambda *rest: rig / "report.html"
    )
    compared = measurement.compare(**_common(rig, "compare"))
    sliders = {one["key"]: one for one in compared["sliders"]}
    force = sliders["coulomb.force"]
    assert force["low"] == pytest.approx(0.5 * force["value"]) and force["high"] == pytest.approx(1.5 * force["value"])
    first = compared["overlays"][0]
    where = {"record": first["record"], "channel": first["channel"]}
    same = measurement.predict(values={}, **where, **_common(rig, "same"))
    assert same["over_noise"]["fit"]["drive_force"] == pytest.approx(
        compared["document"]["before"]["fit"]["drive_force"]["over_noise"], rel=1e-6
    )
    wider = {"coulomb.force": force["value"] + 0.1, "unknown.key": 3.0}
    found = measurement.predict(values=wider, **where, **_common(rig, "moved"))
    (overlay,) = found["overlays"]
    series = dict(zip(overlay["series"], read_curves(rig.parent / "moved", overlay["curves"]), strict=True))
    change = (series["moved"] - series["model"])[np.isfinite(series["moved"])]
    # Coulomb friction of 0.1 N more has the sign of the velocity; filtering smooths its reversals.
    assert np.quantile(np.abs(change), 0.5) == pytest.approx(0.1, rel=0.05)
    assert change.min() < -0.09 and change.max() > 0.09
    assert found["over_noise"]["fit"]["drive_force"] > 2.0 * same["over_noise"]["fit"]["drive_force"]


@pytest.mark.slow
def test_an_optimisation_gives_changes_that_the_page_can_make(tmp_path: Path) -> None:
    steps: list[str] = []
    found = optimize(
        None,
        "",
        # Violates a rule, so that no solids are required.
        {"stage.thickness": "6.1 mm"},
        {"stage.thickness": "6 mm:30 mm"},
        ["sag of the drive surface over the travel"],
        30,
        str(tmp_path),
        lambda step, done, total: steps.append(step),
    )
    assert found["document"]["feasible"] and found["required"] == 1 and found["fronts"] == []
    assert list(found["changes"]) == ["stage.thickness"]
    assert 10.0 < float(found["changes"]["stage.thickness"].removesuffix("mm")) < 30.0
    assert any("designs" in step for step in steps)
