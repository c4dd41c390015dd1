"""The energy audit and limit cycles of stick-slip, against closed expressions and reference numbers."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

from sim.experiments.friction_models import MODELS, Friction
from sim.experiments.hysteresis import hysteresis
from sim.experiments.limit_cycles import SPEEDS, cycle, limit_cycles
from sim.experiments.passivity import MOTIONS, SPEED, START_FREQUENCY, TIP_FREQUENCY, audit, passive_below
from sim.experiments.presliding import presliding
from sim.experiments.stick_slip import stick_slip
from sim.integration import drive
from sim.integration.simulate import simulate
from tests.reference.tables import reference

ROOT = Path(__file__).parents[3]
REFERENCE = reference("thesis_friction")["causal"]
FRICTION = Friction()
MICRO = {"um": 1e-6, "uJ": 1e-6}
RISE = FRICTION.breakaway - FRICTION.coulomb


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("core", MODELS)
def test_the_heat_is_the_integral_of_the_closed_expression(core, motion):
    """Heat rate worked out by hand for each model, integrated over the states of the run."""
    result = audit(FRICTION, core, motion)
    run = result.simulation
    v, z = run.velocity, run.bristle[:, 0]
    level = 1.0 + 0.5 * np.exp(-((v / 1e-3) ** 2))
    a0, a1 = 1e5, math.sqrt(1e5)
    if core == "lugre":
        s = a0 * z / level
        rate = np.abs(v) * (level * s**2 + a1 * np.abs(v) * (1.0 - s * np.sign(v)))
    elif core == "lugre_causal":
        slip = (v - np.abs(v) * a0 * z / level) / (1.0 + a1 * np.abs(v) / level)
        rate = a1 * slip**2 + (a0 * z + a1 * slip) ** 2 * np.abs(v) / level
    else:
        rate = (a0 * z) ** 2 * np.abs(v) / level
    heat = np.concatenate([[0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1]) * np.diff(run.time))])
    assert np.abs(heat - result.heat).max() < 1e-3 * np.abs(result.heat).max()
    if core in ("lugre_undamped", "lugre_causal"):
        # These models are passive.
        assert np.diff(result.heat).min() > -1e-9 * result.heat[-1]


@pytest.mark.parametrize("motion", MOTIONS)
def test_the_elements_of_the_causal_bond_graph_take_the_energy_of_their_laws(motion):
    """Slip: force times slip rate, (|v|/g) F^2; the slip of model 1 gives energy back in the fast start."""
    result = audit(FRICTION, "lugre_causal", motion)
    run, found = result.simulation, result.elements
    v, z, level = run.velocity, run.bristle[:, 0], 1.0 + 0.5 * np.exp(-((run.velocity / 1e-3) ** 2))
    rate = (v - np.abs(v) * 1e5 * z / level) / (1.0 + math.sqrt(1e5) * np.abs(v) / level)
    power = np.abs(v) / level * (1e5 * z + math.sqrt(1e5) * rate) ** 2
    slip = np.concatenate([[0.0], np.cumsum(0.5 * (power[1:] + power[:-1]) * np.diff(run.time))])
    assert np.abs(found["slip"] - slip).max() < 2e-3 * slip[-1]
    assert sum(found.values()) == pytest.approx(run.core_work, abs=1e-15) and np.diff(found["damper"]).min() >= 0.0
    assert audit(FRICTION, "lugre", "start").elements["slip"].min() < -4e-5


def test_the_energy_error_of_stick_slip_falls_with_the_tolerance():
    """Separate integrations of the 20 s of Figure 39: 6e-3 J at 1e-3, 7.5e-13 J at 1e-12; its end at 1.272596412 m."""
    pull = drive.pulled_spring([0.0, 20.0], [0.0, 2.0], 2.0)
    left = {}
    for tolerance in (1e-3, 1e-6, 1e-9, 1e-12):
        run = simulate(FRICTION.model("lugre"), pull, np.linspace(0.0, 20.0, 2001), tolerance=tolerance, energy=True)
        left[tolerance] = np.abs(run.drive_work - run.core_work - run.other_work - run.kinetic).max()
    assert list(left.values()) == pytest.approx([6e-3, 4.25e-7, 7e-10, 7.5e-13], rel=0.2, abs=0.0)
    assert run.position[-1] == pytest.approx(1.272596412, abs=5e-10)


@pytest.mark.parametrize(
    "core, heat, peak",
    [("lugre", 26.617e-6, 62.21), ("lugre_undamped", 109.41e-6, 0.574), ("lugre_causal", 102.44e-6, 1.065)],
)
def test_heat_and_peak_force_are_those_of_a_separate_integration(core, heat, peak):
    """Solved with Radau by other code; the least heat of LuGre is -33.967 uJ."""
    start = audit(FRICTION, core, "start")
    assert start.heat[-1] == pytest.approx(heat, rel=1e-3)
    assert start.least_heat == pytest.approx(-33.967e-6 if core == "lugre" else 0.0, rel=1e-3, abs=1e-12)
    assert audit(FRICTION, core, "tip").peak_force == pytest.approx(peak, rel=2e-3)


def test_lugre_gives_energy_back_in_a_fast_start_and_not_in_a_slow_one():
    result = audit(FRICTION, "lugre", "start")
    assert result.least_heat < -1e-5
    assert result.simulation.velocity[np.flatnonzero(np.diff(result.heat) < 0.0)[0]] > 0.9 * passive_below(FRICTION)
    slow = stick_slip(FRICTION, "lugre").simulation
    assert np.diff(slow.core_work - (slow.stored - slow.stored[0])).min() > -1e-12


def test_a_light_mass_is_shot_off_by_lugre_with_energy_from_nowhere():
    """LSODA has 1456 m/s too."""
    mass = 1e-6
    shot = stick_slip(FRICTION, "lugre", mass)
    assert shot.peak_velocity == pytest.approx(1456.0, abs=1.0)
    spring = 0.5 * 2.0 * (0.1 * shot.slips[0]) ** 2
    assert 0.5 * mass * shot.peak_velocity**2 > 1.9 * spring
    assert stick_slip(FRICTION, "lugre_causal", mass).peak_velocity == pytest.approx(1.17, abs=0.005)


def test_documented_motions_and_audit_are_those_of_the_experiment():
    start = audit(FRICTION, "lugre_causal", "start").simulation
    expected = 0.5 * SPEED * (1.0 - np.cos(START_FREQUENCY * start.time))
    assert np.abs(start.velocity - expected).max() < 1e-8
    tip = audit(FRICTION, "lugre_causal", "tip").simulation
    assert np.abs(tip.velocity - SPEED * np.sin(TIP_FREQUENCY * tip.time)).max() < 1e-8
    for motion, feature, unit, printed in rows("passivity"):
        for core, value in printed.items():
            check(audit(FRICTION, core, motion).features()[feature], unit, value, f"{motion} {feature} {core}")
    assert passive_below(FRICTION) * 1e3 == pytest.approx(float(REFERENCE["passive_below"]["printed"]), abs=0.06)


def rows(name: str):
    """Rows of the documentation's table marked `<!-- table: name -->`: experiment, feature, unit, printed by model."""
    text = (ROOT / "docs" / "causal_friction_model.md").read_text(encoding="utf-8")
    table = text.split(f"<!-- table: {name} -->\n")[1].split("\n\n")[0].splitlines()
    split = [[cell.strip(" `") for cell in line.strip("|").split("|")] for line in table]
    return [(row[0], row[1], row[2], dict(zip(split[0][3:], row[3:]))) for row in split[2:]]


