"""Findings of a comparison, a diagnosis or a search for the next motion, as sentences."""

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from sysid.compare import Comparison
from sysid.diagnose import Diagnosis
from sysid.diagnosis.candidate import Candidate
from sysid.diagnosis.constants import CURVE_MARGIN
from sysid.diagnosis.decision import FreeCurve
from sysid.diagnosis.ledger import Entry
from sysid.diagnosis.residual_maps import ResidualMap
from sysid.documents import WORTH_SAYING, channel_unit, parameter_unit, worst_channel
from sysid.estimation.misfit import ChannelMisfit, dominated_by_few_samples, worst_over_noise
from sysid.experiment_design.t_optimal_design import Suggestion
from workbench.operations.measurement.tables import over_noise_text, quantity_text

COORDINATE_NAMES = {
    "frequency": "one frequency",
    "direction": "direction of motion",
    "distance_since_reversal": "distance since the last reversal",
    "contact_age": "time of contact at rest",
}
"""Names of coordinates in a sentence, where they differ from their keys."""

NEGLIGIBLE_SHARE = 0.05
"""Share of the misfit below which the unexplained rest is not mentioned."""

MENTIONED_SHARE = 0.02
"""Share of the residual's variance from which a coordinate is mentioned."""

CLEARLY_WORSE = 1.5
"""Ratio of the error over noise on the fit records to that on the held-out ones from which both are stated."""

NEAR_NOISE = 1.5
"""Error over noise up to which detectable sizes are stated: above it the unexplained residual hides small effects."""

SEPARATED = 5.0
"""Standard deviations from which two competing effects count as separated."""

Errors = Mapping[str, ChannelMisfit]


def held_out_over_noise(fit: Errors, validate: Errors) -> float:
    """Largest error over noise on the held-out records; on the fit records where there are no others."""
    return worst_over_noise({}, dict(validate)) if validate else worst_over_noise(dict(fit), {})


def is_adequate(found: Comparison) -> bool:
    """Whether the residual of the model is at the noise level."""
    return worst_over_noise(found.fit, found.validate) <= NEAR_NOISE


def near_noise(diagnosis: Diagnosis) -> bool:
    """Whether the model, with the effect found in it, leaves little more than the noise."""
    best = diagnosis.best
    errors = (
        (diagnosis.before_fit, diagnosis.before_validate) if best is None else (best.after_fit, best.after_validate)
    )
    return worst_over_noise(*errors) <= NEAR_NOISE


def dependence_text(maps: Sequence[ResidualMap]) -> str:
    """The two coordinates the residual depends on most, with their shares; empty where there is none."""
    strongest = [m for m in maps if m.share > MENTIONED_SHARE][:2]
    names = [COORDINATE_NAMES.get(m.coordinate, m.coordinate.replace("_", " ")) for m in strongest]
    return " and ".join(f"{name} ({100 * m.share:.0f} %)" for name, m in zip(names, strongest))


def comparison_statement(found: Comparison) -> str:
    """The error of the model over the noise, and the coordinates on which its residual depends."""
    if is_adequate(found):
        most = worst_over_noise(found.fit, found.validate)
        return f"The error is {over_noise_text(most)} the noise: the residual is at the noise level."
    over = held_out_over_noise(found.fit, found.validate)
    text = f"The error is {over_noise_text(over)} the noise on the held-out records."
    fit = worst_over_noise(found.fit, {})
    if fit > CLEARLY_WORSE * over:
        text += f" On the fit records it is {over_noise_text(fit)}."
    if any(m.fit_percent < 0.0 for m in (*found.fit.values(), *found.validate.values())):
        text += " A fit below 0 %: the residual is larger than the variation of the signal."
    return f"{text} The residual depends on {dependence_text(found.maps) or 'no recorded coordinate'}."


