"""Profiles of the way: statistics of what is made up, and what pads make of roughness and waves."""

import numpy as np
import pytest

from designcalc.bearing.sliding import averaged_roughness
from designcalc.bearing.way_profile import Surface, carried_height, carried_waves, synthetic_profiles
from stagecad.parameters.errors import InputError

ROUGH = Surface(roughness=20e-9, correlation_length=20e-6, waviness=0.0, wavelength=10e-3)
SIDE = 0.8e-3


def test_the_made_up_profile_has_its_roughness_and_its_correlation():
    profiles, step = synthetic_profiles(ROUGH, 0.5, SIDE, 3)
    across = np.sqrt(np.sqrt(np.pi) * ROUGH.correlation_length / (4 * np.pi / 15 * SIDE))
    assert np.std(profiles) == pytest.approx(ROUGH.roughness * np.sqrt(np.pi / 2) * across, rel=0.02)
    lag = round(ROUGH.correlation_length / step)
    assert np.mean(profiles[:, lag:] * profiles[:, :-lag]) / np.var(profiles) == pytest.approx(np.exp(-1), abs=0.02)
    again, _ = synthetic_profiles(ROUGH, 0.5, SIDE, 3)
    np.testing.assert_array_equal(profiles, again)


@pytest.mark.parametrize("count", [1, 3])
def test_the_profile_is_periodic_white_noise_behind_a_filter_of_its_whole_length(count):
    profiles, _ = synthetic_profiles(ROUGH, 0.05, SIDE, count)
    n = profiles.shape[1]
    white = np.random.default_rng(1).standard_normal(1 << (count * n - 1).bit_length())[: count * n].reshape(count, n)
    wave_number = 2 * np.pi * np.fft.fftfreq(n, 0.25)
    gain = np.exp(-(wave_number**2) / 8)
    filtered = np.fft.ifft(np.fft.fft(white) * gain).real / np.sqrt(np.mean(gain**2))
    scale = np.std(profiles) / np.std(filtered)
    np.testing.assert_allclose(profiles / scale, filtered, atol=1e-8)


def test_pads_leave_of_roughness_what_the_closed_form_says():
    profiles, step = synthetic_profiles(ROUGH, 1.0, SIDE, 3)
    left = np.std(carried_height(profiles, step, SIDE))
    circle = float(averaged_roughness(ROUGH.roughness, ROUGH.correlation_length, SIDE / 2, 3))
    assert left == pytest.approx(circle, rel=0.05)


def test_waves_longer_than_the_contact_pass_and_opposed_ones_cancel():
    waves = Surface(roughness=0.0, correlation_length=20e-6, waviness=5e-9, wavelength=10e-3)
    in_step, step = synthetic_profiles(waves, 0.3, SIDE, 2)
    half = np.pi * SIDE / waves.wavelength
    transfer = 3 * (np.sin(half) - half * np.cos(half)) / half**3  # Fourier transform of a parabola
    # the contact is rounded down to whole steps of the profile, and its weights to points
    assert np.std(carried_height(in_step, step, SIDE)) == pytest.approx(5e-9 / np.sqrt(2) * transfer, rel=2e-3)
    opposed, _ = synthetic_profiles(waves, 0.3, SIDE, 2, phase=np.pi)
    assert np.std(carried_height(opposed, step, SIDE)) < 1e-12


def test_waves_in_closed_form_are_those_of_the_profiles():
    waves = Surface(roughness=0.0, correlation_length=20e-6, waviness=5e-9, wavelength=7e-3)
    profiles, step = synthetic_profiles(waves, 0.3, SIDE, 2, phase=0.7)
    starts, size = np.array([0, 811, 405]), 50_000
    rows = [profiles[track, start : start + size] for track, start in zip((0, 1, 1), starts)]
    phases = np.array([0.0, 0.7, 0.7])
    found = carried_waves(waves, starts, phases, step, size, SIDE)
    assert found == pytest.approx(np.std(carried_height(rows, step, SIDE)), rel=1e-9)


@pytest.mark.parametrize(
    "call, words",
    [
        (lambda: Surface(1e-8, 0.0, 0.0, 1e-2), "correlation length must be above 0"),
        (lambda: Surface(1e-8, 1e-5, -1e-9, 1e-2), "waviness must be 0 or more"),
        (lambda: synthetic_profiles(ROUGH, 0.3, 30e-6, 1), "a third of the contact"),
        (lambda: synthetic_profiles(ROUGH, 1e-4, SIDE, 1), "twenty correlation lengths"),
    ],
)
def test_outside_the_range_is_said(call, words):
    with pytest.raises(InputError, match=words):
        call()
