"""The nearest design from Python, and what is refused."""

import json

import pytest

import stagecad
from stagecad import InputError
from workbench.operations.measurement.new_experiment import propose
from workbench.operations.optimise import marked_free, need_free, optimize

SAG = "sag of the drive surface over the travel"
THIN = {"stage.thickness": "6.1 mm"}


def test_the_design_found_passes_what_was_required() -> None:
    thin = stagecad.load_design(values=THIN, rules=False)
    assert stagecad.checks(thin, solids=False, proposals=False)[SAG].verdict == "fails"
    steps: list[tuple[str, int, int]] = []
    found = optimize(
        thin, {"stage.thickness": "6 mm:30 mm"}, [SAG], only=True, budget=30, progress=lambda *step: steps.append(step)
    )
    assert found.feasible and list(found.changes) == ["stage.thickness"] and found.unverified == []
    better = thin.with_values(found.changes)
    assert stagecad.checks(better, solids=False, proposals=False)[SAG].verdict == "passes"
    # It is near the limit: half of the change is not enough.
    half = 0.5 * (thin.si("stage.thickness") + better.si("stage.thickness"))
    less = thin.with_values({"stage.thickness": f"{1e3 * half} mm"})
    assert stagecad.checks(less, solids=False, proposals=False)[SAG].verdict == "fails"
    table = found.to_dataframe()
    assert table.loc["stage.thickness", "before"] == "6.1 mm" and SAG in table.loc["stage.thickness", "reason"]
    assert max(done for _, done, _ in steps) == found.outcome.evaluations
    assert "1 changes" in repr(found) and found.plot().axes
    json.dumps(found.to_json(), allow_nan=False)


def test_a_fault_names_the_key_and_no_option_of_the_command() -> None:
    design = stagecad.load_design()
    assert marked_free(design)["stage.thickness"] == "10 mm:30 mm"
    for free, message in (
        ({"stage.thicknes": "1 mm:2 mm"}, "did you mean 'stage.thickness'"),
        ({"stage.thickness": "thick"}, r"^stage\.thickness = 'thick': write LOW:HIGH"),
        ({"stage.thickness": "1 kg:2 kg"}, r"^stage\.thickness: '1 kg' has the wrong dimension"),
    ):
        with pytest.raises(InputError, match=message):
            need_free(design, free)
    with pytest.raises(InputError, match=r"^'bendin of the stage': no such check"):
        optimize(design, keep=["bendin of the stage"], solids=False)
    with pytest.raises(InputError, match=r"^'velocity-drivr' .*; did you mean 'velocity-drive'"):
        propose(["any.csv"], "velocity-drivr")
