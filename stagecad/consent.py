"""Consent to run Python files that come with a user's project, stored for the content of each file.

A project may come from someone else, and the Python files that it names run with the user's rights. They run after the
user has consented (`--trust`): the consent is stored by the sha256 of the file's bytes, in a folder of this user alone,
so that a changed file requires consent again, and a copy does not.
"""

import hashlib
import os
from contextlib import suppress
from pathlib import Path

from stagecad.parameters.atomic import atomic_write_text
from stagecad.parameters.errors import InputError
from stagecad.parameters.input_file import read_named
from stagecad.private import make_private, user_folder

_consented: set[str] = set()
"""Hashes consented to in this process, also where no folder can store them."""


def give_consent(files: tuple[Path, ...]) -> None:
    """Store the consent to run each of `files` with its present content."""
    for path in files:
        store_consent(path, hashlib.sha256(read_named(path)).hexdigest())


def store_consent(path: Path, digest: str) -> None:
    """Store the consent to run a Python file whose content has this sha256."""
    _consented.add(digest)
    # Where it cannot be stored, the consent is for this run.
    with suppress(OSError):
        if folder := _trusted():
            atomic_write_text(make_private(folder) / digest, f"{path.resolve()}\n")


def has_consent(data: bytes) -> bool:
    """Whether the user has consented to a Python file with this content."""
    digest = hashlib.sha256(data).hexdigest()
    with suppress(OSError):
        return digest in _consented or (
            (folder := _trusted()) is not None and (make_private(folder) / digest).is_file()
        )
    return False


def _trusted() -> Path | None:
    folder = user_folder("XDG_STATE_HOME", os.path.join(".local", "state"))
    return folder and folder / "trusted"


def require_consent(path: Path, data: bytes, what: str = "this experiment") -> None:
    """Refuse the content `data` of a Python file, named by `what` runs it, that the user has not consented to."""
    if not has_consent(data):
        state = "is Python code that has changed since you consented to it" if _had_consent(path) else "is Python code"
        raise InputError(
            f"{path}: {state}, which {what} runs with your rights; read it, then repeat the command "
            "with --trust (the consent is stored for the file's present content)"
        )


def _had_consent(path: Path) -> bool:
    """Whether the user has consented to other content of a file."""
    folder, line = _trusted(), f"{path.resolve()}\n"
    with suppress(OSError, UnicodeDecodeError):
        return folder is not None and any(one.read_text("utf-8") == line for one in folder.iterdir())
    return False
