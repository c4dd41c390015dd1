"""The secret that a browser presents to the page of this user."""

import os
import secrets
from contextlib import suppress

from stagecad.parameters.atomic import atomic_write_text
from stagecad.parameters.errors import require
from stagecad.private import make_private, user_folder

LEAST = 16
"""Smallest number of characters."""


def page_token(given: str | None) -> str:
    """The secret that was given, else the one that is kept, so that an open page finds a server started again."""
    if given is not None:
        require(len(given) >= LEAST, f"--token: at least {LEAST} characters are required")
        return given
    folder = user_folder("XDG_STATE_HOME", os.path.join(".local", "state"))
    with suppress(OSError, UnicodeDecodeError):
        if folder is not None:
            file = make_private(folder / "workbench") / "token"
            if not file.exists():
                atomic_write_text(file, secrets.token_urlsafe(24))
            if len(token := file.read_text("utf-8")) >= LEAST:
                return token
    return secrets.token_urlsafe(24)
