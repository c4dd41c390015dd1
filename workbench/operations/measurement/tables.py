"""Tables of an identification: errors, parameters, dependence of the residual, ranking, detectable sizes, revisions.

They are built from the JSON documents of the commands.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from stagecad.parameters.units import format_quantity
from workbench.figures.curves import LEAST_SHARE
from workbench.operations.result import REMARK, Table

PARTS = {"fit": "fit", "validate": "held out"}
"""Names of the sets of records."""
MOST_COORDINATES = 6
"""Coordinates of the residual's dependence that are printed."""

Row = Mapping[str, Any]


def make_table(title: str, columns: str, rows: Iterable[Sequence[str]], note: str = "") -> Table:
    """A table of columns `TITLE:KIND|...`, without those of kind REMARK that are empty in every row."""
    kinds = [(name, kind) for name, _, kind in (column.partition(":") for column in columns.split("|"))]
    rows = tuple(tuple(row) for row in rows)
    kept = [k for k, (_, kind) in enumerate(kinds) if kind != REMARK or any(row[k] for row in rows)]
    return Table(title, tuple(kinds[k] for k in kept), tuple(tuple(row[k] for k in kept) for row in rows), note)


def quantity_text(value: float, unit: str) -> str:
    """A quantity with a prefix that suits its size; a plain number without a unit."""
    return f"{value:.4g}" if unit in ("", "1") else format_quantity(value, unit)


def over_noise_text(ratio: float | None) -> str:
    """An error in multiples of the noise."""
    if ratio is None:
        return ""
    return f"{ratio:.2f} ×" if ratio < 9.995 else f"{ratio:.0f} ×"


def p_value_text(p: float | Mapping[str, float]) -> str:
    """A p value of a JSON document; `{"below": 0.001}` is the least that the permutations can show."""
    return f"< {p['below']}" if isinstance(p, Mapping) else f"{p:.3f}"


def parameter_name(key: str) -> str:
    """`stribeck.break_away` -> `break away`."""
    return key.rpartition(".")[2].replace("_", " ")


def interval_text(quantity: Row) -> str:
    """A 95 % interval; empty where an end is unknown."""
    low, high = quantity.get("low"), quantity.get("high")
    if low is None or high is None:
        return ""
    return f"{quantity_text(low, quantity['unit'])} .. {quantity_text(high, quantity['unit'])}"


def identifiability_text(quantity: Row) -> str:
    """Reason why a fitted value is uncertain; empty where the records determine it."""
    if quantity.get("at_bound"):
        return "at its bound"
    low, high = quantity.get("low"), quantity.get("high")
    if low is None or high is None:
        return "not identifiable from these records"
    return "not distinguishable from zero" if low < 0.0 < high else ""


def revision_text(rung: Row, first: str) -> str:
    """Effects that a revision of the model added and removed: `stribeck`, `magnetic_cogging, without viscous`."""
    if rung["rung"] == 0:
        return first
    removed = " and ".join(rung.get("removed") or ())
    parts = [*(rung.get("added") or ()), *([f"without {removed}"] if removed else [])]
    return ", ".join(parts) or "[model] edited by hand"


def error_table(title: str, before: Row, after: Row | None = None) -> Table:
    """Errors by set of records and channel; where there are some `after` a change, each below that before it."""
    models = {"": before} if after is None else {"before": before, "after": after}
    columns = f"records|channel|{'model|' if after is not None else ''}rms:n|over noise:n strong|fit:n"
    rows = [
        (label, channel.replace("_", " "), *filter(None, [when]), *_error_cells(errors.get(part, {}).get(channel)))
        for part, label in PARTS.items()
        for channel in before.get(part, {})
        for when, errors in models.items()
    ]
    return make_table(title, columns, rows)


def _error_cells(error: Row | None) -> list[str]:
    if error is None:
        return ["", "", ""]
    percent, rms = error.get("fit_percent"), error["rms"]["value"]
    return [
        # A document has null for a number that is not finite.
        quantity_text(rms, error["rms"]["unit"]) if rms is not None and math.isfinite(rms) else "failed",
        over_noise_text(error.get("over_noise")),
        f"{percent:.2f} %" if percent is not None and math.isfinite(percent) else "",
    ]


