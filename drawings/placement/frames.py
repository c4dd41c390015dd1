"""Candidate positions of control frames and datum symbols, with their costs in mm of leader."""

from __future__ import annotations

import math
from collections.abc import Iterator

from drawings.annotations.annotation import DatumSymbol, FeatureControlFrame, LinearDimension
from drawings.annotations.annotation_geometry import BOX
from drawings.annotations.symbols import symbol_text_width
from drawings.dimensions.edges import near_end, places_along
from drawings.dimensions.specification import FrameSpec
from drawings.placement.candidates import Candidate
from drawings.placement.vectors import between, direction, dot, plus, view_point
from drawings.views.view import Point2, View

FRAME_LEADER_COST, FRAME_SHIFT_COST, OFF_CENTRE_COST = 0.5, 0.3, 2.0
"""Costs of a control frame or datum symbol: of its leader per mm, of its shift along the face per mm, and of a leader
at the end of the face instead of at its middle, mm."""
FRAME_CLEARANCE = 1.3
"""Distance of a control frame from the end of the dimension line that it continues, mm."""
END_COST = 10.0
"""Cost of a leader at an end of the line of its face, mm."""


def frame_candidates(spec: FrameSpec, view: View, *, extended: bool = False) -> Iterator[Candidate]:
    """Frames on leaders normal to the face, at several places along it; a control frame may be shifted sideways."""
    lengths = [9.0 + 4.0 * k for k in range(25)] if extended else (9.0, 14.0, 20.0, 27.0, 35.0, 44.0, 54.0)
    shifts = [4.0 * k for k in range(-15, 16)] if extended else (0.0, 6.0, -6.0, 14.0, -14.0, 26.0, -26.0)
    first, second = view.to_paper(spec.first), view.to_paper(spec.second)
    out = direction(spec.outward)
    along = (-out[1], out[0])
    face = math.dist(first, second)
    for fraction in places_along(spec.at, face):
        on = between(spec.first, spec.second, fraction)
        at = between(first, second, fraction)
        for length in lengths:
            cost = FRAME_LEADER_COST * length + OFF_CENTRE_COST * abs(fraction - spec.at)
            cost += END_COST * near_end(fraction, face)
            place = plus(at, out, length)
            if spec.letter:
                yield cost, DatumSymbol(spec.view, on, place, spec.letter)
                continue
            assert spec.characteristic is not None
            for shift in shifts:
                frame = FeatureControlFrame(
                    spec.view, on, plus(place, along, shift), spec.characteristic, spec.tolerance, spec.datums
                )
                yield cost + FRAME_SHIFT_COST * abs(shift), frame


def axis_candidates(spec: FrameSpec, view: View, diameter: LinearDimension) -> Iterator[Candidate]:
    """Datum symbols and control frames in line with the dimension line of a diameter: they apply to its axis (ISO 1101,
    ISO 5459). A control frame may also be at the end of the dimension line that is extended under its text."""
    u = direction(diameter.angle)
    base = dot(diameter.line_at, u)
    for point, out in (
        (diameter.first, 1.0),
        (diameter.second, 1.0),
        (diameter.first, -1.0),
        (diameter.second, -1.0),
    ):
        step = dot(view.to_paper(point), u) - base
        other = diameter.second if point is diameter.first else diameter.first
        if out * (dot(view.to_paper(other), u) - base - step) > 0.0:
            continue
        foot = plus(diameter.line_at, u, step)
        for length in (10.0, 14.0, 18.0, 24.0, 32.0, 44.0):
            yield FRAME_LEADER_COST * length, _in_line(spec, view, foot, plus(foot, u, out * length))
        if spec.letter or diameter.text_at is None:
            continue
        beyond = out * (dot(diameter.text_at, u) - base - step) + symbol_text_width(diameter.text) / 2
        if beyond > 0.0:
            end = plus(foot, u, out * beyond)
            clear = FRAME_CLEARANCE + abs(u[1]) * BOX / 2
            yield 0.0, _in_line(spec, view, end, plus(end, u, out * clear))


def _in_line(spec: FrameSpec, view: View, foot: Point2, end: Point2) -> DatumSymbol | FeatureControlFrame:
    """A datum symbol or control frame with its leader from one point on the paper to another."""
    at = view_point(foot, view)
    if spec.characteristic is None:
        return DatumSymbol(spec.view, at, end, spec.letter)
    return FeatureControlFrame(spec.view, at, end, spec.characteristic, spec.tolerance, spec.datums)
