"""Values of an experiment taken from the design: for `"design"` in its file, and the keys of fitted values."""

from dataclasses import dataclass
from math import hypot

from designcalc.checks.check import DesignInputs
from stagecad.parameters.errors import InputError, nearest
from stagecad.parameters.units import format_quantity
from sysid.experiment.known import DesignValue, DesignValues
from workbench.operations.design import Design
from workbench.operations.result import remark

MASS_DEVIATION = 0.01
"""Relative standard deviation of a mass computed from solids (assumed: densities from catalogues, cables and glue left
out)."""

CONTACT_DEVIATION = 0.2
"""Relative standard deviation of the stiffness of tip on stage by Hertz and Mindlin (assumed: it goes with the cube
root of a load that the tip may carry half of, and a nose's radius and a surface's edge are known to a tenth)."""

ENTRIES = {
    "piezo_spacing": "actuator.piezo_spacing",
    "tip_height": "actuator.tip_height",
    "bias_voltage": "actuator.bias_voltage",
    "coulomb.force": "friction.coulomb",
    "presliding.force": "friction.coulomb",
    "viscous.coefficient": "friction.viscous",
    "stribeck.velocity": "friction.stribeck_velocity",
    "presliding:lugre.stiffness": "friction.bristle_stiffness",
    "presliding:lugre.damping": "friction.bristle_damping",
    "dwell_strengthening:kato.rate": "friction.dwell_rate",
    "dwell_strengthening:kato.exponent": "friction.dwell_exponent",
    "magnetic_cogging.pitch": "teeth.pitch",
}
"""Numbers of an experiment that are entries of the parameter file, by their key there."""


@dataclass(frozen=True)
class DesignNumbers:
    """The design's value of a quantity, SI, by calling it with the quantity's name.

    A deviation given in the parameter file (`"1.2 +- 0.1 N"`) comes with it, and is a prior of the fit.
    """

    design: Design

    def __call__(self, name: str) -> DesignValue:
        if name == "mass":
            from designcalc.friction_stage.physics.loads import moved_mass

            mass = moved_mass(_inputs(self.design))
            return DesignValue(mass, MASS_DEVIATION * mass)
        if name == "contact_stiffness":
            return self._contact_stiffness()
        if name == "stribeck.force":
            breakaway, coulomb = self._entry("friction.breakaway"), self._entry("friction.coulomb")
            deviations = [d.std for d in (breakaway, coulomb) if d.std is not None]
            return DesignValue(max(breakaway.value - coulomb.value, 0.0), hypot(*deviations) if deviations else None)
        if name == "frictional_lag.delay":
            low, high = self._entry("friction.lag_low").value, self._entry("friction.lag_high").value
            return DesignValue(0.5 * (low + high), None, low, high)
        if name in ENTRIES:
            return self._entry(ENTRIES[name])
        known = [*ENTRIES, "mass", "contact_stiffness", "stribeck.force", "frictional_lag.delay"]
        place = f"model.parameters.{name}" if "." in name else f"rig.known.{name}"
        raise InputError(f"{place} = 'design': the design has no such number{nearest(name, known)}")

    def _contact_stiffness(self) -> DesignValue:
        # Its elliptic integrals come from a library that takes a third of a second to load.
        from designcalc.friction_stage.physics.loads import load
        from designcalc.friction_stage.physics.tip_dynamics import contact_stiffness

        r = _inputs(self.design)
        contact = contact_stiffness(r, load(r))
        remark(
            f"note: contact_stiffness = {format_quantity(contact.tangential, 'N/m')} along the surface (Mindlin), "
            f"{format_quantity(contact.normal, 'N/m')} across it (Hertz), under the {contact.load:.3g} N of weight "
            f"and preload"
        )
        return DesignValue(contact.tangential, CONTACT_DEVIATION * contact.tangential)

    def _entry(self, key: str) -> DesignValue:
        design = self.design
        entry, value = design.values.entry(key), design.si(key)
        # The deviation is kept in the attribute's unit, as the value is.
        std = None if entry.std is None or not entry.value else abs(entry.std * value / entry.value)
        return DesignValue(value, std)


def as_design_values(design: Design | None) -> DesignValues:
    """Values of settings stated as `"design"`: of a design, or of the packaged machine where none is given."""
    return DesignNumbers(design or Design())


def _inputs(design: Design) -> DesignInputs:
    """The design with the masses of its solids, as checks and simulation of the stage read it."""
    from stagecad.solids.assembly.built_machine import packaged_masses

    return DesignInputs(design.values, packaged_masses(design.values))
