"""Stacks, presliding curves, sensors and loops of the driven stage, each by itself."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter
from stage_machines import example, ideal_piezos

from designcalc.drive.piezo_stack import stack_tension
from sim.stage import drive_setting
from sim.stage.constants import piezo_response
from sim.stage.machine import Surroundings
from sim.stage.sensors import Disturbances, FilteredProbe, Interferometer, Lvdt
from sim.stage.simulation import drive_stage
from sim.stage.slip_elements import mindlin, parabola, slip_springs
from sim.stage.statics import over_drive_surface
from sim.stage.studies import fine_motion, tip_motion
from sim.stage.studies.coupling import with_ample_amplifier
from sim.stage.studies.feedforward import FEEDFORWARD, inverse_hysteresis
from sim.stage.studies.planar import directed
from sim.stage.studies.positioning import LOOPS, move_to
from sim.stage.studies.speed import SUDDEN
from sim.stage.studies.tip_motion import loads

STEP = 1e-6
FAR_BELOW = -1e-4
PERIOD = 2e-4
FREQUENCY = np.fft.rfftfreq(2000, PERIOD)[1:]


def free_apex(machine, volts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Height of an apex out of touch under a common voltage, m, and the voltage, V."""
    rest = over_drive_surface(machine, 0.0, FAR_BELOW)
    run = drive_stage(machine, rest, np.repeat(volts[:, None, None], 3, axis=2), STEP)
    return run.apex(0)[:, 2], run.voltage(0)[:, 0]


def test_a_stack_has_the_catalogue_stroke_creep_and_rate():
    machine = with_ample_amplifier(example())
    machine = replace(machine, piezo=replace(machine.piezo, creep=0.0))
    triangle = np.interp(np.arange(100_000), [0, 20_000, 60_000, 100_000], [75.0, 150.0, 0.0, 150.0])
    height, volts = free_apex(machine, triangle)
    assert np.ptp(height[2000:]) == pytest.approx(17e-6, rel=5e-3)
    down, up = slice(2000, 6000), slice(6000, 10_000)
    falling = np.interp(75.0, volts[down][::-1], height[down][::-1])
    assert (falling - np.interp(75.0, volts[up], height[up])) / 17e-6 == pytest.approx(0.12, rel=0.02)
    response = piezo_response(example().piezo)
    # Stroke 17 um at 150 V, of which plays keep back their share; small waves have the play-free slope.
    assert response.small_signal_gain < 17e-6 / 150.0 < response.gain
    volts = np.interp(np.arange(20_000), [0, 10_000, 20_000], [75.0, 78.0, 75.0])
    machine = with_ample_amplifier(example())
    height, _ = free_apex(replace(machine, piezo=replace(machine.piezo, creep=0.0)), volts)
    assert np.ptp(height) == pytest.approx(3.0 * response.small_signal_gain, rel=5e-3)
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
    machine = example()
    wave = 75.0 + 75.0 * np.sin(2.0 * math.pi * 5000.0 * drive_setting.step_times(4000, STEP))
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


def test_sensors_leave_their_noise_counts_and_range():
    sensors = example().sensors
    probe = FilteredProbe(sensors, 2e-4, target=1e-3)
    seen = np.array([probe.read(1e-3) for _ in range(60_000)])
    assert np.std(seen[500:]) == pytest.approx(25e-9 * math.sqrt(24 / 5000), rel=0.05)
    assert FilteredProbe(sensors, 2e-4, target=0.0).read(5e-6) == pytest.approx(0.5e-6, abs=sensors.filtered_count)
    assert Interferometer(sensors, 1e-4).read(1e-9) == pytest.approx(2 * 0.62e-9)
    assert Lvdt(sensors, 1e-4).read(0.0) == pytest.approx(10 * 6.2e-6)
    assert fine_motion.converter_count(example()) == pytest.approx(2 * 20 / 46 * 17e-6 / 2**16)


