"""Questions that a proposed experiment file leaves to the user, and what is unknown in it."""

from dataclasses import dataclass

QUESTION = "QUESTION:"
"""Mark of a line that the user should look at."""


def unanswered_questions(text: str) -> list[str]:
    """A warning if the text of an experiment file still has marked lines."""
    lines = [str(k) for k, line in enumerate(text.splitlines(), start=1) if QUESTION in line and k > 1]
    if not lines:
        return []
    shown = ", ".join(lines[:12]) + (", ..." if len(lines) > 12 else "")
    many = len(lines) > 1
    return [
        f"{len(lines)} question{'s' * many} of experiment.toml {'are' if many else 'is'} unanswered (line{'s' * many} "
        f"{shown}): what stands there is assumed"
    ]


@dataclass(frozen=True)
class Prior:
    """Prior knowledge of a value before the fit: its value and standard deviation."""

    value: float
    std: float


@dataclass(frozen=True)
class Unknown:
    """One unknown of a fit: key, start, bounds, typical size, and prior."""

    key: str
    start: float
    low: float
    high: float
    size: float
    prior: Prior | None = None
