"""A process goes on with the kind of item whose libraries it has loaded, and no item is left for ever."""

from __future__ import annotations

import random
from collections.abc import Sequence

import pytest

from stagecad.schedule import FEW, Order, Schedule


def kind(item: str) -> str:
    return item.split()[0]


def choice(
    items: Sequence[str],
    own: Sequence[str] = (),
    others: Sequence[str] = (),
    requires: dict[str, list[str]] | None = None,
) -> str | None:
    place = Schedule(items, Order(requires or {}, kind)).choice(range(len(items)), set(), own, others)
    return None if place is None else items[place]


def test_the_kind_of_the_process_comes_first_then_one_that_no_process_has_begun() -> None:
    items = ["solid 1", "figure 1", "solid 2"]
    assert choice(items) == "solid 1"
    assert choice(items, own=["figure"]) == "figure 1"
    assert choice(items, others=["solid"]) == "figure 1"
    assert choice(items, own=["sheet"], others=["solid"]) == "figure 1"


def test_few_items_are_left_to_the_process_that_has_begun_their_kind() -> None:
    few = [f"solid {number}" for number in range(FEW)]
    waiting = {"figure 1": few}
    assert choice([*few, "figure 1"], own=["figure"], others=["solid"], requires=waiting) is None
    assert choice([*few, "solid more", "figure 1"], own=["figure"], others=["solid"], requires=waiting) == "solid 0"
    # Nothing of its own is left.
    assert choice(few, own=["figure"], others=["solid"]) == "solid 0"
    assert choice(few, others=["solid"]) == "solid 0"
    # The other process has ended.
    assert choice([*few, "figure 1"], own=["figure"], requires=waiting) == "solid 0"


def test_what_an_item_requires_is_completed_first() -> None:
    schedule = Schedule(["sheet", "part"], Order({"sheet": ["part"]}))
    assert schedule.choice([0, 1], set(), (), ()) == 1
    assert schedule.choice([0], set(), (), ()) is None
    assert schedule.choice([0], {1}, (), ()) == 0


@pytest.mark.parametrize("processes", [1, 2, 3])
@pytest.mark.parametrize("seed", range(20))
def test_every_item_is_begun(seed: int, processes: int) -> None:
    """Processes that take their items in steps of one, with random requirements among random kinds."""
    generator = random.Random(seed)
    items = [f"{generator.choice('abc')} {number}" for number in range(30)]
    requires = {item: generator.sample(items[:n], min(n, generator.randrange(4))) for n, item in enumerate(items)}
    schedule = Schedule(items, Order(requires, kind))
    waiting, done = list(range(len(items))), set[int]()
    kinds: list[set[str]] = [set() for _ in range(processes)]
    while waiting:
        begun: list[int] = []
        for number, own in enumerate(kinds):
            others = set().union(*(kinds[k] for k in range(processes) if k != number))
            place = schedule.choice(waiting, done, own, others)
            if place is not None:
                begun.append(waiting.pop(place))
                own.add(schedule.kinds[begun[-1]])
                assert {items.index(other) for other in requires[items[begun[-1]]]} <= done
        assert begun, "all processes wait"
        done.update(begun)
