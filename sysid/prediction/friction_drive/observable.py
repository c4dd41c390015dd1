"""Effects that are observable on a driven stage, and those between tip and stage to try on top of a model."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from sim.effects.catalogue import find
from sim.library.effect import Effect
from sysid.prediction.friction_drive.friction import CONTACT
from sysid.prediction.friction_drive.record import TRANSVERSE, FrictionDriveRecord

CONTACT_EFFECTS = ("coulomb", "presliding", "stribeck", "viscous", "direction_asymmetry", "load_dependent_friction")


def can_show(record: FrictionDriveRecord, effect: Effect) -> bool:
    """Whether a friction-drive's prediction has a place for an effect of pads, drive, piezos, tip or sensor."""
    # Voltages are taken to go straight from row to row.
    if effect.acts_on in ("drive", "piezo", "sensor"):
        return effect.signal is not None and not effect.name.endswith(":of_curves")
    if effect.acts_on == "structure":
        return effect.signal is not None and ":" not in effect.name
    if effect.friction_state is not None:
        bristles = effect.friction_state.name in ("maxwell_slip", "free_maxwell_slip")
        return effect.friction_state.name == "coulomb" or (bristles and TRANSVERSE not in record.measured)
    has_law = effect.level is not None or effect.factor is not None or effect.force is not None
    return (effect.acts_on in ("friction", "axis") and has_law) or effect.acts_on == "memory"


def contact_candidates(records: Sequence[FrictionDriveRecord], present: Sequence[str]) -> list[Effect]:
    """Effects between tip and stage to try on top of a model: first that it slips, then how."""
    cores = {CONTACT + "coulomb", CONTACT + "presliding"}
    taken = set(present)
    names = []
    for name in CONTACT_EFFECTS:
        full = CONTACT + name
        if full in taken:
            continue
        if full in cores:
            # Presliding may take the place of plain slip; nothing else takes the place of presliding.
            allowed = not taken & cores or (name == "presliding" and CONTACT + "coulomb" in taken)
        else:
            allowed = bool(taken & cores)
        if name == "load_dependent_friction" and not any(_goes_up(r) for r in records):
            allowed = False
        if allowed:
            names.append(full)
    return [effect for effect in map(find, names) if all(can_show(r, effect) for r in records)]


def _goes_up(record: FrictionDriveRecord) -> bool:
    common = np.mean(record.drives, axis=0)
    return float(np.ptp(common)) > 0.02 * float(np.ptp(record.drives[1] - record.drives[0]))
