"""What the commands of the loop say to a person: short tables and sentences."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from rich.table import Table

from stagecad.parameters.units import format_quantity
from sysid.compare import Comparison
from sysid.diagnose import Diagnosis
from sysid.diagnosis.residual_maps import ResidualMap
from sysid.diagnosis.trials import explained_share
from sysid.diagnosis.verdict_limits import ADEQUATE_OVER_NOISE
from sysid.estimation.identifiability import public_key
from sysid.estimation.misfit import ChannelMisfit, dominated_by_few_samples, worst_over_noise
from sysid.ladder import Step
from sysid.prediction.problem import Case
from sysid.report import LEAST_P, WORTH_SAYING, channel_unit, worst_channel
from sysid.signals.gaussian_filter import BAND
from workbench.console.rung_words import change_words
from workbench.options import Run

COORDINATE_WORDS = {
    "time": "time",
    "frequency": "one frequency",
    "position": "position",
    "velocity": "velocity",
    "direction": "direction of motion",
    "acceleration": "acceleration",
    "distance_since_reversal": "distance since the last reversal",
    "distance_travelled": "distance travelled",
    "contact_age": "time of contact at rest",
    "normal_load": "normal load",
    "temperature": "temperature",
    "input": "input",
}


NOTHING_LEFT = 0.05
"""Share of the misfit up to which what an effect leaves is not worth a word."""

WORTH_A_WORD = 0.02
"""Share of the residual's variance from which a coordinate is named."""

FAR_ABOVE = 1.5
"""Error over noise on the records of the fit, over that on the held-out ones, from which both are told."""

NEAR_NOISE = 1.5
"""Error over noise up to which it can be said what would have been found: what is still missing hides the rest."""


def plain(value: float, unit: str) -> str:
    """A quantity for people; a plain number without a unit."""
    return f"{value:.4g}" if unit in ("", "1") else format_quantity(value, unit)


def misfit_table(case: Case, rows: Iterable[tuple[str, Mapping[str, ChannelMisfit]]], title: str) -> Table:
    """Errors by record set and channel."""
    table = Table(title=title, title_justify="left")
    for name in ("records", "channel", "rms", "over noise", "fit"):
        table.add_column(name, justify="left" if name in ("records", "channel") else "right")
    for label, by_channel in rows:
        for channel, m in by_channel.items():
            table.add_row(
                label,
                channel,
                plain(m.rms, channel_unit(case, channel)),
                f"{m.over_noise:.2f} x",
                f"{m.fit_percent:.2f} %",
            )
    return table


def parameter_table(parameters: Mapping[str, Mapping[str, Any]], title: str = "Parameters") -> Table:
    """Fitted values with their 95 % intervals, and a word where the records do not settle them."""
    table = Table(title=title, title_justify="left")
    doubts = [doubt_words(q) for q in parameters.values()]
    columns = ("parameter", "value", "95 % interval", *(("remark",) if any(doubts) else ()))
    for name in columns:
        table.add_column(name, justify="right" if name == "value" else "left")
    for (key, q), doubt in zip(parameters.items(), doubts, strict=True):
        table.add_row(*(key, plain(q["value"], q["unit"]), interval_words(q), doubt)[: len(columns)])
    return table


def interval_words(quantity: Mapping[str, Any]) -> str:
    """A 95 % interval as text; empty where it has an open end."""
    low, high = quantity.get("low"), quantity.get("high")
    if low is None or high is None:
        return ""
    return f"{plain(low, quantity['unit'])} .. {plain(high, quantity['unit'])}"


def doubt_words(quantity: Mapping[str, Any]) -> str:
    """What the records leave open of a fitted value; empty where they settle it."""
    if quantity.get("at_bound"):
        return "at its bound"
    low, high = quantity.get("low"), quantity.get("high")
    if low is None or high is None:
        return "not told by these records"
    return "may as well be zero" if low < 0.0 < high else ""


def where_table(maps: Sequence[ResidualMap]) -> Table:
    """Coordinates the residual depends on."""
    table = Table(title="Where it fails: the residual depends on", title_justify="left")
    table.add_column("coordinate")
    table.add_column("share of its variance", justify="right")
    table.add_column("chance", justify="right")
    for m in [m for m in maps if m.share > 0.005][:6]:
        table.add_row(m.coordinate, f"{100 * m.share:.0f} %", chance_words(m.p_value))
    return table


