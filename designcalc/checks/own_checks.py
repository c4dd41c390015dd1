"""Design checks of the user's own: Python files in the folder `checks` beside the parameter file."""

from collections.abc import Callable, Sequence
from functools import wraps
from pathlib import Path
from typing import Any

from designcalc.checks.check import Check, CheckFunction
from stagecad.declared.own_part import run_file
from stagecad.parameters.errors import InputError
from stagecad.parameters.own_code import OwnCodeError, own_code

OWN: dict[str, tuple[str, CheckFunction]] = {}
"""Checks of the user's own that are known in this process, with their subjects, by file; they follow the others."""


def own_check_files(params: Path | None) -> tuple[str, ...]:
    """The files beside a parameter file; none for the packaged design."""
    if params is None:
        return ()
    return tuple(str(path) for path in sorted((params.parent / "checks").glob("*.py")))


def register(files: Sequence[str], trust: bool = False) -> None:
    """Add the checks of these files to those of every design in this process."""
    for name in files:
        if name in OWN and not trust:
            continue
        path = Path(name)
        module = run_file(path, trust, "this project")
        function = getattr(module, "check", None)
        if not callable(function):
            raise InputError(f"{path}: has no function check(r); `stagecad new check NAME` writes a file that has")
        OWN[name] = (str(getattr(module, "SUBJECT", "own checks")), _guarded(path, function))


def _guarded(path: Path, function: Callable[..., Any]) -> CheckFunction:
    """The function of a file, which gives a check or an error of the file."""

    @wraps(function)
    def check(inputs: Any) -> Check:
        with own_code(path):
            found = function(inputs)
        if not isinstance(found, Check):
            raise OwnCodeError(f"{path}: check(r) gives {type(found).__name__}; a Check is required")
        return found

    return check
