"""Every calculator takes arrays where it takes a number, element by element, and says when it is out of its range."""

import dataclasses

import numpy as np
import pytest

from designcalc.bearing import bolted_rail, fastener, porous_air, sliding
from designcalc.bearing.plate import Plate, SupportedPlate
from designcalc.bearing.way_profile import Surface, synthetic_profiles
from designcalc.contact import film, hertz, pulsed
from designcalc.drive import friction_drive, height_adjustment, magnetic_teeth, piezo_stack, tip_ellipse
from designcalc.drive.thermal_network import ThermalNetwork
from designcalc.errors import dynamic_budget, sensors, thermal
from tests.refusals import refused

RAIL = (0.28, 0.01, 0.07, 0.0254, 9.525e-3, 410e9, 141e9, 207e9, 0.14, 0.29, 10.0)
THREAD = fastener.Thread(9.525e-3, 25.4e-3 / 16)


def of_rail(*numbers):
    return bolted_rail.total_stiffness(bolted_rail.Rail(*numbers), 4.0, 1.5)


CALLS = [
    (of_rail, RAIL), (hertz.contact_modulus, (207e9, 0.3, 69e9, 0.33)),
    (hertz.point_contact, (10.0, 0.02, 0.5, 50e9, 0.03, 0.6)), (hertz.line_contact, (10.0, 0.01, 0.02, 0.5, 50e9)),
    (fastener.preload_of_torque, (15.0, 9.525e-3, 0.2)),
    (lambda depth: fastener.strip_area_of_bed(THREAD, depth), (0.011,)),
    (lambda depth: fastener.strip_area_of_screw(THREAD, depth), (0.011,)),
    (fastener.screw_waves, (7.9e3, 38e-3, 50e-3, 410e9, 0.14)),
    (tip_ellipse.tip_ellipse, (8.5e-6, 1.5, 46e-3, 20e-3)),
    (friction_drive.acceleration_limit, (0.3, 0.1, 0.5, 0.05)), (friction_drive.preload_ratio_for, (9.8, 0.3)),
    (friction_drive.resonance, (47e6, 0.1)), (piezo_stack.piezo_stiffness, (800.0, 17e-6)),
    (piezo_stack.stack_heat, (1.4e-6, 150.0, 5e3, 0.05)), (piezo_stack.stack_current, (1.4e-6, 150.0, 5e3)),
    (height_adjustment.wedge_drive, (3.175e-3, 0.05, 20e-3)),
    (height_adjustment.clamp_shift, (8e3, 76e-3, 36e-3, 50e-6, 62e-3, 141e9, 0.29)),
    (height_adjustment.screw_force, (100.0, 0.05, 0.15)),
    (magnetic_teeth.teeth_field, (2e-3, 0.8e-3, 0.4e-3, 1e-3, 0.1e-3)),
    (piezo_stack.stack_tension, (0.03, 8e-6, 5e3, 12e-6, 3e-4, 46e-3)),
    (piezo_stack.sway_stiffness, (36e-3, 25e-6, 50e9)), (piezo_stack.drive_pull, (10.0, 20e-3, 46e-3)),
    (piezo_stack.side_load, (3.3, 36e-3, 5e-3, 25e-6, 50e9, 25e-6)), (piezo_stack.rocking_stiffness, (47e6, 46e-3)),
    (piezo_stack.tip_inertia, (0.03, 0.026, 0.02)),
    (lambda gap: porous_air.stiffness_of_gap(gap, 5e-6, 90.0, 25.4e-3, 413e3), (4e-6,)),
    (lambda span: sensors.count_size(span, 12.0), (25.4e-3,)), (sensors.filtered_noise, (25e-9, 5e3, 24.0)),
    (sensors.velocity_noise, (6e-6, 1e3)), (sensors.lag_error, (0.2, 500.0)),
    (sensors.air_index_error, (0.2, 1.0, 100.0)), (sensors.abbe_error, (0.02, 1e-5)),
    (sensors.cosine_error, (0.2, 1e-4)), (lambda load: film.film_contact(load, 2.0, 2e-6, 1e9, 60e9), (10.0,)),
    (sliding.crown_wear_distance, (1e-6, 2.0, 1e-15, 16.0)), (sliding.crown_wear_depth, (1200.0, 2.0, 1e-15, 16.0)),
    (sliding.averaged_roughness, (20e-9, 20e-6, 0.75e-3)), (sliding.friction_heat, (0.05, 33.0, 0.2)),
    (thermal.differential_growth, (0.28, 4e-6, 1.3e-6)),
    (thermal.bow_of_layers, (0.28, 0.025, 410e9, 4e-6, 0.09, 141e9, 1.3e-6)),
    (thermal.floor_motion, (25e-6, 330.0, 0.02)),
]  # fmt: skip