def check(feature: tuple[float, str] | None, unit: str, printed: str, what: str) -> None:
    assert feature is not None, what
    half = 0.51 * 10.0 ** -len(printed.partition(".")[2])
    assert abs(feature[0] / MICRO.get(unit, 1.0) - float(printed)) <= half, (what, feature, printed)


@pytest.mark.parametrize("core", MODELS)
def test_the_documented_features_are_those_of_the_experiments(core):
    found = {"presliding": presliding(FRICTION, core).features(), "stick-slip": stick_slip(FRICTION, core).features()}
    for experiment, feature, unit, printed in rows("features"):
        if experiment.startswith("hysteresis"):
            found[experiment] = hysteresis(FRICTION, core, experiment.split()[1]).features()
        check(found[experiment][feature], unit, printed[core], f"{experiment} {feature} {core}")


@pytest.mark.parametrize("speed", [2e-3, 2e-2])
def test_the_size_of_a_cycle_follows_from_its_dwell(speed: float) -> None:
    """2 A, A = (Fs - Fc)(1 - exp(-gamma (2 A/(k v))^m)), with the speed of the slip added: sqrt(A^2 + m k v^2)."""
    found = cycle(replace(FRICTION, viscous=0.0), "lugre", speed, 2.0, 1.0)
    dwell = brentq(lambda a: a - RISE * (1.0 - math.exp(-1.66 * (2.0 * a / (2.0 * speed)) ** 0.65)), 1e-9, RISE)
    assert found.size == pytest.approx(2.0 * math.hypot(dwell, math.sqrt(2.0) * speed), rel=0.06)
    assert found.first == pytest.approx(FRICTION.breakaway, rel=0.01)


def test_a_stiff_spring_breaks_away_earlier_with_the_force_of_its_shorter_dwell() -> None:
    """Kato's law at both dwells: of the spring wound from zero, and of the limit cycle."""

    def level(dwell: float) -> float:
        return FRICTION.coulomb + RISE * (1.0 - math.exp(-1.66 * dwell**0.65))

    for speed in SPEEDS[:2]:
        found = cycle(FRICTION, "lugre", speed, 200.0, 1.0)
        first, later = level(found.first / (200.0 * speed)), level(found.dwell)
        assert (found.first, found.top) == (pytest.approx(first, rel=0.02), pytest.approx(later, rel=0.02))
        assert found.first - found.top == pytest.approx(first - later, abs=0.01)


def test_above_the_critical_speed_the_mass_slides() -> None:
    found = limit_cycles(FRICTION, "lugre", 20.0)
    assert found.critical is not None and SPEEDS[0] < found.critical < SPEEDS[-1]
    sticks = np.array(SPEEDS) < found.critical
    assert np.all(found.sizes[sticks] > 0.5 * RISE) and np.all(found.sizes[~sticks] < 0.05 * RISE)
    # A mass that slides is driven by Coulomb and viscous friction alone.
    last = found.cycles[-1].simulation
    assert last.drive[-1] == pytest.approx(FRICTION.coulomb + FRICTION.viscous * SPEEDS[-1], rel=0.03)