def summary_sentence(errors: Mapping[str, Mapping[str, Any]], following: str = "") -> str:
    """The state of a model in one sentence: share of the variance explained, error over noise, what follows."""
    by_channel = {name: m for name, m in (errors.get("validate") or errors.get("fit", {})).items() if m["over_noise"]}
    if not by_channel:
        return following
    channel, worst = max(by_channel.items(), key=lambda item: item[1]["over_noise"])
    left = f"the error left is {over_noise_text(worst['over_noise'])} the noise"
    fit = worst.get("fit_percent")
    if fit is None or fit <= 0.0:
        return f"The model does not yet explain the {channel.replace('_', ' ')}; {left}. {following}".strip()
    explained = 100.0 * (1.0 - (1.0 - 0.01 * fit) ** 2)
    digits = 1 if explained > 99.0 else 0
    text = f"The model explains {min(explained, 99.9):.{digits}f} % of the variance of the {channel.replace('_', ' ')}"
    return f"{text}; {left}. {following}".strip()


def verdict_title(found: Diagnosis) -> str:
    """The verdict of a diagnosis in a few words."""
    none = "No effect is certain" if _possible(found) else "No effect of the library explains the residual"
    titles = {"adequate": "Nothing is missing", "unexplained": none}
    several = len(found.ledger.established) > 1
    missing = f"{established_text(found)} are missing" if several else f"{found.effect} is missing"
    return titles.get(found.verdict, missing)


def _possible(found: Diagnosis) -> Entry | None:
    """The effect that is possible with its own law and gains most, where none is certain."""
    able = (entry for entry in found.ledger.entries if entry.state == "possible" and not entry.is_another_law)
    return next(able, None) if found.best is None else None


def decision_line(found: Diagnosis) -> str:
    """The decision (`missing`, `adequate` or `unexplained`), a colon, and its statement."""
    statement = diagnosis_statement(found)
    if found.effect:
        return f"missing: {statement.replace(' is missing', '', 1).replace(' are missing', '', 1)}"
    return f"{found.verdict}: {statement}" if found.verdict != "adequate" else f"adequate: {_adequate_text(found)}"


def diagnosis_statement(found: Diagnosis) -> str:
    """The decision of a diagnosis with the errors behind it."""
    title = verdict_title(found)
    if found.verdict == "adequate":
        return f"{title}: {_adequate_text(found)}"
    depends = dependence_text(found.maps)
    if found.verdict == "unexplained" or found.best is None:
        possible, words = _possible(found), rivals_text(found)
        if possible is not None:
            words = "; ".join(filter(None, [f"{possible.name} is possible, but {possible.reason}", words]))
        return f"{title}: {words or found.reason}. The residual depends on {depends or 'no recorded coordinate'}."
    model = found.best if found.detected_by else found.ledger.model
    channel = _most_improved(found, model)
    before, after = found.before_validate[channel], model.after_validate[channel]
    unit = channel_unit(found.problem, channel)
    rms = f"{quantity_text(before.rms, unit)} to {quantity_text(after.rms, unit)}"
    ratio = f"from {over_noise_text(before.over_noise)} the noise to {over_noise_text(after.over_noise)}"
    error = f"the error of {channel.replace('_', ' ')} on the held-out records"
    them = "them" if len(found.ledger.established) > 1 else "it"
    if found.detected_by:
        return f"{title}: {found.detected_by}. With it {error} changes from {rms}, {ratio}."
    if dominated_by_few_samples(before, after):
        text = f"{title}. With {them} {error} falls {ratio}."
        text += f" (The plain rms, {rms}, is dominated by a few samples near velocity reversals.)"
    else:
        text = f"{title}. With {them} {error} falls from {rms}, {ratio}."
    fit = found.before_fit[channel].over_noise, model.after_fit[channel].over_noise
    if fit[0] > CLEARLY_WORSE * before.over_noise or fit[1] > CLEARLY_WORSE * after.over_noise:
        text += f" On the fit records it falls from {over_noise_text(fit[0])} to {over_noise_text(fit[1])}."
    text += _remainder_text(found, after)
    worst, other = max(model.after_validate.items(), key=lambda item: item[1].over_noise)
    if other.over_noise > max(CLEARLY_WORSE * after.over_noise, NEAR_NOISE):
        text += f" That of {worst.replace('_', ' ')}, {over_noise_text(other.over_noise)} the noise, is not explained."
    if depends:
        text += f" Without {them} the residual depends on {depends}."
    return text


