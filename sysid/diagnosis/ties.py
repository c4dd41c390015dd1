"""Effects that tie: whose gains the records do not distinguish, and which of them is taken."""

from collections.abc import Sequence

from sysid.diagnosis.candidate import Candidate
from sysid.diagnosis.constants import STEP_Z
from sysid.estimation.covariance import is_determined
from sysid.prediction.model import public_name

TIE = 0.03
"""Largest loss of gain, over the gain, by another effect in the place of one that is indistinguishable from it."""


def simplest(model: Candidate, options: Sequence[Candidate]) -> Candidate:
    """The simplest of the candidates whose gain over a model hardly differs from the largest."""
    best = min(options, key=lambda c: c.loss)
    tied = [c for c in options if is_tied(c, best, max(model.loss - best.loss, 0.0))]

    def complexity(one: Candidate) -> tuple[bool, int, bool, float]:
        # A law whose values are determined only together acts in a limit that a simpler law states: a friction that
        # never slides is a spring. In one direction of motion one that depends on the position is the same as a force.
        effect = one.added[-1]
        return not is_determined(one.fitted, effect.name), one.parameter_count, effect.factor is not None, one.loss

    return min(tied, key=complexity)


def is_tied(other: Candidate, best: Candidate, gained: float) -> bool:
    """Whether the gain of another candidate differs insignificantly from the best one's, `gained`."""
    behind = other.loss - best.loss
    return behind <= 0.1 * TIE * gained or (behind <= TIE * gained and other.held_out.gain_of(best.held_out).z < STEP_Z)


def ties(rivals: Sequence[Candidate], model: Candidate, gained: float) -> tuple[str, ...]:
    """Up to two effects that tie with the one whose place in the model the rivals take, which gains `gained`."""
    # One with more parameters that gains no more contains this effect.
    simple = [c for c in rivals if c.parameter_count <= model.parameter_count or c.held_out.loss < model.held_out.loss]
    names = (public_name(c.added[-1].name) for c in simple if is_tied(c, model, gained))
    return tuple(dict.fromkeys(names))[:2]
