"""Heat, magnetism and the floor; the height adjustment; the sensors."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial

from designcalc.checks.check import Check
from designcalc.checks.drive import tip_resonance
from designcalc.checks.machine import stroke_ellipse
from designcalc.checks.reading import Reading, show
from designcalc.height_adjustment import WedgeDrive, wedge_drive
from designcalc.sensors import abbe_error, count_size, filtered_noise, velocity_noise
from designcalc.thermal import differential_growth, loop_drift, vibration_at_tip

_DATASHEET = "thesis 2.3.4, data sheets"


def thermal_checks(r: Reading) -> Iterator[partial[Check]]:
    """Drift of the tip, the way on the base, magnetism, vibration; with the base's other material beside each."""
    yield partial(tip_drift, r)
    yield partial(way_growth, r)
    yield partial(base_expansion, r)
    yield partial(magnetism, r)
    yield partial(vibration, r)


def height_checks(r: Reading) -> Iterator[partial[Check]]:
    """The set screw and wedge."""
    yield partial(sensitivity, r)
    yield partial(self_locking, r)
    yield partial(adjustment_range, r)
    yield partial(shim, r)
    yield partial(return_spring, r)


def sensor_checks(r: Reading) -> Iterator[partial[Check]]:
    """LVDT, capacitive probe, interferometer."""
    yield partial(lvdt_range, r)
    yield partial(lvdt_resolution, r)
    yield partial(hand_over, r)
    yield partial(probe_noise, r)
    yield partial(probe_count, r)
    yield partial(interferometer, r, "resolution", "the finest step")
    yield partial(interferometer, r, "resolution_coarse", "the coarsest step allowed")
    yield partial(interferometer_range, r)
    yield partial(interferometer_speed, r)
    yield partial(differencing, r)
    yield partial(abbe, r)


def _beside(r: Reading) -> tuple[str, str]:
    """Of Invar 36 and SUS416, the one that the base is not made of: key and name."""
    return ("invar_36", "Invar 36") if r.design.value("base.material") == "sus416" else ("sus416", "SUS416")


def tip_drift(r: Reading) -> Check:
    """Gap between tip and stage: way and pads lift the stage; piezos and tip, in their clamped holder, fill it.

    The clamps take the height pins out of the loop; base and holder together span from the way's foot down to the
    piezos' feet.
    """
    piezo_plane = r("bearing_way.height") + r("pads.height") - r("actuator.tip_height")
    members = [
        (r("bearing_way.height"), r.material("bearing_way", "expansion")),
        (r("pads.height"), r.material("stage", "expansion")),
        (-r("actuator.tip_height"), r.material("tip", "expansion")),
        (-r("piezo.length"), r.material("piezo", "expansion")),
    ]
    below = r("piezo.length") - piezo_plane
    key, other = _beside(r)

    def drift(expansion: float) -> float:
        return abs(loop_drift([m[0] for m in members] + [below], [m[1] for m in members] + [expansion]))

    here, beside = drift(r.material("base", "expansion")), drift(r(f"materials.{key}.expansion"))
    rise = float(stroke_ellipse(r).normal)
    change = r("environment.temperature_change")
    return r.check(
        "drift of the tip against the stage",
        here * change,
        0.1 * rise,
        "m",
        "at most",
        "growth of the loop way - pad - stage - tip - piezo - holder - base",
        "|sum(alpha_i L_i)| dT <= Y/10",
        f"{show(here, 'm')} per kelvin x {change:.3g} K; rise of the ellipse {show(rise, 'm')}",
        "a tip and pads that grow alike, or a bias of the piezos that follows the temperature",
        note=f"with a base and holder of {other}: {show(beside, 'm')} per kelvin",
        requirement="Table 2: low thermal expansion",
    )


def way_growth(r: Reading) -> Check:
    length, change = r("bearing_way.length"), r("environment.temperature_change")
    ceramic = r.material("bearing_way", "expansion")
    key, other = _beside(r)
    growth = float(differential_growth(length, ceramic, r.material("base", "expansion"))) * change
    beside = float(differential_growth(length, ceramic, r(f"materials.{key}.expansion"))) * change
    return r.check(
        "slip between way and base",
        growth,
        1e-6,
        "m",
        "at most",
        "difference of free growth; 1 um, the finish of the joint, is taken up without a ratchet",
        "|alpha_way - alpha_base| L dT <= 1 um",
        f"{show(growth, 'm')} over {show(length, 'm')} and {change:.3g} K",
        f"hold the temperature to {change * 1e-6 / growth:.2g} K, or pin the way at its middle and let it slide",
        note=f"on a base of {other}: {show(beside, 'm')}",
        requirement="Table 2: low thermal expansion",
    )


