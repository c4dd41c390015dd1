"""`effects`: the library of physical effects, from its declarations."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from sim.effects.catalogue import find, library
from sim.effects.custom import load_all_custom
from sim.effects.effect import Effect
from stagecad.parameters.units import attributes
from workbench.operations.result import Line, Table, plain_table


def effects(custom: Sequence[Path] = ()) -> list[Effect]:
    """The effects of the library, and those of files of the user's own."""
    return [*library().values(), *load_all_custom(custom)]


def effect(name: str, custom: Sequence[Path] = ()) -> Effect:
    """An effect by its name, or NAME:VARIANT."""
    return find(name, load_all_custom(custom))


def effect_json(effect: Any) -> dict[str, Any]:
    """An effect as a JSON document."""
    return {
        **attributes(effect, "name", "meaning", "equation", "acts_on"),
        "core": effect.friction_state is not None,
        "shows": effect.shows,
        "dissipation": effect.energy,
        "coordinates": list(effect.coordinates),
        "needs": list(effect.needs),
        "source": effect.source,
        "parameters": [
            {
                "name": f"{effect.name}.{parameter.name}",
                "unit": parameter.unit,
                **{k: {"value": getattr(parameter, k), "unit": parameter.unit} for k in ("default", "low", "high")},
                **attributes(parameter, "meaning", "source", "role", "fixed"),
            }
            for parameter in effect.parameters
        ],
        "variants": [variant.name for variant in effect.variants],
    }


def library_table(effects: Sequence[Any]) -> Table:
    """A row for each effect: name, what it acts on, meaning, parameters."""
    rows = []
    for effect in effects:
        kind = f"{effect.acts_on} (state model)" if effect.friction_state is not None else effect.acts_on
        names = ", ".join(p.name if p.unit == "1" else f"{p.name} [{p.unit}]" for p in effect.parameters)
        rows.append((effect.name, kind, effect.meaning, names))
    return plain_table("", "effect|acts on|meaning|parameters", rows, "*", "meaning|parameters")


def effect_lines(effect: Any) -> list[Line]:
    """Everything that an effect declares, and its parameters."""
    state = effect.friction_state
    facts = {
        "law": effect.equation,
        "shows": effect.shows,
        "acts on": effect.acts_on,
        "state model": state and f"turns the friction level into a force; state: {state.state}",
        "depends on": ", ".join(effect.coordinates),
        "needs": ", ".join(effect.needs),
        "dissipation": effect.energy,
        "source": effect.source,
        "variants": ", ".join(variant.name for variant in effect.variants),
    }
    rows = [(effect.name, effect.meaning), *((name, text) for name, text in facts.items() if text)]
    lines: list[Line] = [plain_table("", "|", rows, "*")]
    parameters = [
        (
            parameter.name,
            f"{parameter.default:g} {parameter.unit}" if parameter.unit != "1" else f"{parameter.default:g}",
            f"{parameter.low:g} .. {parameter.high:g}",
            f"{parameter.role}, fixed" if parameter.fixed else parameter.role,
            parameter.meaning,
            parameter.source,
        )
        for parameter in effect.parameters
    ]
    columns = "parameter|default|bounds|role|meaning|source of default and bounds"
    return [*lines, "", plain_table("", columns, parameters, "*")] if parameters else lines
