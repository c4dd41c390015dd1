"""Solids of the stage, one file per part; with `drawings` the only place that imports cadquery."""
