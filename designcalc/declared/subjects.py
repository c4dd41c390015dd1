"""Checks of a machine of the user's own: those of the folder `checks`, which every machine may have."""

from __future__ import annotations

from typing import TYPE_CHECKING

from designcalc.checks.subjects import Subjects

if TYPE_CHECKING:
    from designcalc.checks.chain import Chain
    from stagecad.parameters.design import Design
    from stagecad.parameters.mass_properties import PartMasses


def _chains(design: Design) -> tuple[Chain, ...]:
    return ()


def _scaled_masses(design: Design, base: Design, masses: PartMasses) -> PartMasses:
    """Those of the nominal design: a tolerance changes a mass by a hundredth at most."""
    return masses


SUBJECTS = Subjects(checks={}, chains=_chains, scaled_masses=_scaled_masses)
