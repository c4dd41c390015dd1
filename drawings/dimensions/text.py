"""Dimension text: decimals by tolerance class, counts, diameter and radius signs, hole callouts."""

import math
import textwrap
from collections.abc import Iterable, Sequence
from typing import Any

from stagecad.parameters.dimension import (
    DatumFeature,
    Dimension,
    FaceRequirement,
    GeometricTolerance,
    SurfaceTexture,
    feature_of,
)

DECIMALS = {"X": 0, "X.X": 1, "X.XX": 2}
"""Number of decimals of each tolerance class: a 12 has a wider tolerance than a 12.0."""

MOST_DECIMALS = 3
"""Most decimals of a number on a sheet: the rounding, 0.5 um, is small against the tightest class."""

DIAMETER, TIMES, PLUS_MINUS, DEGREE = "⌀", "x", "±", "°"


AXIAL = ("perpendicularity", "parallelism", "angularity", "position", "coaxiality", "straightness")
"""Characteristics that hold for the axis of a round feature, within a cylinder."""


def number(value: float, tolerance: str | None, plus_minus: float) -> str:
    """A value with the decimals of its class; where these would round it, with more decimals and the tolerance."""
    value = round(value, MOST_DECIMALS)
    needed = next((n for n in range(MOST_DECIMALS) if abs(round(value, n) - value) < 1e-6), MOST_DECIMALS)
    if tolerance is None:
        return f"{value:.{needed}f}"
    if tolerance not in DECIMALS:
        return f"{value:.{needed}f} {tolerance}"
    own = DECIMALS[tolerance]
    return f"{value:.{own}f}" if needed <= own else f"{value:.{needed}f} {PLUS_MINUS}{plus_minus:g}"


def value_text(dimension: Dimension, plus_minus: float) -> str:
    """A dimension's value with its class and limit deviations: `12.0`, `16 H7 (+0.018/0)`, `0.036 ±0.005`; the value
    in a frame where it is theoretically exact, `{box:46}`."""
    if dimension.exact:
        return f"{{box:{number(dimension.value, None, 0.0)}}}"
    value = number(dimension.value, dimension.tolerance, plus_minus)
    if dimension.deviations is None:
        return value
    low, high = dimension.deviations
    limits = "/".join(f"{round(value, 6):+g}" if value else "0" for value in (high, low))
    limits = f"{PLUS_MINUS}{high:g}" if abs(low + high) < 1e-9 else limits
    return f"{value} ({limits})" if dimension.tolerance else f"{dimension.value:.3f} {limits}"


def times(count: int) -> str:
    """Prefix of a dimension of several equal features: `3x `."""
    return f"{count}{TIMES} " if count > 1 else ""


def dimension_text(dimension: Dimension, plus_minus: float) -> str:
    """Text of a single dimension, without its note."""
    value = value_text(dimension, plus_minus)
    match dimension.kind:
        case "diameter":
            value = DIAMETER + value
        case "tap_drill":
            value = f"{dimension.note}, drill {DIAMETER}{value}"
        case "radius":
            value = f"{'S' if 'spherical' in dimension.note else ''}R{value}"
        case "angle":
            value = f"{number(dimension.value, dimension.tolerance, 0.0).partition(' ')[0]}{DEGREE}"
        case "chamfer":
            value = f"{value}{TIMES}45{DEGREE}"
        case "slope":
            steep = 1 / dimension.value
            ratio = f"1:{steep:g}" if abs(steep - round(steep)) < 1e-9 else f"{dimension.value:g}"
            value = f"slope {{box:{ratio}}}" if dimension.exact else f"slope {ratio}"
        case "depth":
            value = "{depth}" + value
        case "pitch_circle":
            step = number(360 / dimension.count, None, 0.0)
            spacing = f" ({dimension.count}{TIMES} {step}{DEGREE})" if dimension.count > 1 else ""
            return f"{DIAMETER}{value}{spacing}"
        case "sag":
            value = f"crown {value} over {math.dist(*dimension.points):.1f}"
        case "callout":
            return dimension.note
        case "pitch" if dimension.count > 1:
            tolerance = None if dimension.exact else dimension.tolerance
            whole = number(dimension.value * dimension.count, tolerance, plus_minus).partition(" ")[0]
            return f"{dimension.count}{TIMES} {value} (={whole})"
        case _:
            pass
    if dimension.reference:
        value = f"({value})"
    return times(1 if dimension.kind == "pitch" else dimension.count) + value


