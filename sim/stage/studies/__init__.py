"""Studies of the driven stage; their names are here so that listing them loads no compiled kernel."""

STUDY_NAMES = ("steps", "speed", "travel_map", "ellipse", "coupling", "planar", "positioning", "hunting")
"""Names of the studies in the order of a run; `sim.friction_stage.studies.STUDIES` has the functions."""