def chance_words(p: float) -> str:
    """A p value as text, never smaller than the turns of sign behind it can show."""
    return "< 0.001" if p <= 1.5 * LEAST_P else f"{p:.3f}"


def where_words(maps: Sequence[ResidualMap], most: int = 2) -> str:
    """The coordinates the residual depends on most, with their shares; empty where there is none."""
    telling = [m for m in maps if m.share > WORTH_A_WORD][:most]
    return " and ".join(f"{COORDINATE_WORDS[m.coordinate]} ({100 * m.share:.0f} %)" for m in telling)


def angle_words(row: Mapping[str, Any]) -> str:
    """Angle between what the effect named does and what this one could do, in degrees; below 15 it could stand in."""
    return f"{math.degrees(row['angle']['value']):.0f}°" if "angle" in row else ""


def near_noise(diagnosis: Diagnosis) -> bool:
    """Whether the model, with the effect found in it, leaves little more than the noise."""
    best = diagnosis.best
    over = worst_over_noise(diagnosis.before_fit, diagnosis.before_validate)
    return (over if best is None else worst_over_noise(best.after_fit, best.after_validate)) <= NEAR_NOISE


def detectable_table(rows: Sequence[Mapping[str, Any]]) -> Table:
    """The smallest size of each effect that these records could have shown."""
    table = Table(title="What would have been found, had it been at least so large", title_justify="left")
    for name in ("effect", "of", "from", "where it shows best"):
        table.add_column(name, justify="right" if name == "from" else "left")
    for row in rows:
        size = plain(row["value"], row["unit"]) if row["value"] is not None else "no size"
        parameter = row["parameter"].rpartition(".")[2].replace("_", " ")
        table.add_row(row["effect"], parameter, size, shape_words(row))
    return table


def shape_words(row: Mapping[str, Any]) -> str:
    """The shape at which an effect's size shows best, as `pitch 2.1 mm, damping 0.05`."""
    return ", ".join(
        f"{key.rpartition('.')[2].replace('_', ' ')} {plain(q['value'], q['unit'])}" for key, q in row["at"].items()
    )


def noise_line(case: Case) -> str:
    """The noise floor in words."""
    parts = []
    measured = set(case.fit_records[0].measured) | {"position"}
    for channel, noise in case.noise.items():
        if channel in measured:
            parts.append(f"{channel} {format_quantity(noise.value, noise.unit)} ({noise.source})")
    band = getattr(case.fit_records[0], "whole", None)
    text = "noise: " + ", ".join(parts) + f"; residual taken as {case.form.replace('_', ' ')}"
    if band is not None and band.width > 0:
        text += f", below {BAND / band.width:.3g} Hz: what the position's noise allows"
    return text


def say_comparison(run: Run, comparison: Comparison, document: Mapping[str, Any]) -> None:
    """Print a comparison; `document` is its own."""
    case = comparison.case
    for note in case.notes:
        run.note(f"note: {note}")
    run.say(noise_line(case))
    rows = [("fit", comparison.fit), ("held out", comparison.validate)]
    effects = ", ".join(e.name for e in comparison.base.fitted.model.effects) or "no effects"
    run.console.print(misfit_table(case, rows, f"Model as it stands: {effects}"))
    run.console.print(parameter_table(document["parameters"]))
    for line in document["not_identifiable"]:
        run.say(line)
    over = max((m.over_noise for m in (*comparison.fit.values(), *comparison.validate.values())), default=1.0)
    if over <= ADEQUATE_OVER_NOISE[case.form]:
        run.say(f"{over:.2f} x the noise: what is left is noise.")
        return
    run.console.print(where_table(comparison.maps))
    held, fit = held_out(comparison.fit, comparison.validate), worst_over_noise(comparison.fit, {})
    also = f" ({fit:.3g} x on the records of the fit)" if fit > FAR_ABOVE * held else ""
    words = where_words(comparison.maps)
    run.say(f"{held:.3g} x above the noise{also}" + (f"; it fails with {words}." if words else "."))


