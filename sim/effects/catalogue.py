"""The library: every built-in effect by name, variants, and a user's own effects from a file.

A built-in is declared in a module in a folder of `sim.effects`, as `EFFECT` or in the tuple `EFFECTS`.
"""

import copyreg
import functools
import importlib
import pkgutil
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import sim.effects
from sim.effects.effect import Axis, Effect
from stagecad.parameters.errors import InputError, nearest, require, require_known

PUBLIC = (
    *("coulomb", "viscous", "stribeck", "presliding", "bristle_damping", "frictional_lag", "dwell_strengthening"),
    *("direction_asymmetry", "position_dependent_friction", "load_dependent_friction"),
    *("temperature_dependent_friction", "run_in", "quadratic_drag", "constant_bias", "cable_spring"),
    *("magnetic_cogging", "gravity_torque", "backlash", "flexible_mode", "drive_lag", "drive_delay"),
    *("piezo_hysteresis", "piezo_creep", "gain_mismatch", "sensor_lag", "sensor_delay", "sensor_nonlinearity"),
    *("sensor_drift", "sensor_quantisation"),
)
"""Names of the effects that a diagnosis tries."""

ORDER = (
    *PUBLIC,
    *("dahl", "lugre", "lugre_undamped", "lugre_causal", "lugre_causal_as_run", "maxwell_slip", "elasto_plastic"),
    *("rate_and_state", "second_order_dahl"),
)
"""Effect names in the order in which they are listed."""

CHANNELS = (
    *("friction_force", "position", "position_y", "velocity", "spring_force", "drive_force"),
    *("tip_x", "tip_y", "tip_z"),
)
"""Measured channels that a sensor effect can act on: `sensor_lag@position`."""


@functools.cache
def _built_in() -> dict[str, Effect]:
    found: dict[str, Effect] = {}
    for info in pkgutil.walk_packages(sim.effects.__path__, "sim.effects."):
        module = importlib.import_module(info.name)
        effects = getattr(module, "EFFECTS", None) or (getattr(module, "EFFECT", None),)
        found |= {effect.name: effect for effect in effects if isinstance(effect, Effect)}
    rank = {name: place for place, name in enumerate(ORDER)}
    return dict(sorted(found.items(), key=lambda item: (rank.get(item[0], len(rank)), item[0])))


def library() -> dict[str, Effect]:
    """Every built-in effect by name, in the order of `ORDER`."""
    return dict(_built_in())


def find(name: str, custom: Sequence[Effect] = ()) -> Effect:
    """The effect called `name`, among the built-ins and the user's own.

    Args:
        name: an effect; `effect:variant` picks a variant, `effect#2` is a second copy of an effect that is periodic in
            the position, `sensor_effect@channel` the channel a sensor effect acts on, `contact.effect` puts a friction
            effect between tip and stage. The effect returned carries the requested name.
        custom: the user's own effects (`load_custom`).

    Raises:
        InputError: naming the nearest name.
    """
    effects = _built_in() | {effect.name: effect for effect in custom}
    plain, at, channel = name.partition("@")
    contact = plain.startswith("contact.")
    plain = plain.removeprefix("contact.")
    plain, copied, copy = plain.partition("#")
    base, colon, variant = plain.partition(":")
    require_known(base, effects, f"no effect '{name}'")
    effect = effects[base]
    if copied and not (effect.is_periodic and copy.isdecimal() and int(copy) > 1):
        raise InputError(f"effect '{name}': only a periodic effect has copies, '#2' and so on")
    if colon:
        variants = {other.name.partition(":")[2]: other for other in effect.variants}
        if variant not in variants:
            known = nearest(variant, variants) if variants else "; it has none"
            raise InputError(f"effect '{base}' has no variant '{variant}'{known}")
        effect = variants[variant]
    if at:
        if effect.acts_on != "sensor":
            what = f"'{base}' acts on {effect.acts_on}"
            raise InputError(f"effect '{name}': {what}; only a sensor effect takes '@channel'")
        require_known(channel, CHANNELS, f"effect '{name}': no channel '{channel}'")
    if contact and effect.acts_on in ("drive", "piezo", "sensor"):
        raise InputError(f"effect '{name}': '{base}' acts on {effect.acts_on}, not in the contact of tip and stage")
    # Under the requested name, so that its parameters are found by that name too.
    return effect if effect.name == name else replace(effect, name=name)


def is_built_in(effect: Effect) -> bool:
    """Whether an effect is what `find` returns for its name without effects of the user's own."""
    try:
        return find(effect.name) == effect
    except InputError:
        return False


