"""A design: a parameter file, or its text, with other values for some of its keys."""

from __future__ import annotations

import copy
import hashlib
import os
from collections.abc import Callable, Mapping
from functools import cached_property
from pathlib import Path
from typing import Any

from designcalc.checks.run import CONTENTS, own_check_files, register
from stagecad.deferred import pd
from stagecad.parameters.design import Design as Values
from stagecad.parameters.errors import InputError
from stagecad.parameters.file import (
    ParameterFile,
    packaged_text,
    parameter_text,
    parse_parameter_text,
    read_parameter_file,
)
from stagecad.parameters.load import changed_text, design_of, further_override, variations_of
from stagecad.parameters.load import load_design as read_design
from stagecad.parameters.variations import Variations
from workbench.operations.parameters import entry_json
from workbench.operations.result import Result, finite, frame, without_options

TEXT = "design.toml"
"""Name of a parameter file that is a text, in messages."""
STAGE = Path("stage.toml")
"""Parameter file that the commands take in the working folder."""


class Design(Result):
    """Every number of a machine. It never changes: `with_values` gives a new one.

    `design.values.stage.thickness` is the attribute of the parameter `stage.thickness` (mm where it is geometry, SI
    otherwise), `design.si("stage.thickness")` the number in SI.

    The file is read when a value is first used. Pickled, a design is the text of its file with its overrides: another
    process or machine needs no file.

    Attributes:
        path: of the parameter file; None for the packaged machine of the thesis.
        overrides: texts `KEY=VALUE`.
        rules: whether a design that violates a rule across values is refused.
        earlier: parameter file of an earlier issue of the design, for the revision table of the drawings.
    """

    def __init__(
        self,
        path: Path | None = None,
        overrides: tuple[str, ...] = (),
        rules: bool = True,
        text: str | None = None,
        earlier: Path | None = None,
    ) -> None:
        self.path = Path(TEXT) if path is None and text is not None else path
        self.overrides = overrides
        self.rules = rules
        self.earlier = earlier
        self._text = text
        self._folder: Path | None = None
        self._check_files: tuple[str, ...] | None = () if path is None else None
        self._accepted: Mapping[str, bytes] | None = None  # contents of check files that another process has run

    @classmethod
    def chosen(
        cls, params: Path | None, overrides: tuple[str, ...] = (), rules: bool = True, earlier: Path | None = None
    ) -> Design:
        """The design of `--params`, else of stage.toml in the working folder, else the packaged one."""
        return cls(STAGE if params is None and os.path.lexists(STAGE) else params, overrides, rules, earlier=earlier)

    @cached_property
    def values(self) -> Values:
        """The numbers, read and checked.

        Raises:
            InputError: one line with file, key, value, and what is allowed.
        """
        values = design_of(self.file, self.overrides, self.rules)
        return values if self.earlier is None else values.since(read_design(self.earlier))

    def values_with(self, *overrides: str, rules: bool = True) -> Values:
        """The numbers with further overrides `KEY=VALUE`; the user's own checks are then known in this process."""
        register(self.check_files, accepted=self._accepted)
        return design_of(self.file, (*self.overrides, *overrides), rules)

    @property
    def text(self) -> str:
        """Text of the parameter file, without the overrides."""
        if self._text is not None:
            return self._text
        return packaged_text() if self.path is None else parameter_text(self.path)

    @property
    def file(self) -> ParameterFile:
        """The entries of the parameter file, without the overrides."""
        if self._text is None:
            return read_parameter_file(self.path)
        return parse_parameter_text(self._text, str(self.path), self._folder)

    @property
    def check_files(self) -> tuple[str, ...]:
        """Files of the user's own checks, in the folder `checks` beside the parameter file."""
        if self._check_files is None:
            self._check_files = own_check_files(self.path)
        return self._check_files

    @property
    def part_files(self) -> tuple[Path, ...]:
        """Python files of the parts of a machine of the user's own."""
        declaration = design_of(self.file, self.overrides, rules=False).machine.declaration
        if declaration is None:
            return ()
        return tuple(dict.fromkeys(declaration.folder / part.file for part in declaration.parts if part.file))

    @property
    def own_files(self) -> tuple[str, ...]:
        """Files of the user's own parts and checks."""
        return (*map(str, self.part_files), *self.check_files)

    def variations(self, *overrides: str) -> Variations:
        """The design with further overrides, and fast changes of its values; rules are not required."""
        return variations_of(self.file, (*self.overrides, *overrides))

    def further_override(self) -> Callable[[str], Values]:
        """What gives the numbers with one more override `KEY=VALUE`, without regard to rules."""
        return further_override(self.file, self.overrides)

    def with_rules(self) -> Design:
        """The same design, which is refused when it is read if it violates a rule."""
        unread = copy.copy(self)
        unread.rules = True
        return unread

    def contents(self) -> str:
        """Hash of the text, of the project's tables of hardware, and of the overrides."""
        stated = (None, ()) if self.path is None else (self.text, self.file.tables)
        return hashlib.sha256(repr((*stated, self.overrides)).encode()).hexdigest()

    def __getstate__(self) -> dict[str, Any]:
        text = None if self.path is None else self.text
        folder = None if self.path is None else self._folder or self.path.parent.absolute()
        kept = {"path": self.path, "overrides": self.overrides, "rules": self.rules, "earlier": self.earlier}
        accepted = {name: CONTENTS[name] for name in self.check_files if name in CONTENTS}
        return {**kept, "_text": text, "_folder": folder, "_check_files": self.check_files, "_accepted": accepted}

    def si(self, key: str) -> float:
        """The number of a parameter in SI.

        Raises:
            InputError: no such key (the nearest is named), or no number.
        """
        return self.values.si(key)

    def with_values(self, values: Mapping[str, str | float]) -> Design:
        """A design with other values.

        Args:
            values: text with its unit by key (a number where it has no unit).

        Raises:
            InputError: no such key, a value out of its bounds, or a rule across values that no longer holds.

        >>> load_design().with_values({"stage.thickness": "14 mm"}).si("stage.thickness")
        0.014
        """
        changed = Design(self.path, (*self.overrides, *_overrides(values)), self.rules, self._text, self.earlier)
        changed._folder, changed._check_files = self._folder, self._check_files
        return _read(changed)

    def to_toml(
        self, changes: Mapping[str, tuple[str | float | bool, str]] | None = None, name: str = "", origin: str = ""
    ) -> str:
        """Text of a parameter file that gives this design without overrides; comments are kept.

        Args:
            changes: further values with their origins, by key.
            name: of the file in messages; its present one when left out.
            origin: of the overridden values; "assumed: given by --set" when left out.
        """
        written: dict[str, tuple[str | float | bool, str]] = {}
        for override in self.overrides:
            entry = self.values.entry(override.partition("=")[0].strip())
            plain = not entry.unit and not isinstance(entry.value, str)
            written[entry.key] = (entry.formula or (entry.value if plain else entry.text), origin or entry.origin)
        written |= changes or {}
        folder = None if self.path is None else self._folder or self.path.parent
        name = name or str(self.path or "thesis.toml")
        return changed_text(self.text, name, written, folder) if written else self.text

    def to_dataframe(self) -> pd.DataFrame:
        """The parameters: value as text, number in SI (none for a text), tolerance, meaning, origin; index `key`."""
        rows = []
        for entry in self.values.entries:
            number = None if isinstance(entry.value, bool | str) else self.values.si(entry.key)
            rows.append((entry.key, entry.text, number, entry.tolerance or "", entry.meaning, entry.origin))
        return frame(rows, "key", columns=("key", "value", "si", "tolerance", "meaning", "origin"))

    def to_json(self) -> dict[str, Any]:
        """The document of `stagecad params --json`."""
        parameters = {entry.key: entry_json(entry) for entry in self.values.entries}
        return finite({"file": self.values.file, "digest": self.values.digest, "parameters": parameters})

    def __repr__(self) -> str:
        changed = f", {', '.join(self.overrides)}" if self.overrides else ""
        return f"<Design '{self.values.file}': {len(self.values.entries)} parameters{changed}>"


