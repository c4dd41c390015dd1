"""Order in which the items of a pool of processes are begun, and by which process."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

FEW = 3
"""Number of items of a kind up to which they are left to a process that has begun the kind: loading takes longer."""


@dataclass(frozen=True)
class Order:
    """Restrictions on the order of items.

    Args:
        requires: items that must be completed before an item is begun, without cycles.
        kind: of an item. A process loads the libraries of a kind with its first item, and goes on with that kind.
        ahead: processes that have been started already, each for items of a kind (`stagecad.worker_process.Ahead`).
    """

    requires: Mapping[Any, Collection[Any]] = field(default_factory=dict)
    kind: Callable[[Any], str] = lambda item: ""
    ahead: Sequence[Any] = ()


class Schedule:
    """The choice of the next item.

    Attributes:
        kinds: of the items.
        ahead: processes that have been started already.
    """

    def __init__(self, items: Sequence[Any], order: Order) -> None:
        self.kinds = [order.kind(item) for item in items]
        self.ahead = order.ahead
        places = {items.index(item): others for item, others in order.requires.items()}
        self._required = {place: {items.index(other) for other in others} for place, others in places.items()}

    def choice(
        self, waiting: Sequence[int], done: set[int], own: Collection[str], others: Collection[str]
    ) -> int | None:
        """Place in `waiting` of the item that a process is to begin; None if it is to wait.

        It is the first whose requirements are completed: of a kind that the process has begun, else of one that no
        process has begun. An item of a kind of other processes alone is begun where more than `FEW` of that kind could
        be begun now, or where nothing else is left for this process.

        Args:
            waiting: indices of the items not begun.
            done: indices of those completed.
            own: kinds that the process has begun.
            others: kinds that the other processes have begun.
        """
        ready = [place for place, index in enumerate(waiting) if self._required.get(index, set()) <= done]
        kinds = {place: self.kinds[waiting[place]] for place in ready}
        preferred = [place for place in ready if kinds[place] in own]
        preferred += [place for place in ready if kinds[place] not in others]
        if not preferred and any(self.kinds[index] in own for index in waiting):
            counts = Counter(kinds.values())
            ready = [place for place in ready if counts[kinds[place]] > FEW]
        return next(iter((*preferred, *ready)), None)
