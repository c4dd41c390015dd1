"""The parameter file of a run as text: comments kept, the values of `--set` written in."""

from __future__ import annotations

from functools import lru_cache

from workbench.options import Run


def parameter_text(run: Run) -> str:
    """The text of a parameter file that gives the design of a run without `--set`."""
    from stagecad.parameters.file import packaged_text

    path = run.parameter_file
    text = run.text
    if text is None:
        text = path.read_text("utf-8-sig") if path is not None else packaged_text()
    changes: dict[str, tuple[str | float | bool, str]] = {}
    for override in run.overrides:
        key = override.partition("=")[0].strip()
        entry = run.design.entry(key)
        plain = not entry.unit and not isinstance(entry.value, str)
        changes[key] = (entry.formula or (entry.value if plain else entry.text), entry.origin)
    return _changed(text, str(path or "thesis.toml"), tuple(changes.items())) if changes else text


@lru_cache(maxsize=4)
def _changed(text: str, name: str, changes: tuple[tuple[str, tuple[str | float | bool, str]], ...]) -> str:
    from stagecad.parameters.load import changed_text

    return changed_text(text, name, dict(changes))
