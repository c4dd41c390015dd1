"""Consent to run the Python files that an experiment names, by the hash of their content."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from stagecad.parameters.errors import InputError


def python_files(folder: str | Path) -> list[dict[str, Any]]:
    """The Python files that an experiment names: `name`, `text`, `sha256`, and whether they may run (`consented`).

    Raises:
        InputError: a fault in `experiment.toml`, or a file that cannot be read.
    """
    from sysid.experiment.consent import python_files as files_of

    return files_of(Path(folder))


def consent(folder: str | Path, hashes: Mapping[str, str]) -> None:
    """Let Python files of an experiment run with the content that was read.

    Args:
        folder: of the experiment.
        hashes: sha256 of the content by name.

    Raises:
        InputError: a file that has changed since.
    """
    from sysid.experiment.consent import store_consent

    folder = Path(folder)
    present = [one for one in python_files(folder) if one["name"] in hashes]
    for one in present:
        if hashes[one["name"]] != one["sha256"]:
            raise InputError(f"{folder.name}/{one['name']}: has changed since it was shown; read it again")
    for one in present:
        store_consent(folder / one["name"], one["sha256"])
