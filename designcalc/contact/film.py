"""Contact of a crowned body with a flat through a thin soft film."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stagecad.parameters.errors import InputError, require

Array = NDArray[np.float64]


@dataclass(frozen=True)
class FilmContact:
    """A crowned pad with a thin soft film pressed on a flat; arrays in SI units."""

    radius: Array  # of the contact, m
    indentation: Array  # of the film alone, in the middle, m
    peak_pressure: Array  # Pa
    stiffness: Array  # dF/ddelta, N/m


def confined_modulus(modulus: float, poisson: float) -> float:
    """Stiffness of a film that cannot spread: ``E (1-nu)/((1+nu)(1-2nu))``, Pa; nu 0 to below 0.5."""
    if not 0 <= poisson < 0.499:
        raise InputError(
            f"sliding bearing: poisson: {poisson:g} must lie in 0 to 0.499 (a film of 0.5 is incompressible)"
        )
    return modulus * (1 - poisson) / ((1 + poisson) * (1 - 2 * poisson))


def film_contact(
    load: ArrayLike, crown_radius: float, thickness: float, film_modulus: float, substrate_modulus: float
) -> FilmContact:
    """A spherical crown pressed on a flat through a thin film, on elastic bodies.

    Two limits are exact: a film on rigid bodies is an elastic foundation (``F = pi M a^4/(4 R t)``,
    ``delta = a^2/(2R)``, ``p0 = M delta/t``), bodies without a film are Hertz's (``F = 4 E* a^3/(3R)``, ``delta =
    a^2/R``, ``p0 = 2 E* a/(pi R)``). Between them the loads needed for one radius act in series, ``1/F = 1/F_film +
    1/F_Hertz``, and so do the stiffnesses ``pi M a^2/t`` and ``2 E* a``; the peak over the mean pressure goes from 2 to
    1.5 with the shares. A film of micrometres on a crown of metres is near Hertz's limit.

    Args:
        load: F, N, > 0, any shape.
        crown_radius: R of the pad, m.
        thickness: t of the film, m.
        film_modulus: confined modulus M, Pa (`confined_modulus`).
        substrate_modulus: contact modulus E* of pad and way without the film, Pa; ``inf`` for rigid ones.

    Returns:
        `FilmContact`. Valid while the film is thin, t < a, and little dented: check `indentation` against t.

    Raises:
        InputError: an argument not above zero, or a film thicker than the contact's radius.

    Source: Johnson, Contact Mechanics (1985), sections 4.2 and 5.8; the series between the limits is an interpolation.
    """
    force = np.asarray(load, float)
    for name, value in (
        ("crown radius", crown_radius),
        ("film thickness", thickness),
        ("film modulus", film_modulus),
        ("substrate modulus", substrate_modulus),
    ):
        require(value > 0, f"sliding bearing: {name}: {value:g} must be above 0")
    require(np.all(force > 0), "sliding bearing: load: must be above 0 N")
    # F/F_film + F/F_Hertz = 1 falls steadily with a: Newton in ln a from the larger of the two limits, where it is < 2.
    film_scale = 4 * crown_radius * thickness / (np.pi * film_modulus)
    hertz_scale = 3 * crown_radius / (4 * substrate_modulus)
    a = np.maximum((force * film_scale) ** 0.25, np.cbrt(force * hertz_scale))
    for _ in range(30):
        film, hertz = force * film_scale / a**4, force * hertz_scale / a**3
        step = (film + hertz - 1) / (4 * film + 3 * hertz)
        a = a * np.exp(step)
        if np.all(np.abs(step) <= 1e-15):
            break
    if not np.all(thickness <= a):
        raise InputError(
            f"sliding bearing: film thickness: {thickness:g} m is more than the radius {float(np.min(a)):.3g} m of the "
            "contact; the formula is for thin films"
        )
    share = force * film_scale / a**4  # 1 where only the film deflects
    film_stiffness = np.pi * film_modulus * a**2 / thickness
    peak = (1.5 + 0.5 * share) * force / (np.pi * a**2)
    return FilmContact(
        radius=a,
        indentation=peak * thickness / film_modulus,
        peak_pressure=peak,
        stiffness=1 / (1 / film_stiffness + 1 / (2 * substrate_modulus * a)),
    )
