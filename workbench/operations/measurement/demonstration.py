"""The packaged demonstration: a copy of its experiment in a folder that is not the user's own work."""

import hashlib
import json
import shutil
from collections.abc import Iterator
from importlib.resources import as_file, files
from pathlib import Path

from stagecad.parameters.atomic import atomic_write_bytes, atomic_write_text
from stagecad.parameters.input_file import read_input

STATE = ".demo.json"
"""File in a folder of the demonstration: the hash of each file of the experiment as the demonstration left it."""


def fresh_demo(folder: str | Path) -> Path:
    """Copy the packaged demonstration to a folder, or to the next free one; returns the folder."""
    return fresh_copy(free_folder(Path(folder)))


def free_folder(folder: Path) -> Path:
    """`folder`, or the first of FOLDER_2, FOLDER_3, ... that does not exist or is as a demonstration left it."""
    number, free = 1, folder
    while (free.exists() or free.is_symlink()) and not _as_left(free):
        number += 1
        free = folder.with_name(f"{folder.name}_{number}")
    return free


def fresh_copy(folder: Path) -> Path:
    """The packaged experiment in its initial state in `folder`, which is new or one that `free_folder` has found."""
    for left_over in ("ladder", "sections"):
        if (folder / left_over).is_dir():
            shutil.rmtree(folder / left_over)
    with as_file(files("workbench") / "demo_records") as packaged:
        for path in sorted(packaged.iterdir()):
            if path.suffix in (".toml", ".csv"):
                atomic_write_bytes(folder / path.name, path.read_bytes())
    remember(folder)
    return folder


def remember(folder: Path) -> None:
    """Store the state of the experiment in `folder`, by which the next demonstration recognises an unchanged folder."""
    atomic_write_text(folder / STATE, json.dumps(dict(_hashes(folder)), indent=1) + "\n")


def _as_left(folder: Path) -> bool:
    try:
        return not folder.is_symlink() and json.loads(read_input(folder / STATE)) == dict(_hashes(folder))
    except (OSError, ValueError):
        return False


def _hashes(folder: Path) -> Iterator[tuple[str, str]]:
    """Name and hash of each file of the experiment; reports and figures can be made again and do not count."""
    beside = [path for path in folder.iterdir() if path.suffix in (".toml", ".csv", ".parquet", ".mat", ".py")]
    for path in sorted(path for path in (*beside, *(folder / "ladder").rglob("*")) if path.is_file()):
        yield path.relative_to(folder).as_posix(), hashlib.sha256(path.read_bytes()).hexdigest()
