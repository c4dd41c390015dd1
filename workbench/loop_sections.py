"""Sections of the loop's report: what a comparison, a diagnosis or a ladder says, as sentences, tables and figures.

A section is plain data (it is kept as JSON), so a report can be put together again from sections made at other times.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from sim.effect import Effect
from sysid.base_fit import Fitted
from sysid.case import Case
from sysid.compare import Comparison
from sysid.diagnose import ADEQUATE_OVER_NOISE, Diagnosis
from sysid.document import channel_unit, parameters_json, worst_channel
from sysid.identifiability import open_words, public_key
from sysid.intervals import Intervals, intervals
from sysid.misfit import ChannelMisfit
from sysid.residual_maps import ResidualMap
from sysid.trials import Trial
from workbench.loop_figures import AFTER, BEFORE, MODEL, curve_of, draw_ladder, draw_maps, draw_overlay, worst_record
from workbench.loop_text import COORDINATE_WORDS, NOTHING_LEFT, angle_words, near_noise, noise_line, plain, shape_words

Section = dict[str, Any]

SHARE_SHOWN = 0.005


def comparison_section(found: Comparison, document: Mapping[str, Any]) -> Section:
    """What `compare` found."""
    case, fitted = found.case, found.base.fitted
    over = _excess(found.fit, found.validate)
    adequate = over <= ADEQUATE_OVER_NOISE[case.form]
    return {
        **_experiment(case),
        "kind": "compare",
        "title": "The model as it stands",
        "effects": _names(fitted.model.effects),
        "state": "good" if adequate else "bad",
        "number": _times(over),
        "headline": comparison_sentence(found),
        "misfit": _misfit_rows(document["before"]),
        "overlays": _overlays(found.case, {"model": fitted.model}, found.validate, (MODEL,)),
        "maps": _maps(case, found.maps),
        "parameters": parameter_rows(document["parameters"]),
        **_told(fitted, intervals(fitted, case.fit_records)),
        "seconds": document["seconds"],
    }


def comparison_sentence(found: Comparison) -> str:
    """What a comparison found, as a person would say it."""
    over = _excess(found.fit, found.validate)
    if over <= ADEQUATE_OVER_NOISE[found.case.form]:
        return f"The model leaves {_times(over)} the noise: these records ask for nothing more."
    telling = [m for m in found.maps if m.share > 0.02][:2]
    if not telling:
        return f"The model leaves {_times(over)} the noise, and what is left hangs on nothing that was recorded."
    words = " and ".join(f"{COORDINATE_WORDS[m.coordinate]} ({100 * m.share:.0f} % of what is left)" for m in telling)
    return f"The model leaves {_times(over)} the noise. What is left depends on {words}."


def _excess(fit: Mapping[str, ChannelMisfit], validate: Mapping[str, ChannelMisfit]) -> float:
    return max((m.over_noise for m in (*fit.values(), *validate.values())), default=1.0)


def diagnosis_section(found: Diagnosis, document: Mapping[str, Any]) -> Section:
    """What `diagnose` found."""
    case, base = found.case, found.base.fitted
    best = found.best if found.best is not None else (found.trials[0] if found.trials else None)
    models, inks = {"model": base.model}, (MODEL,)
    if best is not None and found.verdict != "adequate":
        label = f"with {best.family}" + ("" if found.best is not None else " (best tried)")
        models, inks = {"before": base.model, label: best.candidate.fitted.model}, (BEFORE, AFTER)
    before = _excess(found.before_fit, found.before_validate)
    section = {
        **_experiment(case),
        "kind": "diagnose",
        "title": f"What is missing: {found.effect}" if found.effect else "What is missing",
        "effects": _names(base.model.effects),
        "state": {"missing-effect": "found", "adequate": "good"}.get(found.verdict, "bad"),
        "number": _times(before),
        "verdict": found.verdict,
        "headline": verdict_sentence(found),
        "misfit": _misfit_rows(document["before"], document["after"] if found.best is not None else None),
        "overlays": _overlays(case, models, found.before_validate, inks),
        "ranking": ranking_rows(document["ranking"], before),
        "ranking_channel": worst_channel(case, found.before_validate).replace("_", " "),
        "detectable": detectable_rows(document["detectable"]) if near_noise(found) else [],
        "maps": _maps(case, found.maps),
        "told_apart": rivals_sentence(found),
        "effect": _effect_words(best) if found.best is not None else None,
        "seconds": document["seconds"],
    }
    if found.best is not None:
        fitted = found.best.candidate.fitted
        known = intervals(fitted, case.fit_records)
        section["parameters"] = parameter_rows(parameters_json(case, fitted, known))
        section.update(_told(fitted, known))
    return section


def verdict_sentence(found: Diagnosis) -> str:
    """The verdict as a person would say it."""
    case = found.case
    if found.verdict == "adequate":
        return f"Nothing is missing: {found.reason}."
    if found.verdict == "unexplained" or found.best is None:
        telling = [m for m in found.maps if m.share > 0.02][:2]
        words = " and ".join(COORDINATE_WORDS[m.coordinate] for m in telling) or "nothing that was recorded"
        return f"No effect of the library explains what is left: {found.reason}. It depends on {words}."
    channel = worst_channel(case, found.before_validate)
    before, after = found.before_validate[channel], found.best.after_validate[channel]
    unit = channel_unit(case, channel)
    errors = f"{plain(before.rms, unit)} to {plain(after.rms, unit)}"
    times = f"{_times(before.over_noise)} the noise to {_times(after.over_noise)}"
    name = channel.replace("_", " ")
    if after.rms / before.rms > 2.0 * after.over_noise / before.over_noise:
        text = (
            f"{found.effect} is missing. With it the error of {name} on the held-out records falls from {times}. "
            f"(The plain rms, {errors}, is ruled by the few samples beside reversals.)"
        )
    else:
        text = (
            f"{found.effect} is missing. With it the error of {name} on the held-out records falls from {errors}, "
            f"from {times}."
        )
    if found.unexplained_share > NOTHING_LEFT:
        text += f" {100 * found.unexplained_share:.0f} % of the misfit stays: add it, and diagnose again."
    return text


def rivals_sentence(found: Diagnosis) -> str:
    """What these records cannot tell apart; empty where there is no rival."""
    names = list(found.indistinguishable)
    if not names or not found.effect:
        return ""
    return (
        f"These records cannot tell {found.effect} from {' or '.join(names)}: on the held-out records they differ by "
        "no more than chance. 'stagecad suggest' looks for a motion that would."
    )


def _effect_words(best: Trial | None) -> dict[str, str] | None:
    if best is None:
        return None
    effect = best.candidate.effect
    return {
        "name": effect.name,
        "meaning": effect.meaning,
        "equation": effect.equation,
        "shows": effect.shows,
        "source": effect.source,
    }


def ladder_section(rungs: Sequence[Mapping[str, Any]], png: Path | None = None) -> Section:
    """The ladder so far, its figure written to `png` as well."""
    last = rungs[-1]
    over = [max((m["over_noise"] for m in _by_channel(rung)), default=float("nan")) for rung in (rungs[0], last)]
    return {
        "kind": "ladder",
        "title": "The ladder",
        "effects": list(last["effects"]),
        "state": "good" if over[1] <= max(ADEQUATE_OVER_NOISE.values()) else "found",
        "number": _times(over[1]),
        "headline": f"From {_times(over[0])} the noise to {_times(over[1])}, in {_steps(len(rungs) - 1)}.",
        "figure": draw_ladder(rungs, png),
        "rungs": [_rung_row(rung) for rung in rungs],
        "parameters": parameter_rows(last.get("parameters", {})),
    }


def _steps(count: int) -> str:
    return "one step" if count == 1 else f"{count} steps"


def _by_channel(rung: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    before = rung["before"]
    return [m for part in ("fit", "validate") for m in before.get(part, {}).values() if m.get("over_noise") is not None]


def _rung_row(rung: Mapping[str, Any]) -> dict[str, Any]:
    added = rung.get("added") or ()
    return {
        "rung": f"{rung['rung']:03d}",
        "added": ", ".join(added) or ("the model as it began" if rung["rung"] == 0 else "[model] edited by hand"),
        "misfit": _misfit_rows(rung["before"]),
    }


def _experiment(case: Case) -> Section:
    rig = case.experiment.rig
    declared = rig.declaration.known
    known = [
        f"{name.replace('_', ' ')} {plain(k.value, declared[name].rotary_unit if rig.rotary else declared[name].unit)}"
        for name, k in rig.known.items()
    ]
    return {
        "records": {record.name: record.sha256 for record in case.records},
        "rig": f"{rig.kind}" + (", rotary" if rig.rotary else "") + (f": {', '.join(known)}" if known else ""),
        "record_words": [_record_words(case, k) for k in range(len(case.records))],
        "noise_words": noise_line(case).removeprefix("noise: "),
        "form": case.form.replace("_", " "),
        "notes": list(case.notes),
    }


def _record_words(case: Case, index: int) -> str:
    record = case.records[index]
    length = float(record.time[-1] - record.time[0])
    role = "fit" if record.role == "fit" else "held out"
    return f"{record.name} ({role}): {record.size} rows in {length:.4g} s"


def _names(effects: Iterable[Effect]) -> list[str]:
    return [e.name for e in effects]


def _times(over: float) -> str:
    return f"{over:.2f} ×" if over < 9.995 else f"{over:.0f} ×"


def _misfit_rows(before: Mapping[str, Any], after: Mapping[str, Any] | None = None) -> list[dict[str, str]]:
    rows = []
    for part, words in (("fit", "records of the fit"), ("validate", "held-out records")):
        for channel, m in before.get(part, {}).items():
            row = {"part": words, "channel": channel.replace("_", " "), **_misfit_words(m)}
            later = (after or {}).get(part, {}).get(channel)
            if later is not None:
                row.update({f"{key}_after": value for key, value in _misfit_words(later).items()})
            rows.append(row)
    return rows


def _misfit_words(m: Mapping[str, Any]) -> dict[str, str]:
    percent = m.get("fit_percent")
    return {
        "rms": plain(m["rms"]["value"], m["rms"]["unit"]),
        "over": _times(m["over_noise"]) if m.get("over_noise") is not None else "",
        "fit": f"{percent:.2f} %" if percent is not None and math.isfinite(percent) else "",
    }


def _overlays(
    case: Case, models: Mapping[str, Any], by_channel: Mapping[str, Any], inks: Sequence[str]
) -> list[dict[str, str]]:
    """The worst channel on the worst held-out record, then the other channels there."""
    records = case.validate_records or case.fit_records
    base = next(iter(models.values()))
    worst = worst_channel(case, by_channel)
    drawn = []
    for channel in [worst, *(c for c in records[0].measured if c != worst)][:3]:
        curve = curve_of(worst_record(records, channel, base), channel, channel_unit(case, channel), models)
        drawn.append({"channel": channel.replace("_", " "), "figure": draw_overlay(curve, inks)})
    return drawn


def _maps(case: Case, maps: Sequence[ResidualMap]) -> dict[str, Any]:
    # An axis that never rests has one age of contact: nothing to draw it against.
    drawable = [m for m in maps if m.centres.size > 1 and np.ptp(m.centres) > 0.0]
    shown = [m for m in drawable if m.share > SHARE_SHOWN][:6] or drawable[:3]
    rotary, tip = case.experiment.rig.rotary, case.kind == "actuator-tip"
    return {
        "figure": draw_maps(shown, rotary, tip) if shown else "",
        "rows": [
            {
                "coordinate": COORDINATE_WORDS[m.coordinate],
                "share": f"{100 * m.share:.1f} %",
                "chance": "< 0.001" if m.p_value <= 0.0015 else f"{m.p_value:.3f}",
            }
            for m in maps
            if m.share > 0.0
        ],
    }


def parameter_rows(parameters: Mapping[str, Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Fitted values with their 95 % intervals, and a word where the records do not settle them."""
    rows = []
    for key, q in parameters.items():
        low, high, interval = q.get("low"), q.get("high"), ""
        word = "at its bound" if q.get("at_bound") else "not told by these records"
        if low is not None and high is not None and math.isfinite(low) and math.isfinite(high):
            interval = f"{plain(low, q['unit'])} … {plain(high, q['unit'])}"
            word = "may as well be zero" if low < 0.0 < high else ""
        rows.append({"key": key, "value": plain(q["value"], q["unit"]), "interval": interval, "word": word})
    return rows


