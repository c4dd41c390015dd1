"""Sweeps of checks, proposals for what fails, and checks that are formulas."""

from __future__ import annotations

import json
import re
from dataclasses import replace

import numpy as np
import pytest

from designcalc.bearing.sliding import crown_wear_depth, crown_wear_distance, friction_heat
from designcalc.checks.check import Change, DesignInputs, FormulaCheck, change
from designcalc.checks.run import evaluate_proposals, run_checks
from designcalc.checks.sweep import SOLIDS, combinations, masses_over, read_range, run_points, sweep_document
from designcalc.drive.friction_drive import acceleration_limit, preload_ratio_for, resonance
from designcalc.drive.height_adjustment import wedge_drive
from designcalc.drive.piezo_stack import stack_current, stack_heat
from designcalc.drive.tip_ellipse import frequency_for, speed_of
from designcalc.errors import sensors
from designcalc.friction_stage.checks import SUBJECTS
from designcalc.friction_stage.quantities import QUANTITIES, stated
from stagecad.parameters.errors import InputError
from stagecad.parameters.formula import Value, parse_formula
from stagecad.parameters.load import load_design
from stagecad.parameters.mass_properties import MassProperties, PartMasses
from stagecad.parameters.rules import violations
from stagecad.solids.assembly.built_machine import body_masses
from tests.refusals import refused

VALUES = np.linspace(1.0, 2.0, 50)
DESIGN = load_design(None, ())


def test_each_point_is_the_design_with_both_values() -> None:
    base = load_design()
    ranges = [read_range(text, base) for text in ("tip.nose_radius=10 mm:30 mm:2", "stage.travel=200 mm:300 mm:2")]
    found = combinations(ranges)
    assert found == [(10.0, 200.0), (10.0, 300.0), (30.0, 200.0), (30.0, 300.0)]
    load = lambda *words: load_design(None, words)  # noqa: E731
    points = run_points(ranges, found, load, base, None)
    assert [bool(point.refused) for point in points] == [False, True, False, True]
    alone = run_checks(load_design(None, ["tip.nose_radius=30 mm"]))
    # Without texts a check has the same numbers and verdict.
    assert [(c.name, c.value, c.limit, c.verdict) for c in points[2].checks] == [
        (c.name, c.value, c.limit, c.verdict) for c in alone
    ]
    assert all(check.source for check in alone) and not points[2].checks[0].substituted
    document = sweep_document(ranges, points)
    json.dumps(document)
    assert document["points"][2]["values"] == [{"value": 0.03, "unit": "m"}, {"value": 0.2, "unit": "m"}]
    assert document["points"][1]["failing"] is None and "run off the way" in document["points"][1]["refused"]
    assert document["checks"]["tip contact pressure"]["verdict"][::2] == ["fails", "passes"]


def test_values_without_a_grid_or_a_solid_have_their_reason() -> None:
    base = load_design()
    one = read_range("tip.nose_radius=10 mm:30 mm:200", base)
    refused("given twice", combinations, [one, one])
    with pytest.raises(InputError, match="40000 combinations; at most 10000"):
        combinations([one, read_range("stage.thickness=10 mm:30 mm:200", base)])

    def masses_at(place: int) -> PartMasses:
        if VALUES[place] > 1.7:
            raise InputError("no solid")
        return plate(VALUES[place], 0.0)

    found = masses_over(VALUES.tolist(), masses_at)
    assert [isinstance(one, str) for one in found] == [bool(value > 1.7) for value in VALUES]
    made: list[int] = []
    masses_over(list(range(20)), lambda place: made.append(place) or plate(1.0, 0.0), interpolate=False)
    assert made == list(range(20))


def plate(thickness: float, hole: float) -> PartMasses:
    """A plate of 1 m by 1 m with a blind hole of depth 1.5 m, which goes through thinner plates."""
    volume = thickness - hole * min(thickness, 1.5)
    centre = (0.5 * thickness**2 - hole * 0.5 * min(thickness, 1.5) ** 2) / volume
    one = MassProperties(volume, volume, (0, 0, centre), np.eye(3) * volume, ((0, 0, 0), (1, 1, thickness)))
    return PartMasses({"plate": one})


@pytest.mark.parametrize("hole, most", [(0.1, 30), (0.0, SOLIDS)])
def test_few_solids_give_the_masses_of_all(hole: float, most: int) -> None:
    made: list[int] = []

    def masses_at(place: int) -> PartMasses:
        made.append(place)
        return plate(VALUES[place], hole)

    found = masses_over(VALUES.tolist(), masses_at)
    assert len(made) == len(set(made)) <= most
    for value, one in zip(VALUES, found, strict=True):
        assert isinstance(one, PartMasses)
        expected = plate(value, hole).parts["plate"]
        assert one.parts["plate"].mass == pytest.approx(expected.mass, rel=1e-7)
        assert one.parts["plate"].centre_of_mass == pytest.approx(expected.centre_of_mass, abs=1e-7)


