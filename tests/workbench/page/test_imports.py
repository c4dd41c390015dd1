"""The page is made of the Python interface: no route, and no job, calls a layer below the operations."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

import workbench.page

PAGE = Path(workbench.page.__file__).parent
PROJECT = ("stagecad", "designcalc", "drawings", "sim", "sysid", "workbench")
ALLOWED = ("workbench.operations", "workbench.figures", "workbench.page", "stagecad.parameters")
"""The parameter file is the input of the interface, and its errors are those of all layers."""
EXCEPTIONS = {"stagecad.__version__": "shown on the page", "stagecad.processes": "jobs run in processes of their own"}
FILES = sorted(PAGE.rglob("*.py"))


def _imports(file: Path) -> Iterator[str]:
    """Full names of what a file imports from the project, inside functions too."""
    for node in ast.walk(ast.parse(file.read_text("utf-8"))):
        if isinstance(node, ast.ImportFrom):
            assert node.level == 0, "relative imports are not looked at"
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)


def _under(name: str, prefix: str) -> bool:
    return name == prefix or name.startswith(f"{prefix}.")


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.relative_to(PAGE).as_posix())
def test_the_page_imports_the_python_interface_alone(file: Path) -> None:
    own = [name for name in _imports(file) if name.split(".")[0] in PROJECT]
    assert [name for name in own if not any(_under(name, one) for one in (*ALLOWED, *EXCEPTIONS))] == []


def test_every_exception_is_used() -> None:
    found = [name for file in FILES for name in _imports(file)]
    assert [one for one in EXCEPTIONS if not any(_under(name, one) for name in found)] == []
