"""Rig parameters of a friction drive: known ones are fixed, the others are estimated from its records and fitted.

The motion determines forces and mass over the contact stiffness only. Where neither mass nor stiffness is known, the
stiffness is fixed; where the mass is known, the inertial part of the motion determines the stiffness, and it is fitted
within a decade or so of that of a Hertz contact under some newtons.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from sysid.experiment.known import Known
from sysid.experiment.record import Record
from sysid.prediction.actuator_tip import VOLTAGES
from sysid.prediction.rig_model import RigParameters

CONTACT_STIFFNESS = 1e7
"""N/m, where the user gives none: the order of a Hertz contact under some newtons."""
STIFFNESS_DECADE = 20.0
"""Factor by which a fitted stiffness may be softer or stiffer than that."""
CONTACT_DAMPING = 0.03
"""Damping ratio of the stage on its contact, where a fit of the dashpot begins."""
MASS = 1.0
"""kg, where a fit of the mass begins."""
MOST_DAMPING = 10.0
"""Largest value of the dashpot over its start, a third of critical; a fit at this bound indicates a missing effect."""
GUIDE = 0.01
"""Scale of the fitted stiffness of a guide across the travel (teeth, a flexure), over that of the contact."""
MOST_TURN = 0.3
"""Largest rotation of the sensors against the tip, rad."""
GOES_UP = 0.02
"""Range of the tip's rise over the swing of its lean from which the rise counts."""


def friction_drive_parameters(known: Mapping[str, Known], records: Sequence[Record]) -> RigParameters:
    """Parameters of the rig, from what is known of it and the records of the fit."""
    found = RigParameters(known)
    gain, indentation = gain_and_indentation(known, records)
    mass = found.put("mass", MASS)
    soft, stiff = CONTACT_STIFFNESS / STIFFNESS_DECADE, CONTACT_STIFFNESS * STIFFNESS_DECADE
    stiffness = found.put("contact_stiffness", CONTACT_STIFFNESS, (soft, stiff), free="mass" in known)
    damping = contact_damping(stiffness, mass)
    stiffest = contact_damping(stiff, mass) if "contact_stiffness" not in known else damping
    found.put("contact_damping", damping, (0.0, MOST_DAMPING * max(damping, stiffest)))
    found.put("gain", gain, known_as="piezo_gain")
    if indentation is not None:
        found.put("press", indentation)
    if any("position_y" in record.channels for record in records):
        found.put_free("guide_stiffness", 0.0, (0.0, STIFFNESS_DECADE * stiffness), GUIDE * stiffness)
        found.put_free("turn", 0.0, (-MOST_TURN, MOST_TURN), 1e-2)
    return found


def contact_damping(stiffness: float, mass: float) -> float:
    """Start of a fit of the contact's dashpot, N s/m."""
    return CONTACT_DAMPING * 2.0 * float(np.sqrt(stiffness * mass))


def gain_and_indentation(known: Mapping[str, Known], records: Sequence[Record]) -> tuple[float, float | None]:
    """Start of a fit: the gain that makes the tip's travel the stage's, m/V, and the preload indentation of the
    tip, m.

    The indentation is none where the tip does not move up and down: then it is not identifiable.
    """
    lever = known["tip_height"].value / known["piezo_spacing"].value
    across, common, travel = [], [], []
    for record in records:
        volts = [record.channels[name] for name in VOLTAGES if name in record.channels]
        across.append(float(np.nanstd(volts[1] - volts[0])))
        common.append(float(np.ptp(np.nanmean(volts, axis=0))))
        travel.append(float(np.nanstd(record.channels["position"])))
    gain = known["piezo_gain"].value if "piezo_gain" in known else max(travel) / max(lever * max(across), 1e-300)
    return gain, gain * max(common) if max(common) > GOES_UP * max(across) else None
