"""Measurements and reported inputs that are no part of the project, in a folder beside it."""

from pathlib import Path

import pytest

SHARED = Path(__file__).parents[2] / "shared"


def beside(*names: str) -> Path:
    """The folder or file of this name; the test is skipped where it is not there."""
    path = SHARED.joinpath(*names)
    if not path.exists():
        pytest.skip(f"{'/'.join(names)} is not beside the project")
    return path
