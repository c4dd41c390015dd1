"""A finger cut out beside a round pocket, which a screw turns about its neck until it grips what is in the pocket.

The neck is a notch hinge between a relief hole and the pocket; the finger beyond it is a bar that the screw twists,
held along its whole depth by the neck's rotational stiffness. Beside the gap slot the finger ends in a wedge, which
bends by itself where the holder presses on it.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import quad

from stagecad.parameters.errors import InputError, require

Array = NDArray[np.float64]

_POINTS = 121
"""Through the depth, for means and maxima."""


@dataclass(frozen=True)
class ClampFinger:
    """A clamp's finger; SI units, depths from the top.

    Raises:
        InputError: a length, lever, angle or modulus that is not above 0; a relief hole as large as the pocket.

    Source: Smith, Chetwynd, Foundations of Ultraprecision Mechanism Design (1992), chapter 4 (notch hinges, stress);
    Timoshenko, Goodier, Theory of Elasticity (1970), section 38 (wedge), and Young, Roark's Formulas (torsion); turning
    of a half-space by a moment: O'Donnell, J. Appl. Mech. 27 (1960) 461.
    """

    neck: float  # least thickness of the neck
    relief_radius: float  # of the hole on the neck's outer side
    pocket_radius: float  # of the pocket on its inner side
    depth: float  # of the finger and its neck
    screw_lever: float  # distance of the screw's axis from the middle of the neck, across the screw
    press_lever: float  # of the line in which the holder presses, likewise
    screw_depth: float  # of the screw's axis
    press_depth: float  # down to which the holder presses
    lug_width: float  # of the finger's cross-section
    lug_thickness: float  # of the finger's cross-section
    wedge_angle: float  # of the finger's end between pocket and gap slot, rad
    press_length: float  # of the wedge's side on which the holder presses
    neck_angle: float  # of the neck, from the screw's direction, rad
    press_angle: float  # of the force on the holder, likewise
    modulus: float  # of the material, Pa
    poisson: float  # of the material

    def __post_init__(self) -> None:
        for name in self.__dataclass_fields__:
            require(name == "poisson" or getattr(self, name) > 0, f"clamp: {name}: must be above 0")
        if self.relief_radius >= self.pocket_radius:
            raise InputError("clamp: relief_radius: must be below that of the pocket")

    @cached_property
    def hinge_stiffness(self) -> float:
        """Rotational stiffness of the neck per depth, k, N m/rad/m.

        ``1/k = integral of 12 dx/(E' t(x)^3) + s 2 x 16.67/(pi E' t^2)``: bending over the relief hole's diameter, t(x)
        between the two circles, ``E' = E/(1 - nu^2)`` since the neck is deep; and the turning of the two half-spaces
        that the neck ends in. Of the latter a notch has the share ``s = t/(t + r)``: none where its radius r is large,
        all at a sharp corner; this interpolation is compared with finite elements only.
        """
        r, t = self.relief_radius, self.neck
        bending = _notch_flexibility(t, r, self.pocket_radius, self.plane_modulus)
        ends = 2 * 16.67 / (np.pi * self.plane_modulus * t**2) * t / (t + r)
        return 1 / (bending + ends)

    @property
    def plane_modulus(self) -> float:
        """``E/(1 - nu^2)``, Pa."""
        return self.modulus / (1 - self.poisson**2)

    @cached_property
    def _torsion(self) -> float:
        """``G J`` of the lug as a rectangle, N m^2; ``J = a b^3 [1/3 - 0.21 b/a (1 - b^4/(12 a^4))]``, a >= b."""
        short, long = sorted((self.lug_width, self.lug_thickness))
        ratio = short / long
        section = long * short**3 * (1 / 3 - 0.21 * ratio * (1 - ratio**4 / 12))
        return self.modulus / (2 * (1 + self.poisson)) * section

    def turn(self, at: Array, torque_at: Array) -> Array:
        """Rotation at a depth by a unit torque at another, rad/(N m): bar with free ends on a rotational foundation.

        ``cosh(l z<) cosh(l (H - z>))/(G J l sinh(l H))``, ``l = sqrt(k/(G J))``.
        """
        stiffness, H = self._torsion, self.depth
        decay = np.sqrt(self.hinge_stiffness / stiffness)
        near, far = np.minimum(at, torque_at), np.maximum(at, torque_at)
        return np.cosh(decay * near) * np.cosh(decay * (H - far)) / (stiffness * decay * np.sinh(decay * H))

    @cached_property
    def _pressed(self) -> Array:
        """Depths within the part on which the holder presses."""
        return self.press_depth * (np.arange(_POINTS) + 0.5) / _POINTS

    @property
    def closure(self) -> float:
        """Mean inward movement of the wall where the holder will press, by a unit force of the screw, m/N."""
        turned = self.turn(self._pressed, np.array(self.screw_depth)).mean()
        return float(self.screw_lever * self.press_lever * turned)

    @property
    def give(self) -> float:
        """Movement of the same wall by a unit force that the holder presses on it with, m/N."""
        turned = self.turn(self._pressed[:, None], self._pressed[None, :]).mean()
        return float(self.press_lever**2 * turned) + self._wedge

    @property
    def _wedge(self) -> float:
        """Bending and shear of the finger's end as a wedge between the line load and the neck, m/N.

        A wedge of thickness ``s tan(alpha)`` under a line load at p, S from its edge to the neck, per depth:
        ``12/(E' tan^3) [ln(S/p) - 2 (1 - p/S) + (1 - p^2/S^2)/2] + 1.2/(G tan) ln(S/p)``. None where the end is blunt.
        """
        if self.wedge_angle >= np.pi / 2:
            return 0.0
        p, S, tan = self.press_length / 2, self.press_lever, np.tan(self.wedge_angle)
        shear_modulus = self.modulus / (2 * (1 + self.poisson))
        bending = 12 / (self.plane_modulus * tan**3) * (np.log(S / p) - 2 * (1 - p / S) + (1 - (p / S) ** 2) / 2)
        return float((bending + 1.2 / (shear_modulus * tan) * np.log(S / p)) / self.press_depth)

    def moment(self, screw_force: float, press_force: float) -> float:
        """Largest moment of the neck per depth, N, where screw and holder press; often at an end of it."""
        every = np.linspace(0.0, self.depth, _POINTS)
        by_screw = self.screw_lever * self.turn(every, np.array(self.screw_depth))
        by_holder = self.press_lever * self.turn(every[:, None], self._pressed[None, :]).mean(axis=1)
        return float(self.hinge_stiffness * np.abs(screw_force * by_screw - press_force * by_holder).max())

    def stress(self, screw_force: float, press_force: float = 0.0) -> float:
        """Largest stress of the neck, Pa: ``K_t [6 (m + v x)/t(x)^2 + n/t(x)]`` over the hinge.

        m is the bending by the turning, v and n are the forces of screw and holder across and along the neck, per depth
        at the top: ``V/H (1 + 6 e/H)``, e from half depth to the screw; ``K_t = (1 + t/(2 r))^(9/20)`` of a notch.
        """
        A, phi, H, t, r = self.neck_angle, self.press_angle, self.depth, self.neck, self.relief_radius
        top = (1 + 6 * abs(H / 2 - self.screw_depth) / H) / H
        across = abs(screw_force * np.cos(A) + press_force * np.cos(A - phi)) * top
        along = abs(screw_force * np.sin(A) + press_force * np.sin(A - phi)) * top
        x = np.linspace(0, r, _POINTS)
        thickness = _notch_thickness(x, t, r, self.pocket_radius)
        local = 6 * (self.moment(screw_force, press_force) + across * x) / thickness**2 + along / thickness
        return float((1 + t / (2 * r)) ** 0.45 * local.max())

    def press_force(self, screw_force: float, gap: float) -> float:
        """Force on the holder once the screw has closed a gap, m, N: ``(closure F - gap)/give``; 0 if it does not."""
        return max(self.closure * screw_force - gap, 0.0) / self.give


def _notch_thickness(x: Array | float, neck: float, r: float, R: float) -> Array:
    """Thickness between two circles of radii r and R, `neck` apart, at a distance x from the middle of the neck, m."""
    return np.asarray(neck + r - np.sqrt(r**2 - np.square(x)) + R - np.sqrt(R**2 - np.square(x)))


@lru_cache(maxsize=256)
def _notch_flexibility(neck: float, r: float, R: float, modulus: float) -> float:
    """Integral of ``12 dx/(E' t(x)^3)`` over the diameter of the smaller circle, 1/N."""
    return float(quad(lambda x: 12 / (modulus * _notch_thickness(x, neck, r, R) ** 3), -r, r)[0])