@pytest.mark.slow
def test_the_stage_between_solids_weighs_what_its_solid_weighs() -> None:
    values = np.linspace(11.0, 13.0, 9).tolist()
    made: list[int] = []

    def masses_at(place: int):
        made.append(place)
        return body_masses(load_design(None, [f"stage.thickness={values[place]} mm"]))

    found, place = masses_over(values, masses_at), min(set(range(9)) - set(made))
    exact = masses_at(place)
    assert not isinstance(found[place], str)
    assert found[place].moving.mass == pytest.approx(exact.moving.mass, rel=1e-8)
    assert np.allclose(found[place].moving.inertia, exact.moving.inertia, rtol=0, atol=1e-9)


def load(override: str):
    return load_design(None, (override,), rules=False)


@pytest.fixture(scope="module")
def evaluated():
    return evaluate_proposals(run_checks(DESIGN), DESIGN, None, load)


def test_every_change_says_what_a_run_with_it_shows(evaluated):
    """Each change is made again here, by itself, and all checks are run."""
    before = {check.name: check.verdict for check in evaluated}
    changes = [(check, one) for check in evaluated for one in check.changes]
    assert len(changes) > 15
    # Of the packaged machine each is enough for its own check, or cannot be made; most break nothing else.
    assert not [one.override for _, one in changes if "not enough" in one.result]
    assert sum(not one.result for _, one in changes) > 0.7 * len(changes)
    # One of every outcome is enough to run in full.
    outcomes = {one.result.split(" ")[0]: (check, one) for check, one in changes}
    assert {"", "passes,", "cannot"} <= set(outcomes)
    for check, one in outcomes.values():
        if one.result.startswith("is refused"):
            with pytest.raises(InputError):
                load(one.override)
            continue
        design = load(one.override)
        after = {c.name: c.verdict for c in run_checks(design)}
        worse = [name for name, verdict in after.items() if verdict != "passes" and before.get(name) == "passes"]
        if one.result == "":
            assert after[check.name] == "passes" and not worse and not violations(design)
            assert f"{one.key} = {one.text} passes, and no other check then fails" in check.proposal
        elif one.result.startswith("passes"):
            assert after[check.name] == "passes" and worse and repr(worse[0]) in one.result
        else:
            assert one.result.startswith("cannot") and violations(design)
    shim = next(c for c in evaluated if c.name == "range of the adjustment against the thickest shim")
    assert [one.key for one in shim.changes] == ["shim.thickest", "height_pin_1.stroke"]
    assert "height_pin_1.stroke" not in shim.proposal and "shim.thickest = 500 um passes" in shim.proposal


def test_a_refused_or_insufficient_change_says_so():
    check = next(c for c in run_checks(DESIGN) if c.name == "piezo stroke of the drive")
    changes = (Change("actuator.stroke_amplitude", "9 um"), Change("actuator.stroke_amplitude", "-1 um"))
    checks = [replace(c, changes=changes if c.name == check.name else ()) for c in run_checks(DESIGN)]
    (found,) = [c for c in evaluate_proposals(checks, DESIGN, None, load) if c.name == check.name]
    assert [one.result.split(":")[0] for one in found.changes] == ["is not enough", "is refused"]
    assert "actuator.stroke_amplitude = 9 um is not enough" in found.proposal


@pytest.mark.parametrize(
    "value, up, text",
    [(0.027468, True, "27.5 mm"), (0.027468, False, "27.4 mm"), (0.02, True, "20 mm"), (1.2e-9, False, "1.2 nm")],
)
def test_a_change_is_rounded_to_the_safe_side(value, up, text):
    (one,) = change("tip.nose_radius", value, "m", up=up)
    assert one.override == f"tip.nose_radius={text}"
    assert change("tip.nose_radius", float("inf"), "m", up=up) == ()


R = DesignInputs(DESIGN)
FUNCTIONS = [one for functions in SUBJECTS.checks.values() for one in functions(DESIGN)]
CHECKS = {one.name: one for one in FUNCTIONS if isinstance(one, FormulaCheck)}
RUN = {check.name: check for check in run_checks(DESIGN)}
NUMBER = re.compile(r"(?<![\w.^])(\d+\.?\d*)(e[+-]?\d+)?(?![\w.])")


def _number(text: str) -> float:
    return parse_formula(text).evaluate(lambda key: Value(float("nan"), ())).si


def _shown_within(text: str, formula: str) -> tuple[float, float]:
    """The value of a formula of numbers, and how much it changes with half of the last of four digits of each.

    Numbers without unit that the formula itself has are exact.
    """
    value, change = _number(text), 0.0
    exact = {match[0] for match in NUMBER.finditer(formula)}
    for match in NUMBER.finditer(text):
        if match[0] in exact and not re.match(" [A-Za-z]", text[match.end() :]):
            continue
        moved = repr(float(match[0]) * (1 + 5e-4))
        change += abs(_number(text[: match.start()] + moved + text[match.end() :]) - value)
    return value, change


@pytest.mark.parametrize("name", RUN)
def test_the_numbers_that_are_shown_give_the_value_and_the_limit(name: str) -> None:
    check = RUN[name]
    assert check.value is not None and check.limit is not None
    sides = re.split(" <= | >= ", check.substituted)
    for text, right in zip(sides, (check.value, check.limit), strict=True):
        value, change = _shown_within(text, check.formula)
        assert value == pytest.approx(right, rel=1e-11, abs=1.01 * change)
        assert change <= 0.02 * abs(value) or value == 0.0 or "-" in text, "rounding hides the value"