def _told(fitted: Fitted, known: Intervals) -> dict[str, Any]:
    """What the records leave open, in words, and the correlations of the fitted values."""
    words = open_words(fitted, known)
    names = [public_key(key) for key in known.keys]
    cells = [[None if not np.isfinite(v) else round(float(v), 2) for v in row] for row in known.correlation]
    return {"open": words, "correlation": {"names": names, "cells": cells} if 1 < len(names) <= 14 else None}


def detectable_rows(detectable: Sequence[Mapping[str, Any]]) -> list[dict[str, str]]:
    """The smallest size of each effect that the records could have shown."""
    return [
        {
            "effect": row["effect"],
            "of": row["parameter"].rpartition(".")[2].replace("_", " "),
            "size": plain(row["value"], row["unit"]) if row["value"] is not None else "no size would have shown",
            "at": shape_words(row),
        }
        for row in detectable
    ]


def ranking_rows(ranking: Sequence[Mapping[str, Any]], before: float) -> list[dict[str, Any]]:
    """Effects tried, best first: what the linear score expected, what the refit reached on held-out records."""
    rows = []
    span = math.log(max(before, 1.5))
    for row in ranking[:10]:
        error, over, chance = row.get("validate_error"), row.get("over_noise"), row["p_value"]
        reduction = row.get("reduction")
        if over is None:
            continue
        law = row.get("law", "")
        rows.append({
            "effect": row["effect"],
            "law": law.partition(":")[2] or law.partition("@")[2] or "",
            "expected": f"{100 * row['expected_reduction']:.0f} %",
            "reached": f"{round(100 * reduction, 1) + 0.0:.1f} %" if reduction is not None else "",
            "error": plain(error["value"], error["unit"]) if error else "",
            "over": _times(over),
            "bar": 100.0 * min(1.0, max(0.0, math.log(max(over, 1.0)) / span)),
            "chance": f"< {chance['below']}" if isinstance(chance, Mapping) else f"{chance:.3f}",
            "angle": angle_words(row),
            "parameters": "; ".join(
                f"{key.rpartition('.')[2].replace('_', ' ')} {plain(q['value'], q['unit'])}"
                + (" (at its bound)" if q.get("at_bound") else "")
                for key, q in row.get("parameters", {}).items()
            ),
        })  # fmt: skip
    return rows
