"""Studies of the driven stage; their names are here so that listing them loads no compiled kernel."""

from collections.abc import Callable, Sequence
from typing import Any

STUDY_NAMES = ("steps", "speed", "travel_map", "ellipse", "coupling", "planar", "positioning", "hunting")
"""Names of the studies that run by default, in their order; `sim.friction_stage.studies.STUDIES` has the functions."""
ON_REQUEST = ("tip_motion",)
"""Studies that run only when named."""

RunAll = Callable[[Callable[[Any], Any], Sequence[Any]], list[Any]]
"""Runs a function on each of several cases: one after another, on all cores, or on a cluster."""