def _pickled(effect: Effect) -> tuple[Any, ...]:
    """A built-in effect by its name, since laws may be closures, one of the user's own by its origin; the type of the
    values of another is made again."""
    own = tuple(getattr(effect, item.name) for item in fields(effect))
    origin = find if is_built_in(effect) else effect.origin
    return (Effect, own) if origin is None else (origin, (effect.name,))


copyreg.pickle(Effect, _pickled)


def find_where(holds: Callable[[Effect], bool]) -> Effect:
    """The first built-in effect for which a condition holds, such as the one that rounds a channel."""
    return next(effect for effect in _built_in().values() if holds(effect))


def rigid_friction() -> Effect:
    """The built-in effect of dry friction without presliding that a record resolves."""
    return find_where(lambda effect: effect.friction_state is not None and effect.friction_state.rigid)


def rounding_effects(names: Sequence[str], custom: Sequence[Effect] = ()) -> list[str]:
    """Those among the `names` of effects that round a channel."""
    return [name for name in names if find(name, custom).rounds]


def laws_of(name: str, custom: Sequence[Effect] = ()) -> tuple[Effect, ...]:
    """The other laws of the effect called `name` (without a variant: `stribeck`, `contact.stribeck`,
    `sensor_drift@position`), in the same contact and on the same channel."""
    plain, at, channel = name.partition("@")
    _, copied, copy = plain.partition("#")
    where = "contact." if plain.startswith("contact.") else ""
    variants = [variant.name.removeprefix(where) for variant in find(name, custom).variants]
    return tuple(find(f"{where}{variant}{copied}{copy}{at}{channel}", custom) for variant in variants)


def valid_name(name: str) -> bool:
    """Whether `name` can be an effect's or a parameter's: lower-case words joined by underscores."""
    return re.fullmatch(r"[a-z][a-z0-9_]*", name) is not None


@dataclass(frozen=True)
class Model:
    """Effects and their parameter values; built by `compose`."""

    effects: tuple[Effect, ...]  # at most one of them with a friction state model
    values: tuple[Any, ...]  # parameter values of each effect, in the same order

    @property
    def state_effect(self) -> Effect | None:
        """The effect with the friction state model, or None where there is no dry friction."""
        return next((effect for effect in self.effects if effect.friction_state is not None), None)

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(effect.name for effect in self.effects)

    def parameters(self) -> dict[str, float]:
        """Every parameter's value by `effect.parameter`, SI."""
        return {
            f"{effect.name}.{name}": value
            for effect, values in zip(self.effects, self.values)
            for name, value in values._asdict().items()
        }

    def factor(self, axis: Axis) -> Any:
        """Product of the effects' factors of the friction level; shape of the axis."""
        factor = 1.0 + 0.0 * axis.velocity
        for effect, p in zip(self.effects, self.values):
            if effect.factor is not None:
                factor = factor * effect.factor(axis, p)
        return factor

    def level(self, axis: Axis) -> Any:
        """Friction level, N: the sum of the effects' levels times the product of their factors; shape of the axis."""
        level = 0.0 * axis.velocity
        for effect, p in zip(self.effects, self.values):
            if effect.level is not None:
                level = level + effect.level(axis, p)
        return level * self.factor(axis)

    def other_force(self, axis: Axis) -> Any:
        """Sum of the forces other than those of the friction state model, N, positive against positive motion."""
        total = 0.0 * axis.velocity
        for effect, p in zip(self.effects, self.values):
            if effect.force is not None:
                total = total + effect.force(axis, p)
        return total


def compose(
    effects: Sequence[str | Effect], parameters: Mapping[str, float] | None = None, custom: Sequence[Effect] = ()
) -> Model:
    """Compose a model; a friction state model replaces the one before it, with that effect's level.

    Args:
        effects: names (as `find` takes them) or effects, in order.
        parameters: values by `effect.parameter`, SI; the rest take their defaults.
        custom: the user's own effects.

    Raises:
        InputError: an unknown effect or parameter, or one given twice.
    """
    found = [find(effect, custom) if isinstance(effect, str) else effect for effect in effects]
    kept: list[Effect] = []
    for effect in found:
        require(not any(effect.name == other.name for other in kept), f"effect '{effect.name}' is given twice")
        if effect.friction_state is not None:
            kept = [other for other in kept if other.friction_state is None]
        kept.append(effect)
    given: dict[str, dict[str, float]] = {effect.name: {} for effect in kept}
    for key, value in (parameters or {}).items():
        # The name of a contact effect contains a dot: the last dot separates effect and parameter.
        name, _, parameter = key.rpartition(".")
        require_known(name, given, f"parameter '{key}': the model has no effect '{name}'")
        given[name][parameter] = value
    return Model(tuple(kept), tuple(effect.values(**given[effect.name]) for effect in kept))
