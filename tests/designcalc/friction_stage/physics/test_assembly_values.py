"""Numbers of the assembly procedure and tolerance chains, against formulas, corners and random machines."""

import math
from itertools import product
from types import SimpleNamespace

import numpy as np
import pytest

from designcalc.checks.check import DesignInputs
from designcalc.checks.run import run_checks
from designcalc.friction_stage.calculated.chains import Chain, Link, chains
from designcalc.friction_stage.checks import assembly_values
from stagecad.parameters.load import load_design

DESIGN = load_design()
CHAINS = {chain.name: chain for chain in chains(DESIGN)}


def test_numbers_of_the_thesis_design_are_those_of_the_checks() -> None:
    design = load_design()
    values = SimpleNamespace(**assembly_values(DesignInputs(design)))
    assert values.way_preload == pytest.approx(15 / (0.2 * 0.375 * 0.0254))
    assert values.bar_preload == pytest.approx(3 / (0.2 * 0.005))
    assert values.clamp_force == pytest.approx(6 / (0.2 * 0.375 * 0.0254))
    # 8 threads to the inch, wedge 1:20, stroke 20 mm.
    assert values.lift_per_turn == pytest.approx(0.0254 / 8 / 20)
    assert values.lift_per_degree == pytest.approx(0.0254 / 8 / 20 / 360)
    assert values.adjustment == pytest.approx(0.5e-3)
    # Two strokes of +-8.5 um, a quarter of a turn apart: their mean swings by 8.5 um sqrt(2)/2 either way.
    assert values.ellipse_height == pytest.approx(8.5e-6 * math.sqrt(2), rel=1e-6)
    assert values.run_in_distance == pytest.approx(3000 * 2 * 0.2)
    assert values.run_in_time == pytest.approx(values.run_in_distance / 0.2)
    # Archard: depth grows with the root of the way, so half the film after (t / 2 / depth)^2 of the strokes.
    assert values.film_strokes == pytest.approx(3000 * (1e-6 / values.run_in_wear) ** 2)
    checks = {check.name: check for check in run_checks(design)}
    assert values.magnet_pull == pytest.approx(checks["attraction of the magnets as preload"].value)
    shift = checks["shift of the tip's height by clamping"].value
    assert values.clamp_squeeze + values.clamp_drop == pytest.approx(shift)
    assert values.run_in_wear == pytest.approx(checks["wear of the PTFE film by running in"].value)


def test_without_teeth_nothing_pulls_and_no_chain_has_their_gap() -> None:
    assert assembly_values(DesignInputs(load_design(overrides=["teeth.fitted=false"])))["magnet_pull"] is None
    assert "tooth gap" not in {chain.name for chain in chains(load_design(overrides=["teeth.fitted=false"]))}


def value(chain: Chain, deviations: np.ndarray) -> np.ndarray:
    """The result for deviations (..., n) of the dimensions."""
    coefficients = np.array([link.coefficient for link in chain.links])
    nominal = np.array([link.nominal for link in chain.links])
    return chain.offset + (nominal + deviations) @ coefficients


@pytest.mark.parametrize("name", CHAINS)
def test_worst_cases_and_statistical_limits_of_chains(name: str) -> None:
    chain = CHAINS[name]
    corners = value(chain, np.array(list(product(*((link.low, link.high) for link in chain.links)))))
    assert (corners.min(), corners.max()) == pytest.approx(chain.worst_case, abs=1e-12)
    chain, rng = CHAINS[name], np.random.default_rng(1)
    least, most = np.array([(link.low, link.high) for link in chain.links]).T
    found = value(chain, rng.uniform(least, most, (200_000, least.size)))
    low, high = chain.statistical
    assert np.mean((found < low) | (found > high)) == pytest.approx(0.0027, abs=0.0004)


def test_the_chains_of_the_thesis_against_sums_by_hand() -> None:
    # Holder 76.00, pocket 76.03, both +-0.01.
    assert CHAINS["holder in pocket"].worst_case == pytest.approx((0.01e-3, 0.05e-3), abs=1e-9)
    # Six dimensions of class X.XX.
    gap = CHAINS["tooth gap"]
    assert gap.nominal == pytest.approx(1e-3, abs=1e-9)
    assert gap.worst_case == pytest.approx((0.94e-3, 1.06e-3), abs=1e-9)
    # The adjustment's middle brings the tip to the drive surface.
    assert CHAINS["tip to drive surface"].nominal == pytest.approx(0.0, abs=1e-9)
    assert CHAINS["tip height"].nominal == pytest.approx((25.4 + 2.0) * 1e-3, abs=1e-9)


def test_two_equal_dimensions_and_asymmetric_deviations_in_statistical_limits() -> None:
    chain = Chain("play", (Link("bore", 1.0, 16e-3, 0.0, 18e-6), Link("pin", -1.0, 16e-3, -17e-6, -6e-6)))
    assert chain.worst_case == pytest.approx((6e-6, 35e-6), abs=1e-12)
    # A trapezoid: beyond 14.5 - d the area is d^2/(2 18 11), twice.
    half = 14.5e-6 - np.sqrt(0.0027 * 18 * 11) * 1e-6
    assert chain.statistical == pytest.approx((20.5e-6 - half, 20.5e-6 + half), abs=1e-8)
    # +-100 um each: 189.6 um by the triangle of their sum; 141 um if they were normal at three sigma.
    chain = Chain("two", tuple(Link(key, 1.0, 0.0, -100e-6, 100e-6) for key in "ab"))
    assert chain.statistical[1] == pytest.approx((200 - 200 * np.sqrt(0.0027)) * 1e-6, rel=1e-3)
