"""Ledger of a diagnosis: the effects that are missing from a model, each with its state and its evidence.

A set S of effects is found by forward selection: the effect that lowers the held-out loss most is added, all values are
refitted, and again, until no effect gains significantly. With L0 the loss of the stated model, L that of the model with
S, L- that of the model without the effect e of S, refitted, and n the loss of noise,

    gain g = L- - L,   share = g / (L0 - n),   own share q = g / (L- - n),   explained T = (L0 - L) / (L0 - n),

L0 in T that of the model before any effect was added.

q is what the effect removes of what is left without it: a true effect of one percent of the misfit removes most of what
is left, once the others are in S; a mimic does not. The evidence of an effect (`Evidence`) is compared with the limits
of `judge`.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np

from sim.effects.effect import Coordinate, Effect
from sysid.diagnosis import constants as limits
from sysid.diagnosis.candidate import Candidate, Reference, simplest, ties
from sysid.diagnosis.held_out import HeldOut, Transfer, transfer
from sysid.diagnosis.model_search import ModelSearch
from sysid.diagnosis.residual_maps import explained_variance, is_local
from sysid.estimation.covariance import Intervals, has_size, implausible, intervals
from sysid.estimation.fit import FittedModel
from sysid.estimation.misfit import blocks, huber_square, scored_channels, worst_over_noise
from sysid.prediction.model import Model, public_name

State = Literal["established", "possible", "refused"]


@dataclass(frozen=True)
class Evidence:
    """Evidence of one effect of a set; symbols as above."""

    # gain, share, own_share: g, share and q
    gain: float
    share: float
    own_share: float
    above_noise: float  # losses without it over those of noise
    held: Transfer  # transfer to the held-out records
    fit: Transfer  # the same on the records of the fit
    # the same with the roles of the records exchanged; none where there are blocks enough
    exchanged: Transfer | None = None
    form: float = 0.0  # gain of the best free curve of its coordinates on S, over that of the largest effect with one
    similar: bool = False  # whether a larger effect of S has one of its coordinates; false for one with copies in S
    floor: float = 0.0  # loss that the form errors of the other effects may leave in its coordinates
    local: bool = False  # whether it and its copies cancel over most of the travel
    margin: float = np.inf  # loss of gain by the best other effect in its place, over g; infinite where none was tried
    sized: bool = True  # whether its fitted size and scales differ from zero
    form_of: str = ""  # coordinate of a larger effect, by a free curve of which it may be replaced; empty for none
    implausible: str = ""  # reason why its values are implausible; empty if they are not

    @property
    def z(self) -> float:
        """Significance on both sets of records together; of one set, on its parts that are left out."""
        return self._on_both(self.held.z, self._other.z)

    @property
    def z_of_half(self) -> float:
        """The same of an effect of half its size."""
        return self._on_both(self.held.z_of_half, self._other.z_of_half)

    @property
    def _other(self) -> Transfer:
        return self.exchanged or self.fit

    def _on_both(self, held: float, other: float) -> float:
        return held if self.fit is self.held else (held + other) / np.sqrt(2.0)

    @property
    def p_value(self) -> float:
        """One-sided p value of that significance."""
        return replace(self.held, z=self.z).p_value

    @property
    def on_others(self) -> float:
        """Significance on records to which it was not fitted, with either role of the records; none if it loses."""
        others = [self.held.z] if self.exchanged is None else [self.held.z, self.exchanged.z]
        return max(others) if min(others) > 0.0 else 0.0


@dataclass(frozen=True)
class Entry:
    """One effect of the ledger."""

    effect: Effect  # the effect
    state: State  # whether it certainly acts
    reason: str  # of the state, as text
    model: Candidate  # the model in which it was judged
    evidence: Evidence | None = None  # numbers; none for an effect that was detected by other means
    ties: tuple[str, ...] = ()  # public names of effects that these records cannot distinguish from it
    # that model without the effect, refitted; none for an effect that was detected by other means
    below: Candidate | None = None
    words: str = ""  # method of detection as text, if not a reduction of the error

    @property
    def name(self) -> str:
        """Its public name."""
        return public_name(self.effect.name)

    @property
    def is_another_law(self) -> bool:
        """Whether a free curve of its coordinates shows that its law is not the true one."""
        return self.evidence is not None and self.evidence.form > limits.MOST_FORM_ERROR

    @property
    def gain(self) -> float:
        """Reduction of the held-out loss; infinite for an effect that was detected by other means."""
        return np.inf if self.evidence is None else self.evidence.gain


@dataclass(frozen=True)
class Ledger:
    """The ledger of a stated model."""

    entries: tuple[Entry, ...]  # established effects first, each group by decreasing marginal gain
    model: Candidate  # the stated model with the established effects; without any, the stated model itself
    explained: float = 0.0  # part of the excess that they remove; 0 without an excess
    coordinate: str = ""  # recurring coordinate whose free curve gains most on top of them; empty for none

    @property
    def established(self) -> tuple[Entry, ...]:
        """The effects that certainly act."""
        return tuple(entry for entry in self.entries if entry.state == "established")


def above_noise(search: ModelSearch, losses: Sequence[float], least: Sequence[float] = (1.0, 1.0)) -> float:
    """Ratio of the loss of a model to that of noise, as far as the level of the noise is known: the larger one of the
    held-out records and those of the fit.

    The loss of noise is at most `least`, that of some model. It is also at most the loss with the best single effect:
    along a wrong model the deviations of the residual are too large. This holds only if the effect leaves the noise of
    the sensors or more: otherwise that is smaller than stated, or no noise, as rounding.
    """
    best = [_losses(candidate) for candidate in search.ranked[:1] if _leaves_noise(candidate)]
    factor = limits.KNOWN_NOISE_LOSS if search.problem.noise_is_known else limits.NEAR_NOISE_LOSS
    return max(loss / (factor * min(noise)) for loss, *noise in zip(losses, least, *best, strict=True))


def _losses(candidate: Candidate) -> tuple[float, float]:
    """Losses of a model on the held-out records and those of the fit."""
    return candidate.held_out.loss, candidate.fit_loss


def _leaves_noise(candidate: Candidate) -> bool:
    """Whether what a model leaves of each channel is the noise of its sensor or more, as far as its level is known."""
    sizes = [one.over_sensor_noise for one in candidate.after_validate.values()]
    return all(size is not None and limits.NEAR_NOISE_LOSS * size**2 >= 1.0 for size in sizes)


def judge(evidence: Evidence, explained: float, refuted_by: str = "") -> tuple[State, str]:
    """State of an effect, and its reason as text, by its evidence, by T of its set, and by the free curve that explains
    clearly more than the set, as text; empty for none."""
    e, half, known = evidence, explained < 0.5, explained >= limits.WELL_EXPLAINED
    strict = not known or e.own_share < 0.5
    largest, form = (1.5, 0.5 * limits.MOST_FORM_ERROR) if half else (limits.MOST_AMPLITUDE, limits.MOST_FORM_ERROR)
    if e.implausible:
        return "refused", e.implausible
    if e.z < limits.CERTAIN_Z:
        return "refused", f"its gain is not significant ({e.z:.1f} standard deviations on all records)"
    if min(e.fit.z, e.on_others) < limits.EACH_Z:
        each = f"{e.fit.z:.1f} standard deviations on the records of the fit, {e.on_others:.1f} on others"
        return "refused", f"its gain is significant on some of the records only ({each})"
    conditions = (
        (
            not strict or e.z_of_half >= limits.CERTAIN_Z,
            f"half of its gain would not be significant ({e.z_of_half:.1f} standard deviations on all records)",
        ),
        (
            1.0 / largest <= e.held.amplitude <= largest,
            f"on the held-out records it acts with {e.held.amplitude:.2g} times its fitted size",
        ),
        (e.form <= form, f"a free curve of its coordinate gains {100 * e.form:.0f} % more: its law is another"),
        (not e.local, "its waves cancel over most of the travel: they describe a force at one place"),
        (e.gain >= e.floor, "the error of the form of the other effects may leave as much"),
        (e.above_noise > 1.0, "what is left without it is noise, as far as its level is known"),
        (
            e.own_share >= (limits.LEAST_OWN_SHARE if known and not e.similar else 0.5),
            f"it removes only {100 * e.own_share:.0f} % of what is left without it",
        ),
        (not half or e.margin >= 0.3, "another effect in its place explains nearly as much"),
        (not refuted_by, refuted_by),
        (
            not e.form_of,
            f"a free curve of {e.form_of}, the coordinate of a larger effect, explains more in its place, and beside "
            "that it gains nothing: the law of the larger effect may be another",
        ),
        (e.sized, "its size, or its width, is not distinguishable from zero beside the other values"),
    )
    failed = next((words for passed, words in conditions if not passed), "")
    if failed:
        return "possible", failed
    return "established", f"it removes {100 * min(e.own_share, 1.0):.0f} % of what is left without it"


@dataclass(frozen=True)
class _Set:
    """A set of effects on top of a stated model."""

    search: ModelSearch  # models
    noise: float  # loss of a complete model
    added: tuple[str, ...]  # names of the effects of the stated model that were added to it before
    model: Candidate  # the model with the set
    recurring: frozenset[Coordinate]  # coordinates whose values recur
    first: HeldOut  # residual of the stated model without the effects that were added to it before
    channel: str = ""  # channel on which it is judged; empty for all

    @cached_property
    def channels(self) -> list[str]:
        """Channels that are compared, where there are several."""
        found = sorted(set(scored_channels(self.search.base.weights).tolist()))
        return found if len(found) > 1 else []

    @cached_property
    def _held_rows(self) -> np.ndarray:
        channels = scored_channels(self.search.base.weights)
        return (channels == self.channel) | (self.channel == "")

    @cached_property
    def _fit_rows(self) -> np.ndarray:
        channels = scored_channels(self.search.base.fitted.weights)
        return (channels == self.channel) | (self.channel == "")

    def held(self, candidate: Candidate | Reference) -> HeldOut:
        """Held-out residual of a model on the channel."""
        return candidate.held_out.at(self._held_rows) if self.channel else candidate.held_out

    @cached_property
    def whole(self) -> HeldOut:
        """Held-out residual of the model with the set on the channel."""
        return self.held(self.model)

    @cached_property
    def intervals(self) -> Intervals:
        """Intervals of the values of the model with the set."""
        return intervals(self.model.fitted, self.search.problem.fit_records)

    @cached_property
    def explained(self) -> float:
        """The part of the excess of the stated model that the set removes."""
        return self._part_of(self.held(self.search.reference).loss)

    @cached_property
    def known(self) -> float:
        """T, the part of the excess of the model before any addition that the effects added before and the set remove:
        the state of an effect does not depend on whether another one was added before it or is found with it."""
        return max(self.explained, self._part_of(self.first.at(self._held_rows).loss))

    def _part_of(self, before: float) -> float:
        return (before - self.whole.loss) / max(before - min(self.noise, self.whole.loss), 1e-9)

    @cached_property
    def refuted_by(self) -> str:
        """Free curve that explains clearly more than the set, as text; one of their own is then a matter of form."""
        own = {name for effect in self.model.added for name in effect.coordinates}
        excess = self.held(self.search.reference).loss - self.noise
        for curve in self.search.curves:
            name = curve.added[0].coordinates[0]
            gain = self.whole.gain_of(self.held(curve))
            rival = name in self.recurring and (self.known < limits.WELL_EXPLAINED or name not in own)
            if rival and gain.loss > limits.CURVE_MARGIN * excess and gain.z >= limits.CERTAIN_Z:
                return f"a free curve of {name} explains more than all effects found"
        return ""

    def evidence(self, effect: Effect) -> Evidence | None:
        """Evidence of one of its effects."""
        search, model = self.search, self.model
        below = search.without(model, effect.name)
        if below is None:
            return None
        without = self.held(below)
        gain = without.gain_of(self.whole)
        rows = self._fit_rows
        number = blocks(search.problem.fit_records, search.base.fitted.weights)[rows]
        worse, better = (one.fitted.fit.residual[rows] for one in (below, model))
        fit = gain if search.problem.crossed else transfer(worse, better, number)
        few = not search.problem.crossed and gain.z < 2.0 * limits.CERTAIN_Z and min(gain.z, fit.z) > 0.0
        return Evidence(
            gain=gain.loss,
            share=gain.loss / max(self.held(search.reference).loss - self.noise, gain.loss, 1e-9),
            own_share=gain.loss / max(without.loss - min(self.noise, self.whole.loss), 1e-9),
            above_noise=above_noise(
                search,
                [without.loss, float(np.mean(huber_square(worse)))],
                [min(1.0, self.whole.loss), min(1.0, float(np.mean(huber_square(better))))],
            ),
            held=gain,
            fit=fit,
            exchanged=self._exchanged(below) if few else None,
            form=self._form(effect),
            floor=self.floor(below, model, model),
            similar=model.families.count(public_name(effect.name)) == 1
            and any(self._gain(e) > gain.loss for e in model.added if set(e.coordinates) & set(effect.coordinates)),
            local=self._is_local(effect),
            implausible=_implausible(model.fitted, effect),
        )

    def _is_local(self, effect: Effect) -> bool:
        """Whether a periodic effect and its copies in the set describe together what acts at one place."""
        family = public_name(effect.name)
        copies = effect.is_periodic and self.model.families.count(family) > 1
        without = self.search.without(self.model, family) if copies else None
        if without is None:
            return False
        change = without.held_out.residual - self.model.held_out.residual
        return is_local(change, self.search.problem.validate_records, self.search.base.weights)

    def _exchanged(self, below: Candidate) -> Transfer | None:
        """Transfer from the held-out records to those of the fit."""
        without, with_it = self.search.exchanged(below), self.search.exchanged(self.model)
        rows = self._fit_rows
        return None if without is None or with_it is None else without.at(rows).gain_of(with_it.at(rows))

    def _form(self, effect: Effect) -> float:
        """Gain of the best free curve of the effect's own coordinates on top of the set, over that of the largest
        effect of the same coordinate; its first coordinate counts even where that does not recur."""
        own = (self.recurring & set(effect.coordinates)) | set(effect.coordinates[:1])
        largest = {q: max(self._gain(e) for e in self.model.added if q in e.coordinates) for q in own}
        if not own or self.whole.loss - self.noise <= 0.5 * limits.MOST_FORM_ERROR * min(largest.values()):
            return 0.0
        curves = self.search.with_curves(self.model, own)
        gains = [(c.added[-1].coordinates[0], self.whole.gain_of(self.held(c))) for c in curves]
        return max((g.loss / max(largest[q], 1e-12) for q, g in gains if g.z >= limits.STEP_Z), default=0.0)

    def replaced_by_form(self, effect: Effect) -> str:
        """Coordinate of a larger effect whose free curve leaves less in the place of an effect on a signal, which gains
        nothing on top of that curve. A signal has the forces of all effects: what an effect on it explains may be an
        error of the form of the larger one. Empty for none."""
        below, gain = self.search.without(self.model, effect.name), self._gain(effect)
        larger = [e for e in self.model.added if self._gain(e) > gain] if effect.signal is not None and below else []
        places = {q for e in larger for q in e.coordinates} & self.recurring
        for curve in self.search.with_curves(below, places) if below and places else ():
            law = curve.added[-1]
            place, kind = law.coordinates[0], law.acts_on
            of_larger = any(place in e.coordinates and kind == e.acts_on for e in larger)
            if of_larger and _gains(self.whole.gain_of(self.held(curve))):
                both = next((c for c in self.search.with_curves(self.model, {place}) if c.added[-1] == law), curve)
                if not _gains(self.held(curve).gain_of(self.held(both))):
                    return place
        return ""

    def _gain(self, effect: Effect) -> float:
        below = self.search.without(self.model, effect.name)
        return 0.0 if below is None else self.held(below).loss - self.whole.loss

    def floor(self, below: Candidate, larger: Candidate, known: Candidate) -> float:
        """Loss that a relative error `FORM_ERROR` of the other effects of a model leaves, in as far as what the larger
        of two models changes is a function of their coordinates.

        The contribution of an effect is the change of the residual without it, all other values refitted: what these
        take up is no error of its form. A change of which only the share s is a function of the coordinates takes up at
        most that share of the error e^2 of a form: the rest is left, so that s e^2 <= s / (1 - s) (L - n), with L the
        loss of the larger model.
        """
        search = self.search
        records, weights, rows = search.problem.validate_records, search.base.weights, self._held_rows
        change, total = below.held_out.residual - larger.held_out.residual, 0.0
        residual = larger.held_out.residual[rows]
        none = float(np.mean(huber_square(residual)))
        for other in below.fitted.model.effects:
            if other.name not in (*below.names, *self.added):
                continue
            shared = explained_variance(change, records, weights, other)
            rest = search.without(known, other.name) if shared > 0.0 else None
            if rest is not None:
                error = limits.FORM_ERROR * (rest.held_out.residual - known.held_out.residual)[rows]
                one, opposite = (float(np.mean(huber_square(residual + s * error))) for s in (1.0, -1.0))
                left = max(none - self.noise, 0.0) / max(1.0 - shared, 1e-9)
                total += shared * min(max(0.5 * (one + opposite) - none, 0.0), left)
        return total

    def rivals(self, effect: Effect) -> list[Candidate]:
        """The set with another effect in the place of one, best first."""
        below = self.search.without(self.model, effect.name)
        found = [] if below is None else self.search.in_place(self.model, below)
        taken = {*self.model.families}
        return [c for c in found if c.implausible is None and public_name(c.added[-1].name) not in taken]


def make_ledger(search: ModelSearch, noise: float, added: Sequence[str], recurring: frozenset[Coordinate]) -> Ledger:
    """The ledger of a stated model; the arguments are fields of `_Set`."""
    none = _Set(search, noise, tuple(added), search.stated, recurring, search.before(added))
    selected = _selected(none, search.ranked)
    whole, entries = _judged_set(none, selected)
    for single in (False, True):
        if above_noise(search, _losses(whole.model)) <= 1.0:
            break
        # A mimic of several effects may gain more than any of them alone: the search begins again with pairs, and with
        # the second single effect. What predicts the held-out records worse than the first set explains no more.
        begin = search.ranked[1:2] if single else [pair for pair in search.pairs if is_step(whole.model, pair)]
        other, of_other = _judged_set(none, _selected(none, begin))
        worse = selected.held_out.gain_of(other.model.held_out).z <= -limits.STEP_Z
        if other.model.added and not worse and is_step(whole.model, other.model):
            whole, entries = other, of_other
    model = search.converged(whole.model) if whole.model.added else search.stated
    order = {"established": 0, "possible": 1, "refused": 2}
    entries.sort(key=lambda entry: (order[entry.state], -entry.gain))
    curves = [c for c in search.with_curves(model, recurring) if c.held_out.loss < model.held_out.loss]
    return Ledger(
        entries=tuple(entries),
        model=model,
        explained=min(1.0, max(replace(whole, model=model).explained, 0.0)) if model.added else 0.0,
        coordinate=curves[0].added[-1].coordinates[0] if curves else "",
    )


def _judged_set(whole: _Set, model: Candidate) -> tuple[_Set, list[Entry]]:
    """The largest part of a set of effects in which all are established, with an entry for each of the set."""
    whole, entries, beside = replace(whole, model=model), [], {}
    while whole.model.added:
        judged = [entry for effect in whole.model.added if (entry := _judged(whole, effect)) is not None]
        # What is certain beside an effect whose law is another one remains so without it, as long as it is significant.
        judged = [beside.get(entry.effect.name, entry) if entry.state == "possible" else entry for entry in judged]
        judged.sort(key=lambda entry: -entry.gain)
        if not judged:
            return replace(whole, model=whole.search.stated), entries
        doubted = [entry for entry in judged if entry.state != "established"]
        if not doubted:
            return whole, [*judged, *entries]
        # A law that is another one may have taken what an effect gains that is only not significant beside it.
        weakest = min(doubted, key=lambda entry: (not entry.is_another_law, entry.gain))
        certain = {entry.effect.name: entry for entry in judged if entry.state == "established"}
        beside = certain if weakest.state == "possible" and weakest.is_another_law else {}
        # It may replace one of the others: the rest is judged without it. What gained by them alone is no finding.
        entries = [weakest, *entries] if weakest.evidence and weakest.evidence.held.z >= limits.EACH_Z else entries
        rest = whole.search.without(whole.model, weakest.effect.name) or whole.search.stated
        whole = replace(whole, model=exchanged(whole.search, rest) if rest.implausible else rest)
    return whole, entries


def _selected(whole: _Set, begin: Sequence[Candidate]) -> Candidate:
    """The model with the set of effects found by forward selection, which begins with one of the candidates `begin`.

    After each step an effect is exchanged as long as that is a step too: an effect, or its variant, that was the best
    one while others were missing may not be so beside them (floating search, Pudil, Novovicova and Kittler 1994).
    """
    search, model = whole.search, whole.search.stated
    while len(model.added) < limits.MOST_EFFECTS and above_noise(search, _losses(model)) > 1.0:
        options = [c for c in (search.step(model) if model.added else begin) if is_step(model, c)]
        options = [c for c in options if model.held_out.loss - c.held_out.loss >= whole.floor(model, c, model)]
        while options:
            # At its minimum an effect may have implausible values that its first steps have not, and on whole records
            # of a driven stage it may gain nothing.
            found = search.converged(option := simplest(model, options))
            if found.implausible is None and found.held_out.loss < model.held_out.loss:
                break
            options.remove(option)
        if not options:
            break
        model = exchanged(search, found)
    return model


def exchanged(search: ModelSearch, model: Candidate) -> Candidate:
    """A set of effects with others in the place of some of them, where each exchange is a step, or, of a set with
    implausible values, a step over the rest of it."""
    while model.added:
        settled = len(model.added) < 2 or above_noise(search, _losses(model)) <= 1.0
        if settled and not model.implausible:
            break
        below = [other for e in model.added if (other := search.without(model, e.name)) is not None]
        options = [c for o in below for c in search.in_place(model, o) if is_step(o if model.implausible else model, c)]
        found = search.converged(simplest(model, options)) if options else model
        if found.implausible or not (model.implausible or is_step(model, found)):
            break
        model = found
    return model


def _gains(gain: Transfer) -> bool:
    """Whether a model leaves less, significantly: a part of its difference may gain where all of it loses."""
    return gain.loss > 0.0 and gain.z >= limits.STEP_Z


def is_step(model: Candidate, larger: Candidate) -> bool:
    """Whether a larger model gains enough to be a step of the selection: significantly, or, as beside other missing
    effects none may be significant, as much as the largest of `MOST_EFFECTS`."""
    gain = model.held_out.gain_of(larger.held_out)
    shares = gain.loss / model.held_out.loss, 1.0 - larger.fit_loss / model.fit_loss
    clear = min(shares) >= 1.0 / limits.MOST_EFFECTS or (
        shares[0] >= limits.STEP_GAIN and shares[1] > 0.0 and gain.z >= limits.STEP_Z
    )
    return larger.implausible is None and clear


def _judged(whole: _Set, effect: Effect) -> Entry | None:
    """An effect with its state. What one channel shows alone, and no other contradicts, is established: a channel that
    no model explains is no evidence against it."""
    entry = _judged_on(whole, effect)
    if entry is None or entry.state != "possible":
        return entry
    channels = [_judged_on(replace(whole, channel=channel), effect) for channel in whole.channels]
    alone = [other for other in channels if other is not None and other.evidence is not None]
    if any(other.evidence.held.z <= -limits.EACH_Z for other in alone if other.evidence is not None):
        return entry
    return next((other for other in alone if other.state == "established"), entry)


def _judged_on(whole: _Set, effect: Effect) -> Entry | None:
    evidence = whole.evidence(effect)
    if evidence is None:
        return None
    state, reason = judge(evidence, whole.known, whole.refuted_by)
    tied: tuple[str, ...] = ()
    if state == "established" and (evidence.share >= limits.LEAST_OWN_SHARE or whole.known < 0.5):
        rivals = whole.rivals(effect)
        behind = [(whole.held(c).loss - whole.whole.loss) / evidence.gain for c in rivals]
        evidence = replace(evidence, margin=min(behind, default=np.inf))
        tied = ties(rivals, whole.model, evidence.gain)
    if state == "established":
        sized = has_size(whole.intervals, effect)
        evidence = replace(evidence, sized=sized, form_of=whole.replaced_by_form(effect))
        state, reason = judge(evidence, whole.known, whole.refuted_by)
    if whole.channel and state == "established":
        reason += f" on {whole.channel.replace('_', ' ')}"
    below = whole.search.without(whole.model, effect.name)
    return Entry(effect, state, reason, whole.model, evidence, tied, below)


def _implausible(fitted: FittedModel, effect: Effect) -> str:
    """Reason why the values of an effect are implausible, as text; empty if they are not."""
    if effect.is_mode and fitted.model.values.get(f"{effect.name}.damping", 0.0) > limits.MOST_DAMPING:
        return f"its damping ratio exceeds {limits.MOST_DAMPING:g}: it is a filter, not a mode"
    return implausible(fitted, [effect.name]) or ""


@dataclass(frozen=True)
class Replacement:
    """An effect of the model, added earlier, that should be removed or replaced."""

    old: str  # its name
    new: str | None  # its replacement; none where it is not needed
    # before, after: error over noise on the held-out records, without and with the replacement
    before: float
    after: float


def find_replacements(search: ModelSearch, added: Sequence[str], others_too: bool = True) -> list[Replacement]:
    """Effects added earlier that are not needed, or in whose place another one gains clearly more."""
    stated, found = search.stated, []
    for name in added:
        family = public_name(name)
        below = search.without(stated, family) if _is_removable(stated.fitted.model, family) else None
        if below is None:
            continue
        gain = below.held_out.gain_of(stated.held_out)
        needed = gain.loss >= limits.LEAST_GAIN * below.held_out.loss or gain.z >= limits.CERTAIN_Z
        options = [search.converged(c) for c in search.step(below)] if needed and others_too else []
        best = min(options, key=lambda c: c.held_out.loss, default=None) if needed else below
        if best is not None and (not needed or _clearly_better(stated, best)):
            before = worst_over_noise({}, stated.after_validate)
            new = best.public_name if best.added else None
            found.append(Replacement(name, new, before, worst_over_noise({}, best.after_validate)))
    return found


def _is_removable(model: Model, family: str) -> bool:
    """Whether an effect acts in the fitted model, is not a friction state, and was estimated from these residuals."""
    present = any(public_name(e.name) == family and e.friction_state is None for e in model.effects)
    own = [u for u in model.unknowns if public_name(u.key.rpartition(".")[0]) == family]
    # An effect detected outside these residuals, such as a mode above the filter band, has priors on all its values.
    return present and not (own and all(u.prior is not None for u in own))


def _clearly_better(stated: Candidate, other: Candidate) -> bool:
    loss = stated.held_out.loss
    least = max(limits.CURVE_MARGIN * (loss - 1.0), limits.LEAST_GAIN * loss)
    return other.gain.z >= limits.CERTAIN_Z and other.gain.loss > least