def say_diagnosis(run: Run, diagnosis: Diagnosis, document: Mapping[str, Any]) -> None:
    """Print a diagnosis; `document` is its own."""
    case, ranking = diagnosis.case, document["ranking"]
    for note in case.notes:
        run.note(f"note: {note}")
    run.say(noise_line(case))
    run.console.print(ranking_table(ranking, len(diagnosis.trials)))
    added = f", with {diagnosis.effect}" if diagnosis.effect else ""
    run.console.print(parameter_table(document["parameters"], f"Parameters of the model{added}"))
    if document["detectable"] and near_noise(diagnosis):
        run.console.print(detectable_table(document["detectable"]))
    if diagnosis.verdict == "missing-effect":
        assert diagnosis.best is not None
        channel = worst_channel(case, diagnosis.before_validate)
        before = diagnosis.before_validate[channel]
        after = diagnosis.best.after_validate[channel]
        unit = channel_unit(case, channel)
        run.say(
            f"missing: {diagnosis.effect} ({plain(before.rms, unit)} -> {plain(after.rms, unit)} in {channel} on the "
            f"held-out records; {before.over_noise:.3g} x -> {after.over_noise:.3g} x the noise)"
        )
        if dominated_by_few_samples(before, after):
            run.say(
                "(the rms is ruled by few samples beside reversals; the multiple of the noise passes over those, and "
                "counts how the body gives way at rest)"
            )
        fit = (worst_over_noise(diagnosis.before_fit, {}), worst_over_noise(diagnosis.best.after_fit, {}))
        if fit[0] > FAR_ABOVE * before.over_noise or fit[1] > FAR_ABOVE * after.over_noise:
            run.say(f"on the records of the fit: {fit[0]:.3g} x -> {fit[1]:.3g} x the noise")
        if diagnosis.detected_by:
            run.say(f"told by more than that error: {diagnosis.detected_by}")
        else:
            run.say(f"without it the model fails with {where_words(diagnosis.maps) or 'nothing that was recorded'}")
        if diagnosis.indistinguishable:
            run.say(
                f"these records cannot tell it from: {', '.join(diagnosis.indistinguishable)}; "
                f"'stagecad suggest' looks for a motion that would"
            )
        if diagnosis.unexplained_share > NOTHING_LEFT:
            run.say(f"{100 * diagnosis.unexplained_share:.0f} % of the misfit stays; add it and diagnose again.")
    elif diagnosis.verdict == "adequate":
        run.say(f"adequate: {diagnosis.reason}.")
    else:
        words = where_words(diagnosis.maps) or "nothing that was recorded"
        run.say(f"unexplained: {diagnosis.reason}. What is left depends on {words}.")
    for line in (*swap_lines(diagnosis), *unphysical_lines(diagnosis), *document["not_identifiable"]):
        run.say(line)


def held_out(fit: dict[str, ChannelMisfit], validate: dict[str, ChannelMisfit]) -> float:
    """Largest error over noise on the held-out records; on those of the fit where there are no others."""
    return worst_over_noise({}, validate) if validate else worst_over_noise(fit, {})


def ranking_table(ranking: Sequence[Mapping[str, Any]], tried: int) -> Table:
    """Effects tried, with what a linear score foretold, what the refit left, and the values it took."""
    title = f"{tried} effects tried, best on the held-out records first"
    table = Table(title=title, title_justify="left")
    for name in ("effect", "expected", "reached", "error left", "over noise", "chance", "angle", "values"):
        table.add_column(name, justify="left" if name in ("effect", "values") else "right")
    for row in ranking[:8]:
        error, chance = row.get("validate_error"), row["p_value"]
        table.add_row(
            row.get("law", row["effect"]),
            f"{100 * row['expected_reduction']:.1f} %",
            f"{round(100 * row['reduction'], 1) + 0.0:.1f} %" if row.get("reduction") is not None else "",
            plain(error["value"], error["unit"]) if error else "",
            f"{row['over_noise']:.2f} x" if "over_noise" in row else "",
            f"< {chance['below']}" if isinstance(chance, dict) else f"{chance:.3f}",
            angle_words(row),
            value_words(row.get("parameters", {})),
        )
    return table


