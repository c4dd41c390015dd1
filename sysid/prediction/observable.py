"""Effects that are observable on a rig, and those to try on top of a model."""

from collections.abc import Sequence

import numpy as np

from sim.effects.catalogue import PUBLIC, find, library
from sim.effects.effect import Effect
from sysid.prediction.force_balance.record import ForceBalanceRecord
from sysid.prediction.model import in_contact, public_name
from sysid.prediction.problem import Problem


def candidate_effects(problem: Problem, present: Sequence[str], all_effects: bool = False) -> list[Effect]:
    """Effects to try on top of a model whose effects are named `present`, in the order of the interface.

    Effects of the model and other laws of their families are excluded; of one that is periodic in the position there
    may be a further copy, with another pitch. A friction effect that multiplies the level needs a level to multiply.
    """
    taken = {public_name(name) for name in present}
    effects = [find(name, problem.custom) for name in taken]
    cores = [e for e in effects if e.friction_state is not None and not in_contact(e)]
    # Quantisation is read off the values themselves.
    names = [name for name in (library() if all_effects else PUBLIC) if not find(name).rounds]
    names += [e.name for e in problem.custom]
    found: list[Effect] = []
    for name in names:
        if name in taken and find(name, problem.custom).is_periodic:
            found.append(find(next_copy(name, present), problem.custom))
            continue
        if name in taken and (name in present or not any(key.startswith(f"{name}@") for key in present)):
            continue
        effect = find(name, problem.custom)
        if not is_observable(problem, effect):
            continue
        # Bristles may take the place of plain friction; nothing else takes the place of a friction state model.
        core = effect.friction_state
        if core is not None and cores and not all_effects and (core.rigid or any(e.has_presliding for e in cores)):
            continue
        if core is None and not cores and (effect.factor is not None or effect.level is not None):
            continue
        found.extend(on_channels(problem, effect, present))
        for variant in effect.variants:
            if variant.refinement or not is_observable(problem, variant):
                continue
            found.extend(on_channels(problem, find(variant.name, problem.custom), present))
    return [*found, *problem.rig.further_candidates(problem.fit_records, present)]


def next_copy(name: str, present: Sequence[str]) -> str:
    """Name of the next copy of a periodic effect on top of a model whose effects are named `present`."""
    return f"{name}#{1 + sum(public_name(other) == name for other in present)}"


LEAST_OF_A_DIRECTION = 0.02
"""Least part of the rows in either direction of motion where an effect depends on the direction."""


def is_observable(problem: Problem, effect: Effect) -> bool:
    """Whether the effect is observable on this rig."""
    records, needs = problem.fit_records, effect.needs
    if any(name in needs and not _varies(records, name) for name in ("load", "temperature")):
        return False
    if "rotary" in needs and not problem.experiment.rig.rotary:
        return False
    balances = [record for record in records if isinstance(record, ForceBalanceRecord)]
    if effect.signal is not None and balances and all(record.is_free for record in balances):
        # With a constant drive, a delay of a channel can make the whole compared force vanish.
        return False
    if effect.coordinates[:1] == ("direction",) and effect.friction_state is None and balances:
        forward = np.mean(np.concatenate([record.axis.direction > 0.0 for record in balances]))
        if not LEAST_OF_A_DIRECTION <= forward <= 1.0 - LEAST_OF_A_DIRECTION:
            return False
    return problem.rig.shows(effect, records, set().union(*(r.channels for r in problem.records)))


def _varies(records: Sequence[object], name: str) -> bool:
    """Whether a recorded load or temperature varies, within a record or from one to the next."""
    values = [getattr(record.axis, name) for record in records if isinstance(record, ForceBalanceRecord)]
    if not values:
        return False
    low, high = min(float(np.min(v)) for v in values), max(float(np.max(v)) for v in values)
    return high - low > 1e-9 * max(1.0, high)


def on_channels(problem: Problem, effect: Effect, present: Sequence[str]) -> list[Effect]:
    """A sensor effect on each of the channels on which the rig shows it, or on all alike; other effects unchanged."""
    channels = list(problem.fit_records[0].measured)
    if effect.acts_on != "sensor" or len(channels) == 1 or effect.between_rows:
        return [effect]
    places = problem.rig.sensor_places(channels)
    each = [effect if place is None else find(f"{effect.name}@{place}", problem.custom) for place in places]
    return [e for e in each if e is effect or e.name not in present]
