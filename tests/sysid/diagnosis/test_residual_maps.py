"""Residual maps: the generating coordinate comes first, and noise depends on no coordinate."""

from pathlib import Path

import numpy as np
import pytest
from scipy.signal import lfilter

from sim.effects.catalogue import find
from sysid.diagnosis.residual_maps import (
    ResidualMap,
    compared_with_time,
    coordinates_of,
    explained_variance,
    order_maps,
    residual_maps,
    standard_errors,
)
from sysid.estimation.fit import fit_model
from sysid.estimation.misfit import residual_weights
from sysid.estimation.reference_fit import reference_fit
from sysid.prediction.problem import Problem
from tests.sysid.slide import NOISE, POSITION, SIGN, TIME, VELOCITY, slide

WARMTH = 21.0 + 3.0 * np.sin(2 * np.pi * TIME / 1.7)


def maps(problem: Problem, nameless: bool = False) -> dict[str, ResidualMap]:
    base = fit_model(problem.start, problem.fit_records)
    of_model = base.model, problem, reference_fit(problem, base)
    found = residual_maps(*of_model)
    return {m.coordinate: m for m in (compared_with_time(found, *of_model) if nameless else found)}


def made(tmp_path: Path, missing: np.ndarray, channels: dict[str, np.ndarray] | None = None) -> dict[str, ResidualMap]:
    return maps(slide(tmp_path, 1.5 * SIGN + missing, "coulomb", held_out=True, extra=channels))


@pytest.mark.parametrize(
    "coordinate,extra",
    [
        ("position", 0.05 * np.sin(2 * np.pi * POSITION / 4e-3)),
        ("velocity", 0.05 * np.cos(120.0 * VELOCITY)),
        ("time", 0.05 * np.sin(2 * np.pi * TIME / 2.5)),
        ("frequency", 0.05 * np.sin(2 * np.pi * 140.0 * TIME)),
    ],
)
def test_generating_coordinate_comes_first(tmp_path: Path, coordinate: str, extra: np.ndarray) -> None:
    found = made(tmp_path, extra)
    first = next(iter(found.values()))
    assert first.coordinate == coordinate
    assert first.share > 0.4
    assert first.p_value < 0.01


def test_direction_and_temperature_are_distinguished(tmp_path: Path) -> None:
    found = made(tmp_path, 0.05 * np.ones(TIME.size))
    assert found["direction"].share > 0.97 * max(m.share for m in found.values()) > 0.4
    assert found["direction"].forward[1] * found["direction"].backward[0] > 0.0
    found = made(tmp_path, 0.03 * (WARMTH - 21.0), {"temperature [degC]": WARMTH})
    assert next(iter(found)) == "temperature"
    drift = 21.0 + 5.0 * (1.0 - np.exp(-TIME))
    found = made(tmp_path, 0.05 * (drift - 21.0), {"temperature [degC]": drift})
    assert found["temperature"].share < 0.6 * found["time"].share


def test_texture_and_events_are_told_apart(tmp_path: Path) -> None:
    waves = np.sin(2 * np.pi * POSITION / 3.1e-4) + np.sin(2 * np.pi * POSITION / 4.7e-4)
    found = made(tmp_path, 0.05 * SIGN * waves)
    position = next(iter(found.values()))
    assert position.coordinate == "position"
    assert position.share > 0.4
    assert position.p_value < 0.01
    stuck = sum(((begin < TIME) & (begin + 0.12 > TIME)).astype(float) for begin in (0.31, 0.78, 1.07, 1.62, 2.05))
    found = maps(slide(tmp_path, (1.5 + 0.08 * stuck) * SIGN, "coulomb"))
    first = next(iter(found.values()))
    assert first.coordinate == "time"
    others = [m for m in found.values() if m.coordinate not in ("time", "distance_travelled", "frequency")]
    assert max(m.share for m in others) < 0.1


def test_noise_depends_on_no_coordinate(tmp_path: Path) -> None:
    found = made(tmp_path, np.zeros(TIME.size))
    assert max(m.share for m in found.values()) < 0.05
    rng = np.random.default_rng(8)
    coloured = NOISE * np.asarray(lfilter([1.0], [1.0, -0.95], rng.standard_normal(TIME.size)))
    # One record: what is written into both alike is no noise.
    found = maps(slide(tmp_path, 1.5 * SIGN + coloured, "coulomb"))
    chance = [m.p_value for m in found.values() if m.coordinate in ("velocity", "acceleration", "direction")]
    assert min(chance) > 0.01
    problem = slide(tmp_path, 1.5 * SIGN, "coulomb", extra={"normal_load [N]": np.full(TIME.size, 10.0)})
    assert "normal_load" not in coordinates_of(problem.fit_records[0])


