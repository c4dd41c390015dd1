"""Masses over the values of one parameter: of solids at some values, between them by interpolation that solids verify.

A dimension of a part moves its faces, so that volume, centre and inertia are smooth functions of it between the values
at which features meet. In an interval the fourth-degree polynomials through the numbers of five solids give those of
two others to `TOLERANCE` of the body's size, or the interval is halved, down to a solid at every value.
"""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from stagecad.parameters.errors import InputError, PartError
from stagecad.parameters.mass_properties import BodyMasses, Masses, MassProperties, PartMasses

Array = NDArray[np.float64]

SOLIDS = 7
"""Solids in each interval."""
VERIFYING = [2, 4]
"""Those that verify the polynomials through the others."""
TOLERANCE = 1e-8
"""Largest difference relative to volume, mass, size or mass times size^2: ten times that of the kernel's integrals."""


def masses_over(
    values: Sequence[float], masses_at: Callable[[int], Masses], interpolate: bool = True
) -> list[Masses | str]:
    """Masses at each of the values, which rise or fall; a text where no solid can be made, which says why.

    Args:
        values: of the parameter.
        masses_at: masses of the solids at the value of that number.
        interpolate: False makes the solids of each value.
    """
    found: dict[int, Masses | str] = {}

    def make(place: int) -> None:
        if place not in found:
            try:
                found[place] = masses_at(place)
            except (InputError, PartError) as error:
                found[place] = str(error)

    def fill(first: int, last: int) -> None:
        places = [round(place) for place in np.linspace(first, last, min(SOLIDS, last - first + 1))]
        for place in places:
            make(place)
        between = [place for place in range(first, last + 1) if place not in found]
        if between and not interpolated(places, between):
            fill(first, places[len(places) // 2])
            fill(places[len(places) // 2], last)

    def interpolated(places: list[int], between: list[int]) -> bool:
        from scipy.interpolate import BarycentricInterpolator

        x = np.array([values[place] for place in places])
        known = [one for place in places if not isinstance(one := found[place], str)]
        same = len({tuple(_bodies(one)) for one in known}) == 1
        if not same or len(known) < SOLIDS or len(np.unique(x)) < SOLIDS:
            return False
        numbers = np.array([_numbers(one) for one in known])
        others = np.delete(np.arange(SOLIDS), VERIFYING)
        estimated = BarycentricInterpolator(x[others], numbers[others])(x[VERIFYING])
        if np.any(np.abs(estimated - numbers[VERIFYING]) > TOLERANCE * _sizes(known[0])):
            return False
        rows = BarycentricInterpolator(x, numbers)([values[place] for place in between])
        found.update((place, _with_numbers(known[0], row)) for place, row in zip(between, rows, strict=True))
        return True

    if interpolate and values:
        fill(0, len(values) - 1)
    for place in range(len(values)):
        make(place)
    return [found[place] for place in range(len(values))]


def _bodies(masses: Masses) -> dict[str, MassProperties]:
    return dict(masses.parts) if isinstance(masses, PartMasses) else vars(masses)


def _numbers(masses: Masses) -> Array:
    """All numbers of all bodies (bodies, 20): volume, mass, centre, inertia, box."""
    bodies = _bodies(masses).values()
    return np.array([np.hstack([np.ravel(number) for number in vars(one).values()]) for one in bodies])


def _sizes(masses: Masses) -> Array:
    """What the differences of these numbers are relative to (bodies, 20)."""
    rows = []
    for one in _bodies(masses).values():
        size = float(np.linalg.norm(np.subtract(*one.bounding_box)))
        rows.append([one.volume, one.mass, *[size] * 3, *[one.mass * size**2] * 9, *[size] * 6])
    return np.array(rows)


def _with_numbers(masses: Masses, numbers: Array) -> Masses:
    bodies = {
        name: MassProperties(float(row[0]), float(row[1]), row[2:5], row[5:14].reshape(3, 3), row[14:].reshape(2, 3))
        for name, row in zip(_bodies(masses), numbers, strict=True)
    }
    return PartMasses(bodies) if isinstance(masses, PartMasses) else BodyMasses(**bodies)
