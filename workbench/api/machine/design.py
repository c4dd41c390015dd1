"""A design: the parameter file of a machine, as an object."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stagecad.parameters.errors import InputError
from stagecad.parameters.file import packaged_path
from stagecad.parameters.load import design_from_text
from stagecad.parameters.load import load_design as read_design
from workbench.api.result import Result, without_options
from workbench.options import Run

if TYPE_CHECKING:
    import pandas as pd

    from stagecad.parameters.design import Design as Values


TEXT = "design.toml"
"""Name of a parameter file that is a text, in messages."""


class Design(Result):
    """Every number of a machine. It never changes: `with_values` gives a new one.

    `design.values.stage.thickness` is the attribute of the parameter `stage.thickness` (mm where it is geometry, SI
    otherwise), `design.si("stage.thickness")` the number in SI.
    """

    def __init__(
        self, path: Path | None, overrides: tuple[str, ...] = (), rules: bool = True, text: str | None = None
    ) -> None:
        self.path = Path(TEXT) if path is None and text is not None else path
        self.overrides = overrides
        self.rules = rules
        self.text = text
        self.values: Values
        if text is None:
            self.values = read_design(path, overrides, rules=rules)
        else:
            self.values = design_from_text(text, str(self.path), overrides, rules=rules)

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
        return _design(self.path, (*self.overrides, *_overrides(values)), self.rules, self.text)

    def run(self, out: str | Path = "build") -> Run:
        """The common options of the commands, for this design."""
        # The packaged file by its path: without one the commands take stage.toml of the working folder.
        path = self.path or packaged_path()
        run = Run(path, self.overrides, Path(out), None, rules=self.rules, text=self.text)
        run.__dict__["design"] = self.values
        return run

    def to_dataframe(self) -> pd.DataFrame:
        """The parameters: value as text, number in SI (none for a text), tolerance, meaning, origin; index `key`."""
        import pandas as pd

        rows = []
        for entry in self.values.entries:
            number = None if isinstance(entry.value, bool | str) else self.values.si(entry.key)
            rows.append(
                {
                    "key": entry.key,
                    "value": entry.text,
                    "si": number,
                    "tolerance": entry.tolerance or "",
                    "meaning": entry.meaning,
                    "origin": entry.origin,
                }
            )
        return pd.DataFrame(rows).set_index("key")

    def to_json(self) -> dict[str, Any]:
        """The document of `stagecad params --json`."""
        from workbench.api.result import finite_json
        from workbench.machine.parameter_json import entry_json

        parameters = {entry.key: entry_json(entry) for entry in self.values.entries}
        return finite_json({"file": self.values.file, "digest": self.values.digest, "parameters": parameters})

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
        text: content of the file, which is then not read; the user's own checks beside it are left out. Tables of
            hardware are those of the folder of `path`.
        rules: whether a design that violates a rule across values is refused; `optimize` repairs it.

    Raises:
        InputError: one line with file, key, value, and what is allowed.

    >>> load_design()  # doctest: +ELLIPSIS
    <Design 'thesis.toml': ... parameters>
    >>> thin = 'extends = "thesis"\\n[stage]\\nthickness = {value = "11 mm", origin = "assumed: lighter"}'
    >>> load_design(text=thin).si("stage.thickness")
    0.011
    """
    return _design(None if path is None else Path(path), _overrides(values or {}), rules, text)


def _overrides(values: Mapping[str, str | float]) -> tuple[str, ...]:
    return tuple(f"{key}={value}" for key, value in values.items())


def _design(path: Path | None, overrides: tuple[str, ...], rules: bool, text: str | None) -> Design:
    with without_options():
        return Design(path, overrides, rules, text)


def as_design(source: Design | str | Path | None) -> Design:
    """A design, or the one in a file; the packaged machine for None.

    Raises:
        InputError: none of these, or a fault in the file.
    """
    if isinstance(source, Design):
        return source
    if source is None or isinstance(source, str | Path):
        return load_design(source)
    raise InputError(f"a Design or its parameter file is required, not {type(source).__name__}")
