"""Optimisation of designs: nearest design, conflicts, relaxations, and levels of Table 1 that can be met."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from designcalc.checks.run import run_checks
from designcalc.optimisation import requirement_levels as module
from designcalc.optimisation.conflicts import irreducible
from designcalc.optimisation.optimise import optimise, required_checks
from designcalc.optimisation.requirement_levels import Levels, LevelStudy, Price, Together
from designcalc.optimisation.search import Evaluator, free_parameters, read_range, repair, start_point, values_at
from stagecad.parameters.file import read_parameter_file
from stagecad.parameters.load import load_design, variations_of
from stagecad.parameters.rules import violations
from tests.reference.tables import cases
from tests.refusals import refused
from workbench.figures.plot import save
from workbench.operations.design import Design
from workbench.operations.levels import ReachedLevels

STROKE, PRESSURE = "piezo stroke of the drive", "tip contact pressure"
LIFT, BENDING, SAG = (
    "acceleration of 1 G without lift-off",
    "bending of the stage above the tip",
    "sag of the drive surface over the travel",
)


def _evaluator(freed: Sequence[str], *overrides: str) -> Evaluator:
    variations = variations_of(read_parameter_file(), overrides)
    given = [read_range(*text.partition("=")[::2], ":", variations.design, "--free") for text in freed]
    return Evaluator(variations, given)


def test_nearest_stroke_by_the_closed_form() -> None:
    """2 A <= 17 um: 8.5 um from above, no change from below."""
    found = optimise(_evaluator(["actuator.stroke_amplitude=4 um:12 um"]), [STROKE], 40)
    assert found.feasible
    (change,) = found.changes
    assert change.key == "actuator.stroke_amplitude" and change.needed_by == (f"'{STROKE}'",)
    assert load_design(None, [f"{change.key}={change.after}"]).si(change.key) == pytest.approx(8.5e-6, rel=5e-3)
    evaluator = _evaluator(["actuator.stroke_amplitude=4 um:12 um"], "actuator.stroke_amplitude=6 um")
    below = optimise(evaluator, [STROKE], 40)
    assert below.feasible and not below.changes


def test_a_value_is_rounded_only_as_far_as_the_design_stays_near() -> None:
    """2 A <= 17.9 um from 10 um: 8.95 um, where 8.9 um has two digits and a change that is 5 % larger."""
    evaluator = _evaluator(["actuator.stroke_amplitude=4 um:12 um"], "piezo.stroke=17.9 um")
    (change,) = optimise(evaluator, [STROKE], 60).changes
    stroke = load_design(None, [f"{change.key}={change.after}"]).si(change.key)
    assert 10e-6 - 1.05e-6 / 0.98 <= stroke <= 8.95e-6 * (1 + 1e-9)


@pytest.mark.slow
def test_nearest_nose_by_bisection() -> None:
    """The contact pressure falls with the radius of the nose: the least one, found independently."""

    def passes(radius: float) -> bool:
        checks = run_checks(load_design(None, [f"tip.nose_radius={radius} mm"]), None, ("tip on stage",))
        return next(one.verdict for one in checks if one.name == PRESSURE) == "passes"

    low, high = 20.0, 60.0
    for _ in range(8):
        low, high = (low, (low + high) / 2) if passes((low + high) / 2) else ((low + high) / 2, high)
    evaluator = _evaluator(["tip.nose_radius=15 mm:60 mm", "bearing.way_roughness=10 nm:1 um"])
    found = optimise(evaluator, [PRESSURE], 60)
    assert found.feasible
    (change,) = found.changes  # the other parameter is taken back
    assert low <= 1e3 * load_design(None, [f"{change.key}={change.after}"]).si("tip.nose_radius") <= 1.04 * high


def test_start_that_violates_rules() -> None:
    """Pads of 30 mm by 12 mm are not 2 : 1 and run off the way; within 5 % are lengths up to 25.2 mm."""
    found = optimise(_evaluator(["pads.length=20 mm:32 mm"], "pads.length=30 mm"), [], 40)
    assert found.before.violated and found.feasible
    (change,) = found.changes
    design = load_design(None, [f"pads.length={change.after}"])
    assert violations(design) == [] and 24.5 <= design.pads.length <= 25.2
    assert change.needed_by[0].startswith("the rule")


@pytest.mark.slow
def test_lengths_that_many_rules_tie_together_are_found_by_their_remedies() -> None:
    """300 mm of travel need longer ways, stage, base, bars and clamp screws; random designs do not find them."""
    lengths = {
        "bearing_way.length": "280 mm:500 mm",
        "stage.length": "230 mm:450 mm",
        "base.length": "360 mm:600 mm",
        "tooth_bar.length": "280 mm:500 mm",
        "tooth_bar.screw_span": "265 mm:490 mm",
        "base.bracket_spacing_along": "335 mm:590 mm",
        "screws.clamp_long.length": "150 mm:300 mm",
        "screws.clamp_short.length": "100 mm:250 mm",
    }
    evaluator = _evaluator([f"{key}={ends}" for key, ends in lengths.items()], "stage.travel=300 mm")
    assert violations(evaluator.base)
    repair(evaluator)
    found = evaluator.archive[-1]
    assert not found.violated and not found.refused
    texts = [f"{key}={value} mm" for key, value in found.values.items()]
    assert not violations(load_design(None, ["stage.travel=300 mm", *texts]))


@pytest.mark.slow
def test_irreducible_conflict_is_verified_by_leaving_out_each_member() -> None:
    """A light stage against a stiff one: with the sag, which both allow, three requirements."""
    freed = ["stage.thickness=10 mm:30 mm"]
    found = optimise(_evaluator(freed), [LIFT, BENDING, SAG], 40)
    assert not found.feasible and [set(one.names) for one in found.conflicts] == [{LIFT, BENDING}]
    for left_out in (LIFT, BENDING):
        rest = [name for name in (LIFT, BENDING, SAG) if name != left_out]
        assert optimise(_evaluator(freed), rest, 40).feasible
    # An independent search: no thickness of a fine grid satisfies both.
    evaluator = _evaluator(freed)
    for place in np.linspace(0, 1, 41):
        assert evaluator.at(np.array([place]), (LIFT, BENDING)).unmet
    relax = {one.name: one for one in found.relax}
    assert set(relax) == {LIFT, BENDING} and all(one.margin < 0 and one.keeping for one in relax.values())


def test_a_certain_check_and_no_conflict_where_a_design_exists() -> None:
    found = optimise(_evaluator(["stage.thickness=10 mm:30 mm"]), ["LVDT range", SAG], 40)
    assert not found.feasible and [(one.names, one.fixed) for one in found.conflicts] == [(("LVDT range",), True)]
    # All others are met by the design that is given along.
    assert found.design.satisfies([SAG])
    assert irreducible(_evaluator(["stage.thickness=10 mm:30 mm"]), [LIFT, SAG], 40) is None


def test_ranges_choices_and_required_checks() -> None:
    design = load_design()
    assert {"stage.thickness", "tip.material"} <= {one.key for one in free_parameters(design, ())}
    (one,) = [one for one in free_parameters(design, ["stage.thickness=11 mm:13 mm"]) if one.key == "stage.thickness"]
    assert (one.low, one.high, one.value(0.5), one.distance(13.0)) == (11.0, 13.0, 12.0, 0.5)
    choice = read_range("tip.material", "alumina | al_6061_t6", "..", design, "free")
    assert [choice.value(place) for place in (0.0, 0.4, 0.6, 1.0)] == ["alumina"] * 2 + ["al_6061_t6"] * 2
    free = (one, choice)
    assert values_at(free, start_point(free)) == {"stage.thickness": 12.0, "tip.material": "al_6061_t6"}
    wide = read_range("bearing.way_roughness", "10 nm..10 um", "..", design, "free")
    assert wide.value(0.5) == pytest.approx(10**-6.5)
    checks = run_checks(load_design(), subjects=("error budget", "friction drive"))
    assert required_checks(checks, [STROKE]) == (STROKE,) and len(required_checks(checks, ["error budget*"])) == 4
    assert len(required_checks(checks, [])) == len(checks)
    refused("did you mean 'piezo stroke of the drive'", required_checks, checks, ["piezo strok of the drive"])


@pytest.mark.parametrize("text, words", cases("mistakes", "free"))
def test_free_parameters_that_are_none(text: str, words: str) -> None:
    refused(words, free_parameters, load_design(), [text])


@pytest.mark.parametrize(
    "overrides, freed, required, inside",
    [
        # 4 Ra <= t/4.
        (
            ["bearing.way_roughness=2 um", "bearing.film_thickness=2 um"],
            ["bearing.way_roughness=10 nm:2 um", "bearing.film_thickness=1 um:3 um"],
            ["way roughness against the PTFE film"],
            lambda d: 4 * d.si("bearing.way_roughness") <= 0.25 * d.si("bearing.film_thickness") * (1 + 1e-9),
        ),
        # mu (1 + p) g >= 1 G, and a pad of two to one, a rule that the start violates.
        (
            ["preload.ratio=0.2", "pads.length=30 mm"],
            ["preload.ratio=0.1:4", "pads.length=20 mm:32 mm"],
            ["acceleration of 1 G with the required preload"],
            lambda d: 0.3 * (1 + d.value("preload.ratio")) >= 1 - 1e-9 and abs(d.pads.length / d.pads.width - 2) <= 0.1,
        ),
    ],
)
def test_starting_designs_outside_a_known_feasible_region(overrides, freed, required, inside) -> None:
    evaluator = _evaluator(freed, *overrides)
    assert not inside(evaluator.base)
    found = optimise(evaluator, required, 60)
    assert found.feasible
    design = evaluator.design(found.design.values)
    assert inside(design) and violations(design) == []


def test_ends_within_its_evaluations_and_leaves_out_what_the_best_compromise_fails() -> None:
    """A light stage against a stiff one, and the stroke, which one change meets."""
    freed = ["stage.thickness=10 mm:30 mm", "actuator.stroke_amplitude=4 um:12 um"]
    found = optimise(_evaluator(freed), [LIFT, BENDING, STROKE], 40, evaluations=110)
    assert not found.complete and not found.feasible and set(found.left_out) in ({LIFT}, {BENDING})
    assert found.design.satisfies({LIFT, BENDING, STROKE}.difference(found.left_out))
    assert STROKE in {name for change in found.changes for name in (word.strip("'") for word in change.needed_by)}
    # What rounds the values and states the reasons is not limited.
    assert found.evaluations <= 110 + 40
    assert not optimise(_evaluator(freed), [LIFT, BENDING, STROKE], 40, seconds=1e-3).complete


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
    product = {check.name: check for check in run_checks(design)}[PRODUCT]
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
