"""The sensors: LVDT, capacitive probe, interferometer."""

from designcalc.checks.check import Check, CheckFunction, DesignInputs, FormulaCheck
from designcalc.friction_stage.quantities import stated
from stagecad.parameters.design import Design

_DATASHEET = "thesis 2.3.4, data sheets"
_LVDT_COUNT = "sensors.lvdt.range/2^sensors.lvdt.bits"


def checks(design: Design) -> list[CheckFunction]:
    """LVDT, capacitive probe, interferometer."""
    return [
        lvdt_range,
        lvdt_resolution,
        hand_over,
        probe_noise,
        probe_count,
        interferometer("resolution", "the finest step", thesis="'meets the requirements': it misses 0.1 nm"),
        interferometer("resolution_coarse", "the coarsest step allowed"),
        interferometer_range,
        interferometer_speed,
        differencing,
        lag,
        probe_linearity,
        contactless,
        abbe,
        cosine,
        air_index("stage.travel", "travel"),
        air_index("sensors.interferometer.dead_path", "dead path"),
    ]


lvdt_range = stated(
    "LVDT range",
    "sensors.lvdt.range >= requirements.sensor_range",
    source=_DATASHEET,
    proposal="a linear encoder, or the interferometer, over the whole travel",
    thesis="the LVDT covers an eighth of the travel that Table 2 requires of the sensor",
    requirement="Table 2: sensor range",
)


lvdt_resolution = stated(
    "LVDT count",
    f"{_LVDT_COUNT} <= requirements.resolution_coarse",
    source=_DATASHEET,
    proposal="use it for coarse position only",
    requirement="Table 2: sensor resolution",
)


hand_over = stated(
    "hand-over from LVDT to capacitive probe",
    "sensors.lvdt.linearity*sensors.lvdt.range <= sensors.probe.range/sensors.filtered_probe.gain/2",
    source="the coarse sensor must bring the stage into the fine one's range",
    proposal="switch the gain off until the probe has taken over, and calibrate the LVDT there",
    thesis="with x25 gain the probe sees 1 um; the LVDT is off by 63 um: no hand-over",
    requirement="Table 2: sensor range",
)


probe_noise = stated(
    "capacitive probe noise after its filter",
    "sensors.probe.resolution*sqrt(sensors.filtered_probe.filter_frequency/sensors.probe.bandwidth)"
    " <= sensors.filtered_probe.claimed_resolution",
    (
        "sensors.filtered_probe.filter_frequency",
        "sensors.filtered_probe.filter_frequency*(check.limit/check.value)^2",
        False,
    ),
    source="white noise through an RC filter",
    proposal="a lower corner of the filter",
    thesis="'1 nm' by gain: the filter, not the gain, lowers the noise, and white noise leaves 1.7 nm",
    requirement="Table 1: resolution",
)


probe_count = stated(
    "capacitive probe count",
    "sensors.probe.range/sensors.filtered_probe.gain/2^sensors.filtered_probe.bits"
    " <= sensors.filtered_probe.claimed_resolution",
    source="converter behind the gain",
    proposal="more bits",
    requirement="Table 1: resolution",
)


def interferometer(key: str, label: str, thesis: str = "") -> FormulaCheck:
    return stated(
        f"interferometer resolution, {label}",
        f"sensors.interferometer.resolution <= requirements.{key}",
        source=_DATASHEET,
        proposal="a finer interpolation (lambda/2048 and beyond), or a resolution of 1 nm",
        thesis=thesis,
        requirement="Table 2: sensor resolution",
    )


interferometer_range = stated(
    "interferometer range",
    "2*sensors.interferometer.range >= requirements.sensor_range",
    source=_DATASHEET,
    requirement="Table 2: sensor range",
)


interferometer_speed = stated(
    "interferometer speed",
    "sensors.interferometer.highest_speed >= requirements.speed",
    source=_DATASHEET,
    requirement="Table 1: speed",
)


differencing = stated(
    "velocity by differencing the LVDT",
    f"{_LVDT_COUNT}/sqrt(6)*2*sensors.lvdt.bandwidth <= 0.01*requirements.speed",
    source="two roundings, count/sqrt(6) x rate",
    proposal="an observer, or a velocity sensor",
)


lag = stated(
    "lag of the LVDT at full speed",
    "requirements.speed/(2*pi*sensors.lvdt.bandwidth) <= sensors.probe.range/2",
    source="first-order sensor of the bandwidth stated; half the probe's range must catch the stage",
    proposal="enter the probe's range at {requirements.speed*check.limit/check.value} at most, or correct the lag",
    requirement="Table 1: speed",
)


probe_linearity = stated(
    "capacitive probe linearity",
    "sensors.probe.linearity*sensors.probe.range <= requirements.resolution_coarse",
    source=_DATASHEET,
    proposal="calibrate it against the interferometer, or use {check.limit/sensors.probe.linearity} of it",
    requirement="Table 2: sensor resolution",
)


def contactless(r: DesignInputs) -> Check:
    travel, sensors = r("requirements.sensor_range"), r.design.sensors
    reach = {
        "LVDT": (r("sensors.lvdt.range"), sensors.lvdt.contactless),
        "interferometer": (2 * r("sensors.interferometer.range"), sensors.interferometer.contactless),
    }
    fit = [name for name, (length, free) in reach.items() if free and length >= travel]
    wanted = int(r.design.requirements.sensor_contactless)
    return stated(
        "sensors over the travel that do not touch",
        "sensors.that_fit >= sensors.wanted",
        given={"sensors.that_fit": (len(fit), ""), "sensors.wanted": (wanted, "")},
        source=_DATASHEET + "; number of sensors that reach over the travel and let the stage move across their axis",
        proposal="an interferometer, or a grid encoder",
        requirement="Table 2: sensor without contact",
        note=", ".join(fit) or "none",
    )(r)


cosine = stated(
    "cosine error of the interferometer",
    "2*stage.travel*sin(sensors.interferometer.misalignment/2)^2 <= requirements.resolution_coarse",
    source="beam at an angle to the travel: travel (1 - cos(angle)), without cancellation",
    proposal="align the beam to {sensors.interferometer.misalignment*sqrt(check.limit/check.value)}",
    requirement="Table 2: sensor resolution",
    note="the finest resolution, {requirements.resolution}, needs "
    "{sensors.interferometer.misalignment*sqrt(requirements.resolution/check.value)}",
)


def air_index(path: str, label: str) -> FormulaCheck:
    """An interferometer measures in wavelengths, and the wavelength in air follows temperature and pressure."""
    return stated(
        f"refractive index of the air over the interferometer's {label}",
        f"{path}*(0.93 ppm/K*environment.temperature_change + 0.0027 ppm/Pa*environment.pressure_change)"
        " <= requirements.repeatability",
        source="slopes of Edlen's equation (Birch, Downs 1994)",
        proposal="correct the index by a weather station, or hold the air to {100*check.limit/check.value} % of this",
        requirement="Section 2.3.2: repeatability (Table 1 has none)",
    )


abbe = stated(
    "Abbe error at the payload",
    "(stage.thickness/2 + payload.height)*sin(4*bearing.way_straightness/bearing_way.length)"
    " <= requirements.resolution_coarse",
    source="pitch of a way bowed by its straightness error; line of measurement at the middle of the plate",
    proposal="measure at the height of the payload, or measure the pitch too and correct it",
    requirement="Table 1: resolution",
)
