"""The rig kind `friction-drive`: a stage that the tip of an actuator drives by friction."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from sim.effects.catalogue import find
from sim.effects.effect import Effect
from sysid.experiment.experiment import Rig
from sysid.experiment.record import Record
from sysid.prediction.actuator_tip import LENGTHS
from sysid.prediction.effect_terms import Values
from sysid.prediction.friction_drive.friction import CONTACT
from sysid.prediction.friction_drive.parameters import friction_drive_parameters
from sysid.prediction.friction_drive.record import (
    TRANSVERSE,
    FrictionDriveRecord,
    friction_drive_record,
    predict_friction_drive,
)
from sysid.prediction.rig_model import Channels, Effects, Noises, RigModel, RigParameters, Start

CONTACT_EFFECTS = ("coulomb", "presliding", "stribeck", "viscous", "direction_asymmetry", "load_dependent_friction")


ROUNDS = 12
"""Most iterations of the motion of a simulated stage."""

SETTLED = 1e-4
"""Change from one iteration to the next, over the range of the motion, at which the motion is taken as found."""


class FrictionDrive(RigModel):
    """Voltages in, position of the stage out."""

    name = "friction-drive"
    predict = staticmethod(predict_friction_drive)
    required = LENGTHS
    restarts = True

    def parameters(self, rig: Rig, records: Sequence[Record], noise: Noises) -> RigParameters:
        return friction_drive_parameters(rig.known, [r for r in records if r.role == "fit"])

    def prepare(self, rig: Rig, records: Sequence[Record], noise: Noises, values: Values) -> list[FrictionDriveRecord]:
        return [friction_drive_record(self, record, rig.known, noise) for record in records]

    def shows(self, effect: Effect, records: Sequence[FrictionDriveRecord], channels: set[str]) -> bool:
        # Voltages are taken to go straight from row to row.
        if effect.acts_on in ("drive", "piezo", "sensor"):
            return effect.signal is not None and not effect.name.endswith(":of_curves")
        if effect.acts_on == "structure":
            return effect.is_mode and ":" not in effect.name
        if effect.friction_state is not None:
            elements = effect.friction_state.springs is not None
            return effect.friction_state.rigid or (elements and all(TRANSVERSE not in r.measured for r in records))
        has_law = effect.level is not None or effect.factor is not None or effect.force is not None
        return (effect.acts_on in ("friction", "axis") and has_law) or effect.acts_on == "memory"

    def further_candidates(self, records: Sequence[FrictionDriveRecord], present: Sequence[str]) -> list[Effect]:
        """Effects between tip and stage to try on top of a model: first that it slips, then how."""
        effects = [find(CONTACT + name) for name in CONTACT_EFFECTS]
        state = next((e for e in effects if e.friction_state is not None and e.name in present), None)

        def is_tried(effect: Effect) -> bool:
            if effect.name in present or ("load" in effect.needs and not any(_goes_up(r) for r in records)):
                return False
            if effect.friction_state is None:
                return state is not None
            # Presliding may take the place of plain slip; nothing else takes the place of presliding.
            return state is None or (effect.has_presliding and not state.has_presliding)

        return [e for e in effects if is_tried(e) and self.shows(e, records, set())]

    def simulate(self, rig: Rig, record: Record, effects: Effects, values: Values, start: Start | None) -> Channels:
        """The predicted motion; laws that depend on the motion are evaluated along the predicted one, by iteration."""
        names = ["position", *([TRANSVERSE] if "rig.turn" in values else [])]
        found = {name: np.full(record.size, start.position if start is not None else 0.0) for name in names}
        for _ in range(ROUNDS):
            before, found = found, self.predict_along(rig, record, found, effects, values)
            change = max(float(np.max(np.abs(found[name] - before[name]))) for name in names)
            if change <= SETTLED * float(np.ptp(found["position"])):
                break
        return found


def _goes_up(record: FrictionDriveRecord) -> bool:
    common = np.mean(record.drives, axis=0)
    return float(np.ptp(common)) > 0.02 * float(np.ptp(record.drives[1] - record.drives[0]))