def value_words(parameters: Mapping[str, Mapping[str, Any]]) -> str:
    """The values of one effect in a line."""
    return "; ".join(
        f"{key.rpartition('.')[2].replace('_', ' ')} {plain(q['value'], q['unit'])}"
        + (" (at its bound)" if q.get("at_bound") else "")
        for key, q in parameters.items()
    )


def swap_lines(diagnosis: Diagnosis) -> list[str]:
    """Effects added earlier that should go, in words."""
    lines = []
    for swap in diagnosis.swaps:
        change = f"({swap.before:.3g} x -> {swap.after:.3g} x the noise on the held-out records)"
        if swap.new is None:
            lines.append(f"{swap.old}, added earlier, is not needed any more {change}: add --drop {swap.old}")
        else:
            lines.append(
                f"{swap.new} in the place of {swap.old}, added earlier, explains more {change}: "
                f"add {swap.new} --drop {swap.old}"
            )
    return lines


def unphysical_lines(diagnosis: Diagnosis) -> list[str]:
    """Effects that would explain something only with a value beyond what is physical, in words.

    Beside an effect that is named, only those that would take as much as half of what it takes: rivals, were they real.
    """
    named = explained_share(diagnosis.base, diagnosis.best) if diagnosis.best is not None else 0.0
    least = max(WORTH_SAYING, 0.5 * named)
    lines = []
    for trial in diagnosis.trials[:12]:
        amplitude = next((p for p in trial.effect.parameters if p.role == "amplitude"), None)
        blocked_reduction = trial.refit.blocked_reduction
        if (
            amplitude is not None
            and blocked_reduction >= least
            and blocked_reduction > 2.0 * trial.refit.predicted_reduction
        ):
            error = 100.0 * (1.0 - (1.0 - min(blocked_reduction, 1.0)) ** 0.5)
            lines.append(
                f"{trial.public_name} would lower the error by {error:.0f} %, but only with a {amplitude.name} below "
                f"{amplitude.low:g} {amplitude.unit}, which is not physical."
            )
    return lines


def say_step(run: Run, step: Step, parameters: Mapping[str, Any]) -> None:
    """Print what adding effects did."""
    case = step.case
    rows = [
        ("fit, before", step.before_fit),
        ("fit, after", step.after_fit),
        ("held out, before", step.before_validate),
        ("held out, after", step.after_validate),
    ]
    signs = [f"{sign} {', '.join(step.rung.document[key])}" for sign, key in (("+", "added"), ("-", "removed"))
             if step.rung.document[key]]  # fmt: skip
    run.console.print(misfit_table(case, rows, f"Rung {step.rung.number:03d}: {' '.join(signs)}"))
    run.console.print(parameter_table(parameters))
    for key, (old, new) in step.changed.items():
        unit = parameters.get(public_key(key), {}).get("unit", "")
        run.say(f"{public_key(key)} moved from {plain(old, unit)} to {plain(new, unit)}")
    run.say(f"wrote {step.rung.path} and {case.experiment.path}")


def ladder_table(rungs: Sequence[Mapping[str, Any]]) -> Table:
    """The error after each effect added so far."""
    table = Table(title="Ladder", title_justify="left")
    for name in ("rung", "added", "channel", "fit rms", "held-out rms", "fit over noise", "held-out over noise"):
        table.add_column(name, justify="left" if name in ("rung", "added", "channel") else "right")
    for rung in rungs:
        fit, held = rung["before"].get("fit", {}), rung["before"].get("validate", {})
        first = True
        for channel, m in fit.items():
            h = held.get(channel)
            table.add_row(
                f"{rung['rung']:03d}" if first else "",
                change_words(rung, "the model before anything was added") if first else "",
                channel,
                plain(m["rms"]["value"], m["rms"]["unit"]),
                plain(h["rms"]["value"], h["rms"]["unit"]) if h else "",
                f"{m['over_noise']:.2f} x",
                f"{h['over_noise']:.2f} x" if h else "",
            )
            first = False
    return table
