"""Checks of a machine of the user's own: those of the folder `checks`, which every machine may have."""

from __future__ import annotations

from typing import TYPE_CHECKING

from designcalc.checks.run import Subjects

if TYPE_CHECKING:
    from designcalc.checks.chain import Chain
    from stagecad.parameters.design import Design
    from stagecad.parameters.mass_properties import PartMasses


def _chains(design: Design) -> tuple[Chain, ...]:
    return ()


def _present_masses(design: Design, base: Design, masses: PartMasses) -> PartMasses:
    """Those of the present solids: a result is verified with its own."""
    return masses


SUBJECTS = Subjects(checks={}, chains=_chains, changed_masses=_present_masses)
