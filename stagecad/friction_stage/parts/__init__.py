"""Parts that are made from a drawing, a module each; and what a part of this machine is."""

from dataclasses import dataclass
from operator import attrgetter
from typing import Any


@dataclass(frozen=True)
class Definition:
    """A part (`stagecad.solids.modelling.part.Part`): what its module states, and what the parameter file says of it.

    `of` is the module, or an object in a module for several parts; `table` its table in the parameter file.
    """

    of: Any
    table: str

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return getattr(self.of, name)

    def material(self, design: Any) -> str:
        """Name of its material."""
        return attrgetter(f"{self.table}.material")(design)

    def description(self, design: Any) -> str:
        """First line of the text of its module."""
        return (self.of.__doc__ or "").strip().partition("\n")[0].rstrip(".")

    def part_number(self, design: Any) -> str:
        """None: it is made."""
        return ""
