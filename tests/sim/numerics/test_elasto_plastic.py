"""Elasto-plastic elements."""

import numpy as np
import pytest

from sim.numerics import elasto_plastic

STRETCHES = np.array([0.4e-6, 1.5e-6, 2.2e-6, 4e-6])
CURVE = np.array([0.3, 0.7, 0.85, 1.0])
ELEMENTS = elasto_plastic.elements_along(STRETCHES, CURVE)


def stressed(stress: float) -> elasto_plastic.Springs:
    """Springs that each carry `stress` times what they can."""
    springs = elasto_plastic.springs_of(ELEMENTS)
    springs.force[:] = stress * springs.limit
    return springs


def test_the_virgin_curve_and_its_inverse():
    assert np.sum(ELEMENTS.weights) == pytest.approx(1.0, rel=1e-14)
    for stretch, force in zip(STRETCHES, CURVE, strict=True):
        assert elasto_plastic.displace(elasto_plastic.springs_of(ELEMENTS), stretch, 1.0) == pytest.approx(
            force, rel=1e-12
        )
    assert elasto_plastic.displace(elasto_plastic.springs_of(ELEMENTS), 1.0, 1.0) == pytest.approx(1.0, rel=1e-14)
    assert np.min(elasto_plastic.elements_along(STRETCHES, np.array([0.1, 0.8, 0.9, 1.0])).weights) == 0.0
    random = np.random.default_rng(2)
    ahead, back = elasto_plastic.springs_of(ELEMENTS), elasto_plastic.springs_of(ELEMENTS)
    total = 0.0
    for step in 2e-6 * random.standard_normal(200):
        wanted = elasto_plastic.displace(ahead, step, 1.0)
        moved, total = elasto_plastic.displace_to(back, total, wanted, 1.0)
        assert total == pytest.approx(wanted, abs=1e-12)
        if abs(wanted) < 1.0 - 1e-9:
            assert moved == pytest.approx(step, rel=1e-9, abs=1e-18)
        np.copyto(back.force, ahead.force)
    springs = elasto_plastic.springs_of(ELEMENTS)
    moved, total = elasto_plastic.displace_to(springs, 0.0, 2.0, 1.0)
    assert (moved, total) == (pytest.approx(STRETCHES[-1]), pytest.approx(1.0))
    assert springs.force == pytest.approx(springs.limit)


@pytest.mark.parametrize("depth", [0.2e-6, 1.9e-6, 7e-6])
def test_unloading_is_the_virgin_curve_at_twice_its_size(depth):
    virgin = elasto_plastic.displace(elasto_plastic.springs_of(ELEMENTS), 0.5 * depth, 1.0)
    assert elasto_plastic.displace(stressed(1.0), -depth, 1.0) == pytest.approx(1.0 - 2.0 * virgin, rel=1e-12)


def test_the_mean_force_is_that_at_half_of_the_displacement_and_has_its_tangent():
    springs = stressed(-0.4)
    for displacement in (-3e-6, 0.7e-6, 2.6e-6, 9e-6):
        half = stressed(-0.4)
        total, tangent = elasto_plastic.mean_force(springs, 0.0, displacement, 1.0)
        assert total == pytest.approx(elasto_plastic.displace(half, 0.5 * displacement, 1.0), abs=1e-14)
        later, _ = elasto_plastic.mean_force(springs, 0.0, displacement + 1e-10, 1.0)
        assert tangent == pytest.approx((later - total) / 1e-10, rel=1e-4, abs=1e-3)
    # A dashpot shares the limit: no force beyond it.
    assert elasto_plastic.mean_force(springs, 1e9, 1e-6, 1.0)[0] == pytest.approx(1.0)


def test_a_record_is_taken_element_by_element():
    """Against each element alone: its force, of constant stiffness, within its part of the level."""
    position = np.cumsum(1e-6 * np.random.default_rng(3).standard_normal(300))
    level = 1.0 + 0.2 * np.sin(np.arange(300.0))
    expected = np.zeros(300)
    stretches, weights, _ = ELEMENTS
    for stretch, weight in zip(stretches, weights, strict=True):
        force = np.sign(position[1] - position[0]) * weight * level[0]
        for i in range(300):
            force += 0.9 * weight / stretch * (position[i] - position[i - 1] if i else 0.0)
            force = min(max(force, -weight * level[i]), weight * level[i])
            expected[i] += force
    assert elasto_plastic.force_along(position, level, ELEMENTS._replace(force=0.9)) == pytest.approx(
        expected, abs=1e-12
    )


