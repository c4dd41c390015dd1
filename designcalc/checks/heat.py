"""Drift by heat, way on base, magnetism, the floor's shake."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from designcalc.checks.check import Check
from designcalc.checks.drive import tip_resonance
from designcalc.checks.machine import stroke_ellipse
from designcalc.checks.reading import Reading, show
from designcalc.thermal import differential_growth, loop_drift, vibration_at_tip


def checks(r: Reading) -> Iterator[partial[Check]]:
    """Drift of the tip, the way on the base, magnetism, vibration; with the base's other material beside each."""
    yield partial(tip_drift, r)
    yield partial(way_growth, r)
    yield partial(base_expansion, r)
    if r.design.teeth.fitted:
        yield partial(magnetism, r)
    yield partial(vibration, r)


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
