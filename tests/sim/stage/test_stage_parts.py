"""Stacks, presliding curves, sensors and loops of the driven stage, each by itself."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from stage_machines import example, ideal_piezos

from sim.stage.piezo import piezo_response
from sim.stage.sensors import FilteredProbe, Interferometer, Lvdt
from sim.stage.simulation import drive_stage
from sim.stage.slip_elements import mindlin, parabola, slip_springs
from sim.stage.statics import over_drive_surface
from sim.stage.studies.coupling import with_ample_amplifier
from sim.stage.studies.planar import directed
from sim.stage.studies.positioning import LOOPS, move_to
from sim.stage.studies.steps import converter_count
from sim.stage.waveforms import largest_stroke, step_times, two_piezo_ellipse, volts_for

STEP = 1e-6
FAR_BELOW = -1e-4


def free_apex(machine, volts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Height of an apex out of touch under a common voltage, m, and the voltage, V."""
    run = drive_stage(
        machine, over_drive_surface(machine, 0.0, FAR_BELOW), np.repeat(volts[:, None, None], 3, axis=2), STEP
    )
    return run.apex(0)[:, 2], run.voltage(0)[:, 0]


def test_a_whole_sweep_has_the_catalogue_stroke_and_hysteresis():
    machine = with_ample_amplifier(example())
    machine = replace(machine, piezo=replace(machine.piezo, creep=0.0))
    triangle = np.interp(np.arange(100_000), [0, 20_000, 60_000, 100_000], [75.0, 150.0, 0.0, 150.0])
    height, volts = free_apex(machine, triangle)
    assert np.ptp(height[2000:]) == pytest.approx(17e-6, rel=5e-3)
    down, up = slice(2000, 6000), slice(6000, 10_000)
    falling = np.interp(75.0, volts[down][::-1], height[down][::-1])
    rising = np.interp(75.0, volts[up], height[up])
    assert (falling - rising) / 17e-6 == pytest.approx(0.12, rel=0.02)


def test_a_small_wave_moves_no_play():
    response = piezo_response(example().piezo)
    # Stroke 17 um at 150 V, of which plays keep back their share; small waves have the play-free slope.
    assert response.small_signal_gain < 17e-6 / 150.0 < response.gain
    volts = np.interp(np.arange(20_000), [0, 10_000, 20_000], [75.0, 78.0, 75.0])
    machine = with_ample_amplifier(example())
    height, _ = free_apex(replace(machine, piezo=replace(machine.piezo, creep=0.0)), volts)
    assert np.ptp(height) == pytest.approx(3.0 * response.small_signal_gain, rel=5e-3)


def test_creep_gains_its_share_a_decade():
    machine = ideal_piezos(example())
    machine = replace(machine, piezo=replace(machine.piezo, creep=0.02))
    volts = np.full(1_000_000, 85.0)
    height, _ = free_apex(machine, volts)
    at = [height[int(t * 1e5) - 1] for t in (0.03, 0.99)]
    # Between 0.03 and 1 s the ladder of lags from 0.1 s on has just begun to climb: some four tenths of a decade of it.
    first = 10.0 * 17e-6 / 150.0
    times = 0.1 * 10.0 ** (3.0 * np.arange(13) / 12)
    ladder = [1.0 + 0.005 * np.sum(1.0 - np.exp(-t / times)) for t in (0.03, 0.99)]
    assert at == pytest.approx([first * gain for gain in ladder], rel=2e-4)


def test_the_amplifiers_current_limits_the_rate():
    machine = example()
    wave = 75.0 + 75.0 * np.sin(2.0 * math.pi * 5000.0 * step_times(4000, STEP))
    _, volts = free_apex(machine, wave)
    slope = np.abs(np.diff(volts)) / (10 * STEP)
    assert slope.max() == pytest.approx(2.0 / 1.4e-6, rel=1e-3)
    assert machine.piezo.unclipped_frequency(8.5e-6) == pytest.approx(2.0 / 1.4e-6 / (2 * math.pi * 75.0))


@pytest.mark.parametrize("curve", [mindlin, parabola])
def test_elements_follow_their_curve_and_masings_rule(curve):
    _, stiffness, caps = slip_springs(curve)
    assert caps.sum() == pytest.approx(1.0)

    def force(stretch: np.ndarray, start: np.ndarray, reach: float = 1.0) -> np.ndarray:
        """Of all elements moved on by `stretch` from forces `start`, each kept within `reach` caps."""
        each = start[:, None] + stiffness[:, None] * stretch
        return np.clip(each, -reach * caps[:, None], reach * caps[:, None])

    u = np.linspace(0.0, 1.0, 101)
    loading = force(u, np.zeros(4)).sum(axis=0)
    assert np.abs(loading - curve(u)).max() < 0.04
    turned = force(-2.0 * u, force(np.array([1.0]), np.zeros(4))[:, 0]).sum(axis=0)
    assert turned == pytest.approx(1.0 - 2.0 * loading, abs=1e-12)


def test_filtered_probe_leaves_the_noise_of_its_filter_and_ends_at_its_range():
    sensors = example().sensors
    probe = FilteredProbe(sensors, 2e-4, target=1e-3)
    seen = np.array([probe.read(1e-3) for _ in range(60_000)])
    assert np.std(seen[500:]) == pytest.approx(25e-9 * math.sqrt(24 / 5000), rel=0.05)
    far = FilteredProbe(sensors, 2e-4, target=0.0)
    assert far.read(5e-6) == pytest.approx(0.5e-6, abs=sensors.filtered_count)


def test_counts_and_linearity_of_the_other_sensors():
    sensors = example().sensors
    assert Interferometer(sensors, 1e-4).read(1e-9) == pytest.approx(2 * 0.62e-9)
    assert Lvdt(sensors, 1e-4).read(0.0) == pytest.approx(10 * 6.2e-6)


def test_the_thesis_ellipse_and_its_turned_copies_keep_within_the_stroke():
    machine = example()
    ellipse = two_piezo_ellipse(machine, 8.5e-6, math.pi / 2)
    assert 2 * ellipse.along == pytest.approx(10.45e-6, rel=1e-3)
    for direction in np.linspace(0.0, 2 * math.pi, 13):
        turned = directed(machine, 8.5e-6, math.pi / 2, float(direction))
        angle = np.linspace(0.0, 2 * math.pi, 721)
        along = -turned.along * np.cos(angle)
        x, y = along * math.cos(direction), along * math.sin(direction)
        volts = volts_for(machine, x, y, turned.normal * np.sin(angle)) - 75.0
        assert np.abs(volts).max() == pytest.approx(75.0, rel=1e-4)
        assert largest_stroke(machine, turned) == pytest.approx(8.5e-6)


def test_a_count_of_the_converter_is_a_fifth_of_a_nanometre():
    assert converter_count(example()) == pytest.approx(2 * 20 / 46 * 17e-6 / 2**16)


def test_the_loop_settles_to_a_nanometre_by_interferometer_and_not_past_an_lvdt():
    machine = example()
    fine = move_to((machine, 8.5e-6, math.pi / 2, 5000.0, LOOPS["interferometer"]))
    assert fine.taken_over is not None
    assert np.abs(fine.error[-500:].mean()) < 1e-9
    assert fine.within(1e-9) is not None
    lost = move_to((machine, 8.5e-6, math.pi / 2, 5000.0, LOOPS["lvdt_and_probe"]))
    assert np.abs(lost.error[-500:]).min() > 50e-6
    assert lost.within(1e-9) is None
