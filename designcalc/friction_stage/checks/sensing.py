"""The sensors: LVDT, capacitive probe, interferometer."""

from __future__ import annotations

from functools import partial

from designcalc.checks.check import Check, CheckFunction, DesignInputs, at_least, at_most, change, ratio, show
from designcalc.errors.sensors import (
    abbe_error,
    air_index_error,
    cosine_error,
    count_size,
    filtered_noise,
    lag_error,
    velocity_noise,
)
from stagecad.parameters.design import Design

_DATASHEET = "thesis 2.3.4, data sheets"


def checks(design: Design) -> list[CheckFunction]:
    """LVDT, capacitive probe, interferometer."""
    return [
        lvdt_range,
        lvdt_resolution,
        hand_over,
        probe_noise,
        probe_count,
        partial(interferometer, key="resolution", label="the finest step"),
        partial(interferometer, key="resolution_coarse", label="the coarsest step allowed"),
        interferometer_range,
        interferometer_speed,
        differencing,
        lag,
        probe_linearity,
        contactless,
        abbe,
        cosine,
        partial(air_index, path="stage.travel", label="travel"),
        partial(air_index, path="sensors.interferometer.dead_path", label="dead path"),
    ]


def lvdt_range(r: DesignInputs) -> Check:
    return Check(
        "LVDT range",
        at_least(r("sensors.lvdt.range"), r("requirements.sensor_range"), "m"),
        source=_DATASHEET,
        formula="range >= travel",
        substituted=f"{show(r('sensors.lvdt.range'), 'm')} against {show(r('requirements.sensor_range'), 'm')}",
        proposal="a linear encoder, or the interferometer, over the whole travel",
        thesis="the LVDT covers an eighth of the travel that Table 2 requires of the sensor",
        requirement="Table 2: sensor range",
    )


def lvdt_resolution(r: DesignInputs) -> Check:
    step = float(count_size(r("sensors.lvdt.range"), r("sensors.lvdt.bits")))
    return Check(
        "LVDT count",
        at_most(step, r("requirements.resolution_coarse"), "m"),
        source=_DATASHEET,
        formula="range/2^bits <= 10 nm",
        substituted=show(step, "m"),
        proposal="use it for coarse position only",
        requirement="Table 2: sensor resolution",
    )


def hand_over(r: DesignInputs) -> Check:
    error = r("sensors.lvdt.linearity") * r("sensors.lvdt.range")
    fine = r("sensors.probe.range") / r("sensors.filtered_probe.gain")
    return Check(
        "hand-over from LVDT to capacitive probe",
        at_most(error, fine / 2, "m"),
        source="the coarse sensor must bring the stage into the fine one's range",
        formula="linearity x range <= (probe range/gain)/2",
        substituted=f"{show(error, 'm')} against {show(fine / 2, 'm')}",
        proposal="switch the gain off until the probe has taken over, and calibrate the LVDT there",
        thesis="with x25 gain the probe sees 1 um; the LVDT is off by 63 um: no hand-over",
        requirement="Table 2: sensor range",
    )


def probe_noise(r: DesignInputs) -> Check:
    noise = float(
        filtered_noise(
            r("sensors.probe.resolution"), r("sensors.probe.bandwidth"), r("sensors.filtered_probe.filter_frequency")
        )
    )
    return Check(
        "capacitive probe noise after its filter",
        at_most(noise, r("sensors.filtered_probe.claimed_resolution"), "m"),
        source="white noise through an RC filter",
        formula="25 nm sqrt(24 Hz/5 kHz) <= 1 nm",
        substituted=show(noise, "m"),
        proposal="a lower corner of the filter",
        changes=change(
            "sensors.filtered_probe.filter_frequency",
            r("sensors.filtered_probe.filter_frequency")
            * (r("sensors.filtered_probe.claimed_resolution") / noise) ** 2,
            "Hz",
            up=False,
        ),
        thesis="'1 nm' by gain: the filter, not the gain, lowers the noise, and white noise leaves 1.7 nm",
        requirement="Table 1: resolution",
    )


def probe_count(r: DesignInputs) -> Check:
    fine = r("sensors.probe.range") / r("sensors.filtered_probe.gain")
    step = float(count_size(fine, r("sensors.filtered_probe.bits")))
    return Check(
        "capacitive probe count",
        at_most(step, r("sensors.filtered_probe.claimed_resolution"), "m"),
        source="12-bit converter behind the gain",
        formula="range/gain/2^bits <= 1 nm",
        substituted=f"{show(fine, 'm')}/4096 = {show(step, 'm')}",
        proposal="more bits",
        requirement="Table 1: resolution",
    )


def interferometer(r: DesignInputs, key: str, label: str) -> Check:
    step = r("sensors.interferometer.resolution")
    return Check(
        f"interferometer resolution, {label}",
        at_most(step, r(f"requirements.{key}"), "m"),
        source=_DATASHEET,
        formula="0.62 nm <= required resolution",
        substituted=show(step, "m"),
        proposal="a finer interpolation (lambda/2048 and beyond), or a resolution of 1 nm",
        thesis=("'meets the requirements': it misses 0.1 nm" if key == "resolution" else ""),
        requirement="Table 2: sensor resolution",
    )


def interferometer_range(r: DesignInputs) -> Check:
    return Check(
        "interferometer range",
        at_least(2 * r("sensors.interferometer.range"), r("requirements.sensor_range"), "m"),
        source=_DATASHEET,
        formula="2 x 1.328 m >= travel",
        requirement="Table 2: sensor range",
    )