def _most_improved(found: Diagnosis, model: Candidate) -> str:
    """The channel whose error over noise a model reduces by the largest factor."""
    before, after = found.before_validate, model.after_validate
    improved = {c: before[c].over_noise / max(after[c].over_noise, 1e-9) for c in before if c in after}
    return max(improved, key=lambda c: improved[c]) if improved else worst_channel(found.problem, before)


def _adequate_text(found: Diagnosis) -> str:
    """Why a model is adequate; its error where it is above the noise, and what it means where the fit has less."""
    held, fit = held_out_over_noise(found.before_fit, found.before_validate), worst_over_noise(found.before_fit, {})
    if held <= NEAR_NOISE:
        return f"{found.reason}."
    text = f"{found.reason}. The error is {over_noise_text(held)} the noise on the held-out records"
    if held <= CLEARLY_WORSE * fit:
        return f"{text}."
    return (
        f"{text} and {over_noise_text(fit)} on those of the fit: they differ in something that is not in the model, "
        "such as the temperature or the wear at their first row."
    )


def established_text(found: Diagnosis) -> str:
    """The effects that certainly act, largest gain first, each with the number of its periods."""
    count = Counter(entry.name for entry in found.ledger.established)
    names = [name if many == 1 else f"{name} ({many} periods)" for name, many in count.items()]
    return f"{', '.join(names[:-1])} and {names[-1]}" if len(names) > 1 else "".join(names)


def _remainder_text(found: Diagnosis, after: ChannelMisfit) -> str:
    """How much of the signal is explained, how much of the misfit is left, and on what that depends."""
    left = found.unexplained_share
    text = f" The model then explains {after.fit_percent:.0f} % of the signal" if after.fit_percent > 0.0 else ""
    if left <= NEGLIGIBLE_SHARE:
        return f"{text}." if text else ""
    text += f"{' and' if text else ' It'} leaves {100 * left:.0f} % of the misfit"
    if found.ledger.coordinate:
        name = COORDINATE_NAMES.get(found.ledger.coordinate, found.ledger.coordinate.replace("_", " "))
        text += f", which depends on {name}"
    return f"{text}."


def rivals_text(found: Diagnosis) -> str:
    """Shares of the misfit that the best free curve and the best named effect explain; empty without any."""
    curve, named = _better_curve(found), found.best_named
    parts = []
    if curve is not None:
        name = COORDINATE_NAMES.get(curve.coordinate, curve.coordinate.replace("_", " "))
        share = f"{100 * curve.share:.0f} % of the misfit"
        parts.append(f"a free curve, a {curve.quantity} of {name}, explains {share}")
    if named is not None and named[1] > NEGLIGIBLE_SHARE:
        verb, what = ("", "") if parts else (" explains", " of the misfit")
        parts.append(f"the best named effect, {named[0]},{verb} {100 * named[1]:.0f} %{what}")
    return ", ".join(parts)


def _better_curve(found: Diagnosis) -> FreeCurve | None:
    """The best free curve where it explains clearly more than the best named effect."""
    curve, named = found.free_curve, found.best_named[1] if found.best_named else 0.0
    return curve if curve is not None and curve.share > max(NEGLIGIBLE_SHARE, named + CURVE_MARGIN) else None


def in_command(folder: Path) -> str:
    """A folder as an argument of a printed command: in quotes where it contains blanks."""
    return f'"{folder}"' if " " in str(folder) else str(folder)


def next_step_statement(found: Diagnosis) -> str:
    """Possible next steps where more is missing than the effect named, or nothing is named; else empty."""
    folder = in_command(found.problem.experiment.folder)
    if found.best is not None and len(found.ledger.established) > 1:
        return f"To add them one after the other: 'stagecad add {folder} --all'."
    if found.best is not None and found.unexplained_share > NEGLIGIBLE_SHARE:
        return f"More is missing: run 'stagecad add {folder} {found.effect}', then 'stagecad diagnose {folder}' again."
    if found.verdict != "unexplained":
        return ""
    curve, named, possible = _better_curve(found), found.best_named, _possible(found)
    name = possible.name if possible else named[0] if named and named[1] > NEGLIGIBLE_SHARE else ""
    ways = []
    if name:
        ways.append(f"if {name} is certainly present, run 'stagecad add {folder} {name}' and diagnose again")
    if curve is not None:
        name = COORDINATE_NAMES.get(curve.coordinate, curve.coordinate.replace("_", " "))
        ways.append(f"declare an effect of your own, a {curve.quantity} of {name} ([model] custom)")
    shifts = any(m.coordinate == "acceleration" and m.share > MENTIONED_SHARE for m in found.maps)
    if shifts and any(unknown.key == "rig.mass" for unknown in found.problem.start.unknowns):
        key = "inertia" if found.problem.experiment.rig.rotary else "mass"
        ways.append(f"state the {key} under [rig.known]: it is fitted, and what the model lacks shifts it")
    if any(noise.source != "given" for noise in found.problem.noise.values()):
        ways.append("state the noise of the sensors under [noise], which is only estimated")
    return f"What to do: {'; or '.join(ways)}." if ways else ""