def test_no_check_is_left_out_and_the_formulas_are_those_of_the_calculators() -> None:
    assert len(RUN) == len(FUNCTIONS) == sum(1 for check in RUN.values() if check.substituted)
    assert all(re.search(" <= | >= ", check.formula) for check in RUN.values())

    def q(name: str) -> float:
        return QUANTITIES[name][0](R)

    travel, speed, friction = R("stage.travel"), R("requirements.speed"), R("drive.friction")
    count = float(sensors.count_size(R("sensors.lvdt.range"), R("sensors.lvdt.bits")))
    first = min(q("resonance.tip_up"), q("resonance.tip_rocking"))
    laws, ratio = frequency_for(speed, q("ellipse.along")), q("load.preload") / q("load.weight")
    frequency, voltage, capacitance = q("frequency.of_speed"), R("piezo.highest_voltage"), q("capacitance.driven")
    wedge = wedge_drive(R("set_screw.pitch"), R("height_pin_1.slope"), R("height_pin_1.stroke"))
    crown, pad, half = R("pads.crown_radius"), q("load.heaviest_pad"), R("bearing.film_thickness") / 2
    distance, coating = 2 * travel * R("bearing.run_in_cycles"), R("tip.coating_thickness")
    worn = crown_wear_distance(coating, R("tip.nose_radius"), R("drive.tip_wear_rate"), q("load.of_tip"))
    straight = 4 * R("bearing.way_straightness") / R("bearing_way.length")
    filtered = sensors.filtered_noise(
        *(R(f"sensors.{key}") for key in ("probe.resolution", "probe.bandwidth", "filtered_probe.filter_frequency"))
    )
    expected = {
        "LVDT count": count,
        "velocity by differencing the LVDT": sensors.velocity_noise(count, 2 * R("sensors.lvdt.bandwidth")),
        "lag of the LVDT at full speed": sensors.lag_error(speed, R("sensors.lvdt.bandwidth")),
        "capacitive probe noise after its filter": filtered,
        "cosine error of the interferometer": sensors.cosine_error(travel, R("sensors.interferometer.misalignment")),
        "Abbe error at the payload": sensors.abbe_error(R("stage.thickness") / 2 + R("payload.height"), straight),
        "refractive index of the air over the interferometer's travel": sensors.air_index_error(
            travel, R("environment.temperature_change"), R("environment.pressure_change")
        ),
        **{f"drive frequency for the speed, {law}": laws[law] for law in ("stopping", "coasting", "apex")},
        "speed at a third of the tip's resonance": speed_of(q("ellipse.along"), first / 3)["coasting"],
        "acceleration of 1 G without lift-off": acceleration_limit(friction, ratio, gravity=R("environment.gravity")),
        "sway of the tip on its stacks against the drive": resonance(q("stiffness.sway"), q("mass.on_piezos")),
        "heat of the piezos at full speed": 2 * stack_heat(capacitance, voltage, frequency, R("piezo.loss_factor")),
        "peak current of one piezo at full speed": stack_current(capacitance, voltage, frequency),
        "height adjustment within the ellipse": R("actuator.key_angle") * 57.29577951308232 * wedge.lift_per_degree,
        "range of the height adjustment": wedge.range / 2,
        "heat of sliding at full speed": friction_heat(R("bearing.dynamic_friction"), q("load.whole"), speed),
        "life of the PTFE film": crown_wear_distance(half, crown, R("bearing.wear_rate"), pad),
        "wear of the PTFE film by running in": crown_wear_depth(distance, crown, R("bearing.run_in_wear_rate"), pad),
        "wear of the tip's coating": worn / 0.421,
        "pressure under the screw heads on the way": q("force.way_screw")
        / (np.pi / 4 * (R("screws.way.head_diameter") ** 2 - R("bearing_way.bolt_hole") ** 2)),
    }
    for name, value in expected.items():
        assert CHECKS[name](R).value == pytest.approx(float(value), rel=1e-12), name
    needed = preload_ratio_for(R("requirements.acceleration"), friction, R("environment.gravity"))
    changes = CHECKS["acceleration of 1 G with the required preload"](R).changes
    assert float(changes[0].text) == pytest.approx(float(needed), rel=5e-3)
    assert CHECKS["self-locking of the wedge"](R).limit == pytest.approx(1.5 * float(wedge.locking_friction), rel=1e-12)


def test_names_of_quantities_are_no_parameters_and_what_is_divided_by_zero_is_infinite() -> None:
    assert not set(QUANTITIES) & {entry.key for entry in DESIGN.entries}
    still = DesignInputs(load_design(None, ["environment.temperature_change=0 K"]))
    stating = stated("n", "stage.length <= 1 m*K/environment.temperature_change", source="s", note="{check.limit/0}")
    check = stating(still)
    assert check.limit == float("inf") and check.note == "inf" and check.verdict != "fails"
