"""Small calculators against closed forms, and calculators and motions against numbers of separate programs."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.spatial.transform import Rotation

from designcalc.bearing import fastener
from designcalc.checks.chain import Chain, Link
from designcalc.drive import height_adjustment, suspension
from designcalc.drive.tip_ellipse import tip_ellipse
from designcalc.errors import error_budget, sensors, thermal
from sim.effects.catalogue import compose
from sim.effects.effect import Axis
from tests.reference.tables import reference

SENSORS = reference("sensors")


def test_sensors_have_the_thesis_numbers():
    lvdt, probe = SENSORS["lvdt"], SENSORS["probe"]
    assert float(sensors.count_size(lvdt["range"], lvdt["bits"])) == pytest.approx(lvdt["count"], rel=1e-2)
    noise = sensors.filtered_noise(probe["noise"], probe["bandwidth"], probe["cutoff"])
    assert float(noise) == pytest.approx(probe["filtered"], rel=5e-3)
    count = sensors.count_size(probe["range"] / probe["gain"], probe["bits"])
    assert float(count) == pytest.approx(probe["count"], rel=5e-3)
    rng = np.random.default_rng(1)
    count, rate = 6.2e-6, 1000.0
    start, step = rng.uniform(0, 1, 40000), rng.uniform(0, 50, 40000)
    velocity = (np.round(start + step) - np.round(start)) * count * rate
    error = velocity - step * count * rate
    assert float(np.std(error)) == pytest.approx(float(sensors.velocity_noise(count, rate)), rel=2e-2)
    assert float(sensors.cosine_error(0.2, 1e-9)) == pytest.approx(0.2 * 0.5e-18, rel=1e-12, abs=0.0)
    assert float(sensors.abbe_error(0.02, 1e-5)) == pytest.approx(2e-7, rel=1e-9)
    speed, bandwidth = 0.2, 500.0
    steps = np.arange(0, 5e-3, 1e-6)
    reading, rate = 0.0, 2 * np.pi * bandwidth
    for place in speed * steps:
        reading += 1e-6 * rate * (place - reading)
    assert speed * steps[-1] - reading == pytest.approx(float(sensors.lag_error(speed, bandwidth)), rel=1e-2)


def test_bimetal_strip_bows_as_its_fibres():
    """Two layers, fibres in equilibrium: force and moment balance solved directly over a fine stack of fibres."""
    t1, e1, a1, t2, e2, a2 = 0.0254, 410e9, 4e-6, 0.09, 145e9, 1.3e-6
    n = 4000
    y = (np.arange(n) + 0.5) / n * (t1 + t2)
    modulus, alpha = np.where(y < t1, e1, e2), np.where(y < t1, a1, a2)
    rows = np.array([[np.sum(modulus), np.sum(modulus * y)], [np.sum(modulus * y), np.sum(modulus * y**2)]])
    _, curvature = np.linalg.solve(rows, [np.sum(modulus * alpha), np.sum(modulus * alpha * y)])
    assert thermal.bow_of_layers(0.28, t1, e1, a1, t2, e2, a2) == pytest.approx(abs(curvature) * 0.28**2 / 8, rel=1e-3)


def test_wedge_and_ellipse_of_the_thesis_screw():
    drive = height_adjustment.wedge_drive(25.4e-3 / 8, 1 / 20, 20e-3)
    assert drive.lift_per_turn == pytest.approx(158.75e-6, rel=1e-4)
    assert drive.lift_per_degree == pytest.approx(441e-9, rel=1e-3) and drive.range == pytest.approx(1e-3)
    # at the locking friction a push of zero just holds: the down-going force changes sign
    angle, rub = math.atan(1 / 20), math.atan(drive.locking_friction)
    assert math.tan(angle - rub) - math.tan(rub) == pytest.approx(0.0, abs=1e-12)
    assert height_adjustment.screw_force(100.0, 1 / 20, 0.0) == pytest.approx(5.0)
    path = tip_ellipse(10e-6, math.pi / 2, 46e-3, 20e-3)
    assert float(path.normal) / 2 == pytest.approx(7.071e-6, rel=1e-4)
    assert float(path.along) / 2 == pytest.approx(6.149e-6, rel=1e-4)


def test_threads_have_their_tabulated_areas_and_limits():
    """ASME B1.1: 3/8-16 UNC has a tensile stress area of 0.0775 in^2 and a basic pitch diameter of 0.3344 in."""
    thread = fastener.Thread(0.375 * 25.4e-3, 25.4e-3 / 16)
    assert thread.stress_area / 25.4e-3**2 == pytest.approx(0.0775, abs=1e-4)
    assert thread.pitch_diameter / 25.4e-3 == pytest.approx(0.3344, abs=1e-4)
    assert np.array(thread.least_screw) / 25.4e-3 == pytest.approx([0.3595, 0.3287], abs=1.5e-4)
    assert np.array(thread.largest_nut) / 25.4e-3 == pytest.approx([0.3401, 0.321], abs=6e-4)
    # By hand with these diameters, 216 mm^2 for the way's screws; the basic profile has 290.7 mm^2.
    assert fastener.strip_area_of_bed(thread, 11.1125e-3) == pytest.approx(216e-6, rel=0.01)
    # ISO 898-1: M10 57.99, M5 14.2, M6 20.1 mm^2. ISO 965-2: M10 6g in 6H, tolerances rounded.
    m10 = fastener.Thread(10e-3, 1.5e-3)
    assert m10.stress_area == pytest.approx(57.99e-6, rel=1e-4)
    assert fastener.Thread(5e-3, 0.8e-3).stress_area == pytest.approx(14.2e-6, abs=0.05e-6)
    assert fastener.Thread(6e-3, 1e-3).stress_area == pytest.approx(20.1e-6, abs=0.05e-6)
    assert np.array(m10.least_screw) * 1e3 == pytest.approx([9.732, 8.862], abs=6e-3)
    assert np.array(m10.largest_nut) * 1e3 == pytest.approx([9.206, 8.676], abs=6e-3)


def test_flanges_and_waves_of_screws():
    """7874 N on a head of 14.29 mm over a hole of 10.5 mm, 20 mm of part, 14.3 mm thick: 1.45 um by hand; cones of 45
    and 30 degrees, which parts of other widths would have, leave 803 nm and 1.18 um."""
    compliance = fastener.cone_compliance(14.2875e-3, 10.5e-3, 14.3e-3, 20e-3, 410e9)
    assert 7874.0 * float(compliance) == pytest.approx(1.446e-6, rel=1e-3)
    for tangent, give in ((1.0, 803e-9), (math.tan(math.radians(30.0)), 1.18e-6)):
        wide = 14.2875e-3 * math.exp((tangent - 0.348 - 0.013 * math.log(14.3 / 14.2875)) / 0.193)
        found = fastener.cone_compliance(14.2875e-3, 10.5e-3, 14.3e-3, wide, 410e9)
        assert 7874.0 * float(found) == pytest.approx(give, rel=5e-3)
    # The displacements of many point forces in a row, summed, and their first wave taken by a Fourier sum.
    force, pitch, away, modulus, poisson = 7.9e3, 38.1e-3, 30e-3, 410e9, 0.14
    row, along = np.arange(-4000, 4001) * pitch, np.arange(64) / 64 * pitch
    sunk = np.sum((1 - poisson**2) * force / (np.pi * modulus * np.hypot(along[:, None] - row, away)), axis=1)
    wave = 2 * np.abs(np.fft.rfft(sunk)[1]) / 64
    assert float(fastener.screw_waves(force, pitch, away, modulus, poisson)) == pytest.approx(wave, rel=1e-4)


def test_earnshaw_by_energy_differences():
    rng = np.random.default_rng(3)
    for _ in range(20):
        a, b, r = rng.normal(size=3), rng.normal(size=3), rng.normal(size=3) + np.array([0, 0, 3.0])

        def energy(place, a=a, b=b):
            d = np.linalg.norm(place)
            return 1e-7 * (a @ b / d**3 - 3 * (a @ place) * (b @ place) / d**5)

        step = 1e-3 * np.eye(3)
        rough = np.zeros((3, 3))
        for i, j, s, t in itertools.product(range(3), range(3), (1, -1), (1, -1)):
            rough[i, j] += s * t * energy(r + s * step[i] + t * step[j]) / (4 * 1e-3**2)
        exact = suspension.dipole_hessian(a, b, r)
        np.testing.assert_allclose(exact, rough, rtol=1e-4, atol=1e-5 * np.abs(exact).max())
        assert abs(np.trace(exact)) < 1e-12 * np.abs(exact).max() and np.linalg.eigvalsh(exact)[0] < 0


def test_clamps_squeeze_the_holder_and_tilt_the_actuator():
    """Two opposed line forces on a disc (Hertz's exact field): in-plane stresses summed over it grow its height."""
    force, diameter, height, modulus, poisson = 4e3, 76e-3, 36.6e-3, 141e9, 0.29
    radius = diameter / 2
    shift = height_adjustment.clamp_shift(2 * force, diameter, height, 0.0, 60e-3, modulus, poisson)
    r = (np.arange(1500) + 0.5) / 1500 * radius
    R, T = np.meshgrid(r, (np.arange(1440) + 0.5) / 1440 * 2 * np.pi)
    x, y = R * np.cos(T), R * np.sin(T)
    per_length = force / height

    def radial(depth, side):  # stress towards a force on the rim: -2 P cos(angle)/(pi distance)
        return -2 * per_length * depth / (np.pi * (depth**2 + side**2))

    total = radial(radius - y, x) + radial(radius + y, x) + 2 * 2 * per_length / (np.pi * diameter)
    mean = np.sum(total * R) / np.sum(R)
    assert shift.squeeze == pytest.approx(-poisson / modulus * mean * height, rel=2e-3)
    shift = height_adjustment.clamp_shift(0.0, 76e-3, 36.6e-3, 50e-6, 62e-3, 141e9, 0.29)
    apex = Rotation.from_euler("y", 50e-6 / 36.6e-3).apply([0.0, 0.0, 62e-3])
    assert shift.squeeze == 0.0 and shift.drop == pytest.approx(62e-3 - apex[2], rel=1e-6)
    assert shift.sideways == pytest.approx(apex[0] + 25e-6)


def test_the_index_of_air_goes_with_its_density():
    """n - 1 at 20 degC and 101.325 kPa is 2.714e-4, as the density of the air: 186 nm/K over 200 mm."""
    n, kelvin, pascal = 2.714e-4, 293.15, 101325.0
    warmer = 0.2 * n * (1 - kelvin / (kelvin + 1))
    assert float(sensors.air_index_error(0.2, 1.0, 0.0)) == pytest.approx(warmer, rel=0.01)
    assert float(sensors.air_index_error(0.2, 1.0, 0.0)) == pytest.approx(186e-9, rel=1e-3)
    assert float(sensors.air_index_error(0.2, 0.0, 100.0)) == pytest.approx(0.2 * n * 100 / pascal, rel=0.01)


def test_floor_motion_is_that_of_an_oscillator_under_noise_in_third_octaves():
    """Response integrated numerically; 5.0 nm at 327 Hz, 4.5 times that of one component of 25 um/s at 30 Hz."""
    velocity = 25e-6

    def response(first, damping):
        total = 0.0
        for middle in thermal.THIRD_OCTAVES:
            low, high = middle * 2 ** (-1 / 6), middle * 2 ** (1 / 6)

            def power(f, width=high - low):
                r = f / first
                gain = r**4 / ((1 - r**2) ** 2 + (2 * damping * r) ** 2)
                return velocity**2 / width / (2 * math.pi * f) ** 2 * gain

            total += quad(power, low, high, points=[first] if low < first < high else None, limit=500)[0]
        return math.sqrt(total)

    for first, damping in ((327.0, 0.02), (63.0, 0.02), (63.0, 0.3), (5.0, 0.1)):
        moved = float(thermal.floor_motion(velocity, first, damping))
        assert moved == pytest.approx(response(first, damping), rel=1e-6)
    assert float(thermal.floor_motion(velocity, 327.0, 0.02)) == pytest.approx(5.0e-9, rel=0.02)
    single = velocity * 2 * math.pi * 30 / (2 * math.pi * 327) ** 2
    assert float(thermal.floor_motion(velocity, 327.0, 0.02)) / single == pytest.approx(4.5, rel=0.02)


def test_budgets_add_rigid_transforms():
    turn, about, point = (0.3, -0.2, 0.5), (0.1, 0.2, -0.1), np.array([0.4, 0.0, 0.3])
    part = error_budget.Contribution("x", "test", (1e-3, 0, 2e-3), turn, about)
    expected = Rotation.from_rotvec(turn).apply(point - about) + about + [1e-3, 0, 2e-3] - point
    np.testing.assert_allclose(error_budget.error_at(part, point), expected, atol=1e-15)
    parts = [
        error_budget.Contribution("a", "s", (3e-9, 0, 0)),
        error_budget.Contribution("b", "s", (4e-9, 0, 0)),
        error_budget.Contribution("c", "s", (-1e-9, 0, 0), random=False),
        error_budget.Contribution("tilt", "s", rotation=(0, 1e-6, 0)),
    ]
    rows, total = error_budget.budget(parts, (0.0, 0.0, 0.02))
    assert [row[0].name for row in rows] == ["tilt", "b", "a", "c"]
    assert total[0] == pytest.approx(math.sqrt(9e-18 + 16e-18 + (0.02 * 1e-6) ** 2) + 1e-9)


def test_two_uniform_dimensions_and_sizes_that_cancel() -> None:
    """Their sum has a triangular density: 0.2 mm (1 - sqrt(0.0027)); normal ones would give 0.14 mm."""
    chain = Chain("n", tuple(Link(key, 1.0, 0.0, -1e-4, 1e-4) for key in ("a", "b")))
    assert chain.statistical[1] == pytest.approx(2e-4 * (1 - math.sqrt(0.0027)), rel=2e-3)
    assert chain.statistical[1] == pytest.approx(190e-6, rel=0.01)
    terms = (1, 0.1), (1, 0.2), (-1, 0.3)
    links = tuple(Link(f"key_{size}", factor, size, 0.0, 0.0) for factor, size in terms)
    assert 0.1 + 0.2 - 0.3 != 0.0 and Chain("n", links).nominal == 0.0
    assert Chain("n", links, 1e-12).nominal == pytest.approx(1e-12)
    np.testing.assert_allclose(suspension.rank_sum([[1.0, 5.0], [2.0, 5.0], [3.0, 1.0]]), [1 + 2.5, 2 + 2.5, 3 + 1])


def test_katos_law_at_three_dwell_times() -> None:
    effect = compose(["coulomb", "dwell_strengthening:kato"]).effects[1]
    age = np.array([0.1, 1.0, 10.0])
    axis = Axis(*[0.0 * age] * 6, age, *[0.0 * age] * 2)
    level = 1.0 + effect.level(axis, effect.values(force=0.1, rate=1.66, exponent=0.65, memory_length=1e-4))
    assert level == pytest.approx([1.031039, 1.080986, 1.099940], abs=1e-6)
