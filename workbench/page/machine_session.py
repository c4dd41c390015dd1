"""The design that the page shows: a parameter file, the changes made on the page, and their history."""

import json
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import Any

from stagecad.parameters.atomic import atomic_write_text
from stagecad.parameters.errors import InputError
from stagecad.parameters.file import packaged_text, parameter_text
from stagecad.parameters.input_file import read_input
from stagecad.parameters.rules import violations
from workbench.operations.design import Design, load_design
from workbench.operations.diff import diff
from workbench.operations.live_checks import LiveChecks, check_row
from workbench.operations.parameters import entry_row
from workbench.operations.result import remark
from workbench.page.project import Project

CHANGED = "assumed: changed in the workbench"
"""Origin of a value that the page writes."""

Changes = dict[str, str]
"""Text of a value by key, as for `--set`."""


class ChangedElsewhereError(InputError):
    """A change of a design that has changed since the page read it, as in another window."""


MOST_SHOWN = 6
"""Largest number of changes that a message names."""


class MachineSession:
    """State of the machine view; kept in a file, so that a new server continues where the last one ended."""

    def __init__(self, project: Project) -> None:
        self.project = project
        self.checks = LiveChecks()
        self._lock = threading.RLock()
        self._state = project.state / "machine.json"
        self._first = project.params.name if project.params is not None else None
        self.file = self._first
        self._text = self._read(self.file)
        self._history: list[Changes] = [{}]
        self._place = 0
        self._saved: tuple[tuple[str | None, str], Design] | None = None
        self._restore()
        self._know_checks()

    def _know_checks(self) -> None:
        """Take the user's own checks beside the file, if there is consent to run them."""
        try:
            self.checks.set_file(None if self.file is None else self._folder(self.file) / self.file)
        except InputError as error:
            remark(str(error))

    @property
    def changes(self) -> Changes:
        """Present changes of the saved file."""
        return dict(self._history[self._place])

    def as_json(self) -> dict[str, Any]:
        """File, files that can be opened, changes, digest of the design, and what there is to undo or redo."""
        with self._lock:
            return {
                "file": self.file,
                "files": self.project.parameter_files(),
                "changes": self.changes,
                "digest": self.design().values.digest,
                "undo": self._place,
                "redo": len(self._history) - 1 - self._place,
            }

    def open(self, file: str | None, seen: str | None = None) -> None:
        """Open a parameter file of the project (None: the packaged design); the history begins anew."""
        with self._unchanged(seen):
            if file not in (None, self._first, *self.project.parameter_files()):
                raise InputError(f"{file}: no parameter file of this folder")
            text = self._read(file)
            self._design(file, text, {})
            self.file, self._text, self._history, self._place = file, text, [{}], 0
            self._know_checks()
            self._keep()

    @contextmanager
    def _unchanged(self, seen: str | None) -> Iterator[None]:
        """Hold the design that has the digest `seen`; with None, whatever the design is now."""
        with self._lock:
            if seen is not None and seen != self.design().values.digest:
                shown = [f"{key} = {text}" for key, text in list(self.changes.items())[:MOST_SHOWN]]
                raise ChangedElsewhereError(
                    f"the design was changed elsewhere: {self.file or 'the packaged design'} now with "
                    f"{', '.join(shown) or 'no change'}; your change was not made, repeat it"
                )
            yield

    def commit(self, changes: Changes, seen: str | None = None) -> None:
        """Make `changes` the present ones, as a step that can be undone."""
        with self._unchanged(seen):
            self.design(changes)
            saved = {entry.key: entry.text for entry in self.saved.values.entries}
            changes = {key: text for key, text in changes.items() if text != saved.get(key)}
            if changes != self._history[self._place]:
                self._history = [*self._history[: self._place + 1], changes][-200:]
                self._place = len(self._history) - 1
                self._keep()

    def step(self, by: int, seen: str | None = None) -> None:
        """Undo (-1) or redo (+1) one step; nothing happens at the ends of the history."""
        with self._unchanged(seen):
            place = min(max(self._place + by, 0), len(self._history) - 1)
            self.design(self._history[place])
            self._place = place
            self._keep()

    @property
    def saved(self) -> Design:
        """The design of the file without changes."""
        with self._lock:
            if self._saved is None or self._saved[0] != (self.file, self._text):
                self._saved = (self.file, self._text), self.design({})
            return self._saved[1]

    def design(self, changes: Changes | None = None) -> Design:
        """The design with `changes` (by default the present ones); rules across values are not required."""
        return self._design(self.file, self._text, self.changes if changes is None else changes)

    def _design(self, file: str | None, text: str, changes: Changes) -> Design:
        if file is None:
            return load_design(values=changes, rules=False)
        return load_design(self._folder(file) / file, changes, text, rules=False)

    def preview(self, changes: Changes, limit: float, since: int) -> dict[str, Any]:
        """What the page shows while a value is dragged: checks evaluated within `limit` seconds, violated rules.

        Checks that the page has, by the version `since` of an earlier answer, are left out.
        """
        design = self.design(changes)
        result = self.checks.update(design.values, limit, since)
        return {
            "count": result.count,
            "version": result.version,
            "checks": [check_row(position, check) for position, check in result.checks.items()],
            "pending": list(result.pending),
            "seconds": result.seconds,
            "violations": [asdict(one) for one in violations(design.values)],
            "changed": self._changed(design, changes),
        }

    def save(self, name: str, seen: str | None = None) -> str:
        """Write the design to a new parameter file of the project, comments kept, and continue with it."""
        with self._unchanged(seen):
            target = self.project.new_parameter_file(name)
            text = self.design().to_toml(name=target.name, origin=CHANGED)
            atomic_write_text(target, text)
            self.file, self._text, self._history, self._place = target.name, text, [{}], 0
            self._keep()
        return target.name

    def differences(self, other: str | None = None) -> list[dict[str, Any]]:
        """Keys in which the design differs from its saved file, or from another file of the project."""
        base = self.saved
        if other is not None:
            base = self._design(other, self._read(other), {})
        return [
            {
                "key": change.key,
                "before": change.before and entry_row(change.before),
                "after": change.after and entry_row(change.after),
            }
            for change in diff(base, self.design(), solids=False, margins=False).changed
        ]

    def _changed(self, design: Design, changes: Changes) -> dict[str, str]:
        """Text of the values that differ from the saved file: those set, and those computed from them."""
        saved = {entry.key: entry.text for entry in self.saved.values.entries}
        return {e.key: e.text for e in design.values.entries if e.text != saved[e.key] or e.key in changes}

    def _read(self, file: str | None) -> str:
        if file is None:
            return packaged_text()
        path = self.project.params if self.project.params and self.project.params.name == file else None
        return parameter_text(path or self.project.inside(file))

    def _folder(self, file: str | None) -> Path:
        """Folder of a parameter file of the page, in which its tables of hardware are."""
        params = self.project.params
        return params.absolute().parent if params is not None and params.name == file else self.project.folder

    def _keep(self) -> None:
        document = {"file": self.file, "text": self._text, "history": self._history, "place": self._place}
        atomic_write_text(self._state, json.dumps(document))

    def _restore(self) -> None:
        """Take up the state of an earlier server where its steps are still valid; else begin anew."""
        first = self.file, self._text
        try:
            kept = json.loads(read_input(self._state))
            # Changes belong to the text of a file: after an edit elsewhere they may mean something else.
            if kept["text"] == self._read(kept["file"]) and (self.file is None or kept["file"] == self.file):
                history = [{str(key): str(text) for key, text in step.items()} for step in kept["history"]]
                self.file, self._text = kept["file"], kept["text"]
                place = range(len(history))[kept["place"]]
                self.design(history[place])
                self._history, self._place = history, place
        except FileNotFoundError:
            pass
        except (OSError, ValueError, LookupError, TypeError, AttributeError, RecursionError) as error:
            self.file, self._text = first
            reason = " ".join(str(error).split())[:200]
            remark(f"{self._state}: the changes of an earlier server are left out ({reason})")
