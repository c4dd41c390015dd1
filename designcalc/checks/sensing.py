"""The sensors: LVDT, capacitive probe, interferometer."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from designcalc.checks.check import Check
from designcalc.checks.inputs import Reading, over, show
from designcalc.errors.sensors import abbe_error, cosine_error, count_size, filtered_noise, lag_error, velocity_noise

_DATASHEET = "thesis 2.3.4, data sheets"


def checks(r: Reading) -> Iterator[partial[Check]]:
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
    yield partial(lag, r)
    yield partial(probe_linearity, r)
    yield partial(contactless, r)
    yield partial(abbe, r)
    yield partial(cosine, r)


def lvdt_range(r: Reading) -> Check:
    return r.check(
        "LVDT range",
        r("sensors.lvdt.range"),
        r("requirements.sensor_range"),
        "m",
        "at least",
        _DATASHEET,
        "range >= travel",
        f"{show(r('sensors.lvdt.range'), 'm')} against {show(r('requirements.sensor_range'), 'm')}",
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


def lag(r: Reading) -> Check:
    speed, bandwidth = r("requirements.speed"), r("sensors.lvdt.bandwidth")
    late = float(lag_error(speed, bandwidth))
    window = r("sensors.probe.range") / 2
    return r.check(
        "lag of the LVDT at full speed",
        late,
        window,
        "m",
        "at most",
        "first-order sensor of the bandwidth stated; half the probe's range must catch the stage",
        "v/(2 pi f) <= probe range/2",
        f"{show(speed, 'm/s')} at {show(bandwidth, 'Hz')}: {show(late, 'm')}",
        f"enter the probe's range at {show(speed * window / late, 'm/s')} at most, or correct the known lag",
        requirement="Table 1: speed",
    )


def probe_linearity(r: Reading) -> Check:
    error = r("sensors.probe.linearity") * r("sensors.probe.range")
    limit = r("requirements.resolution_coarse")
    return r.check(
        "capacitive probe linearity",
        error,
        limit,
        "m",
        "at most",
        _DATASHEET,
        "linearity x full range <= 10 nm",
        show(error, "m"),
        f"calibrate it against the interferometer, or use {show(limit / r('sensors.probe.linearity'), 'm')} of it",
        requirement="Table 2: sensor resolution",
    )


def contactless(r: Reading) -> Check:
    travel = r("requirements.sensor_range")
    sensors = r.design.sensors
    reach = {
        "LVDT": (r("sensors.lvdt.range"), sensors.lvdt.contactless),
        "interferometer": (2 * r("sensors.interferometer.range"), sensors.interferometer.contactless),
    }
    fit = [name for name, (length, free) in reach.items() if free and length >= travel]
    return r.check(
        "sensors over the travel that do not touch",
        len(fit),
        1.0 if r.design.requirements.sensor_contactless else 0.0,
        "",
        "at least",
        _DATASHEET,
        "number of sensors that reach over the travel and let the stage move across their axis",
        ", ".join(fit) or "none",
        "an interferometer, or a grid encoder",
        requirement="Table 2: sensor without contact",
    )


def cosine(r: Reading) -> Check:
    travel, angle = r("stage.travel"), r("sensors.interferometer.misalignment")
    error = float(cosine_error(travel, angle))
    limit = r("requirements.resolution_coarse")
    return r.check(
        "cosine error of the interferometer",
        error,
        limit,
        "m",
        "at most",
        "beam at an angle to the travel",
        "travel (1 - cos(angle)) <= 10 nm",
        f"{show(travel, 'm')} at {show(angle, 'rad')}: {show(error, 'm')}",
        f"align the beam to {show(angle * over(limit, error) ** 0.5, 'rad')}",
        note=f"the finest resolution, {show(r('requirements.resolution'), 'm')}, needs "
        f"{show(angle * over(r('requirements.resolution'), error) ** 0.5, 'rad')}",
        requirement="Table 2: sensor resolution",
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
