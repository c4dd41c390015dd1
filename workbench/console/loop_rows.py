"""Rows of the tables of the loop's report, as text ready to print."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from workbench.console.loop_text import angle_words, doubt_words, interval_words, plain, shape_words, value_words


def times(over: float) -> str:
    """An error over noise as text."""
    return f"{over:.2f} ×" if over < 9.995 else f"{over:.0f} ×"


def misfit_rows(before: Mapping[str, Any], after: Mapping[str, Any] | None = None) -> list[dict[str, str]]:
    """Errors by record set and channel, with those `after` beside them where there are any."""
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
        "over": times(m["over_noise"]) if m.get("over_noise") is not None else "",
        "fit": f"{percent:.2f} %" if percent is not None and math.isfinite(percent) else "",
    }


def parameter_rows(parameters: Mapping[str, Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Fitted values with their 95 % intervals, and a word where the records do not settle them."""
    return [
        {
            "key": key,
            "value": plain(q["value"], q["unit"]),
            "interval": interval_words(q).replace(" .. ", " … "),
            "word": doubt_words(q),
        }
        for key, q in parameters.items()
    ]


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
            "over": times(over),
            "bar": 100.0 * min(1.0, max(0.0, math.log(max(over, 1.0)) / span)),
            "chance": f"< {chance['below']}" if isinstance(chance, Mapping) else f"{chance:.3f}",
            "angle": angle_words(row),
            "parameters": value_words(row.get("parameters", {})),
        })  # fmt: skip
    return rows


def scored_only(ranking: Sequence[Mapping[str, Any]]) -> str:
    """Effects that were tried and looked too poor for the table, with what the score expected of each."""
    rest = [row for row in ranking if row.get("over_noise") is None]
    return ", ".join(f"{row['effect']} ({100 * row['expected_reduction']:.0f} %)" for row in rest)