def base_expansion(r: Reading) -> Check:
    steel, invar = r("materials.sus416.expansion"), r("materials.invar_36.expansion")
    chosen = r.material("base", "expansion")
    return r.check(
        "expansion of the base's material",
        chosen,
        2e-6,
        "1/K",
        "at most",
        "thesis 2.3.3: chosen for its low expansion; the Invar family lies below 2e-6/K",
        "alpha_base <= 2e-6/K",
        f"Invar 36 {show(invar, '1/K')}, SUS416 {show(steel, '1/K')}",
        "Invar 36",
        thesis=f"'INVAR SUS416': SUS416 is a martensitic stainless steel of {show(steel, '1/K')}, "
        f"{steel / invar:.2g} times Invar's",
        requirement="Table 2: low thermal expansion",
    )


def magnetism(r: Reading) -> Check:
    """Invar 36 (up to some 230 degC) and SUS416 are both ferromagnetic: flux must not find a way through the base."""
    name = str(r.design.value("base.material"))
    attracted = r.given(
        f"{name} attracted by a magnet", float(r.design.materials[name].magnetic), "", "materials table: 1 is yes"
    )
    gap, clear = r("teeth.gap"), r("tooth_bar.height") - r("teeth.groove_depth")
    _, other = _beside(r)
    return r.check(
        "flux of the teeth leaking into the base",
        attracted * gap / clear,
        0.25,
        "",
        "at most",
        "the iron below the teeth carries the flux in a section thick beside the gap",
        "gap/(bar height - groove) <= 1/4 where the base is ferromagnetic",
        f"{show(gap, 'm')}/{show(clear, 'm')}",
        "higher bars, or a non-magnetic liner under them",
        note=f"ferromagnetic as well: {other}; neither material of the base frees it of the magnets",
    )


def vibration(r: Reading) -> Check:
    floor = r.given("floor acceleration", 1e-3, "m/s^2", "assumed: VC-B at 30 Hz, about 5 mm/s^2 peak over 5")
    first = tip_resonance(r)
    motion = float(vibration_at_tip(floor, first))
    return r.check(
        "floor vibration between tip and stage",
        motion,
        r("requirements.resolution_coarse"),
        "m",
        "at most",
        "base shaken below the first resonance of the loop",
        "a/(2 pi f_1)^2 <= 10 nm",
        f"{show(floor, 'm/s^2')}, f_1 = {show(first, 'Hz')}: {show(motion, 'm')}",
        "an isolation table",
        requirement="Table 1: resolution",
    )


def _wedge(r: Reading) -> WedgeDrive:
    return wedge_drive(r("set_screw.pitch"), r("height_pin_1.slope"), r("height_pin_1.stroke"))


def sensitivity(r: Reading) -> Check:
    drive = _wedge(r)
    rise = float(stroke_ellipse(r).normal)
    return r.check(
        "height adjustment within the ellipse",
        5 * drive.lift_per_degree,
        rise / 2,
        "m",
        "at most",
        "wedge on a set screw; a hand sets a key to about five degrees",
        "5 deg x P s/360 <= Y/2",
        f"{show(drive.lift_per_turn, 'm')} a turn, {show(drive.lift_per_degree, 'm')} a degree; Y = {show(rise, 'm')}",
        "a finer slope, or a fine-pitch screw",
        thesis="the tip height is to be set within the 1-10 um of its ellipse",
    )


def self_locking(r: Reading) -> Check:
    drive = _wedge(r)
    friction = r.given("friction of the pins", 0.15, "", "assumed: greased aluminium, low end")
    return r.check(
        "self-locking of the wedge",
        friction,
        1.5 * drive.locking_friction,
        "",
        "at least",
        "friction angles of both faces of the wedge",
        "mu >= 1.5 tan(atan(s)/2)",
        f"{friction:.3g} against {drive.locking_friction:.3g}",
        "a flatter slope",
    )


