"""The checks find what does not fit together in the thesis, and pass once the design is changed as they propose."""

from __future__ import annotations

import json
from functools import cache

import numpy as np
import pytest

from designcalc.checks.check import Change, Check, Comparison, DesignInputs
from designcalc.checks.report import corrections, requirements
from designcalc.checks.run import changed_masses, evaluate_proposals, run_checks
from designcalc.checks.sweep import changing_checks, combinations, read_range, run_points, sweep_document
from designcalc.checks.tolerance import tolerance_study
from designcalc.friction_stage.calculated.alternatives import ranking
from designcalc.friction_stage.calculated.budget import budgets
from designcalc.friction_stage.checks import SUBJECTS
from stagecad.parameters.errors import InputError
from stagecad.parameters.load import load_design
from stagecad.parameters.mass_properties import BodyMasses, MassProperties
from tests.reference.tables import cases, reference
from tests.refusals import refused
from workbench.operations.result import finite

CASES = reference("contradictions")["check"]
BODY = MassProperties(8e-4, 2.1, (0.0, 0.0, 0.033), np.eye(3) * 0.01, ((-0.115, -0.135, 0.02), (0.115, 0.135, 0.04)))
TIP = MassProperties(8.5e-6, 0.023, (0.0, 0.0, 0.004), np.eye(3) * 4e-6, ((-0.03, -0.02, 0.0), (0.03, 0.03, 0.02)))
MASSES = BodyMasses(BODY, TIP)
CHANGED = [
    (c["name"], c[key], verdict) for c in CASES for key, verdict in (("pass", "passes"), ("break", "fails")) if key in c
]


def load(*overrides):
    return load_design(None, overrides, rules=False)


@cache
def named(*overrides) -> dict[str, Check]:
    return {check.name: check for check in run_checks(load(*overrides))}


@pytest.mark.parametrize("case", CASES, ids=lambda case: case["name"])
def test_contradictions_are_found(case):
    check = named()[case["name"]]
    assert check.verdict == case["verdict"]
    if "value" in case:
        assert check.value == pytest.approx(case["value"], rel=5e-3)
    assert case.get("thesis", "") in check.thesis
    if case["verdict"] == "fails":
        assert check.proposal


@pytest.mark.parametrize("name, changes, verdict", CHANGED, ids=[f"{name}, {verdict}" for name, _, verdict in CHANGED])
def test_what_a_check_proposes_passes_and_the_misprint_itself_would_fail(name, changes, verdict):
    checks = run_checks(load(*changes), None, (named()[name].subject,))
    assert {check.name: check.verdict for check in checks}[name] == verdict


def test_every_check_can_be_argued_with():
    checks = run_checks(load())
    assert len({check.name for check in checks}) == len(checks)
    assert {check.subject for check in checks} == set(SUBJECTS.checks)
    for check in checks:
        assert check.source and check.formula and check.inputs, check.name
        document = check.as_json()
        keys = {"name", "value", "limit", "margin", "verdict", "source", "formula", "inputs"}
        assert keys <= set(document) and document["verdict"] in ("passes", "fails", "out_of_range", "undecidable")
    json.dumps([check.as_json() for check in checks], allow_nan=False)


@pytest.mark.parametrize("value, limit, at_most, margin, verdict", [
    (8.0, 10.0, True, 0.2, "passes"), (12.0, 10.0, True, -0.2, "fails"), (12.0, 10.0, False, 0.2, "passes"),
    (8.0, 10.0, False, -0.2, "fails"), (10.0, 10.0, True, 0.0, "passes"), (-1.0, 0.0, False, -1.0, "fails"),
    (None, 1.0, True, None, "undecidable"), (float("nan"), 1.0, True, None, "undecidable"),
])  # fmt: skip
def test_margin_and_verdict(value, limit, at_most, margin, verdict):
    check = Check("n", Comparison(value, limit, "m", at_most), source="source", formula="f")
    assert check.margin == (None if margin is None else pytest.approx(margin)) and check.verdict == verdict


