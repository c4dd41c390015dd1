"""A design as text and overrides, so that another process can load it without the user's files."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from workbench.machine.own_checks import own_check_files
from workbench.options import Run

if TYPE_CHECKING:
    from stagecad.parameters.design import Design
    from stagecad.parameters.file import ParameterFile


@dataclass(frozen=True)
class DesignSource:
    """A parameter file by its text; None is the packaged thesis design."""

    text: str | None
    name: str
    overrides: tuple[str, ...]
    own: tuple[str, ...] = ()
    """files of own checks, which run in every process that loads the design"""
    folder: Path | None = None
    """in which tables of hardware are; that of `name` when left out"""

    def design(self, *more: str, rules: bool = True) -> Design:
        """The design with `more` overrides `KEY=VALUE`."""
        from stagecad.parameters.load import design_from_text, load_design

        if self.own:
            from workbench.machine.own_checks import register

            register(self.own)
        overrides = (*self.overrides, *more)
        if self.text is None:
            return load_design(None, overrides, rules=rules)
        return design_from_text(self.text, self.name, overrides, rules=rules, folder=self.folder)

    def further_override(self) -> Callable[[str], Design]:
        """What gives the design with one more override `KEY=VALUE`, without regard to rules."""
        from stagecad.parameters.load import further_override

        return further_override(self._file(), self.overrides)

    def _file(self) -> ParameterFile:
        from stagecad.parameters.file import parse_parameter_text, read_parameter_file

        return read_parameter_file() if self.text is None else parse_parameter_text(self.text, self.name, self.folder)

    def contents(self) -> str:
        """Hash of the text, of the project's tables of hardware, and of the overrides."""
        tables = () if self.text is None else self._file().tables
        return hashlib.sha256(repr((self.text, tables, self.overrides)).encode()).hexdigest()


def source_of(run: Run) -> DesignSource:
    """Files and overrides from which the run's design was read."""
    path = run.params
    if path is None and Path("stage.toml").is_file():
        path = Path("stage.toml")
    if path is None:
        return DesignSource(None, "", run.overrides)
    folder = path.parent.absolute()
    if run.text is not None:
        return DesignSource(run.text, path.name, run.overrides, (), folder)
    return DesignSource(path.read_text("utf-8-sig"), path.name, run.overrides, own_check_files(path), folder)