def test_the_thesis_ellipse_and_its_turned_copies_keep_within_the_stroke():
    machine = example()
    ellipse = drive_setting.two_piezo_ellipse(machine, 8.5e-6, math.pi / 2)
    assert 2 * ellipse.along == pytest.approx(10.45e-6, rel=1e-3)
    for direction in np.linspace(0.0, 2 * math.pi, 13):
        turned = directed(machine, 8.5e-6, math.pi / 2, float(direction))
        angle = np.linspace(0.0, 2 * math.pi, 721)
        along = -turned.along * np.cos(angle)
        x, y = along * math.cos(direction), along * math.sin(direction)
        volts = drive_setting.volts_for(machine, x, y, turned.normal * np.sin(angle)) - 75.0
        assert np.abs(volts).max() == pytest.approx(75.0, rel=1e-4)
        assert drive_setting.largest_stroke(machine, turned) == pytest.approx(8.5e-6)


def test_the_loop_settles_to_a_nanometre_by_interferometer_and_not_past_an_lvdt():
    machine = example()
    fine = move_to(drive_setting.TipDrive(machine, 8.5e-6, math.pi / 2, 5000.0), LOOPS["interferometer"])
    assert fine.taken_over is not None and np.abs(fine.error[-500:].mean()) < 1e-9
    assert fine.within(1e-9, 0.01) is not None
    lost = move_to(drive_setting.TipDrive(machine, 8.5e-6, math.pi / 2, 5000.0), LOOPS["lvdt_and_probe"])
    # The LVDT hands over where its reading is within a count of the target, rounded to half a count: at its own error.
    assert lost.taken_over is not None
    handed = np.searchsorted(lost.run.time, lost.taken_over)
    sensors = machine.sensors
    assert abs(lost.error[handed]) == pytest.approx(sensors.lvdt_linearity_error, abs=1.5 * sensors.lvdt_count)
    # While the ellipse is taken away the stage moves on; the probe never sees the target.
    assert np.abs(lost.error[handed:]).min() > 10 * sensors.filtered_range and lost.within(1e-9) is None


def surroundings() -> Surroundings:
    bands = tuple((f * 2 ** (-1 / 6), f * 2 ** (1 / 6)) for f in (8.0, 10.0, 12.5, 16.0, 20.0, 25.0, 31.5, 40.0, 50.0))
    return Surroundings(25e-6, bands, 300.0, 0.05, 1e-3, 300e-9, 1800.0)


def test_disturbances_have_the_rms_that_they_are_made_of():
    given, piezo = surroundings(), example().piezo
    made = Disturbances(given, piezo, 2e-4, 1e-6)
    # Of a base that moves v/w in each band, an oscillator of a much higher frequency moves (w/w_1)^2 of that.
    time = np.arange(0.0, 60.0, 2e-4)
    middles = [0.5 * (low + high) for low, high in given.floor_bands]
    slow = sum((25e-6 / (2 * math.pi * middle)) ** 2 * (middle / 300.0) ** 4 for middle in middles)
    assert np.std(made.floor(time)) == pytest.approx(math.sqrt(slow), rel=0.05)
    # Behind the amplifier's lag, rebuilt here, the noise has its rms.
    noise = made.disturbed(np.zeros((400_000, 1, 3)))[:, 0, 0]
    share = 1 - math.exp(-2 * math.pi * piezo.bandwidth * 1e-6)
    assert np.std(lfilter([share], [1.0, share - 1.0], noise)[100:]) == pytest.approx(1e-3, rel=0.02)
    # The air: steps of sigma sqrt(2 dt/tau) between readings, and sigma in the long run.
    quick = Disturbances(Surroundings(0.0, given.floor_bands, 300.0, 0.05, 0.0, 300e-9, 0.02), piezo, 2e-4, 1e-6)
    index = np.array([quick.air() for _ in range(100_000)])
    assert np.std(index[1000:]) == pytest.approx(300e-9, rel=0.05)
    assert np.std(np.diff(index)) == pytest.approx(300e-9 * math.sqrt(2 * 2e-4 / 0.02), rel=0.02)
    quiet = Disturbances(None, piezo, 2e-4, 1e-6)
    assert quiet.air() == 0.0 and not quiet.floor(time).any() and quiet.disturbed(noise) is noise


