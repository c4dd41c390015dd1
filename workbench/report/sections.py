"""Sections of the loop's report: what a comparison, a diagnosis or a ladder says, as sentences, tables and figures.

A section is plain data (it is kept as JSON), so a report can be put together again from sections made at other times.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from sim.library.effect import Effect
from sysid.compare import Comparison
from sysid.diagnose import Diagnosis
from sysid.diagnosis.residual_maps import ResidualMap
from sysid.diagnosis.trials import CandidateFit
from sysid.diagnosis.verdict_limits import ADEQUATE_OVER_NOISE
from sysid.estimation.covariance import Intervals, intervals
from sysid.estimation.fit import FittedModel
from sysid.estimation.identifiability import identifiability_report, public_key
from sysid.estimation.misfit import dominated_by_few_samples, worst_over_noise
from sysid.prediction.problem import Case
from sysid.report import channel_unit, worst_channel
from workbench.console.loop_rows import detectable_rows, misfit_rows, parameter_rows, ranking_rows, scored_only, times
from workbench.console.loop_text import (
    COORDINATE_WORDS,
    FAR_ABOVE,
    NOTHING_LEFT,
    chance_words,
    held_out,
    near_noise,
    noise_line,
    plain,
    swap_lines,
    unphysical_lines,
    where_words,
)
from workbench.console.rung_words import change_words
from workbench.report.figures import AFTER, BEFORE, MODEL, curve_of, draw_ladder, draw_maps, draw_overlay, worst_record

Section = dict[str, Any]

SHARE_SHOWN = 0.005


def comparison_section(found: Comparison, document: Mapping[str, Any]) -> Section:
    """What `compare` found."""
    case, fitted = found.case, found.base.fitted
    adequate = worst_over_noise(found.fit, found.validate) <= ADEQUATE_OVER_NOISE[case.form]
    return {
        **_experiment(case),
        "kind": "compare",
        "title": "The model as it stands",
        "effects": _names(fitted.model.effects),
        "state": "good" if adequate else "bad",
        "number": times(held_out(found.fit, found.validate)),
        "headline": comparison_sentence(found),
        "misfit": misfit_rows(document["before"]),
        "overlays": _overlays(found.case, {"model": fitted.model}, found.validate, (MODEL,)),
        "maps": _maps(case, found.maps),
        "parameters": parameter_rows(document["parameters"]),
        **_told(fitted, intervals(fitted, case.fit_records)),
        "seconds": document["seconds"],
    }


def comparison_sentence(found: Comparison) -> str:
    """What a comparison found, as a person would say it."""
    most = worst_over_noise(found.fit, found.validate)
    if most <= ADEQUATE_OVER_NOISE[found.case.form]:
        return f"The model leaves {times(most)} the noise: these records ask for nothing more."
    over = held_out(found.fit, found.validate)
    text = f"The model leaves {times(over)} the noise on the held-out records."
    fit = worst_over_noise(found.fit, {})
    if fit > FAR_ABOVE * over:
        text += f" On the records of the fit it leaves {times(fit)}."
    words = where_words(found.maps)
    return text + (
        f" What is left depends on {words}." if words else " What is left hangs on nothing that was recorded."
    )


def diagnosis_section(found: Diagnosis, document: Mapping[str, Any]) -> Section:
    """What `diagnose` found."""
    case, base = found.case, found.base.fitted
    best = found.best if found.best is not None else (found.trials[0] if found.trials else None)
    models, inks = {"model": base.model}, (MODEL,)
    if best is not None and found.verdict != "adequate":
        label = f"with {best.public_name}" + ("" if found.best is not None else " (best tried)")
        models, inks = {"before": base.model, label: best.fitted.model}, (BEFORE, AFTER)
    before = held_out(found.before_fit, found.before_validate)
    fitted = base if found.best is None else found.best.fitted
    return {
        **_experiment(case),
        "kind": "diagnose",
        "title": f"What is missing: {found.effect}" if found.effect else "What is missing",
        "effects": _names(base.model.effects),
        "state": {"missing-effect": "found", "adequate": "good"}.get(found.verdict, "bad"),
        "number": times(before),
        "verdict": found.verdict,
        "headline": verdict_sentence(found),
        "misfit": misfit_rows(document["before"], document["after"] if found.best is not None else None),
        "overlays": _overlays(case, models, found.before_validate, inks),
        "ranking": ranking_rows(document["ranking"], before),
        "tried": len(found.trials),
        "scored_only": scored_only(document["ranking"]),
        "ranking_channel": worst_channel(case, found.before_validate).replace("_", " "),
        "detectable": detectable_rows(document["detectable"]) if near_noise(found) else [],
        "maps": _maps(case, found.maps),
        "told_apart": rivals_sentence(found),
        "effect": _effect_words(best) if found.best is not None else None,
        "parameters": parameter_rows(document["parameters"]),
        "parameters_of": f"of the model with {found.effect}" if found.effect else "of the model as it stands",
        **_told(fitted, intervals(fitted, case.fit_records)),
        "remarks": [*swap_lines(found), *unphysical_lines(found)],
        "seconds": document["seconds"],
    }


def verdict_sentence(found: Diagnosis) -> str:
    """The verdict as a person would say it."""
    case = found.case
    if found.verdict == "adequate":
        return f"Nothing is missing: {found.reason}."
    if found.verdict == "unexplained" or found.best is None:
        words = where_words(found.maps) or "nothing that was recorded"
        return f"No effect of the library explains what is left: {found.reason}. It depends on {words}."
    channel = worst_channel(case, found.before_validate)
    before, after = found.before_validate[channel], found.best.after_validate[channel]
    unit = channel_unit(case, channel)
    errors = f"{plain(before.rms, unit)} to {plain(after.rms, unit)}"
    ratio = f"{times(before.over_noise)} the noise to {times(after.over_noise)}"
    name = channel.replace("_", " ")
    if found.detected_by:
        return (
            f"{found.effect} is missing: {found.detected_by}. The error of {name} on the held-out records goes from "
            f"{errors}, from {ratio}."
        )
    if dominated_by_few_samples(before, after):
        text = (
            f"{found.effect} is missing. With it the error of {name} on the held-out records falls from {ratio}. "
            f"(The plain rms, {errors}, is ruled by the few samples beside reversals.)"
        )
    else:
        text = (
            f"{found.effect} is missing. With it the error of {name} on the held-out records falls from {errors}, "
            f"from {ratio}."
        )
    fit = (worst_over_noise(found.before_fit, {}), worst_over_noise(found.best.after_fit, {}))
    if fit[0] > FAR_ABOVE * before.over_noise or fit[1] > FAR_ABOVE * after.over_noise:
        text += f" On the records of the fit it falls from {times(fit[0])} to {times(fit[1])}."
    words = where_words(found.maps)
    if words:
        text += f" Without it the model fails with {words}."
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


def _effect_words(best: CandidateFit | None) -> dict[str, str] | None:
    if best is None:
        return None
    effect = best.effect
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
        "number": times(over[1]),
        "headline": f"From {times(over[0])} the noise to {times(over[1])}, in {_steps(len(rungs) - 1)}.",
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
    return {
        "rung": f"{rung['rung']:03d}",
        "added": change_words(rung, "the model as it began"),
        "misfit": misfit_rows(rung["before"]),
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
        "notes": list(case.notes),
    }


def _record_words(case: Case, index: int) -> str:
    record = case.records[index]
    length = float(record.time[-1] - record.time[0])
    role = "fit" if record.role == "fit" else "held out"
    return f"{record.name} ({role}): {record.size} rows in {length:.4g} s"


def _names(effects: Iterable[Effect]) -> list[str]:
    return [e.name for e in effects]


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
                "chance": chance_words(m.p_value),
            }
            for m in maps
            if m.share > 0.0
        ],
    }


def _told(fitted: FittedModel, known: Intervals) -> dict[str, Any]:
    """What the records leave open, in words, and the correlations of the fitted values."""
    words = identifiability_report(fitted, known)
    names = [public_key(key) for key in known.keys]
    cells = [[None if not np.isfinite(v) else round(float(v), 2) for v in row] for row in known.correlation]
    return {"open": words, "correlation": {"names": names, "cells": cells} if 1 < len(names) <= 14 else None}