def interferometer_speed(r: DesignInputs) -> Check:
    return Check(
        "interferometer speed",
        at_least(r("sensors.interferometer.highest_speed"), r("requirements.speed"), "m/s"),
        source=_DATASHEET,
        formula="500 mm/s >= 200 mm/s",
        requirement="Table 1: speed",
    )


def differencing(r: DesignInputs) -> Check:
    step = float(count_size(r("sensors.lvdt.range"), r("sensors.lvdt.bits")))
    rate = 2 * r("sensors.lvdt.bandwidth")
    noise = float(velocity_noise(step, rate))
    wanted = r("requirements.speed")
    return Check(
        "velocity by differencing the LVDT",
        at_most(noise, 0.01 * wanted, "m/s"),
        source="two roundings, count/sqrt(6) x rate",
        formula="count/sqrt(6) f_s <= 1 % of the speed",
        substituted=f"{show(step, 'm')} at {show(rate, 'Hz')}: {show(noise, 'm/s')}",
        proposal="an observer, or a velocity sensor",
    )


def lag(r: DesignInputs) -> Check:
    speed, bandwidth = r("requirements.speed"), r("sensors.lvdt.bandwidth")
    late = float(lag_error(speed, bandwidth))
    window = r("sensors.probe.range") / 2
    return Check(
        "lag of the LVDT at full speed",
        at_most(late, window, "m"),
        source="first-order sensor of the bandwidth stated; half the probe's range must catch the stage",
        formula="v/(2 pi f) <= probe range/2",
        substituted=f"{show(speed, 'm/s')} at {show(bandwidth, 'Hz')}: {show(late, 'm')}",
        proposal=f"enter the probe's range at {show(speed * window / late, 'm/s')} at most, or correct the known lag",
        requirement="Table 1: speed",
    )


def probe_linearity(r: DesignInputs) -> Check:
    error = r("sensors.probe.linearity") * r("sensors.probe.range")
    limit = r("requirements.resolution_coarse")
    return Check(
        "capacitive probe linearity",
        at_most(error, limit, "m"),
        source=_DATASHEET,
        formula="linearity x full range <= 10 nm",
        substituted=show(error, "m"),
        proposal=f"calibrate it against the interferometer, or use {show(limit / r('sensors.probe.linearity'), 'm')} "
        "of it",
        requirement="Table 2: sensor resolution",
    )


def contactless(r: DesignInputs) -> Check:
    travel = r("requirements.sensor_range")
    sensors = r.design.sensors
    reach = {
        "LVDT": (r("sensors.lvdt.range"), sensors.lvdt.contactless),
        "interferometer": (2 * r("sensors.interferometer.range"), sensors.interferometer.contactless),
    }
    fit = [name for name, (length, free) in reach.items() if free and length >= travel]
    return Check(
        "sensors over the travel that do not touch",
        at_least(len(fit), 1.0 if r.design.requirements.sensor_contactless else 0.0, ""),
        source=_DATASHEET,
        formula="number of sensors that reach over the travel and let the stage move across their axis",
        substituted=", ".join(fit) or "none",
        proposal="an interferometer, or a grid encoder",
        requirement="Table 2: sensor without contact",
    )


def cosine(r: DesignInputs) -> Check:
    travel, angle = r("stage.travel"), r("sensors.interferometer.misalignment")
    error = float(cosine_error(travel, angle))
    limit = r("requirements.resolution_coarse")
    return Check(
        "cosine error of the interferometer",
        at_most(error, limit, "m"),
        source="beam at an angle to the travel",
        formula="travel (1 - cos(angle)) <= 10 nm",
        substituted=f"{show(travel, 'm')} at {show(angle, 'rad')}: {show(error, 'm')}",
        proposal=f"align the beam to {show(angle * ratio(limit, error) ** 0.5, 'rad')}",
        requirement="Table 2: sensor resolution",
        note=f"the finest resolution, {show(r('requirements.resolution'), 'm')}, needs "
        f"{show(angle * ratio(r('requirements.resolution'), error) ** 0.5, 'rad')}",
    )


def air_index(r: DesignInputs, path: str, label: str) -> Check:
    """An interferometer measures in wavelengths, and the wavelength in air follows temperature and pressure."""
    length, warmer, pressure = r(path), r("environment.temperature_change"), r("environment.pressure_change")
    error = float(air_index_error(length, warmer, pressure))
    limit = r("requirements.repeatability")
    return Check(
        f"refractive index of the air over the interferometer's {label}",
        at_most(error, limit, "m"),
        source="slopes of Edlen's equation (Birch, Downs 1994)",
        formula="L (0.93 ppm/K dT + 0.0027 ppm/Pa dp) <= repeatability",
        substituted=f"L = {show(length, 'm')}, {warmer:.3g} K and {show(pressure, 'Pa')}: {show(error, 'm')}",
        proposal=f"correct the index by a weather station, or hold the air to {ratio(limit, error):.2g} of these "
        "changes",
        requirement="Section 2.3.2: repeatability (Table 1 has none)",
    )


def abbe(r: DesignInputs) -> Check:
    offset = r("stage.thickness") / 2 + r("payload.height")
    straightness, way = r("bearing.way_straightness"), r("bearing_way.length")
    angle = 4 * straightness / way
    error = float(abbe_error(offset, angle))
    return Check(
        "Abbe error at the payload",
        at_most(error, r("requirements.resolution_coarse"), "m"),
        source="pitch of a way bowed by its straightness error; line of measurement at the middle of the plate",
        formula="offset x 4 s/L <= 10 nm",
        substituted=f"{show(offset, 'm')} x {show(angle, 'rad')} = {show(error, 'm')}",
        proposal="measure at the height of the payload, or measure the pitch too and correct it",
        requirement="Table 1: resolution",
    )
