"""What counts as right when a loop has judged an experiment with a known hidden effect."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import permutations
from typing import Any

LARGEST_TIE = 3
SAME = (
    {"constant_bias", "direction_asymmetry"},
    {"drive_lag", "sensor_lag"},
    {"drive_delay", "sensor_delay"},
)


@dataclass(frozen=True)
class Outcome:
    """One experiment, judged.

    Args:
        case: folder's name.
        kind: `single`, `pair`, `chain` (three or more), `none` or `unexplained`.
        right: the verdict is right: first name right or in a named tie of at most three; adequate; unexplained.
        said: the verdict in words.
        tied: how many effects were named together.
        where_right: for an unlisted effect, whether the first coordinate is right; none otherwise.
        both: for a pair or a chain, whether every effect was found; none otherwise.
        at_once: the same of the ledger of the first diagnosis.
        established: effects that the first ledger establishes.
        false: those of them that are not hidden.
        remainder: error over noise on the held-out record with all of them.
        started: error over noise on the held-out record before anything was added.
        held_out: error over noise on the held-out record in the end; none where nothing was added rightly.
        stopped: after a single effect was added, whether the loop stopped; none where not followed.
        seconds: time of the first diagnosis.
        best_named: the effect that explains most of the excess, and its share; none where there is no excess.
        free_curve: the same of the free curves, by coordinate.
        accept: every right answer.
        added: what was added, in order; empty where not followed.
    """

    case: str
    kind: str
    rig: str
    effect: str
    size: str
    hard: bool
    right: bool
    said: str
    tied: int = 1
    where_right: bool | None = None
    both: bool | None = None
    at_once: bool | None = None
    established: tuple[str, ...] = ()
    false: tuple[str, ...] = ()
    remainder: float | None = None
    started: float | None = None
    held_out: float | None = None
    stopped: bool | None = None
    seconds: float = math.nan
    failed: str = ""
    best_named: tuple[str, float] | None = None
    free_curve: tuple[str, float] | None = None
    accept: tuple[str, ...] = ()
    added: tuple[str, ...] = ()


def wilson(hits: int, count: int, z: float = 1.96) -> tuple[float, float]:
    """95 % interval of a share, Wilson's score interval (J. Am. Stat. Assoc. 22 (1927) 209)."""
    if count == 0:
        return 0.0, 1.0
    p = hits / count
    centre = (p + z * z / (2 * count)) / (1 + z * z / count)
    half = z * math.sqrt(p * (1 - p) / count + z * z / (4 * count * count)) / (1 + z * z / count)
    return max(centre - half, 0.0), min(centre + half, 1.0)


def share(values: Iterable[bool]) -> str:
    """`hits/count  share [interval]` of a list of hits, as text."""
    hits = list(values)
    if not hits:
        return "-"
    low, high = wilson(sum(hits), len(hits))
    return f"{sum(hits)}/{len(hits)} = {100 * sum(hits) / len(hits):.1f} % [{100 * low:.1f}, {100 * high:.1f}]"


def kind_of(entry: dict[str, Any]) -> str:
    """What sort of case a key's entry is."""
    if entry["effect"] == "none":
        return "none"
    if entry["effect"].startswith("UNKNOWN"):
        return "unexplained"
    return ("single", "pair", "chain")[min(len(hidden_effects(entry)), 3) - 1]


def hidden_effects(entry: dict[str, Any]) -> list[str]:
    """Names of the hidden effects of a key's entry; empty where nothing is hidden, or an effect of no library."""
    if entry["effect"] == "none" or entry["effect"].startswith("UNKNOWN"):
        return []
    return list(entry.get("hidden") or entry["effect"].split("+"))


def size_of(entry: dict[str, Any]) -> str:
    """Level of what is visible over the noise."""
    if entry["effect"] == "none":
        return "-"
    visible = float(entry.get("visible", 0.0))
    return "strong" if visible >= 10.0 else "moderate" if visible >= 3.0 else "weak" if visible >= 1.0 else "faint"


def same(first: str, second: str) -> bool:
    """Whether two names stand for one answer where records cannot tell them apart."""
    first, second = first.split(":")[0].split("@")[0], second.split(":")[0].split("@")[0]
    return first == second or any({first, second} <= group for group in SAME)


def plain(name: str) -> str:
    """The name of an effect without its variant and channel."""
    return name.split(":")[0].split("@")[0]


def said(document: dict[str, Any]) -> tuple[str, list[str]]:
    """The verdict in words, and the names it gives."""
    if document["verdict"] != "missing-effect":
        return document["verdict"], []
    names = list(dict.fromkeys(plain(name) for name in [document["effect"], *document.get("indistinguishable", [])]))
    return " = ".join(names), names


def share_of(document: dict[str, Any], field: str, key: str) -> tuple[str, float] | None:
    """Name and share of `best_named` or `free_curve` of a document."""
    found = document.get(field)
    return (plain(found[key]), float(found["share"])) if found else None


def first_right(document: dict[str, Any], entry: dict[str, Any]) -> bool:
    """Whether the first diagnosis is right: see Outcome."""
    # A key may state the unlisted effect itself.
    accept = {"unexplained": {"unexplained"}, "none": {"adequate"}}.get(kind_of(entry), set(entry["accept"]))
    verdict, names = said(document)
    if names:
        return bool(accept & set(names)) and (names[0] in accept or len(names) <= LARGEST_TIE)
    return verdict in accept


def all_found(effects: Sequence[str], told: Sequence[Sequence[str]]) -> bool:
    """Whether every effect was told, or is in a tie of at most three: each by a round, or an entry, of its own."""
    rounds = [names[:LARGEST_TIE] for names in told]
    return any(
        all(any(same(name, other) for other in names) for name, names in zip(effects, chosen, strict=True))
        for chosen in permutations(rounds, len(effects))
    )


def established(document: dict[str, Any]) -> list[list[str]]:
    """Name and ties of each effect that the ledger of a document establishes; copies of one effect once."""
    rows = [row for row in document.get("ledger", []) if row["state"] == "established"]
    return list({plain(row["effect"]): [plain(row["effect"]), *row["indistinguishable"]] for row in rows}.values())


def not_hidden(told: Sequence[Sequence[str]], entry: dict[str, Any]) -> tuple[str, ...]:
    """Effects that were told and are not hidden, nor tied with a hidden one."""
    true = [*hidden_effects(entry), *entry["accept"]] if hidden_effects(entry) else []
    return tuple(names[0] for names in told if not any(same(name, other) for name in names for other in true))


def worst_over_noise(stage: dict[str, Any]) -> float | None:
    """Largest `over_noise` of the channels of `before` or `after` of a document, on the held-out record."""
    values = [channel.get("over_noise") for channel in (stage or {}).get("validate", {}).values() if channel]
    numbers = [float(value) for value in values if value is not None]
    return max(numbers) if numbers else None
