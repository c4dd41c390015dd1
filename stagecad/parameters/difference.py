"""What differs between two designs."""

from __future__ import annotations

from dataclasses import dataclass, replace

from stagecad.parameters.design import Design
from stagecad.parameters.entry import Entry


@dataclass(frozen=True)
class Difference:
    """A key in which two designs differ; none where a design lacks the key."""

    key: str
    before: Entry | None
    after: Entry | None


def diff(design_a: Design, design_b: Design) -> tuple[Difference, ...]:
    """Keys whose value, tolerance or origin differ, in the order of the first design."""

    def plain(entry: Entry | None) -> Entry | None:
        # The same length written as 1 in and as 25.4 mm is no difference.
        return replace(entry, text="") if entry else None

    a_by_key, b_by_key = ({entry.key: entry for entry in design.entries} for design in (design_a, design_b))
    keys = [*a_by_key, *(key for key in b_by_key if key not in a_by_key)]
    pairs = [(key, a_by_key.get(key), b_by_key.get(key)) for key in keys]
    return tuple(Difference(key, a, b) for key, a, b in pairs if plain(a) != plain(b))
