"""Parts of a section of the report that comparison and diagnosis have in common: the experiment, figures, parameters.

A section is plain data (it is kept as JSON), so a report can be composed again from sections made at other times.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from stagecad.parameters.errors import InputError
from sysid.diagnosis.residual_maps import ResidualMap
from sysid.prediction.model import Model
from sysid.prediction.problem import Problem
from sysid.report import worst_channel
from workbench.figures.curves import curve_of, worst_record
from workbench.operations.statements import noise_text
from workbench.operations.tables import (
    correlation_table,
    dependence_table,
    error_table,
    parameter_table,
    quantity_text,
    simulation_table,
)
from workbench.report.identification import WIDTH, Section

MOST_CORRELATED = 14
"""Parameters up to which the matrix of correlations is shown."""
MOST_OVERLAYS = 3
"""Channels of which an overlay is drawn."""


def fitted_section(
    problem: Problem, model: Model, document: Mapping[str, Any], title: str, after: Any = None
) -> Section:
    """Experiment, errors and parameters of a document of `compare` or `diagnose`; `title` is that of the parameters."""
    names, matrix = document["correlation"]["keys"], document["correlation"]["matrix"]
    shown = 1 < len(names) <= MOST_CORRELATED
    tables = {"whiteness": correlation_table(document).as_json()} if "correlation_of_residual" in document else {}
    return {
        "effects": [e.name for e in model.effects],
        "records": {record.name: record.sha256 for record in problem.records},
        "rig": _rig_text(problem),
        "record_list": [
            f"{r.name} ({'fit' if r.role == 'fit' else 'held out'}): {r.size} rows in {r.time[-1] - r.time[0]:.4g} s"
            for r in problem.records
        ],
        "noise": noise_text(problem),
        "notes": list(problem.notes),
        "warnings": list(document["warnings"]),
        "errors": error_table("", document["before"], after).as_json(),
        "simulation": simulation_table(document).as_json(),
        **tables,
        "where": dependence_table(document["where"]).as_json(),
        "parameters": parameter_table(document["parameters"], title).as_json(),
        "not_identifiable": document["not_identifiable"],
        "correlation": {"names": names, "cells": matrix} if shown else None,
        "seconds": document["seconds"],
    }


def _rig_text(problem: Problem) -> str:
    rig = problem.experiment.rig
    known = []
    for name, quantity in rig.known.items():
        declared = rig.declaration.known[name]
        unit = declared.rotary_unit if rig.rotary else declared.unit
        known.append(f"{name.replace('_', ' ')} {quantity_text(quantity.value, unit)}")
    return f"{rig.kind}" + (", rotary" if rig.rotary else "") + (f": {', '.join(known)}" if known else "")


def figures_section(
    problem: Problem, models: Mapping[str, Model], by_channel: Mapping[str, Any], maps: Sequence[ResidualMap]
) -> Section:
    """Overlays of the worst channel on the worst held-out record and of other channels there, and residual maps."""
    from workbench.figures.identification import loops_figure, maps_figure, overlay_figure

    records = problem.validate_records or problem.fit_records
    worst, first = worst_channel(problem, by_channel), next(iter(models.values()))
    overlays = []
    for channel in [worst, *(c for c in records[0].measured if c != worst)][:MOST_OVERLAYS]:
        curve = curve_of(problem, worst_record(records, channel, first), channel, models)
        of = f"{curve.record} {curve.channel}"
        overlays.append(
            {
                "channel": curve.words,
                "figure": overlay_figure(curve, WIDTH).svg(f"overlay {of}"),
                "loops": loops_figure(curve, WIDTH).svg(f"loops {of}") if curve.motion else "",
            }
        )
    try:
        drawn = maps_figure(maps, problem, WIDTH).svg("maps " + " ".join(m.coordinate for m in maps))
    except InputError:
        drawn = ""
    return {"overlays": overlays, "maps": drawn}
