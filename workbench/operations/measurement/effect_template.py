"""Template of a user's own effect: it loads, fits and is diagnosed without changes."""

from __future__ import annotations

from pathlib import Path

from sim.effects.catalogue import library, valid_name
from stagecad.parameters.atomic import atomic_write_text
from stagecad.parameters.errors import InputError

TEXT = '''\
"""A user's effect, tried together with the library's: custom = ["{name}.py"] under [model] in experiment.toml."""

from sim import Effect, Parameter


def force(axis, p):
    """Force against positive motion, SI. `axis` has position, velocity, load, temperature, contact_age,
    reversal_distance, travelled, time, each a float or an array: use numpy functions, and no `if`."""
    return p.strength * axis.position**3


effect = Effect(
    "{name}",
    "a spring that stiffens as it is stretched",
    equation="force = strength * x^3",
    force=force,  # or factor=..., which multiplies the friction level, or level=..., which adds to it
    parameters=[Parameter("strength", "N/m^3", 1e4, 0.0, 1e9, "force per cube of stretch", "assumed")],
)
'''
"""Start, low and high bound follow a parameter's unit; then its meaning, and where the numbers come from."""


def write_effect_template(path: Path) -> str:
    """Write the file and return the name of its effect, which is the file's.

    Raises:
        InputError: the file is there already, is no Python file, or its name cannot be an effect's.
    """
    name = path.stem
    if path.suffix != ".py":
        raise InputError(f"{path}: must end in .py")
    if not valid_name(name):
        raise InputError(f"{path}: the effect is named after its file: lower-case words joined by underscores")
    if name in library():
        raise InputError(f"{path}: a built-in effect is named '{name}'; choose another")
    if path.exists():
        raise InputError(f"{path}: is there already; name a new file")
    atomic_write_text(path, TEXT.format(name=name))
    return name