def adjustment_range(r: Reading) -> Check:
    drive = _wedge(r)
    chain = [r("drawing.tolerance_x_x")] * 4 + [r("drawing.tolerance_x_xx")] * 2
    stack = sum(chain)
    return r.check(
        "range of the height adjustment",
        drive.range / 2,
        stack,
        "m",
        "at least",
        "worst case of the height chain: holder, piezo, two pins at X.X; way and pad at X.XX",
        "s stroke/2 >= sum of tolerances",
        f"+-{show(drive.range / 2, 'm')} against +-{show(stack, 'm')}",
        f"a stroke of {show(2 * stack / r('height_pin_1.slope'), 'm')}, or tighter pins",
    )


def shim(r: Reading) -> Check:
    thinnest = r("shim.thinnest")
    rise = float(stroke_ellipse(r).normal)
    return r.check(
        "thinnest shim against the ellipse",
        thinnest,
        rise,
        "m",
        "at most",
        "thesis 2.3.3: a shim sets the gap between tip and stage",
        "thinnest shim <= Y",
        f"{show(thinnest, 'm')} against {show(rise, 'm')}",
        f"touch off by the piezos' own signal, or turn the screw {show(thinnest / _wedge(r).lift_per_degree, '')} "
        "degrees after the shim is out",
    )


def return_spring(r: Reading) -> Check:
    """The spring must push pin 1 back against what it carries: holder, piezos, tip, and pin 2 by its friction."""
    holder = math.pi / 4 * r("holder.diameter") ** 2 * r("holder.height") * r.material("holder", "density")
    stacks = 3 * math.pi / 4 * r("piezo.diameter") ** 2 * r("piezo.length") * r.material("piezo", "density")
    load = (holder + stacks + r("tip.mass_limit")) * r("environment.gravity")
    friction = r.given("friction of the pins, dry", 0.3, "", "assumed: dry aluminium, high end")
    needed = 2 * friction * load  # both faces of the wedge
    squeeze = r("spring.free_length") - r("spring.installed_length") - r("height_pin_1.stroke") / 2
    force = r("spring.rate") * squeeze
    return r.check(
        "spring that returns the height pin",
        force,
        2 * needed,
        "N",
        "at least",
        "Coulomb friction on both faces of the wedge under holder, piezos and tip; factor 2",
        "k (L0 - L - stroke/2) >= 2 x 2 mu m g",
        f"{show(force, 'N')} against {show(needed, 'N')} of friction (plain volumes, {show(load, 'N')})",
        f"{show((2 * needed - force) / r('spring.rate'), 'm')} more compression at the far end of the stroke, by a "
        "longer spring or a shorter stroke",
    )


def lvdt_range(r: Reading) -> Check:
    return r.check(
        "LVDT range",
        r("sensors.lvdt.range"),
        r("requirements.sensor_range"),
        "m",
        "at least",
        _DATASHEET,
        "range >= travel",
        "25.4 mm against 200 mm",
        "a linear encoder, or the interferometer, over the whole travel",
        thesis="the LVDT covers an eighth of the travel that Table 2 asks of the sensor",
        requirement="Table 2: sensor range",
    )


def lvdt_resolution(r: Reading) -> Check:
    step = float(count_size(r("sensors.lvdt.range"), r("sensors.lvdt.bits")))
    return r.check(
        "LVDT count",
        step,
        r("requirements.resolution_coarse"),
        "m",
        "at most",
        _DATASHEET,
        "range/2^bits <= 10 nm",
        show(step, "m"),
        "use it for coarse position only",
        requirement="Table 2: sensor resolution",
    )


def hand_over(r: Reading) -> Check:
    error = r("sensors.lvdt.linearity") * r("sensors.lvdt.range")
    fine = r("sensors.probe.range") / r("sensors.filtered_probe.gain")
    return r.check(
        "hand-over from LVDT to capacitive probe",
        error,
        fine / 2,
        "m",
        "at most",
        "the coarse sensor must bring the stage into the fine one's range",
        "linearity x range <= (probe range/gain)/2",
        f"{show(error, 'm')} against {show(fine / 2, 'm')}",
        "switch the gain off until the probe has taken over, and calibrate the LVDT there",
        thesis="with x25 gain the probe sees 1 um; the LVDT is off by 63 um: no hand-over",
        requirement="Table 2: sensor range",
    )


