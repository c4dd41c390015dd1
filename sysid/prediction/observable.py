"""Effects that are observable on a rig, and those to try on top of a model."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from sim.effects.catalogue import ORDER, find, library
from sim.library.effect import Effect
from sysid.prediction.force_balance.record import ForceBalanceRecord
from sysid.prediction.friction_drive.observable import can_show, contact_candidates
from sysid.prediction.friction_drive.record import FrictionDriveRecord
from sysid.prediction.model import in_contact, public_name
from sysid.prediction.problem import Problem

PUBLIC_EFFECTS = ORDER[: ORDER.index("sensor_quantisation")]
"""Names of the interface that are tried by refitting; `sensor_quantisation` is read off the values themselves."""


def candidate_effects(problem: Problem, present: Sequence[str], all_effects: bool = False) -> list[Effect]:
    """Effects to try on top of a model whose effects are named `present`, in the order of the interface.

    Effects of the model and other laws of their families are excluded. A friction effect that multiplies the
    level needs a level to multiply.
    """
    taken = {public_name(name) for name in present}
    effects = [find(name, problem.custom) for name in taken]
    cores = {e.friction_state.name for e in effects if e.friction_state is not None and not in_contact(e)}
    names = list(PUBLIC_EFFECTS)
    if all_effects:
        names += [n for n in library() if n not in names and n != "sensor_quantisation"]
    names += [e.name for e in problem.custom]
    found: list[Effect] = []
    for name in names:
        if name in taken and not _another_channel(problem, name, present):
            continue
        effect = find(name, problem.custom)
        if not is_observable(problem, effect):
            continue
        # Bristles may take the place of plain friction; nothing else takes the place of a friction state model.
        core = effect.friction_state
        if core is not None and cores and not all_effects and (core.name in cores or cores != {"coulomb"}):
            continue
        if core is None and not cores and (effect.factor is not None or effect.level is not None):
            continue
        found.extend(on_channels(problem, effect, present))
        for variant in effect.variants:
            if variant.refinement or not is_observable(problem, variant):
                continue
            found.extend(on_channels(problem, find(variant.name, problem.custom), present))
    driven = [r for r in problem.fit_records if isinstance(r, FrictionDriveRecord)]
    return [*found, *contact_candidates(driven, present)] if driven else found


def _another_channel(problem: Problem, name: str, present: Sequence[str]) -> bool:
    return name.startswith("sensor_") and any(p.startswith(f"{name}@") for p in present) and name not in present


def is_observable(problem: Problem, effect: Effect) -> bool:
    """Whether the effect is observable on this rig."""
    kind, records = problem.kind, problem.fit_records
    channels = set().union(*(r.channels for r in problem.records))
    acts = effect.acts_on
    if "load" in effect.needs and not _varies(records, "load"):
        return False
    if "temperature" in effect.needs and not _varies(records, "temperature"):
        return False
    if "rotary" in effect.needs and not problem.experiment.rig.rotary:
        return False
    if kind == "actuator-tip":
        return acts in ("drive", "piezo", "sensor") or (acts == "structure" and effect.signal is not None)
    if isinstance(records[0], FrictionDriveRecord):
        return can_show(records[0], effect)
    if acts == "piezo" or effect.between_rows:
        # Other measured channels are too smooth for the course of a signal between the rows to matter.
        return False
    if "imposed_motion" in effect.needs and kind != "velocity-drive":
        return False
    if acts == "drive":
        return kind == "force-drive" and effect.inverse is not None
    if acts == "structure" and effect.memory is not None:
        # In a spring-pull rig with one channel a gap is not distinguishable from a longer pull.
        return kind == "velocity-drive" or (kind == "spring-pull" and {"position", "spring_force"} <= channels)
    if acts == "structure":
        return kind != "velocity-drive"
    return not (acts == "sensor" and kind == "force-drive") or effect.inverse is not None


def _varies(records: Sequence[object], name: str) -> bool:
    for record in records:
        if isinstance(record, ForceBalanceRecord):
            values = getattr(record.axis, name)
            if np.ptp(values) > 1e-9 * max(1.0, float(np.max(np.abs(values)))):
                return True
    return False


def on_channels(problem: Problem, effect: Effect, present: Sequence[str]) -> list[Effect]:
    """A sensor effect on each measured channel and, for an actuator tip, on all together; other effects unchanged."""
    if effect.acts_on != "sensor":
        return [effect]
    channels = list(problem.fit_records[0].measured)
    # How a command runs from row to row is the same for the whole log.
    if problem.kind == "force-drive" or len(channels) == 1 or effect.between_rows:
        return [effect]
    each = [find(f"{effect.name}@{channel}", problem.custom) for channel in channels]
    each = [e for e in each if e.name not in present]
    return [effect, *each] if problem.kind == "actuator-tip" else each