def test_a_bristle_sticks_for_a_part_of_a_step_at_a_stiffness_of_its_own():
    one = elasto_plastic.Elements(np.array([1e-6]), np.ones(1))
    fraction = elasto_plastic.sticking_fraction(np.array([0.0, 0.5e-6, 2.5e-6, 3.5e-6, 3.4e-6]), one)
    assert fraction == pytest.approx([1.0, 0.625, 0.125, 0.5, 1.0])
    # Twice the limit, twice the stretch; and a limit that has fallen lets the force fall onto it.
    loaded = elasto_plastic.force_along(np.array([0.0, 0.0, 0.2e-6]), np.array([1.0, 1.0, 2.0]), ELEMENTS)
    assert loaded[-1] == pytest.approx(0.2e-6 * np.sum(ELEMENTS.stiffness))
    fallen = elasto_plastic.force_along(np.array([0.0, 1e-3, 1e-3]), np.array([2.0, 2.0, 0.5]), ELEMENTS)
    assert fallen == pytest.approx([2.0, 2.0, 0.5])
    stretches = elasto_plastic.stretch_along(np.array([0.0, 1e-3]), np.array([2.0, 2.0]), ELEMENTS)
    assert stretches[:, 1] == pytest.approx(2.0 * STRETCHES)


@pytest.mark.parametrize("z", [-2.4e-6, -0.8e-6, -0.1e-6, 0.3e-6, 0.95e-6, 1.9e-6])
@pytest.mark.parametrize("v", [-2e-3, 3e-3])
@pytest.mark.parametrize(("weight", "damping", "force"), [(0.7, 0.0, 1.0), (0.0, 300.0, 0.0)])
def test_the_smooth_law_has_its_own_derivatives(z, v, weight, damping, force):
    fixed = 1e-6, weight, damping, force
    direction = np.sign(v)
    rate, out, rate_z, rate_v, rate_g, force_z, force_v, force_g = elasto_plastic.smooth_element(
        z, v, direction, 1.3, *fixed
    )

    def slope(change: tuple[float, float, float], size: float) -> np.ndarray:
        ends = [
            elasto_plastic.smooth_element(z + s * change[0], v + s * change[1], direction, 1.3 + s * change[2], *fixed)[
                :2
            ]
            for s in (size, -size)
        ]
        return (np.array(ends[0]) - np.array(ends[1])) / (2.0 * size)

    assert slope((1.0, 0.0, 0.0), 1e-12) == pytest.approx([rate_z, force_z], rel=1e-5, abs=1e-6)
    assert slope((0.0, 1.0, 0.0), 1e-8) == pytest.approx([rate_v, force_v], rel=1e-6)
    assert slope((0.0, 0.0, 1.0), 1e-5) == pytest.approx([rate_g, force_g], rel=1e-5, abs=1e-9)
    assert out == pytest.approx(force * weight * z / 1e-6 + damping * rate)


def test_elements_behind_a_gap():
    position = 1e-3 * np.sin(np.linspace(0.3, 20.0, 4000)) + 4e-4 * np.sin(np.linspace(0.0, 57.0, 4000))
    gap, rigid = 5e-4, elasto_plastic.Elements(np.array([1e-12]), np.ones(1))
    played = np.empty(position.size)
    # By its definition: the output is the nearest value to the last one within half the gap of the input.
    played[0] = position[0] - 0.5 * gap * np.sign(position[1] - position[0])
    for i in range(1, position.size):
        played[i] = min(max(played[i - 1], position[i] - 0.5 * gap), position[i] + 0.5 * gap)
    body = elasto_plastic.position_behind_gap(position, np.ones(position.size), rigid, gap)
    assert np.diff(body) == pytest.approx(np.diff(played), abs=3e-12)
    level, stretch, gap = 2.0, 1e-4, 3e-4
    position = np.concatenate([np.linspace(0.0, 1e-3, 1001), np.linspace(1e-3, 0.0, 1001)[1:]])
    one, limit = elasto_plastic.Elements(np.array([stretch]), np.ones(1), level), np.full(position.size, level)
    body = elasto_plastic.position_behind_gap(position, limit, one, gap)
    force = elasto_plastic.force_along(body, limit, one)
    back = 1e-3 - position[1000:]
    bends = [0.0, stretch, stretch + gap, 2.0 * stretch + gap, 1e-3]
    expected = np.interp(back, bends, [level, 0.0, 0.0, -level, -level])
    assert force[1000:] == pytest.approx(expected, abs=1e-9 * level)


def test_rigid_sides_of_a_gap_touch_where_the_play_moves():
    """Against the play operator by its definition: it moves where the sides touch."""
    position = 1e-3 * np.sin(np.linspace(0.3, 20.0, 4000)) + 4e-4 * np.sin(np.linspace(0.0, 57.0, 4000))
    gap, direction = 5e-4, np.sign(np.diff(position, prepend=2.0 * position[0] - position[1]))
    touches = elasto_plastic.contact_across_gap(position, direction, gap, 0.5 * gap)
    played = [position[0]]
    for x in position[1:]:
        played.append(min(max(played[-1], x - 0.5 * gap), x + 0.5 * gap))
    moved = np.abs(np.diff(played)) > 1e-12
    assert np.mean(touches[1:] == moved) > 0.999 and touches[0] == 0.0
    assert elasto_plastic.contact_across_gap(position, direction, gap)[0] == 1.0
