"""A design of the friction stage: its tables as typed attributes, and what follows from them."""

from dataclasses import dataclass
from functools import cached_property

from stagecad.friction_stage.parameters.derived import Derived, Tables
from stagecad.parameters import design


@dataclass(frozen=True)
class Design(design.Design, Tables):
    """Every number of the machine: the tables of the parameter file as attributes, and every entry by its key."""

    @cached_property
    def derived(self) -> Derived:
        """Heights, places and envelopes that follow from the parameters."""
        return Derived(self)
