"""The sensors that reach over the travel and do not touch the stage."""

from designcalc.checks.check import Check, DesignInputs
from designcalc.friction_stage.quantities import stated


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
        source="thesis 2.3.4, data sheets; number of sensors that reach over the travel and let the stage move across "
        "their axis",
        proposal="an interferometer, or a grid encoder",
        requirement="Table 2: sensor without contact",
        note=", ".join(fit) or "none",
    )(r)
