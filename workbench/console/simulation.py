"""Features of simulations in the terminal: of experiments, of the stage's studies, and of a Monte Carlo study."""

from __future__ import annotations

from typing import Any

import numpy as np

from workbench.cli.options import Run
from workbench.console.tables import feature_text, plain_table, rich_table
from workbench.identification.tables import CODE, STRONG, TEXT, make_table, quantity_text
from workbench.simulation.monte_carlo import Study

MOST_LISTED = 8
"""Sampled parameters that are listed."""


def print_features(run: Run, experiment: str, found: dict[str, Any]) -> None:
    """A row for each model (and case) of an experiment, a column for each feature."""
    if not found:
        return
    if experiment == "stage":
        for study, features in found.items():
            table = plain_table(f"stage: {study.replace('_', ' ')}", "", "value")
            for name, feature in features.items():
                table.add_row(name.replace("_", " "), feature_text(feature))
            run.console.print(table)
        return
    rows: list[tuple[str, dict[str, Any]]] = []
    for model, features in found.items():
        if all(feature is None or "unit" in feature for feature in features.values()):
            rows.append((model, features))
        else:
            rows += [(f"{model}  {case}", inner) for case, inner in features.items()]
    names = list(rows[0][1])
    table = plain_table(experiment, "", *(name.replace("_", " ") for name in names))
    for label, features in rows:
        table.add_row(label, *[feature_text(features[name]) for name in names])
    run.console.print(table)


def print_simulated_records(run: Run, document: dict[str, Any]) -> None:
    """Values and noise with which the records of an experiment were simulated, and the files."""
    run.echo(f"model: {', '.join(document['effects']) or 'no effects'}")
    shown = {key: q for key, q in document["parameters"].items() if q["from"] != "default"}
    rows = [(key, quantity_text(q["value"], q["unit"]), q["from"]) for key, q in shown.items()]
    run.console.print(rich_table(make_table("Values", [("parameter", CODE), ("value", STRONG), ("from", TEXT)], rows)))
    for channel, noise in document["noise"].items():
        correlation = f", autocorrelation {noise['autocorrelation']:.2f}" if "autocorrelation" in noise else ""
        run.echo(f"noise of {channel}: {quantity_text(noise['value'], noise['unit'])} ({noise['from']}{correlation})")
    for record in document["records"]:
        run.echo(f"{record['name']} ({record['role']}): {record['rows']} rows")
    run.echo(f"wrote {', '.join(document['files'])}")


def print_monte_carlo(run: Run, study: Study) -> None:
    """The sampled parameters, and each feature's value at the design, its deviation and 95 % band."""
    listed = "; ".join(one.text for one in study.parameters[:MOST_LISTED])
    more = len(study.parameters) - MOST_LISTED
    run.echo(f"sampled: {listed}" + (f"; and {more} more" if more > 0 else ""))
    for experiment in dict.fromkeys(path[0] for path in study.distributions):
        distributions = {
            path[1:]: distribution for path, distribution in study.distributions.items() if path[0] == experiment
        }
        changing = {path: distribution for path, distribution in distributions.items() if distribution.varies}
        titles = ("", "design", "deviation", "2.5 %", "97.5 %", "depends most on")
        table = plain_table(experiment, *titles, left=("", "depends most on"))
        for path, distribution in changing.items():
            found = distribution.finite
            cells = [distribution.nominal, found.std(ddof=1), *np.quantile(found, [0.025, 0.975])]
            table.add_row(
                "  ".join(name.replace("_", " ") for name in path),
                *[feature_text(None if x is None else {"value": float(x), "unit": distribution.unit}) for x in cells],
                distribution.strongest_text or "-",
            )
        if table.row_count:
            run.console.print(table)
        if len(changing) < len(distributions):
            run.echo(f"{experiment}: {len(distributions) - len(changing)} features do not change")
    if study.refused:
        run.note(
            f"{len(study.refused)} of {len(study.samples)} samples are invalid designs, first: {study.refused[0][1]}"
        )