def equivalence_statement(found: Diagnosis) -> str:
    """Effects that these records cannot distinguish from the one named; empty where there is none."""
    names = list(found.indistinguishable)
    if not names or not found.effect:
        return ""
    return (
        f"These records cannot distinguish {found.effect} from {' or '.join(names)}: the difference on the held-out "
        "records is not significant. 'stagecad suggest' looks for a motion that separates them."
    )


def replacement_statements(diagnosis: Diagnosis) -> list[str]:
    """Effects added earlier that should be removed or replaced."""
    lines = []
    for swap in diagnosis.replacements:
        before, after = over_noise_text(swap.before), over_noise_text(swap.after)
        change = f"({before} to {after} the noise on the held-out records)"
        if swap.new is None:
            lines.append(f"{swap.old}, added earlier, is no longer needed {change}: add --drop {swap.old}")
        else:
            lines.append(
                f"{swap.new} in place of {swap.old}, added earlier, explains more {change}: "
                f"add {swap.new} --drop {swap.old}"
            )
    return lines


def unphysical_statements(diagnosis: Diagnosis) -> list[str]:
    """Effects that would reduce the error only with a value beyond its physical range.

    With a named effect, only those that would explain at least half as much as it does.
    """
    named = 1.0 - diagnosis.unexplained_share if diagnosis.best is not None else 0.0
    least = max(WORTH_SAYING, 0.5 * named)
    lines = []
    for trial in diagnosis.trials[:12]:
        amplitude = next((p for p in trial.effect.parameters if p.role == "amplitude"), None)
        predicted, blocked = trial.reductions
        if amplitude is not None and blocked >= least and blocked > 2.0 * predicted:
            error = 100.0 * (1.0 - (1.0 - min(blocked, 1.0)) ** 0.5)
            unit = parameter_unit(diagnosis.problem, f"{trial.effect.name}.{amplitude.name}")
            lines.append(
                f"{trial.public_name} would lower the error by {error:.0f} %, but only with a {amplitude.name} below "
                f"{amplitude.low:g} {unit}, which is not physical."
            )
    return lines


def suggestion_statements(found: Suggestion) -> list[str]:
    """The next motion, or why none is needed."""
    lines = []
    if found.revisited:
        lines.append(
            f"Nothing is missing now; {found.revisited}, added last, is compared with effects that could replace it."
        )
    if len(found.competing) < 2:
        state = {
            "adequate": "the residual is at the noise level, and no effects compete",
            "unexplained": "no effect of the library explains the residual, so none compete",
        }.get(found.diagnosis.verdict, f"no other effect competes with {found.diagnosis.effect}")
        return [*lines, f"{state}: the space-filling motion covers what these records do not contain."]
    for name in found.inseparable:
        lines.append(
            f"no motion of this family separates {found.competing[0]} from {name}: on this rig, with these channels, "
            "they are equivalent."
        )
    best = found.motions[0]
    for pair in best.pairs:
        if pair.effects[1] not in found.inseparable:
            lines.append(
                f"run {best.motion.name}: separates {pair.effects[1]} from {pair.effects[0]} at "
                f"{_sigma(pair.deviations)} in {best.motion.seconds:.0f} s; these records: {_sigma(pair.records)}"
                + (" (already separated)" if pair.records >= SEPARATED else "")
            )
    return lines


def _sigma(deviations: float) -> str:
    return f"{deviations:.1f} sigma" if deviations < 100.0 else f"{deviations:.0f} sigma"
