"""Results of a design go to other processes: they pickle, and give the same document there."""

import pickle
from pathlib import Path

import pytest

import stagecad
from workbench.operations.calculate import calculate
from workbench.operations.checks import chains, ranges_of, sweep
from workbench.operations.design import Design
from workbench.operations.result import Result


def _results() -> dict[str, Result]:
    design = stagecad.load_design()
    thicker = design.with_values({"stage.thickness": "14 mm"})
    return {
        "design": thicker,
        "checks": stagecad.checks(design, solids=False, proposals=False),
        "diff": stagecad.diff(design, thicker, solids=False),
        "sweep": sweep(design, ranges_of(design, ["stage.thickness=12mm:14mm:2"]), solids=False),
        "chains": chains(design),
        "calculation": calculate("hertz", design, {"load": "20 N"}),
    }


@pytest.fixture(scope="module")
def results() -> dict[str, Result]:
    return _results()


@pytest.mark.parametrize("name", ["design", "checks", "diff", "sweep", "chains", "calculation"])
def test_a_pickled_result_is_the_same(results: dict[str, Result], name: str) -> None:
    result = results[name]
    other = pickle.loads(pickle.dumps(result))
    assert repr(other) == repr(result) and "<table" in other._repr_html_()
    assert other.to_json() == result.to_json()
    assert len(other.to_dataframe()) == len(result.to_dataframe()) > 0


def test_a_pickled_design_needs_no_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "stage.toml"
    file.write_text('extends = "thesis"\n[stage]\nthickness = {value = "14 mm", origin = "assumed: stiffer"}\n')
    monkeypatch.chdir(tmp_path)
    design = Design.chosen(None, ("stage.width=272 mm",))
    assert design.path == Path("stage.toml") and Design.chosen(file).path == file
    data = pickle.dumps(design)
    file.unlink()
    other = pickle.loads(data)
    assert other.si("stage.thickness") == 0.014 and other.si("stage.width") == pytest.approx(0.272)
    assert other.values_with("stage.thickness=13 mm").si("stage.thickness") == 0.013
    assert Design.chosen(None).path is None
