"""A metal bellows between slide and frame: a spring that stiffens with the cube of its stretch."""

from sim import Effect, Parameter


def force(axis, p):
    """Force against the motion, N; `axis` holds floats or arrays, so use numpy functions and no `if`."""
    return p.strength * axis.position**3


effect = Effect(
    "bellows",
    "restoring force of a bellows, cubic in its extension",
    equation="force = strength * x^3",
    shows="Residual bends away from zero at both ends of the travel, alike in both directions of motion.",
    force=force,
    parameters=[Parameter("strength", "N/m^3", 1e4, 0.0, 1e9, "force per cube of stretch", "assumed: 1 N at 46 mm")],
)