def test_a_map_is_the_mean_of_the_added_force_whatever_an_outlier(tmp_path: Path) -> None:
    drawn = made(tmp_path, 0.05 * np.sin(2 * np.pi * POSITION / 4e-3))["position"]
    wanted = 5.0 * np.sin(2 * np.pi * drawn.centres / 4e-3)
    both = 0.5 * (drawn.forward + drawn.backward)
    # Bins are half a millimetre wide or less, and each holds its own mean of the wave.
    assert np.corrcoef(both, wanted)[0, 1] > 0.97
    extra = np.zeros(TIME.size)
    extra[900] = 1e3
    found = made(tmp_path, extra)
    assert max(m.share for m in found.values()) < 0.1


def test_order_of_coordinates_beside_time() -> None:
    empty = np.empty(0)
    time, place = (ResidualMap(n, s, 0.0, empty, empty, empty) for n, s in (("time", 0.55), ("position", 0.5)))
    assert [m.coordinate for m in order_maps([time, place])] == ["position", "time"]
    much = ResidualMap("time", 0.65, 0.0, empty, empty, empty)
    assert [m.coordinate for m in order_maps([place, much])] == ["time", "position"]

    def one(name: str, share: float, beside_time: float = 0.0) -> ResidualMap:
        return ResidualMap(name, share, 0.0, empty, empty, empty, beside_time)

    time, less, more = one("time", 0.6), one("velocity", 0.7, -0.1), one("velocity", 0.7, 0.1)
    place = one("position", 0.7, -0.1)
    for others, first in ((less, "time"), (more, "velocity"), (place, "position")):
        assert order_maps([time, others], nameless=True)[0].coordinate == first
        assert order_maps([time, others])[0].coordinate == others.coordinate
    short, far = one("time", 0.1), one("distance_travelled", 0.2)
    assert [m.coordinate for m in order_maps([short, far], nameless=True)] == ["time", "distance_travelled"]
    assert [m.coordinate for m in order_maps([short, far])] == ["distance_travelled", "time"]


def test_shares_of_time_and_velocity_beside_each_other(tmp_path: Path) -> None:
    once = 0.05 * ((TIME > 1.2) & (TIME < 1.7)) * np.sign(VELOCITY)
    for name, missing, first in (("once", once, "time"), ("curve", 0.05 * np.cos(120.0 * VELOCITY), "velocity")):
        problem = slide(tmp_path / name, 1.5 * SIGN + missing, "coulomb", held_out=True)
        found = maps(problem, nameless=True)
        assert next(iter(found)) == first
        assert abs(found["velocity"].beside_time) > 0.3
        assert (found["velocity"].beside_time < 0.0) == (first == "time")


def test_standard_errors_count_correlated_samples_once():
    """Against the scatter of the mean over realisations of noise with a constant part in each block of 50 samples."""
    rng = np.random.default_rng(4)
    block = np.repeat(np.arange(40), 50)
    cells = np.tile(np.arange(5), 400)
    means, errors = [], []
    for _ in range(300):
        residual = rng.standard_normal(40)[block] + rng.standard_normal(block.size)
        own = np.bincount(cells, residual) / np.bincount(cells)
        means.append(own)
        errors.append(standard_errors(cells, residual - own[cells], block, 5))
    np.testing.assert_allclose(np.mean(errors, axis=0), np.std(means, axis=0), rtol=0.1)


def test_change_of_a_friction_level_is_a_function_of_the_position_times_the_direction(tmp_path: Path) -> None:
    problem = slide(tmp_path, 1.5 * SIGN, "coulomb", held_out=True)
    records = problem.validate_records
    weights = residual_weights(problem.start, records)
    pick, known = weights.samples[0]["friction_force"], coordinates_of(records[0])
    factor, force = find("position_dependent_friction"), find("gravity_torque")
    level = (known["position"] * np.sign(known["velocity"]))[pick]
    assert explained_variance(level, records, weights, factor) > 0.9
    assert explained_variance(level, records, weights, force) < 0.5
    # A force of one sign is no friction level, though it is a constant function of any coordinate.
    assert explained_variance(np.ones(pick.size), records, weights, factor) < 0.1
    assert explained_variance(np.ones(pick.size), records, weights, force) == pytest.approx(1.0)
