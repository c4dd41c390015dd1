"""Fine motion by the pressed tip: its gain by the margin, and feedforward through the inverse of stacks and pads."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from stage_machines import example

from sim.stage.drive_setting import TipDrive
from sim.stage.run import drive_stage
from sim.stage.statics import over_drive_surface
from sim.stage.studies.coupling import with_ample_amplifier
from sim.stage.studies.fine_motion import (
    FEEDFORWARD,
    MARGIN,
    FineController,
    HeldStage,
    held_stage,
    inverse_hysteresis,
    tracking_error,
)

PERIOD = 2e-4
FREQUENCY = np.fft.rfftfreq(2000, PERIOD)[1:]


def test_the_largest_rate_of_a_stage_without_dynamics_is_that_of_the_closed_form():
    """L = w T/(z - 1) is largest against -1 at half the sampling rate: 1/|1 + L| = 1/(1 - w T/2)."""
    stiff = HeldStage(PERIOD, 0.02, FREQUENCY, np.ones(FREQUENCY.size, complex))
    assert stiff.largest_rate(1.0, stiff.notches()) * PERIOD == pytest.approx(2.0 * (1.0 - 1.0 / MARGIN), rel=0.03)
    assert not stiff.notches().size


def test_notches_allow_a_larger_rate_and_remove_the_resonance():
    r = FREQUENCY / 240.0
    held = HeldStage(PERIOD, 0.02, FREQUENCY, 1.0 / (1.0 - r**2 + 0.1j * r))
    with_notch, without = FineController(held, 1.0), FineController(held, 1.0, notched=False)
    # Of an integrator and a resonance 1/(2 zeta) high: the peak of L, w/(2 zeta w_1), is 1 - 1/Ms at the phase of -1.
    assert without.rate == pytest.approx(0.1 * 2.0 * math.pi * 240.0 * (1.0 - 1.0 / MARGIN), rel=0.15)
    assert with_notch.rate > 3.0 * without.rate
    # The sections as they run, against their frequency response: a lean that follows 240 Hz is stopped.
    time = PERIOD * np.arange(4000)
    errors = np.diff(np.sin(2.0 * math.pi * 240.0 * time), prepend=0.0) * 1e-9 / with_notch.per_error
    lean = np.array([with_notch.lean(error) for error in errors])
    assert np.abs(lean[-1000:]).max() < 1e-3 * np.abs(lean[:20]).max()


@pytest.mark.slow
def test_voltages_of_the_inverse_give_the_stretch_in_the_simulated_stack():
    machine = with_ample_amplifier(example())
    machine = replace(machine, piezo=replace(machine.piezo, creep=0.0))
    time = np.arange(40_000) * 1e-6
    wanted = 4e-6 * np.sin(2.0 * math.pi * 50.0 * time) + 2e-6 * np.sin(2.0 * math.pi * 110.0 * time)
    volts = machine.piezo.bias + inverse_hysteresis(machine.piezo, wanted)
    rest = over_drive_surface(machine, 0.0, -1e-4)
    run = drive_stage(machine, rest, np.repeat(volts[:, None, None], 3, axis=2), 1e-6)
    height, asked = run.apex(0)[:, 2], np.interp(run.time, time, wanted)
    linear = (volts - machine.piezo.bias) * machine.piezo.stroke / machine.piezo.highest_voltage
    late = run.time > 0.01
    # The mean gain is off by the loop; what is left here is the lag of the mechanics.
    assert np.abs(linear - wanted).max() > 3e-7
    assert np.abs(height - asked)[late].max() < 2e-8


def test_each_part_of_the_feedforward_lowers_the_tracking_error():
    machine = example()
    # Stacks that bend, so that the tip has to lean by micrometres.
    machine = replace(machine, tip=replace(machine.tip, sway_stiffness=5e5, sway_damping=5.0))
    drive = TipDrive(machine, 8.5e-6, math.pi / 2, 5000.0)
    held = held_stage(drive)
    errors = [tracking_error(drive, held, kind) for kind in FEEDFORWARD]
    assert errors == sorted(errors, reverse=True) and errors[-1] < machine.sensors.interferometer_count
