"""The last change of the model of an experiment taken back: the rung then reached, and its document."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sysid.experiment.experiment import find_experiment
from sysid.experiment.history import Revision, undo


@dataclass(frozen=True)
class Undoing:
    """The rung of the ladder that stands again.

    Args:
        rung: that stands.
        kept: file of the undone rung.
    """

    rung: Revision
    kept: Path

    def as_json(self) -> dict[str, Any]:
        """As a JSON document."""
        return {"schema": 1, "rung": self.rung.number, "effects": list(self.rung.effects), "kept": str(self.kept)}


def undo_last(experiment: Path) -> Undoing:
    """Go back to the rung before the last; the experiment is not loaded, since an edited `[model]` may be invalid.

    Args:
        experiment: its folder, or its `experiment.toml`.

    Raises:
        InputError: nothing to undo, `[model]` was edited by hand since, or another run holds the lock.
    """
    return Undoing(*undo(find_experiment(experiment)))
