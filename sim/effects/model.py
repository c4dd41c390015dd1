"""A model: effects with values for their parameters, ready to be integrated or evaluated along a measured motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from sim.effects.catalogue import find
from sim.effects.effect import Axis, Effect
from stagecad.parameters.errors import InputError, nearest


@dataclass(frozen=True)
class Model:
    """Effects and their parameter values; built by `compose`.

    Args:
        effects: at most one of them with a friction state model.
        values: parameter values of each effect, in the same order.
    """

    effects: tuple[Effect, ...]
    values: tuple[Any, ...]

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
        if any(effect.name == other.name for other in kept):
            raise InputError(f"effect '{effect.name}' is given twice")
        if effect.friction_state is not None:
            kept = [other for other in kept if other.friction_state is None]
        kept.append(effect)
    given: dict[str, dict[str, float]] = {effect.name: {} for effect in kept}
    for key, value in (parameters or {}).items():
        # The name of a contact effect contains a dot: the last dot separates effect and parameter.
        name, _, parameter = key.rpartition(".")
        if name not in given:
            raise InputError(f"parameter '{key}': the model has no effect '{name}'{nearest(name, given)}")
        given[name][parameter] = value
    return Model(tuple(kept), tuple(effect.values(**given[effect.name]) for effect in kept))
