"""Error budget at the payload against Table 1."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from designcalc.checks.check import Check
from designcalc.checks.machine import film, weight
from designcalc.checks.reading import Reading, show
from designcalc.error_budget import Contribution, budget
from designcalc.sensors import filtered_noise
from designcalc.sliding_bearing import averaged_roughness


def contributions(r: Reading) -> list[Contribution]:
    """Named errors of the stage: x along the travel, y across, z normal; the stage's middle plane is z = 0."""
    noise = float(
        filtered_noise(
            r("sensors.probe.resolution"), r("sensors.probe.bandwidth"), r("sensors.filtered_probe.filter_frequency")
        )
    )
    bow, length, travel = r("bearing.way_straightness"), r("bearing_way.length"), r("stage.travel")
    load = (weight(r) + r("preload.force")) / r("pads.count")
    spot = 2 * float(film(r, load).radius)
    left = float(averaged_roughness(r("bearing.way_roughness"), 20e-6, spot, spot, int(r("pads.count"))))
    across = r("pads.spacing_across")
    span = r("pads.spacing_along")
    turn = 4 * bow / length
    change = r("environment.temperature_change")
    growth = r.material("base", "expansion") * travel / 2 * change
    return [
        Contribution("sensor noise", "capacitive probe behind its filter", (noise, 0, 0)),
        Contribution("interferometer step", "data sheet", (r("sensors.interferometer.resolution"), 0, 0)),
        Contribution("straightness of the ways, up", "lapped way", (0, 0, bow / 2), random=False),
        Contribution("straightness of the ways, sideways", "lapped way", (0, bow / 2, 0), random=False),
        Contribution("pitch on a bowed way", "slope of the bow, 4 s/L", rotation=(0, turn, 0), random=False),
        Contribution("yaw on a bowed way", "slope of the bow, 4 s/L", rotation=(0, 0, turn), random=False),
        Contribution("roll by unlike ways", "half a bow over the pads' width", rotation=(bow / 2 / across, 0, 0)),
        Contribution("smoothness, heave", "averaging over the pads", (0, 0, left)),
        Contribution("smoothness, pitch", "averaging over the pads", rotation=(0, left * np.sqrt(2) / span, 0)),
        Contribution("growth of the base", "expansion over half the travel", (growth, 0, 0), random=False),
    ]


def payload_point(r: Reading) -> tuple[float, float, float]:
    """Centre of the payload over the stage's middle plane, m."""
    return 0.0, 0.0, r("stage.thickness") / 2 + r("payload.height")


def checks(r: Reading) -> Iterator[partial[Check]]:
    """The total in each direction that Table 1 bounds."""
    yield partial(total_error, r, 0, "along", "resolution_coarse", "Table 1: resolution")
    yield partial(total_error, r, 2, "normal", "smoothness", "Table 1: smoothness")


def total_error(r: Reading, axis: int, direction: str, key: str, requirement: str) -> Check:
    rows, total = budget(contributions(r), payload_point(r))
    rows = sorted(rows, key=lambda row: -abs(row[1][axis]))
    return r.check(
        f"error budget at the payload, {direction}",
        float(total[axis]),
        r(f"requirements.{key}"),
        "m",
        "at most",
        "homogeneous transforms; random errors by squares, systematic ones by size",
        "sum |e_i| + sqrt(sum e_j^2) at the payload",
        "; ".join(f"{c.name} {show(abs(float(e[axis])), 'm')}" for c, e in rows[:4]),
        f"start with {rows[0][0].name}: {rows[0][0].source}",
        requirement=requirement,
    )