def test_mass_from_the_solids_is_used_and_a_calculator_out_of_range_says_so():
    checks = run_checks(load("teeth.gap=0.03 mm"))
    troubled = [check for check in checks if check.verdict == "out_of_range"]
    assert troubled and all("gap over pitch" in check.note for check in troubled)
    assert any(check.subject == "sensors" and check.verdict == "passes" for check in checks)
    design = load()
    name = "preload against the required share of the load"
    measured = next(c for c in run_checks(design, MASSES) if c.name == name)
    estimated = named()[name]
    assert measured.inputs["moving body mass"].value == 2.1
    assert "measured" in measured.inputs["moving body mass"].origin
    assert "estimated" in estimated.inputs["moving body mass"].origin
    assert measured.limit == pytest.approx(0.1 * (2.1 + 1.0) * 9.80665)


@pytest.mark.parametrize(
    "override",
    [
        ("preload.force=0 N", "payload.mass=0 kg"),
        ("environment.temperature_change=0 K", "environment.storage_change=0 K", "environment.floor_velocity=0 m/s"),
        ("piezo.loss_factor=0", "piezo.moving_mass=0 g", "piezo.strain_limit=0 MPa"),
        ("sensors.interferometer.misalignment=0 rad", "bearing.way_waviness=0 m"),
        ("actuator.phase=0 deg",),
        ("base.clamp_slot_1=45 mm",),
        ("actuator.fitted=3", "sea.whole_underside=true", "teeth.fitted=false", "stage.travel=20 mm"),
    ],
    ids=lambda override: override[0],
)
def test_extreme_designs_get_their_verdicts(override):
    """Nothing to heat, to shake or to preload: the checks still say something, and no check gets lost."""
    checks = run_checks(load(*override), MASSES)
    lost = 0 if "teeth.fitted=false" not in override else 9
    assert len(checks) == len(named()) - lost
    json.dumps([finite(check.as_json()) for check in checks], allow_nan=False)


def test_one_changed_parameter_moves_its_checks_and_four_pads_are_checked():
    before, after = named(), named("bearing_way.bolt_spacing=50 mm")
    moved_checks = {name for name in before if before[name].value != after[name].value}
    assert "bearing way stiffness" in moved_checks
    assert all("bearing_way.bolt_spacing" in after[name].inputs for name in moved_checks)
    checks = run_checks(load("pads.count=4", "teeth.fitted=false"))
    assert not [c for c in checks if c.subject == "magnetic teeth" or "teeth" in c.name]
    assert next(c for c in checks if c.name == "lightest pad load over the mean").value == pytest.approx(1.0)


def test_report_traces_the_requirements_and_names_the_corrections():
    checks, ranked = run_checks(load()), ranking(DesignInputs(load()))
    assert ranked[0].name == "sliding pads" and ranked[-1].name == "passive magnets"
    # every entry of both tables has a check, and no check bears on an entry that is in neither
    assert all(requirements(checks, SUBJECTS.requirements).values())
    assert {check.requirement for check in checks} - {""} == set(requirements(checks, SUBJECTS.requirements))
    assert len(corrections(checks)) >= 20
    # where the thesis is wrong and the design follows it, a change that would pass stands beside
    assert all(check.proposal for check in corrections(checks) if check.verdict == "fails")


def test_suspensions_are_ranked_by_the_sum_of_their_places():
    """Places worked out by hand: stiffness 1 3 2 4, smoothness 1 2 3 4, friction 4 1.5 3 1.5 and so on."""
    ranked = ranking(DesignInputs(load()))
    assert {c.name: c.places for c in ranked} == {
        "sliding pads": 1 + 1 + 4 + 2 + 1,
        "porous air bearing": 3 + 2 + 1.5 + 1 + 3,
        "ball on spring": 2 + 3 + 3 + 3 + 2,
        "passive magnets": 4 + 4 + 1.5 + 4 + 4,
    }


def test_budget_at_the_payload_is_the_sum_of_its_rows_and_turns_about_the_stage():
    design = load()
    found = {one.name: one for one in budgets(DesignInputs(design))}
    straight = {cause.name: e for cause, e in found["straightness"].rows}
    # a bow of 1 um over 280 mm, seen over 200 mm: sag (200/280)^2 um, slope 4 sag/200 mm at the pattern's corner, 75 mm
    sag = 1e-6 * (200 / 280) ** 2
    assert straight["bow of the ways"][2] == pytest.approx(sag)
    assert abs(straight["bow of the ways, pitch"][2]) == pytest.approx(4 * sag / 0.2 * 0.075, rel=1e-4)
    for one in found.values():
        sizes = [abs(e[one.axis]) for _, e in one.rows]
        assert sizes == sorted(sizes, reverse=True)
        random = np.sqrt(sum(e[one.axis] ** 2 for cause, e in one.rows if cause.random))
        fixed = sum(abs(e[one.axis]) for cause, e in one.rows if not cause.random)
        assert one.total[one.axis] == pytest.approx(random + fixed, rel=1e-3)


