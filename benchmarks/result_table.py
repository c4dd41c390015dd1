"""The result of the hidden-effect benchmark as text: targets, results of the loop and its peers, and failures.

Every share has its counts and its 95 % interval. The targets apply to the loop; the peers are listed beside it.
"""

import math
from collections.abc import Callable, Iterable, Sequence
from statistics import median

from benchmarks.scoring import Outcome, same, share

ADEQUATE, UNEXPLAINED = "adequate", "unexplained"
Names = dict[str, list[str]]
"""Effects that each peer names for a case, first the one that matters most."""

PEERS = ("forward regression", "pysindy")


def table(outcomes: Sequence[Outcome], beside: Sequence[Names]) -> str:
    """The whole result as text; `beside` goes with `outcomes` row by row."""
    single = [o for o in outcomes if o.kind == "single"]
    lines = [*_asked(outcomes), *_remainder(outcomes), *_after_adding(single), *_seconds(outcomes)]
    for title, group in (("rig", lambda o: o.rig), ("size", lambda o: o.size), ("effect", lambda o: o.effect)):
        lines += [f"\nby {title}: the loop's first diagnosis is right"]
        chosen = {"effect": [o for o in outcomes if o.kind != "pair"], "size": single}.get(title, list(outcomes))
        lines += [_right(name, [o for o in chosen if group(o) == name]) for name in sorted({group(o) for o in chosen})]
    lines += ["\nby rig and size: single effects"]
    for rig in sorted({o.rig for o in single}):
        for size in ("strong", "moderate", "weak", "faint"):
            found = [o for o in single if (o.rig, o.size) == (rig, size)]
            lines += [_right(f"{rig}, {size}", found)] if found else []
    return "\n".join([*lines, *_peers(outcomes, beside), *_missed(outcomes)])


def _asked(outcomes: Sequence[Outcome]) -> list[str]:
    single = [o for o in outcomes if o.kind == "single"]
    clear = [o for o in single if o.size in ("strong", "moderate")]
    none = [o for o in outcomes if o.kind == "none"]
    unlisted = [o for o in outcomes if o.kind == "unexplained"]
    pairs, chains = ([o for o in outcomes if o.kind == kind] for kind in ("pair", "chain"))
    told = [name in o.false for o in outcomes for name in o.established]
    named = [o for o in outcomes if o.kind in ("single", "pair") and o.said not in (ADEQUATE, UNEXPLAINED, "failed")]
    return [
        "first name right, or in a named tie of at most three",
        _line("3 noise deviations or more, plain", (o.right for o in clear if not o.hard), 97),
        _line("3 noise deviations or more, hard", (o.right for o in clear if o.hard), 94),
        _line("1 to 3 noise deviations", (o.right for o in single if o.size == "weak"), 75),
        _line("answers that are ties", (o.tied > 1 for o in named), 10, at_most=True),
        _line("ties of names that are not one thing here", (o.tied > 1 and not one_thing(o) for o in named)),
        "nothing hidden",
        _line("adequate", (o.right for o in none), 98),
        _line("adequate, plain records", (o.right for o in none if not o.hard)),
        _line("adequate, hard records", (o.right for o in none if o.hard)),
        "effect of no library",
        _line("unexplained", (o.right for o in unlisted), 95),
        _line("unexplained, and the right coordinate first", (o.right and bool(o.where_right) for o in unlisted), 95),
        _line("right coordinate first, where unexplained", (bool(o.where_right) for o in unlisted if o.right)),
        "two hidden effects",
        _line("both found", (o.both for o in pairs if o.both is not None), 90),
        _line("both in the first ledger", (o.at_once for o in pairs if o.at_once is not None), 90),
        _line("first name right", (o.right for o in pairs)),
        "three hidden effects or more",
        _line("all found", (o.both for o in chains if o.both is not None), 75),
        _line("all in the first ledger", (o.at_once for o in chains if o.at_once is not None), 75),
        "effects established in the first ledger",
        _line("false ones", told, 3, at_most=True),
    ]


def one_thing(outcome: Outcome) -> bool:
    """Whether a tie is of names for the same thing in such records: a late sensor and a late drive of one chain."""
    names = outcome.said.split(" = ")
    return all(same(names[0], name) for name in names[1:])


def _line(title: str, hits: Iterable[bool], asked: float | None = None, at_most: bool = False) -> str:
    found = list(hits)
    text = f"  {title:44s} {share(found):36s}"
    if asked is None or not found:
        return text.rstrip()
    reached = 100.0 * sum(found) / len(found)
    good = reached <= asked if at_most else reached >= asked
    return f"{text} target: {'at most' if at_most else 'at least'} {asked:g} %{'' if good else ', MISSED'}"


