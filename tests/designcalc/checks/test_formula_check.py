"""Every check is one formula: the numbers that are shown give its value, and calculators of the same law agree."""

from __future__ import annotations

import re

import pytest

from designcalc.bearing.fastener import head_pressure
from designcalc.bearing.sliding import crown_wear_depth, crown_wear_distance, friction_heat
from designcalc.checks.check import DesignInputs, FormulaCheck
from designcalc.checks.run import run_checks
from designcalc.drive.friction_drive import acceleration_limit, preload_ratio_for, resonance
from designcalc.drive.height_adjustment import wedge_drive
from designcalc.drive.piezo_stack import stack_current, stack_heat
from designcalc.drive.tip_ellipse import frequency_for, speed_of
from designcalc.errors import sensors
from designcalc.friction_stage.quantities import QUANTITIES, stated
from designcalc.friction_stage.subjects import SUBJECTS
from stagecad.parameters.formula import Value, parse_formula
from stagecad.parameters.load import load_design

DESIGN = load_design()
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


def test_no_check_is_left_out() -> None:
    assert len(RUN) == len(FUNCTIONS) == sum(1 for check in RUN.values() if check.substituted)
    assert all(re.search(" <= | >= ", check.formula) for check in RUN.values())


def test_the_formulas_are_those_of_the_calculators() -> None:
    def q(name: str) -> float:
        return QUANTITIES[name][0](R)

    count = float(sensors.count_size(R("sensors.lvdt.range"), R("sensors.lvdt.bits")))
    first = min(q("resonance.tip_up"), q("resonance.tip_rocking"))
    laws, ratio = frequency_for(R("requirements.speed"), q("ellipse.along")), q("load.preload") / q("load.weight")
    frequency, voltage, capacitance = q("frequency.of_speed"), R("piezo.highest_voltage"), q("capacitance.driven")
    wedge = wedge_drive(R("set_screw.pitch"), R("height_pin_1.slope"), R("height_pin_1.stroke"))
    crown, pad, half = R("pads.crown_radius"), q("load.heaviest_pad"), R("bearing.film_thickness") / 2
    distance = 2 * R("stage.travel") * R("bearing.run_in_cycles")
    worn = crown_wear_distance(
        R("tip.coating_thickness"), R("tip.nose_radius"), R("drive.tip_wear_rate"), q("load.of_tip")
    )
    straight = 4 * R("bearing.way_straightness") / R("bearing_way.length")
    filtered = sensors.filtered_noise(
        *(R(f"sensors.{key}") for key in ("probe.resolution", "probe.bandwidth", "filtered_probe.filter_frequency"))
    )
    expected = {
        "LVDT count": count,
        "velocity by differencing the LVDT": sensors.velocity_noise(count, 2 * R("sensors.lvdt.bandwidth")),
        "lag of the LVDT at full speed": sensors.lag_error(R("requirements.speed"), R("sensors.lvdt.bandwidth")),
        "capacitive probe noise after its filter": filtered,
        "cosine error of the interferometer": sensors.cosine_error(
            R("stage.travel"), R("sensors.interferometer.misalignment")
        ),
        "Abbe error at the payload": sensors.abbe_error(R("stage.thickness") / 2 + R("payload.height"), straight),
        "refractive index of the air over the interferometer's travel": sensors.air_index_error(
            R("stage.travel"), R("environment.temperature_change"), R("environment.pressure_change")
        ),
        **{f"drive frequency for the speed, {law}": laws[law] for law in ("stopping", "coasting", "apex")},
        "speed at a third of the tip's resonance": speed_of(q("ellipse.along"), first / 3)["coasting"],
        "acceleration of 1 G without lift-off": acceleration_limit(
            R("drive.friction"), ratio, gravity=R("environment.gravity")
        ),
        "sway of the tip on its stacks against the drive": resonance(q("stiffness.sway"), q("mass.on_piezos")),
        "heat of the piezos at full speed": 2 * stack_heat(capacitance, voltage, frequency, R("piezo.loss_factor")),
        "peak current of one piezo at full speed": stack_current(capacitance, voltage, frequency),
        "height adjustment within the ellipse": R("actuator.key_angle") * 57.29577951308232 * wedge.lift_per_degree,
        "range of the height adjustment": wedge.range / 2,
        "heat of sliding at full speed": friction_heat(
            R("bearing.dynamic_friction"), q("load.whole"), R("requirements.speed")
        ),
        "life of the PTFE film": crown_wear_distance(half, crown, R("bearing.wear_rate"), pad),
        "wear of the PTFE film by running in": crown_wear_depth(distance, crown, R("bearing.run_in_wear_rate"), pad),
        "wear of the tip's coating": worn / 0.421,
        "pressure under the screw heads on the way": head_pressure(
            q("force.way_screw"), R("screws.way.head_diameter"), R("bearing_way.bolt_hole")
        ),
    }
    for name, value in expected.items():
        assert CHECKS[name](R).value == pytest.approx(float(value), rel=1e-12), name
    needed = preload_ratio_for(R("requirements.acceleration"), R("drive.friction"), R("environment.gravity"))
    changes = CHECKS["acceleration of 1 G with the required preload"](R).changes
    assert float(changes[0].text) == pytest.approx(float(needed), rel=5e-3)
    assert CHECKS["self-locking of the wedge"](R).limit == pytest.approx(1.5 * float(wedge.locking_friction), rel=1e-12)


def test_names_of_quantities_are_no_parameters_and_what_is_divided_by_zero_is_infinite() -> None:
    assert not set(QUANTITIES) & {entry.key for entry in DESIGN.entries}
    still = DesignInputs(load_design(None, ["environment.temperature_change=0 K"]))
    check = stated("n", "stage.length <= 1 m*K/environment.temperature_change", source="s", note="{check.limit/0}")(
        still
    )
    assert check.limit == float("inf") and check.note == "inf" and check.verdict != "fails"
