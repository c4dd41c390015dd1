"""Play of height pin 2 in its bore, within which it turns."""

from designcalc.checks.check import DesignInputs, Quantities


def wedge_contact(r: DesignInputs) -> Quantities:
    # Both fits in the middle of their tolerances.
    middle = {key: 1e-3 * sum(r.design.deviations(key)) / 2 for key in ("base.pin_2_bore", "height_pin_2.diameter")}
    bore, pin = (r(key) + deviation for key, deviation in middle.items())
    return {"play.of_pin_2": (bore - pin, "m")}