def test_a_disturbed_loop_settles_to_what_it_leaves_of_the_floor():
    """Each wave of the floor times the sensitivity of the loop at its frequency; the air's error is left out."""
    given = replace(surroundings(), air_error=0.0)
    machine = replace(example(), surroundings=given)
    drive = drive_setting.TipDrive(machine, 8.5e-6, math.pi / 2, 5000.0)
    held = fine_motion.held_stage(drive)
    controller = fine_motion.FineController(held, 1.0)
    disturbed = move_to(drive, LOOPS["interferometer"], held)
    late = disturbed.run.time > disturbed.run.time[-1] - 0.2
    rate, amplitude, _ = Disturbances(given, machine.piezo, held.period, STEP).waves
    loop = controller.rate * held.period / (np.exp(1j * rate * held.period) - 1.0)
    expected = math.sqrt(0.5 * np.sum((amplitude / np.abs(1.0 + loop)) ** 2))
    assert expected < 0.7 * disturbed.by_floor[late].std()
    assert 0.7 * expected < disturbed.error[late].std() < 1.3 * expected + machine.sensors.interferometer_count
    found = disturbed.features("x")
    assert found["x_within_10nm"] is not None and found["x_error_std"][0] < 10e-9


def test_loads_of_a_sinusoid_and_of_a_stiff_tip_on_three_stacks():
    """Strokes of 8.5 um at 3 kHz: voltage, current and dielectric heat of a sine; tension by the check's calculator."""
    piezo = replace(example().piezo, loss=3e-7, tension=125.0, slew_rate=math.inf)
    machine = replace(example(), piezo=piezo)
    found = loads(machine, drive_setting.two_piezo_ellipse(machine, 8.5e-6, math.pi / 2), 3000.0)
    assert found.voltage == pytest.approx(1.0, rel=1e-3)
    assert found.current == pytest.approx(2 * math.pi * 3000.0 * 75.0 * 1.4e-6 / 2.0, rel=1e-3)
    # The third stack goes half-way between the others: cos(45 deg) of their stroke.
    assert found.heat == pytest.approx(2.5 * math.pi * 3000.0 * 3e-7 * 75.0**2, rel=1e-3)
    rise, tilt = 2 * 8.5e-6 * math.cos(math.pi / 4), 8.5e-6 * math.sqrt(2.0) / 0.046
    two = float(stack_tension(machine.tip.mass, machine.tip.inertia, 3000.0, rise, tilt, 0.046))
    # The calculator leaves the rise to the two driven stacks; here the third, off their line, carries a third of it.
    turned = machine.tip.inertia * (2 * math.pi * 3000.0) ** 2 * tilt / 0.046
    pushed = machine.tip.mass * (2 * math.pi * 3000.0) ** 2 * rise / 2 / 3
    assert found.tension == pytest.approx(math.hypot(turned, pushed) / 125.0, rel=1e-2)
    assert found.tension * 125.0 < two


def test_an_overtone_adds_its_harmonic_to_the_path():
    turn = np.linspace(0.0, 2 * math.pi, 7)
    along, up = drive_setting.Ellipse(2.0, 1.0, 0.1, 0.0, (drive_setting.Overtone(3, 0.5j, 0.25 + 0.0j),)).at(turn)
    assert along == pytest.approx(-2.0 * np.cos(turn + 0.1) - 0.5 * np.sin(3 * turn))
    assert up == pytest.approx(np.sin(turn) + 0.25 * np.cos(3 * turn))


def test_the_search_finds_motions_no_worse_than_the_sinusoids_it_starts_from(monkeypatch):
    """A fraction of the search, on a rigid stage at 2 kHz: every goal is kept, and every motion within the limits."""
    for name, number in {"ROUNDS": 2, "PLAIN": 1, "TRIALS": 3}.items():
        monkeypatch.setattr(tip_motion, name, number)
    machine = replace(example(), piezo=replace(example().piezo, loss=3e-7, tension=125.0))
    drive = drive_setting.TipDrive(machine, 8.5e-6, math.pi / 2, 2000.0)
    found = tip_motion.tip_motions(drive, lambda run, cases: list(map(run, cases)))
    assert set(found.best) == set(tip_motion.GOALS)
    for goal, motion in found.best.items():
        merit = tip_motion.GOALS[goal]
        assert merit(motion, found.thesis.speed) >= merit(found.sinusoids[goal], found.thesis.speed)
        assert motion.loads.largest <= 1.0 + 1e-9
    assert found.best["fastest"].speed >= found.thesis.speed
    for goal in ("least_ripple", "least_wear"):
        assert found.best[goal].speed >= found.thesis.speed


