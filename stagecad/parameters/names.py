"""Names in a user's files that become names of files."""

import re

from stagecad.parameters.errors import InputError, require

_IDENTIFIER = re.compile(r"[a-z][a-z0-9_]{0,63}")
_FORBIDDEN = re.compile(r'[/\\:*?"<>|\x00-\x1f\x7f]')
LONGEST = 150
"""Largest number of bytes of a name, which has room for what a command adds to it."""


def is_identifier(name: object) -> bool:
    """Whether a name consists of small letters, digits and _, as those of parts, checks and effects do."""
    return isinstance(name, str) and _IDENTIFIER.fullmatch(name) is not None


def identifier(name: str, place: str) -> str:
    """The name of a part, of a check, ..., after which files are named.

    Raises:
        InputError: it is none; `place` begins the message.
    """
    require(is_identifier(name), f"{place}: a name has small letters, digits and _, and begins with a letter")
    return name


def file_stem(name: object, place: str) -> str:
    """A name in words, of a record say, after which a file is named.

    Raises:
        InputError: it would lead to another folder, or no system has files of this name; `place` begins the message.
    """
    fits = isinstance(name, str) and bool(name.strip()) and len(name.encode("utf-8", "replace")) <= LONGEST
    if not isinstance(name, str) or not fits or name.startswith(".") or _FORBIDDEN.search(name):
        raise InputError(
            f"{place}: a file is named after it: write at most {LONGEST} letters, digits, blanks and signs, none of "
            '/ \\ : * ? " < > |, and no point at the beginning'
        )
    return name
