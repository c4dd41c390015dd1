"""Vectors on the paper: directions, sums, points between two others, view coordinates of a point of the paper."""

from __future__ import annotations

import math

from drawings.views.view import Point2, View


def direction(degrees: float) -> Point2:
    turn = math.radians(degrees)
    return (math.cos(turn), math.sin(turn))


def plus(point: Point2, direction: Point2, length: float) -> Point2:
    return (point[0] + length * direction[0], point[1] + length * direction[1])


def between(first: Point2, second: Point2, fraction: float) -> Point2:
    return (first[0] + fraction * (second[0] - first[0]), first[1] + fraction * (second[1] - first[1]))


def view_point(point: Point2, view: View) -> Point2:
    """View coordinates of a point of the paper."""
    return ((point[0] - view.place[0]) / view.scale, (point[1] - view.place[1]) / view.scale)


def dot(a: Point2, b: Point2) -> float:
    return a[0] * b[0] + a[1] * b[1]
