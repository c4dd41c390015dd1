"""The thesis's friction models, with the values of its Table 3."""

import math
from dataclasses import dataclass

from sim.effects.catalogue import Model, compose
from stagecad.parameters.errors import InputError

MODELS = ("lugre", "lugre_undamped", "lugre_causal", "lugre_causal_as_run")
"""Canudas et al.; 'no bristle damping'; 'modified dynamics' as derived; the same as its listings ran it (a1 = 0)."""

MOST_STEPS = 3_000_000
"""Largest number of steps of a simulation (some seconds); the experiments need far fewer unless a contact is stiff."""

TITLES = {
    "lugre": "LuGre (Canudas et al.)",
    "lugre_undamped": "No bristle damping",
    "lugre_causal": "Causal, as derived",
    "lugre_causal_as_run": "Causal, as run (a1 = 0)",
}


@dataclass(frozen=True)
class Friction:
    """Parameters of the friction experiments, SI; the defaults are the thesis's Table 3."""

    coulomb: float = 1.0  # Fc, N
    breakaway: float = 1.5  # Fs, N
    stribeck_velocity: float = 1e-3  # vs, m/s
    bristle_stiffness: float = 1e5  # a0, N/m
    bristle_damping: float = math.sqrt(1e5)  # a1, N*s/m
    viscous: float = 0.4  # a2, N*s/m

    def __post_init__(self) -> None:
        for name in ("coulomb", "stribeck_velocity", "bristle_stiffness"):
            if not (getattr(self, name) > 0.0 and math.isfinite(getattr(self, name))):
                raise InputError(f"friction.{name} = {getattr(self, name):g}; must be positive")
        for name in ("bristle_damping", "viscous"):
            if not (getattr(self, name) >= 0.0 and math.isfinite(getattr(self, name))):
                raise InputError(f"friction.{name} = {getattr(self, name):g}; must not be negative")
        if not self.breakaway >= self.coulomb:
            raise InputError(
                f"friction.breakaway = {self.breakaway:g} N; must not be below friction.coulomb = {self.coulomb:g} N"
            )

    def model(self, core: str) -> Model:
        """The model with the friction state model of that name, Stribeck curve and viscous friction."""
        values = {
            f"{core}.force": self.coulomb,
            f"{core}.stiffness": self.bristle_stiffness,
            "stribeck.force": self.breakaway - self.coulomb,
            "stribeck.velocity": self.stribeck_velocity,
            "viscous.coefficient": self.viscous,
        }
        if core in ("lugre", "lugre_causal"):
            values[f"{core}.damping"] = self.bristle_damping
        return compose([core, "stribeck", "viscous"], values)
