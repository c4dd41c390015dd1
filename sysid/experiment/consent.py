"""The Python files that an experiment names (`[model] custom`), and whether they may run (`stagecad.consent`)."""

from __future__ import annotations

import hashlib
from contextlib import suppress
from pathlib import Path
from typing import Any

from stagecad.consent import has_consent
from stagecad.parameters.errors import InputError
from sysid.experiment.readers.base import shown_path
from sysid.experiment.toml_table import TomlTable, read_toml, shown


def custom_files(model: TomlTable, folder: Path) -> tuple[Path, ...]:
    """The Python files that `[model] custom` names."""
    found = []
    for item in model.texts("custom"):
        path = folder / item
        with suppress(OSError, ValueError):
            if path.resolve().is_relative_to(folder.resolve()):
                found.append(path)
                continue
        raise InputError(
            f"{model.where('custom')}: {shown(item)} is outside the folder of the experiment; copy the file there"
        )
    return tuple(found)


def python_files(folder: Path) -> list[dict[str, Any]]:
    """The Python files that the experiment in `folder` names: name, text, sha256, and whether they may run."""
    file = folder / "experiment.toml"
    found = []
    for path in custom_files(read_toml(file, shown_path(str(file)))[2].table("model"), folder):
        try:
            data = path.read_bytes()
        except OSError as error:
            raise InputError(f"{path}: cannot be read: {error.strerror}") from None
        name, digest = path.relative_to(folder).as_posix(), hashlib.sha256(data).hexdigest()
        text = data.decode("utf-8", errors="replace")
        found.append({"name": name, "text": text, "sha256": digest, "consented": has_consent(data)})
    return found