def numbers(result):
    if dataclasses.is_dataclass(result):
        return [np.asarray(value, float) for value in vars(result).values()]
    return [np.asarray(result, float)]


@pytest.mark.parametrize("call, arguments", CALLS, ids=lambda item: getattr(item, "__name__", ""))
def test_an_array_gives_what_its_elements_give(call, arguments):
    scales = np.array([[0.97, 1.0, 1.02]])
    alone = [numbers(call(*[a * scale for a in arguments])) for scale in scales[0]]
    together = numbers(call(*[a * scales for a in arguments]))
    for index, values in enumerate(together):
        expected = [found[index] for found in alone]
        np.testing.assert_allclose(np.broadcast_to(values, (1, 3))[0], expected, rtol=1e-12)


STAGE = Plate(0.230, 0.270, 0.012, 68.9e9, 0.33, 2700.0)
ROUGH = Surface(20e-9, 20e-6, 0.0, 10e-3)
SECTION = magnetic_teeth.MagnetSection(5e-3, 2e-3, 1e-3, 2.5e-3, 2, 8e-3, 5e-3, 5e-3, 6e-3)
OUTSIDE = [
    (bolted_rail.Rail, (*RAIL[:-3], 0.7), "poisson: must lie in 0 to 0.5"),
    (bolted_rail.Rail, (*RAIL[:-2], 0.7), "bed-poisson: must lie in 0 to 0.5"),
    (bolted_rail.Rail, (np.array([0.28, -1.0]), *RAIL[1:]), "length: must be above 0 m"),
    (bolted_rail.total_stiffness, (bolted_rail.Rail(*RAIL), 1.0, 1.5), "spacing-ratio: must be above 1"),
    (bolted_rail.joint_stiffness, (bolted_rail.Rail(*RAIL), 0.0), "flange-ratio: must be above 0"),
    (Plate, (0.1, 0.1, 0.0, 70e9, 0.3, 2700.0), "thickness"), (Plate, (0.1, 0.1, 1e-3, 70e9, 0.6, 2700.0), "poisson"),
    (SupportedPlate, (STAGE, [((0.2, 0.0), 1e6)]), "outside the plate"),
    (fastener.preload_of_torque, (15.0, 9.5e-3, 0.9), "nut factor 0.05 to 0.5"),
    (fastener.strip_area_of_bed, (THREAD, 0.0), "engagement"),
    (fastener.screw_waves, (7.9e3, 38e-3, 7.6e-3, 410e9, 0.14), "a quarter pitch"),
    (hertz.point_contact, (0.0, 1.0, np.inf, 1e9), "load: must be above 0 N"),
    (hertz.point_contact, (10.0, 0.02, np.inf, np.inf), "modulus: must be above 0 Pa, and finite"),
    (hertz.point_contact, (1e6, 1e-3, np.inf, 50e9), "not small compared with their radii"),
    (hertz.point_contact, (1.0, np.inf, np.inf, 1e9), "curvatures"),
    (hertz.point_contact, (1.0, 1.0, -0.5, 1e9), "curvatures"),
    (hertz.point_contact, (1.0, 1.0, np.inf, 1e9, np.inf), "line contact"),
    (hertz.contact_modulus, (1e9, 0.6, 1e9, 0.3), "poisson: must lie in 0 to 0.5"),
    (hertz.contact_modulus, (np.inf, 0.3, np.inf, 0.3), "rigid"),
    (hertz.line_contact, (1.0, 0.0, 1.0, np.inf, 1e9), "length: must be above 0 m"),
    (pulsed.peak_of_mean, (-1.0, 12e-6, 7e9, 1.4e8), "mean, contact and stiffness must be above 0"),
    (film.film_contact, (10.0, 2.0, 5e-3, 1e9, 60e9), "the formula is for thin films"),
    (film.film_contact, (0.0, 2.0, 2e-6, 1e9, 60e9), "load: must be above 0 N"),
    (film.confined_modulus, (0.5e9, 0.5), "poisson"), (sliding.crown_wear_depth, (1200.0, 2.0, 0.0, 16.0), "wear rate"),
    (sliding.averaged_profile, (np.arange(0.0, 0.1, 1e-4), 1e-4, 1.0), "3 or more"),
    (sliding.pad_loads, ([(0, 0), (1, 1), (2, 2)], 10.0, (0, 0)), "must not lie on one line"),
    (sliding.crown_wear_distance, (1.0, 2.0, 1e-15, 16.0), "the depth 0 to a tenth of the radius"),
    (sliding.friction_heat, (-0.1, 1.0, 1.0), "friction, load and speed must be 0 or more"),
    (Surface, (1e-8, 0.0, 0.0, 1e-2), "correlation length must be above 0"),
    (Surface, (1e-8, 1e-5, -1e-9, 1e-2), "waviness must be 0 or more"),
    (synthetic_profiles, (ROUGH, 0.3, 30e-6, 1), "a third of the contact"),
    (synthetic_profiles, (ROUGH, 1e-4, 0.8e-3, 1), "twenty correlation lengths"),
    (friction_drive.tip_force_limit, ([(0, 0), (1, 0), (0, 1)], (0.2, 0.2), (np.nan, 0.0)), "must be finite"),
    (friction_drive.tip_force_limit, ([(0, 0), (1, 1), (2, 2)], (0, 0), (0, 1)), "one line"),
    (friction_drive.acceleration_limit, (0.3, 0.1, 1.5), "the share 0 to 1"),
    (friction_drive.preload_ratio_for, (1.0, 0.0), "friction: must be above 0"),
    (friction_drive.resonance, (1.0, 0.0), "stiffness and mass must be above 0"),
    (tip_ellipse.tip_ellipse, (1e-5, 1.0, 0.0, 1.0), "piezo spacing and tip height must be above 0"),
    (tip_ellipse.speed_of, (0.0, 1.0), "travel of the tip must be above 0"),
    (tip_ellipse.frequency_for, (-1.0, 1e-5), "travel of the tip must be above 0"),
    (piezo_stack.piezo_stiffness, (800.0, 0.0), "blocking force and free stroke must be above 0"),
    (piezo_stack.stack_heat, (1e-6, 150.0, 1e3, 1.5), "the loss factor 0 to 1"),
    (piezo_stack.stack_current, (0.0, 150.0, 1e3), "capacitance must be above 0"),
    (piezo_stack.stack_tension, (-1.0, 1.0, 1.0, 1.0, 1.0, 1.0), "mass, inertia, frequency and motion must be above 0"),
    (piezo_stack.sway_stiffness, (0.0, 25e-6, 50e9), "above 0"), (piezo_stack.drive_pull, (1.0, 1.0, 0.0), "above 0"),
    (piezo_stack.side_load, (1.0, 36e-3, 72e-3, 25e-6, 50e9, 0.0), "at most the whole length"),
    (piezo_stack.rocking_stiffness, (0.0, 1.0), "above 0"), (piezo_stack.tip_inertia, (1.0, 1.0, 0.0), "above 0"),
    (height_adjustment.wedge_drive, (1e-3, 1.5, 0.02), "the slope 0 to 1"),
    (height_adjustment.screw_force, (-1.0, 0.05, 0.1), "load and friction must be 0 or more"),
    (height_adjustment.clamp_shift, (1.0, 76e-3, 36.6e-3, 0.0, 62e-3, 141e9, 0.6), "Poisson"),
    (magnetic_teeth.teeth_field, (5e-3, 5e-3, 1e-3), "tooth-width"),
    (magnetic_teeth.teeth_field, (5e-3, 2e-3, 0.0), "gap: 0 m must be above 0"),
    (magnetic_teeth.teeth_field, (5e-3, 2e-3, 1e-6), "gap over pitch"),
    (magnetic_teeth.teeth_field, (-5e-3, 2e-3, 1e-3), "pitch"),
    (magnetic_teeth.magnet_forces, (SECTION, 0.0, 1.2, 1.05), "must be above 0"),
    (magnetic_teeth.magnet_forces, (SECTION, 40e-3, -1.0, 1.05), "must be above 0"),
    (magnetic_teeth.magnet_forces, (SECTION, 40e-3, 1.2, 0.0), "must be above 0"),
    (sensors.count_size, (0.02, 12.5), "whole number in 1 to 32"), (sensors.count_size, (0.02, 40), "in 1 to 32"),
    (sensors.count_size, (0.0, 12), "span: must be above 0 m"), (sensors.velocity_noise, (0.0, 1e3), "must be above 0"),
    (sensors.lag_error, (0.2, 0.0), "bandwidth"), (dynamic_budget.band_density, (1.0, 0.0), "bandwidth"),
    (dynamic_budget.PositionLoop, (0.0, 470.0, 0.05, 24.0, 5e3), "above 0"),
    (ThermalNetwork, (np.ones(1), np.zeros((1, 1)), np.zeros(1)), "outside"),
    (sensors.filtered_noise, (1e-9, 24.0, 5e3), "above 0 and at most at the bandwidth"),
    (sensors.abbe_error, (0.02, 2.0), "-90 to 90 deg"), (sensors.cosine_error, (-0.2, 0.0), "-90 to 90 deg"),
    (thermal.floor_motion, (25e-6, 330.0, 0.0), "the resonance above 0"),
    (thermal.bow_of_layers, (0.28, 0.0, 1e9, 0.0, 0.1, 1e9, 0.0), "thickness: must be above 0"),
]  # fmt: skip


@pytest.mark.parametrize("call, arguments, words", OUTSIDE, ids=lambda item: getattr(item, "__name__", ""))
def test_outside_its_range_a_calculator_says_so(call, arguments, words):
    refused(words, call, *arguments)