def load_design(
    path: str | Path | None = None,
    values: Mapping[str, str | float] | None = None,
    text: str | None = None,
    rules: bool = True,
) -> Design:
    """Read a parameter file.

    Args:
        path: the file; the packaged machine of the thesis when left out.
        values: other values by key, as of `Design.with_values`.
        text: content of the file, which is then not read. Tables of hardware and checks of the user's own are those of
            the folder of `path`.
        rules: whether a design that violates a rule across values is refused; `optimize` repairs it.

    Raises:
        InputError: one line with file, key, value, and what is allowed.

    >>> load_design()  # doctest: +ELLIPSIS
    <Design 'thesis.toml': ... parameters>
    >>> thin = 'extends = "thesis"\\n[stage]\\nthickness = {value = "11 mm", origin = "assumed: lighter"}'
    >>> load_design(text=thin).si("stage.thickness")
    0.011
    """
    return _read(Design(None if path is None else Path(path), _overrides(values or {}), rules, text))


def _overrides(values: Mapping[str, str | float]) -> tuple[str, ...]:
    return tuple(f"{key}={value}" for key, value in values.items())


def _read(design: Design) -> Design:
    with without_options():
        _ = design.values
    return design


def as_design(source: Design | str | Path | None) -> Design:
    """A design, or the one in a file; the packaged machine for None."""
    if isinstance(source, Design):
        return source
    if source is None or isinstance(source, str | Path):
        return load_design(source)
    raise InputError(f"a Design or its parameter file is required, not {type(source).__name__}")
