"""Rules across values: what must hold together for the machine to be made at all, in the user's words."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from stagecad.parameters.design import Design


def require(design: Design) -> None:
    """Raise an InputError that names keys and values where the values do not go together."""