def simulation_table(document: Row) -> Table:
    """Errors of a free run and of simulations over short horizons from measured states.

    No rows where the prediction along the inputs is the simulation: then they are the errors of the model.
    """
    runs = {"free run": document["free_run"], **document["horizon"]}
    columns = "records|channel"
    columns += "".join(f"|{name}:n|fit:n" for name in runs)
    rows = []
    for part, label in PARTS.items():
        for channel in document["free_run"].get(part, {}):
            found = [_error_cells(run.get(part, {}).get(channel)) for run in runs.values()]
            rows.append([label, channel.replace("_", " "), *(cells[k] for cells in found for k in (0, 2))])
    prediction = document["form"] == "output" and all(run == document["free_run"] for run in runs.values())
    note = (
        "Error of the motion simulated from the inputs: from the first row on, and from measured states over short "
        "horizons. Near stick and slip a small error of force decides when a body slips, and a free run may diverge."
    )
    return make_table("Error of simulation (rms)", columns, [] if prediction else rows, note)


def correlation_table(document: Row) -> Table:
    """Whiteness of the residual by channel, the inputs that it correlates with; the information criteria as note."""
    columns = "channel|residual|p:n|autocorrelation:n|correlated with:warn"
    rows = []
    for channel, one in document["correlation_of_residual"].items():
        inputs = (
            f"{name.replace('_', ' ')} ({row['correlation']:+.2f} at {quantity_text(row['lag']['value'], 's')})"
            for name, row in one["correlated_with"].items()
        )
        white, step = "white" if one["white"] else "not white", quantity_text(one["step"]["value"], "s")
        first = f"{one['autocorrelation']:+.2f} at {step}"
        rows.append([channel.replace("_", " "), white, p_value_text(one["p_value"]), first, ", ".join(inputs)])
    criteria = document["information"]
    note = (
        f"AIC {criteria['aic']:.1f}, BIC {criteria['bic']:.1f} with {criteria['parameters']} parameters on "
        f"{criteria['samples']} samples of the fit."
    )
    return make_table("Correlation of the residual (records of the fit)", columns, rows, note)


def parameter_table(parameters: Mapping[str, Row], title: str = "Parameters") -> Table:
    """Fitted values with their 95 % intervals, and a remark where the records do not determine them."""
    rows = [
        (key, quantity_text(q["value"], q["unit"]), interval_text(q), identifiability_text(q))
        for key, q in parameters.items()
        if not q.get("nuisance")
    ]
    return make_table(title, "parameter:code|value:n strong|95 % interval|remark:warn", rows)


def dependence_table(where: Sequence[Row]) -> Table:
    """Coordinates that the residual depends on, strongest first."""
    columns = "coordinate|share of its variance:n|p value:n"
    rows = [
        (row["coordinate"].replace("_", " "), f"{100 * row['share']:.1f} %", p_value_text(row["p_value"]))
        for row in where
        if row["share"] > LEAST_SHARE
    ]
    return make_table("Dependence of the residual on each coordinate", columns, rows)


def ranking_table(ranking: Sequence[Row], tried: int, before: float = math.inf) -> Table:
    """Effects tried (`ranking` of the document), best first: reduction predicted by the score test, reduction reached
    by the refit, values. Bars are as long as the error over noise `before`, of the stated model."""
    columns = "effect|predicted:n|reached:n|error left:n|over noise:n strong|:bar|p value:n|angle:warn|values:quiet"
    span = math.log(max(before, 1.5))
    refitted = [row for row in ranking if row.get("over_noise") is not None][:10]
    rows = []
    for row in refitted:
        error, reduction = row.get("validate_error"), row.get("reduction")
        bar = min(1.0, max(0.0, math.log(max(row["over_noise"], 1.0)) / span))
        cells = [
            row.get("law", row["effect"]),
            f"{100 * row['expected_reduction']:.1f} %",
            f"{round(100 * reduction, 1) + 0.0:.1f} %" if reduction is not None else "",
            quantity_text(error["value"], error["unit"]) if error else "",
            over_noise_text(row["over_noise"]),
            f"{100.0 * bar:.1f}",
            p_value_text(row["p_value"]),
            f"{math.degrees(row['angle']['value']):.0f}°" if "angle" in row else "",
            _values_text(row.get("parameters", {})),
        ]
        rows.append(cells)
    note = (
        "Predicted: reduction of the error by the score test, before any refit. Reached: after the refit, on held-out "
        "records. Bars are logarithmic, from the noise to the stated model. Angle: between the change of the residual "
        "by the named effect and those that another effect can make, to first order; below 15° the two are similar on "
        "these records, and only the refit separates them."
    )
    rest = [row for row in ranking if row.get("over_noise") is None]
    if rest:
        listed = ", ".join(f"{row['effect']} ({100 * row['expected_reduction']:.0f} %)" for row in rest)
        note += f" Not refitted, since the predicted reduction is small: {listed}."
    return make_table(f"{tried} effects tried, best on the held-out records first", columns, rows, note)