def _right(title: str, outcomes: Sequence[Outcome]) -> str:
    return _line(title, (o.right for o in outcomes))


def _remainder(outcomes: Sequence[Outcome]) -> list[str]:
    """Error with everything that the first ledger establishes, where that is all that is hidden."""
    left = [o.remainder for o in outcomes if o.remainder is not None and o.established and o.right and not o.false]
    if not left:
        return []
    text = f"median {median(left):.2f} of {len(left)}"
    missed = ", MISSED" if median(left) > 1.15 else ""
    title = "error over noise with all established effects"
    return ["held-out records", f"  {title:44s} {text:36s} target: median at most 1.15{missed}"]


def _after_adding(single: Sequence[Outcome]) -> list[str]:
    held = sorted(o.held_out for o in single if o.held_out is not None and not math.isnan(o.held_out))
    if not held:
        return []
    clear = [o for o in single if o.held_out is not None and o.size in ("strong", "moderate")]
    lines = ["held-out records, after adding what was rightly named"]
    for title, values in (("all", held), ("3 deviations or more", sorted(o.held_out or 0.0 for o in clear))):
        if values:
            high = values[min(int(0.9 * len(values)), len(values) - 1)]
            text = f"median {median(values):.2f}, 90 % below {high:.2f}"
            missed = ", MISSED" if median(values) > 1.1 else ""
            lines += [f"  {f'error over noise, {title}':44s} {text:36s} target: median at most 1.1{missed}"]
    return [
        *lines,
        _line("the loop stops after the one effect", (bool(o.stopped) for o in single if o.stopped is not None)),
    ]


def _seconds(outcomes: Sequence[Outcome]) -> list[str]:
    seconds = sorted(o.seconds for o in outcomes if not math.isnan(o.seconds))
    if not seconds:
        return []
    high = seconds[min(int(0.95 * len(seconds)), len(seconds) - 1)]
    return [f"seconds of a diagnosis (other jobs beside it): median {median(seconds):.1f}, 95 % below {high:.1f}"]


CLASSES: tuple[tuple[str, Callable[[Outcome], bool]], ...] = (
    (
        "3 noise deviations or more, plain",
        lambda o: o.kind == "single" and o.size in ("strong", "moderate") and not o.hard,
    ),
    ("3 noise deviations or more, hard", lambda o: o.kind == "single" and o.size in ("strong", "moderate") and o.hard),
    ("1 to 3 noise deviations", lambda o: o.kind == "single" and o.size == "weak"),
    ("all single effects", lambda o: o.kind == "single"),
    ("nothing hidden: nothing named", lambda o: o.kind == "none"),
    ("effect of no library: unexplained", lambda o: o.kind == "unexplained"),
    ("two effects: first name", lambda o: o.kind == "pair"),
)


def peer_right(outcome: Outcome, names: Sequence[str]) -> bool:
    """Whether the first name is right. Naming nothing is `adequate`: peers cannot say that something else is there."""
    return (names[0] if names else ADEQUATE) in outcome.accept


def _peers(outcomes: Sequence[Outcome], beside: Sequence[Names]) -> list[str]:
    present = [name for name in PEERS if any(name in row for row in beside)]
    if not present:
        return []
    lines = ["\npeers on the same records, with a library of features made by hand: first answer right"]
    lines += [f"  {'':36s}" + "".join(f" {name:>32s}" for name in ("the loop", *present))]
    rows = list(zip(outcomes, beside, strict=True))
    for title, belongs in CLASSES:
        chosen = [(o, row) for o, row in rows if belongs(o)]
        if chosen:
            cells = [share(o.right for o, _ in chosen)]
            cells += [share(peer_right(o, row[name]) for o, row in chosen if name in row) for name in present]
            lines += [f"  {title:36s}" + "".join(f" {cell:>32s}" for cell in cells)]
    if "pysindy" not in present:
        lines += ["  pysindy is not installed (pip install 'stagecad[peers]'): left out"]
    return lines


def _missed(outcomes: Sequence[Outcome]) -> list[str]:
    lines = ["\nmissed"]
    for o in outcomes:
        why = [] if o.right else [o.said]
        why += [f"not hidden: {', '.join(o.false)}"] if o.false else []
        why += [f"not all found: {' then '.join(o.added) or 'nothing'} added"] if o.both is False else []
        why += ["wrong coordinate first"] if o.right and o.where_right is False else []
        why += [o.failed] if o.failed else []
        if why:
            lines += [f"  {o.case} {o.rig} {o.effect} {o.size}{' hard' if o.hard else ''}: {'; '.join(why)}"]
    return lines if len(lines) > 1 else ["\nmissed: none"]
