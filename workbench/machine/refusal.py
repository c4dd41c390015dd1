"""Advice for a design that the rules accept, but of which the CAD kernel makes no valid solid."""

from __future__ import annotations

from stagecad.parameters.errors import PartError
from stagecad.parameters.load import load_design
from stagecad.solids.artefacts.part import CRASHED

MOST_NAMED = 6
"""Largest number of parameters named."""
SHARED = ("threads", "screws", "making", "teeth", "actuator")
"""Tables that shape several parts."""


def refusal_line(error: PartError) -> str | None:
    """The parameters that may be at fault, those of the part first.

    Where all are the packaged design's, the kernel may have been ended for lack of memory; None if it was not ended.
    """
    packaged = {entry.key: entry for entry in load_design().entries}
    changed = [
        entry
        for entry in error.design.entries
        if isinstance(entry.value, float | int) and entry.key in packaged and entry.value != packaged[entry.key].value
    ]
    if not changed:
        return f"part '{error.part}': {error.reason}; is there enough memory?" if error.reason == CRASHED else None
    changed.sort(key=lambda entry: ((error.part, *SHARED) + (entry.key.split(".")[0],)).index(entry.key.split(".")[0]))
    shown = ", ".join(
        f"{entry.key} = {entry.text} (packaged: {packaged[entry.key].text})" for entry in changed[:MOST_NAMED]
    )
    more = f" and {len(changed) - MOST_NAMED} more" if len(changed) > MOST_NAMED else ""
    return (
        f"{error.design.file}: the CAD kernel makes no valid solid of '{error.part}' with {shown}{more}; bring them "
        f"nearer to the packaged values ({error.reason})"
    )