def _values_text(parameters: Mapping[str, Row]) -> str:
    """Values as text, without the numbered parts of a law that are zero."""
    return "; ".join(
        f"{parameter_name(key)} {quantity_text(q['value'], q['unit'])}" + (" (at its bound)" * bool(q.get("at_bound")))
        for key, q in parameters.items()
        if not q.get("nuisance") and (q["value"] or not key[-1].isdigit())
    )


def detectable_table(sizes: Sequence[Row]) -> Table:
    """The smallest size of each effect that these records could have shown."""
    columns = "effect|parameter|from:n strong|at:quiet"
    rows = [
        (
            row["effect"],
            parameter_name(row["parameter"]),
            quantity_text(row["value"], row["unit"]) if row["value"] is not None else "not detectable",
            ", ".join(f"{parameter_name(k)} {quantity_text(q['value'], q['unit'])}" for k, q in row["at"].items()),
        )
        for row in sizes
    ]
    note = "The smallest size that the diagnosis would have accepted, with the model's own values refitted."
    return make_table("Smallest detectable size of each effect on these records", columns, rows, note)


def worst_over_noise(by_channel: Mapping[str, Row]) -> float:
    """The largest error over noise of the errors of a document; NaN without any."""
    return max((m["over_noise"] for m in by_channel.values() if m.get("over_noise") is not None), default=math.nan)


def ladder_table(rungs: Sequence[Row]) -> Table:
    """The error after each revision of the model."""
    columns = "rung|added|channel|fit rms:n|held-out rms:n|fit over noise:n|held-out over noise:n strong"
    rows = []
    for rung in rungs:
        held = rung["before"].get("validate", {})
        first = (f"{rung['rung']:03d}", revision_text(rung, "the model before anything was added"))
        for channel, error in rung["before"].get("fit", {}).items():
            (fit_rms, fit_ratio, _), (rms, ratio, _) = _error_cells(error), _error_cells(held.get(channel))
            rows.append((*first, channel.replace("_", " "), fit_rms, rms, fit_ratio, ratio))
            first = ("", "")
    note = "rms: all rows. Over noise: without the largest 3 % of the errors and the rows that friction holds at rest."
    return make_table("Ladder", columns, rows, note)


def motion_table(motions: Sequence[Row]) -> Table:
    """Motions of the document of `suggest`, with the separation of each pair of effects."""
    columns = "motion:strong|seconds:n|would separate|at σ:n|these records, σ:n|purpose:quiet"
    rows = []
    for motion in motions:
        name, seconds, reason = motion["motion"], f"{motion['seconds']:.1f}", motion["reason"]
        for pair in motion["separates"] or (None,):
            cells = ("", "", "")
            if pair is not None:
                sigma, now = f"{pair['deviations']:.1f}", f"{pair['these_records']:.1f}"
                cells = (" from ".join(pair["effects"]), sigma, now)
            rows.append((name, seconds, *cells, reason))
            name = seconds = reason = ""
    note = (
        "σ: difference of two competing effects after either has been refitted to the other, in standard deviations. "
        "Ordered by σ² per second for the closest pair; the space-filling motion is always last."
    )
    return make_table("Motions, the one that separates most per second first", columns, rows, note)


def bootstrap_table(document: Row) -> Table:
    """Intervals of a bootstrap and of the linear covariance; `document` is that of `compare --bootstrap`."""
    found = document["bootstrap"]
    title = f"Intervals of {found['settled']} refits (95 %)"
    if found["settled"] < found["draws"]:
        title += f"; {found['draws'] - found['settled']} more did not converge"
    columns = "parameter:code|value:n strong|by refitting|by linear covariance|width, refitted / linear:n"
    rows = []
    for key, q in found["parameters"].items():
        linear = {**document["parameters"][key], "unit": q["unit"]}
        known = linear.get("low") is not None and linear.get("high") is not None
        width = f"{(q['high'] - q['low']) / (linear['high'] - linear['low']):.2f}" if known else ""
        cells = (quantity_text(q["value"], q["unit"]), interval_text(q), interval_text(linear) or "unknown", width)
        rows.append((key, *cells))
    return make_table(title, columns, rows)