@pytest.mark.parametrize("text, words", cases("mistakes", "sweep"))
def test_a_bad_sweep_is_said(text, words):
    refused(words, read_range, text, load())


def test_a_sweep_may_be_quoted_and_weighs_a_thicker_plate():
    design = load()
    plain = read_range("stage.thickness=8 mm:20 mm:13", design)
    assert plain.values == tuple(float(v) for v in range(8, 21))
    assert read_range('stage.thickness="8 mm":"20 mm":13', design) == plain
    assert read_range("stage.thickness='8 mm':'0.02 m':13", design) == plain
    design, thick = load(), load("stage.thickness=15 mm")
    heavier = changed_masses(thick, design, MASSES)
    assert heavier.moving.mass - BODY.mass == pytest.approx(0.230 * 0.270 * 0.003 * 2700) and heavier.tip == TIP
    assert changed_masses(design, design, MASSES) == MASSES and changed_masses(thick, design, None) is None


def test_sweep_moves_the_margins_and_survives_a_refused_point():
    design = load()
    swept = read_range("bearing_way.bolt_spacing=30 mm:80 mm:3", design)
    assert swept.values == (30.0, 55.0, 80.0)

    def some(override):
        if "=80" in override:
            raise InputError("too far apart")
        return load(override)

    points = run_points([swept], combinations([swept]), some, design, None)
    assert points[2].refused == "too far apart" and not points[2].checks
    assert changing_checks(points)[0] == "bolt spacing against its optimum"  # its verdict changes
    document = sweep_document([swept], points)
    row = document["checks"]["bearing way stiffness"]
    assert row["value"][0] != row["value"][1] and row["value"][2] is None
    assert document["values"][1] == {"value": 0.055, "unit": "m"}
    counts = read_range("pads.count=3:4:2", design)
    assert counts.override(int(counts.values[0])) == "pads.count=3"


def test_tolerances_spread_a_margin_as_its_closed_form():
    """Wall a - d/2 against d/4, with a and d drawn directly."""
    study = tolerance_study(load(), load, None, samples=100_000, subjects=("bearing ways", "height adjustment"))
    spread = next(s for s in study.spreads if s.name == "ceramic remaining beside the way's bolt holes")
    rng = np.random.default_rng(99)
    a, d = 10 + rng.uniform(-0.1, 0.1, 200_000), 10.5 + rng.uniform(-0.1, 0.1, 200_000)
    margin = (a - d / 2) / (d / 4) - 1
    assert spread.low == pytest.approx(np.quantile(margin, 0.05), abs=1e-3)
    assert spread.high == pytest.approx(np.quantile(margin, 0.95), abs=1e-3)
    assert spread.leading == "bearing_way.bolt_edge"
    assert len(study.matter_most) == 3 and len(study.could_be_loosened) == 3
    assert study.matter_most[0].share >= study.matter_most[1].share
    assert study.could_be_loosened[0].plus_minus <= study.could_be_loosened[-1].plus_minus
    json.dumps(study.as_json())


def test_what_could_be_loosened_fails_no_check_and_a_proposal_undoes_nothing_set() -> None:
    design = load()
    study = tolerance_study(design, load, MASSES, samples=100, subjects=("tolerance chains", "magnetic teeth"))
    # Loosened to X.X, its chain would fail.
    assert "stage.iron_pocket_depth" not in {one.key for one in study.could_be_loosened}
    design, change = load("stage.thickness=11 mm"), Change("stage.thickness", "12 mm")
    compared = Comparison(2.0, 1.0, "m", True)
    check = Check("bending", compared, source="", formula="", proposal="stiffer", changes=(change,))
    (found,) = evaluate_proposals([check], design, None, lambda override: load("stage.thickness=11 mm", override))
    assert "passes, and no other check then fails" not in found.proposal
