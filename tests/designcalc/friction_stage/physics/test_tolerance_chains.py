"""Tolerance chains: worst case by all corners, statistics by random machines, nominal values by the solids' rules."""

from itertools import product

import numpy as np
import pytest

from designcalc.friction_stage.physics.tolerance_chains import Chain, Link, chains
from stagecad.parameters.load import load_design

DESIGN = load_design()
CHAINS = {chain.name: chain for chain in chains(DESIGN)}


def value(chain: Chain, deviations: np.ndarray) -> np.ndarray:
    """The result for deviations (..., n) of the dimensions."""
    coefficients = np.array([link.coefficient for link in chain.links])
    nominal = np.array([link.nominal for link in chain.links])
    return chain.offset + (nominal + deviations) @ coefficients


@pytest.mark.parametrize("name", CHAINS)
def test_the_worst_case_is_reached_at_a_corner_and_never_exceeded(name: str) -> None:
    chain = CHAINS[name]
    corners = value(chain, np.array(list(product(*((link.low, link.high) for link in chain.links)))))
    assert (corners.min(), corners.max()) == pytest.approx(chain.worst_case, abs=1e-12)


@pytest.mark.parametrize("name", CHAINS)
def test_the_statistical_limits_hold_for_9973_of_10000_machines(name: str) -> None:
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


def test_asymmetric_deviations_shift_the_statistical_middle() -> None:
    chain = Chain("play", (Link("bore", 1.0, 16e-3, 0.0, 18e-6), Link("pin", -1.0, 16e-3, -17e-6, -6e-6)))
    assert chain.worst_case == pytest.approx((6e-6, 35e-6), abs=1e-12)
    # A trapezoid: beyond 14.5 - d the area is d^2/(2 18 11), twice.
    half = 14.5e-6 - np.sqrt(0.0027 * 18 * 11) * 1e-6
    assert chain.statistical == pytest.approx((20.5e-6 - half, 20.5e-6 + half), abs=1e-8)


def test_two_equal_dimensions_are_uniform_as_the_draws_of_the_tolerance_study() -> None:
    """+-100 um each: 189.6 um by the triangle of their sum; 141 um if they were normal at three sigma."""
    chain = Chain("two", tuple(Link(key, 1.0, 0.0, -100e-6, 100e-6) for key in "ab"))
    assert chain.statistical[1] == pytest.approx((200 - 200 * np.sqrt(0.0027)) * 1e-6, rel=1e-3)


def test_a_machine_without_teeth_has_no_chain_of_its_gap() -> None:
    assert "tooth gap" not in {chain.name for chain in chains(load_design(overrides=["teeth.fitted=false"]))}