def callout(dimensions: Sequence[Dimension], plus_minus: Sequence[float]) -> tuple[str, ...]:
    """Lines of the callout of a feature: count, thread or diameter, depth, counterbore, notes."""
    value = {d.name: value_text(d, p) for d, p in zip(dimensions, plus_minus, strict=True)}
    count = max(d.count for d in dimensions)
    lines: list[str] = []
    line_of: dict[str, int] = {}
    thread = next((d.note for d in dimensions if d.kind in ("tap_drill", "thread_depth")), "")
    threaded = _thread(dimensions, value, thread) if thread else []
    for d in dimensions:
        if thread and d.note == thread:
            lines, threaded = [*lines, *threaded], []
            continue
        match d.kind:
            case "diameter":
                sign = next((f"{{{word}}}" for word in ("counterbore", "countersink") if word in d.name), "")
                line_of[d.name] = len(lines)
                lines.append(f"{sign}{DIAMETER}{value[d.name]}")
            case "depth" if d.note or not lines:
                lines.append("{depth}" + value[d.name])
            case "depth":
                # That of the diameter with whose name its own begins: `clamp counterbore depth`.
                named = [name for name in line_of if d.name.startswith(name)]
                at = next((i for i, line in enumerate(lines) if "{depth}" not in line), 0)
                at = line_of[max(named, key=len)] if named else at
                lines[at] += " {depth}" + value[d.name]
            case "count" if int(d.value) == count and len(dimensions) > 1:
                continue
            case "count":
                own = d.name
                if len(dimensions) > 1:
                    own = own.removeprefix(f"{d.feature}s").removeprefix(d.feature.split()[0]).strip()
                lines.append(f"{d.value:g} {own}")
            case "chamfer":
                lines.append(f"{value[d.name]}{TIMES}45{DEGREE}")
            case "callout":
                lines.append(d.note)
                continue
            case _:
                lines.append(dimension_text(d, plus_minus[list(dimensions).index(d)]).removeprefix(times(d.count)))
        if d.note and lines:
            lines[-1] += f"{',' if d.kind == 'count' else ''} {d.note}"
    if not lines:
        lines = [dimensions[0].name]
    lines[0] = times(count) + lines[0]
    return tuple(wrapped_lines(lines))


def _thread(dimensions: Sequence[Dimension], value: dict[str, str], thread: str) -> list[str]:
    """`M6x1 {depth}7.0` and `drill ⌀5 {depth}9.0`; `through` where no depth is declared."""
    own = [d for d in dimensions if d.note == thread]
    deep = next((d for d in own if d.kind == "thread_depth"), None)
    drill = next((d for d in own if d.kind == "tap_drill"), None)
    hole = next((d for d in own if d.kind == "depth"), None)
    # A remark may say how far it goes.
    far = any(d.kind == "callout" and ("length" in d.note or d.note.startswith(("to ", "through"))) for d in dimensions)
    through = "" if hole or far else " through"
    first = thread + (f" {{depth}}{value[deep.name]}" if deep else through)
    words = [DIAMETER + value[drill.name]] if drill else []
    words += ["{depth}" + value[hole.name]] if hole else []
    return [first, *([f"drill {' '.join(words)}"] if words else [])]


def wrapped_lines(lines: Sequence[str], longest: int = 34) -> list[str]:
    """Long lines broken at spaces."""
    return [
        part for line in lines for part in textwrap.wrap(line, longest, break_long_words=False, break_on_hyphens=False)
    ]


def tolerance_text(tolerance: GeometricTolerance) -> str:
    """The second compartment of a control frame: `⌀0.2 CZ`."""
    cylindrical = tolerance.round and tolerance.characteristic in AXIAL
    return f"{DIAMETER if cylindrical else ''}{tolerance.value:g}{' CZ' if tolerance.combined else ''}"


def lines_of_features(requirements: Sequence[FaceRequirement]) -> dict[str, list[str]]:
    """Control frames and roughness by the name of the holes in whose callout they are."""
    found: dict[str, list[str]] = {}
    for one in requirements:
        if isinstance(one, GeometricTolerance) and feature_of(one):
            # Drawn by `drawings.annotations.symbols`: `{frame:position|⌀0.2|A|B}`.
            cells = "|".join((one.characteristic, tolerance_text(one), *one.datums))
            found.setdefault(one.feature, []).append(f"{{frame:{cells}}}")
        elif isinstance(one, SurfaceTexture) and feature_of(one):
            found.setdefault(one.feature, []).append(roughness_text(one))
    return found


def roughness_text(texture: SurfaceTexture) -> str:
    """`Ra 0.8 reamed` with the symbol of ISO 21920."""
    return f"{{surface}}Ra {number(texture.roughness, None, 0.0)} {texture.process}".strip()


def general_tolerance(design: Any, requirements: Iterable[FaceRequirement]) -> GeometricTolerance:
    """The profile of all faces without a tolerance of their own, in the first three datums of a part (ISO 22081)."""
    letters = sorted(r.letter for r in requirements if isinstance(r, DatumFeature))[:3]
    width, key = 2 * design.drawing.tolerance_x_x, "drawing.tolerance_x_x"
    return GeometricTolerance(
        "general tolerance", "profile", width, key, (), (0.0, 0.0, 1.0), "any", datums=tuple(letters)
    )
