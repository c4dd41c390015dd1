"""Sliding bearing: pressure, pv, film, roughness and smoothness, stiffness, wear and heat."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from designcalc.checks.check import Check
from designcalc.checks.machine import film, pads, weight
from designcalc.checks.reading import Reading, show
from designcalc.sliding_bearing import (
    averaged_roughness,
    crown_wear_distance,
    friction_heat,
    pad_loads,
    pad_stiffness,
)

_FILM = "Johnson (1985), sections 4.2 and 5.8: crown and film in series"


def checks(r: Reading) -> Iterator[partial[Check]]:
    """Every check of the sliding bearing."""
    yield partial(lightest_pad, r)
    yield partial(pressure, r)
    yield partial(pv, r)
    yield partial(indentation, r)
    yield partial(proportions, r)
    yield partial(film_thickness, r)
    yield partial(stiction, r)
    yield partial(preload, r)
    yield partial(roughness_under_film, r)
    yield partial(smoothness, r, "way_roughness", "way as drawn")
    yield partial(smoothness, r, "proposed_way_roughness", "way as proposed")
    yield partial(pitch, r)
    yield partial(wear, r)
    yield partial(heat, r)


def _loads(r: Reading) -> np.ndarray:
    return pad_loads(pads(r), weight(r) + r("preload.force"), r.centre())


def _heaviest(r: Reading) -> float:
    return r.given("heaviest pad load", float(np.max(_loads(r))), "N", "statics of weight and preload on the pads")


def lightest_pad(r: Reading) -> Check:
    loads = _loads(r)
    return r.check(
        "lightest pad load over the mean",
        float(np.min(loads) / np.mean(loads)),
        0.5,
        "",
        "at least",
        "statics of the plate on its pads",
        "min N/mean N",
        ", ".join(show(float(n), "N") for n in loads),
        "pads nearer to equal shares of the load",
    )


def pressure(r: Reading) -> Check:
    load = _heaviest(r)
    contact = film(r, load)
    peak, allowed = float(contact.peak_pressure), r("bearing.allowable_pressure")
    return r.check(
        "pad pressure",
        peak,
        allowed,
        "Pa",
        "at most",
        _FILM,
        "p0 = (1.5 to 2) F/(pi a^2) <= p_allowed",
        f"F = {show(load, 'N')}: p0 = {show(peak, 'Pa')} over a spot of radius {show(float(contact.radius), 'm')}",
        f"a crown radius of about {show(r('pads.crown_radius') * (peak / allowed) ** 1.5, 'm')} (pressure falls as "
        "R^(-2/3)), or a lighter pad load",
    )


def pv(r: Reading) -> Check:
    load = _heaviest(r)
    contact = film(r, load)
    mean = load / (np.pi * float(contact.radius) ** 2)
    speed = r("requirements.speed")
    return r.check(
        "PTFE pressure times speed",
        mean * speed,
        r("bearing.allowable_pv"),
        "W/m^2",
        "at most",
        "pv limit of the film",
        "F/(pi a^2) v <= (pv)_allowed",
        f"{show(mean, 'Pa')} x {show(speed, 'm/s')} = {mean * speed:.3g} W/m^2",
        "a larger crown radius, or full speed only in moves, not all day",
        requirement="Table 1: speed",
    )


def indentation(r: Reading) -> Check:
    contact = film(r, _heaviest(r))
    thickness = r("bearing.film_thickness")
    return r.check(
        "indentation of the PTFE film",
        float(contact.indentation),
        0.25 * thickness,
        "m",
        "at most",
        _FILM,
        "delta = p0 t/M <= t/4",
        f"{show(float(contact.indentation), 'm')} of {show(thickness, 'm')}",
        "a larger crown radius",
        note="also the range of the film's formula",
    )


def proportions(r: Reading) -> Check:
    length, width = r("pads.length"), r("pads.width")
    return r.check(
        "pads twice as long as wide",
        abs(length / width - 2),
        0.1,
        "",
        "at most",
        "thesis 2.3.2, rule of Slocum (1992)",
        "|length/width - 2| <= 0.1",
        f"{show(length, 'm')}/{show(width, 'm')}",
        f"length of {show(2 * width, 'm')}",
    )


def film_thickness(r: Reading) -> Check:
    thickness = r("bearing.film_thickness")
    return r.check(
        "PTFE film as printed, '1 mm - 2 um'",
        thickness,
        r.given("thickest film that sheds its heat", 3e-6, "m", "thesis 2.3.2: Nanosurf 2 has 2 to 3 um"),
        "m",
        "at most",
        "thesis 2.3.2: keep the film thin, so that heat passes into the stage",
        "t <= 3 um",
        show(thickness, "m"),
        "1 to 2 um",
        thesis="'1 mm - 2 um' is a misprint for 1 - 2 um: a film of 1 mm would be 300 times too thick",
    )


def stiction(r: Reading) -> Check:
    static, dynamic = r("bearing.static_friction"), r("bearing.dynamic_friction")
    return r.check(
        "static over dynamic friction",
        static / dynamic,
        1.2,
        "",
        "at most",
        "thesis 2.3.2: PTFE with static within 10-20 % of dynamic",
        "mu_s/mu_d <= 1.2",
        f"{static:.3g}/{dynamic:.3g}",
        "run in for some thousand cycles; choose the filled PTFE grade for it",
        requirement="Table 1: resolution",
    )


def preload(r: Reading) -> Check:
    wanted = r("preload.ratio") * weight(r)
    force = r("preload.force")
    return r.check(
        "preload against the share of the load asked for",
        force,
        wanted,
        "N",
        "at least",
        "thesis 2.3.2: 10 % of the applied load",
        "F >= ratio x (m + m_payload) g",
        f"{show(force, 'N')} against {show(wanted, 'N')}",
        f"preload of {show(wanted, 'N')}",
    )


def roughness_under_film(r: Reading) -> Check:
    rough, thickness = r("bearing.way_roughness"), r("bearing.film_thickness")
    peak = 4 * rough
    return r.check(
        "way roughness against the PTFE film",
        peak,
        0.25 * thickness,
        "m",
        "at most",
        "Rz about 4 Ra; a quarter of the film, so that no peak cuts through",
        "4 Ra <= t/4",
        f"4 x {show(rough, 'm')} against {show(thickness / 4, 'm')}",
        f"lap the way to {show(r('bearing.proposed_way_roughness'), 'm')} Ra, as Nanosurf 2 did (nanometres)",
        thesis="Ra 1 um under a film of 1-2 um contradicts Nanosurf's way, lapped to nanometres",
        requirement="Table 1: smoothness",
    )


def smoothness(r: Reading, key: str, label: str) -> Check:
    load = _heaviest(r)
    contact = film(r, load)
    side = 2 * float(contact.radius)
    rough = r(f"bearing.{key}")
    correlation = r.given("correlation length", 20e-6, "m", "assumed: lapped ceramic, grain of the lap")
    number = int(r("pads.count"))
    left = float(averaged_roughness(rough, correlation, side, side, number))
    limit = r("requirements.smoothness")
    return r.check(
        f"smoothness of the {label}",
        left,
        limit,
        "m",
        "at most",
        "averaging of a random surface over the pads' contact",
        "Ra sqrt(pi/2) sqrt(pi) l/(2a sqrt(n)) <= 1 nm rms",
        f"Ra = {show(rough, 'm')}, contact {show(side, 'm')} wide, {number} pads: {show(left, 'm')}",
        f"Ra of {show(rough * limit / left, 'm')}, or flatter pads",
        thesis=_printed_rule(rough) if key == "way_roughness" else "",
        requirement="Table 1: smoothness",
    )


def _printed_rule(roughness: float) -> str:
    """What 'smoothness in the order of sqrt(Ra^3)' comes to: it depends on the unit, for it is no length."""
    in_metres, in_millimetres = np.sqrt(roughness**3), np.sqrt((roughness * 1e3) ** 3) * 1e-3
    return (
        f"'smoothness in the order of sqrt(Ra^3)' is no length: worked in metres it reads {show(in_metres, 'm')}, "
        f"in millimetres {show(in_millimetres, 'm')}; average the surface over the pad instead"
    )


def pitch(r: Reading) -> Check:
    loads, places = _loads(r), pads(r)
    stiffness = pad_stiffness(places, np.array([float(film(r, max(float(n), 1e-3)).stiffness) for n in loads]))
    moment = (weight(r) + r("preload.force")) * r("drive.friction") * r("stage.thickness")
    tilt = moment / stiffness.pitch
    drop = tilt * r("stage.travel") / 2
    return r.check(
        "pitch of the stage under its drive force",
        drop,
        r("requirements.smoothness"),
        "m",
        "at most",
        "pads as springs; the tip pushes below the centre of mass",
        "theta = mu N h/K_pitch; height error theta x travel/2",
        f"K_pitch = {stiffness.pitch:.3g} N m/rad, K_roll = {stiffness.roll:.3g}, K_z = "
        f"{show(stiffness.normal, 'N/m')}: {show(tilt, 'rad')}",
        "pads further apart along the travel",
        requirement="Table 1: smoothness",
    )


def wear(r: Reading) -> Check:
    load = _heaviest(r)
    radius, depth = r("pads.crown_radius"), r("bearing.film_thickness") / 2
    rate = r.given("specific wear rate", 1e-15, "m^2/N", "assumed: filled PTFE run in on lapped ceramic")
    distance = float(crown_wear_distance(depth, radius, rate, load))
    wanted = r.given("distance asked for", 1e4, "m", "assumed: 25 000 strokes there and back over the travel")
    return r.check(
        "life of the PTFE film",
        distance,
        wanted,
        "m",
        "at least",
        "Archard, the crown worn by half the film",
        "s = pi R (t/2)^2/(k F)",
        f"R = {show(radius, 'm')}, F = {show(load, 'N')}: {show(distance, 'm')}",
        f"a crown radius of {show(radius * wanted / distance, 'm')}",
    )


def heat(r: Reading) -> Check:
    load = weight(r) + r("preload.force")
    watts = float(friction_heat(r("bearing.dynamic_friction"), load, r("requirements.speed")))
    return r.check(
        "heat of sliding at full speed",
        watts,
        r.given("heat that the stage sheds", 1.0, "W", "assumed: 1 W raises a free 2 kg stage by 2 K an hour"),
        "W",
        "at most",
        "friction power",
        "mu N v",
        f"{show(load, 'N')}: {show(watts, 'W')}",
        "less preload",
    )
