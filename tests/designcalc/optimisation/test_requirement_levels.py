"""Levels of Table 1 that can be met."""

from pathlib import Path

import pytest
from PIL import Image

from designcalc.checks.run import run_checks
from designcalc.optimisation import requirement_levels as module
from designcalc.optimisation.requirement_levels import Levels, LevelStudy, Price, Together
from designcalc.optimisation.search import read_range
from stagecad.parameters.file import read_parameter_file
from stagecad.parameters.load import load_design, variations_of
from workbench.figures.plot import save
from workbench.operations.design import Design
from workbench.operations.levels import ReachedLevels

TIPPING = "acceleration at the end of the travel without tipping"
PRODUCT = "PTFE pressure times speed"
PRELOAD = "acceleration of 1 G with the required preload"


@pytest.mark.slow
def test_levels_by_the_closed_form(monkeypatch: pytest.MonkeyPatch) -> None:
    """With the preload up to the load itself, mu (1 + 1) g; p v of the film is proportional to the speed."""
    monkeypatch.setattr(module, "LEVELS", tuple(one for one in module.LEVELS if one.name in ("speed", "acceleration")))
    monkeypatch.setattr(module, "FRONTS", ())
    design = load_design()
    free = [read_range("preload.ratio", "0.1:1", ":", design, "--free")]
    found = LevelStudy(lambda more: variations_of(read_parameter_file(), more), free, None, 20).levels()
    checks = {check.name: check for check in run_checks(design)}
    product = checks[PRODUCT]
    assert product.limit is not None and product.value is not None
    speed, acceleration = 0.2 * product.limit / product.value, 0.3 * 2 * 9.80665
    assert 0.97 * speed < found.alone["speed"] <= speed
    assert 0.97 * acceleration < found.alone["acceleration"] <= acceleration
    assert TIPPING in found.never["acceleration"]
    # The speed does not contradict the acceleration; checks of the smoothness of 1 nm, which is kept here, may.
    together = found.together[0].levels
    assert together["speed"] == pytest.approx(found.alone["speed"], rel=0.03)
    assert together["acceleration"] <= acceleration
    assert {(one.requirement, one.check) for one in found.prices} >= {("speed", PRODUCT), ("acceleration", PRELOAD)}


def _levels() -> Levels:
    required = {"resolution": 1e-8, "speed": 0.2, "acceleration": 9.80665, "smoothness": 1e-9}
    units = {"resolution": "m", "speed": "m/s", "acceleration": "m/s^2", "smoothness": "m"}
    found = Levels(required, units, {"acceleration": [TIPPING]}, {"speed": 0.03, "smoothness": 2.5e-7})
    found.together = [Together("", {**required, "speed": 0.02}), Together("speed", {})]
    found.prices = [Price("speed", PRODUCT, 2.8e6, 4e4, "Pa*m/s")]
    found.fronts = {("speed", "smoothness"): [(0.01, 3e-7), (0.02, 5e-7)]}
    return found


def test_report_and_document_of_the_levels(tmp_path: Path) -> None:
    result = ReachedLevels(Design(), _levels())
    report = result.report()
    assert "| speed | 200 mm/s | 30 mm/s | 20 mm/s | - |" in report
    assert f"- acceleration: {TIPPING}" in report and f"| speed 200 mm/s | {PRODUCT} |" in report
    document = result.to_json()
    assert document["alone"]["smoothness"] == {"value": 2.5e-7, "unit": "m"}
    assert document["together"][1] == {"kept": "speed", "levels": {}}
    save(result.plot(), tmp_path / "levels.png")
    with Image.open(tmp_path / "levels.png") as picture:
        assert picture.size[0] > 400


def test_options_that_the_study_does_not_use(command) -> None:
    said = command.refused("optimize", "--no-solids", "--levels", "--keep", "LVDT range", "--evaluations", "100")
    assert "--levels: not used with it: --keep, --evaluations" in said