def test_the_largest_rate_of_a_stage_without_dynamics_is_that_of_the_closed_form():
    """L = w T/(z - 1) is largest against -1 at half the sampling rate: 1/|1 + L| = 1/(1 - w T/2)."""
    stiff = fine_motion.HeldStage(PERIOD, 0.02, FREQUENCY, np.ones(FREQUENCY.size, complex))
    assert stiff.largest_rate(1.0, stiff.notches()) * PERIOD == pytest.approx(
        2.0 * (1.0 - 1.0 / fine_motion.MARGIN), rel=0.03
    )
    assert not stiff.notches().size
    # |L| = w T/(2 sin(a/2)) with the phase -(pi + a)/2, a = 2 pi f T: L = -w T/2 at half the sampling rate.
    found = {name: value for name, (value, _) in stiff.margins(500.0, 1.0, stiff.notches()).items()}
    assert found["sensitivity"] == pytest.approx(1.0 / (1.0 - 0.05), rel=1e-3)
    assert found["gain_margin"] == pytest.approx(20.0, rel=1e-3)
    assert found["phase_margin"] == pytest.approx(0.5 * math.pi - math.asin(0.05), rel=1e-3)


def test_notches_allow_a_larger_rate_and_remove_the_resonance():
    r = FREQUENCY / 240.0
    held = fine_motion.HeldStage(PERIOD, 0.02, FREQUENCY, 1.0 / (1.0 - r**2 + 0.1j * r))
    with_notch, without = fine_motion.FineController(held, 1.0), fine_motion.FineController(held, 1.0, notched=False)
    # Of an integrator and a resonance 1/(2 zeta) high: the peak of L, w/(2 zeta w_1), is 1 - 1/Ms at the phase of -1.
    assert without.rate == pytest.approx(0.1 * 2.0 * math.pi * 240.0 * (1.0 - 1.0 / fine_motion.MARGIN), rel=0.15)
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
    drive = drive_setting.TipDrive(machine, 8.5e-6, math.pi / 2, 5000.0)
    held = fine_motion.held_stage(drive)
    rms = {kind: fine_motion.tracked(drive, held, fine_motion.sine, kind).rms for kind in FEEDFORWARD}
    # Each of the two terms lowers the error, also beside the other.
    assert rms["none"] > rms["gain"] > max(rms["inverse"], rms["friction"])
    assert min(rms["inverse"], rms["friction"]) > rms["hysteresis"]
    assert rms["hysteresis"] < machine.sensors.interferometer_count
    moved = {
        kind: fine_motion.tracked(drive, held, fine_motion.short_move, kind) for kind in ("none", "gain", "hysteresis")
    }
    assert moved["none"].largest > moved["gain"].largest > moved["hysteresis"].largest
    slow, quick = moved["none"].settled(1e-9), moved["hysteresis"].settled(1e-9)
    assert slow is not None and quick is not None and quick < slow


def test_the_second_run_of_the_speed_study_begins_at_once():
    """The ellipse grows within ten cycles, but 2 ms at least; in the second run within half a cycle."""
    machine, time = ideal_piezos(example()), drive_setting.step_times(20_000, 1e-6)
    setting = drive_setting.Setting(drive_setting.two_piezo_ellipse(machine, 8.5e-6, math.pi / 2), 6000.0, 0.0)
    waves = [
        drive_setting.grown_wave(machine, setting, time, cycles)[:, 0, 0]
        for cycles in (drive_setting.RISE_CYCLES, SUDDEN)
    ]
    slow, sudden = (np.ptp(wave[time < 1.0 / 6000.0]) / np.ptp(wave[time > 10e-3]) for wave in waves)
    assert slow < 0.1 and sudden > 0.7