def probe_noise(r: Reading) -> Check:
    noise = float(
        filtered_noise(
            r("sensors.probe.resolution"), r("sensors.probe.bandwidth"), r("sensors.filtered_probe.filter_frequency")
        )
    )
    return r.check(
        "capacitive probe noise after its filter",
        noise,
        r("sensors.filtered_probe.claimed_resolution"),
        "m",
        "at most",
        "white noise through an RC filter",
        "25 nm sqrt(24 Hz/5 kHz) <= 1 nm",
        show(noise, "m"),
        f"a corner of {show(r('sensors.filtered_probe.filter_frequency') * (1e-9 / noise) ** 2, 'Hz')}",
        thesis="'1 nm' by gain: the filter, not the gain, lowers the noise, and white noise leaves 1.7 nm",
        requirement="Table 1: resolution",
    )


def probe_count(r: Reading) -> Check:
    fine = r("sensors.probe.range") / r("sensors.filtered_probe.gain")
    step = float(count_size(fine, r("sensors.filtered_probe.bits")))
    return r.check(
        "capacitive probe count",
        step,
        r("sensors.filtered_probe.claimed_resolution"),
        "m",
        "at most",
        "12-bit converter behind the gain",
        "range/gain/2^bits <= 1 nm",
        f"{show(fine, 'm')}/4096 = {show(step, 'm')}",
        "more bits",
        requirement="Table 1: resolution",
    )


def interferometer(r: Reading, key: str, label: str) -> Check:
    step = r("sensors.interferometer.resolution")
    return r.check(
        f"interferometer resolution, {label}",
        step,
        r(f"requirements.{key}"),
        "m",
        "at most",
        _DATASHEET,
        "0.62 nm <= resolution asked for",
        show(step, "m"),
        "a finer interpolation (lambda/2048 and beyond), or say 1 nm",
        thesis="'meets the requirements': it misses 0.1 nm" if key == "resolution" else "",
        requirement="Table 2: sensor resolution",
    )


def interferometer_range(r: Reading) -> Check:
    return r.check(
        "interferometer range",
        2 * r("sensors.interferometer.range"),
        r("requirements.sensor_range"),
        "m",
        "at least",
        _DATASHEET,
        "2 x 1.328 m >= travel",
        requirement="Table 2: sensor range",
    )


def interferometer_speed(r: Reading) -> Check:
    return r.check(
        "interferometer speed",
        r("sensors.interferometer.highest_speed"),
        r("requirements.speed"),
        "m/s",
        "at least",
        _DATASHEET,
        "500 mm/s >= 200 mm/s",
        requirement="Table 1: speed",
    )


def differencing(r: Reading) -> Check:
    step = float(count_size(r("sensors.lvdt.range"), r("sensors.lvdt.bits")))
    rate = 2 * r("sensors.lvdt.bandwidth")
    noise = float(velocity_noise(step, rate))
    wanted = r("requirements.speed")
    return r.check(
        "velocity by differencing the LVDT",
        noise,
        0.01 * wanted,
        "m/s",
        "at most",
        "two roundings, count/sqrt(6) x rate",
        "count/sqrt(6) f_s <= 1 % of the speed",
        f"{show(step, 'm')} at {show(rate, 'Hz')}: {show(noise, 'm/s')}",
        "an observer, or a velocity sensor",
    )


def abbe(r: Reading) -> Check:
    offset = r("stage.thickness") / 2 + r("payload.height")
    straightness, way = r("bearing.way_straightness"), r("bearing_way.length")
    angle = 4 * straightness / way
    error = float(abbe_error(offset, angle))
    return r.check(
        "Abbe error at the payload",
        error,
        r("requirements.resolution_coarse"),
        "m",
        "at most",
        "pitch of a way bowed by its straightness error; line of measurement at the middle of the plate",
        "offset x 4 s/L <= 10 nm",
        f"{show(offset, 'm')} x {show(angle, 'rad')} = {show(error, 'm')}",
        "measure at the height of the payload, or measure the pitch as well and correct it",
        requirement="Table 1: resolution",
    )
