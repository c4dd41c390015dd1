"""Field and forces of the toothed irons of the design, with one magnet over each bar."""

from dataclasses import dataclass, replace

from designcalc.checks.check import DesignInputs, remembered
from designcalc.drive.magnetic_teeth import MagnetForces, MagnetSection, TeethField, magnet_forces, teeth_field

CIRCUITS = 2
"""Magnetic circuits: one pocket with its magnet over each of the two bars."""


@dataclass(frozen=True)
class MagnetCircuit:
    """One magnet with its two irons and its bar."""

    section: MagnetSection  # geometry across the travel
    length: float  # of magnet and irons along the travel, m
    remanence: float  # T
    recoil_permeability: float  # relative

    def forces(self, refinement: float = 1.0, **changes: float) -> MagnetForces:
        """Forces of the circuit, with some lengths of its section changed."""
        section = replace(self.section, **changes)
        return magnet_forces(section, self.length, self.remanence, self.recoil_permeability, refinement)


MAGNETS = "finite elements in the cross-section of magnet, irons and bar, leakage included; virtual work"
"""How the forces of the magnets are found."""


def circuit(r: DesignInputs) -> MagnetCircuit:
    """One of the two magnetic circuits of the design."""
    section = MagnetSection(
        pitch=r("teeth.pitch"),
        tooth_width=r("teeth.width"),
        gap=r("teeth.gap"),
        groove_depth=r("teeth.groove_depth"),
        teeth=int(r("teeth.per_iron")),
        iron_height=r("tooth_iron.height"),
        magnet_thickness=r("magnet.thickness"),
        magnet_height=r("magnet.height"),
        channel_depth=r("tooth_bar.channel_depth"),
    )
    length = min(r("tooth_iron.length"), r("magnet.length"))
    return MagnetCircuit(section, length, r("magnet.remanence"), r("magnet.recoil_permeability"))


@remembered
def magnets(r: DesignInputs) -> MagnetForces:
    """Working point of one circuit of the design, leakage included."""
    return circuit(r).forces()


@remembered
def attraction(r: DesignInputs) -> float:
    """Pull of all magnets of the design on the stage, N; 0 without teeth."""
    return CIRCUITS * magnets(r).attraction if r.design.teeth.fitted else 0.0


@remembered
def tooth_field(r: DesignInputs) -> TeethField:
    """Field of one cell of the teeth, which repeats across the travel."""
    return teeth_field(r("teeth.pitch"), r("teeth.width"), r("teeth.gap"), r("teeth.groove_depth"))
