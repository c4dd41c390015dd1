"""Limits of size for readable packages: parameters and lines of functions, lines of files, files of folders."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGES = ("stagecad", "designcalc", "sim", "sysid", "drawings", "workbench")
FILES = [path for package in PACKAGES for path in sorted((ROOT / package).rglob("*.py"))]
PARAMETERS, FUNCTION_LINES, FILE_LINES, FILES_OF_FOLDER = 8, 80, 600, 25


def _functions(path: Path) -> list[ast.FunctionDef | ast.AsyncFunctionDef]:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    return [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)]


def _parameters(function: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    arguments = function.args
    names = [argument.arg for argument in (*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs)]
    return len(names) - (names[:1] in (["self"], ["cls"]))


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(ROOT)))
def test_a_file_and_its_functions_are_short(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    assert text.count("\n") <= FILE_LINES
    assert "fmt: skip" not in text and "fmt: off" not in text
    for function in _functions(path):
        assert _parameters(function) <= PARAMETERS, function.name
        assert function.end_lineno is not None
        assert function.end_lineno - function.lineno < FUNCTION_LINES, function.name


def test_a_folder_has_few_files() -> None:
    for folder in sorted({path.parent for path in FILES}):
        modules = [path.name for path in folder.glob("*.py") if path.name != "__init__.py"]
        assert len(modules) <= FILES_OF_FOLDER, f"{folder.relative_to(ROOT)}: {len(modules)} files"


def test_tests_have_the_folders_of_the_packages() -> None:
    for package in PACKAGES:
        for folder in sorted(path for path in (ROOT / "tests" / package).rglob("*") if path.is_dir()):
            if any(folder.glob("test_*.py")):
                place = folder.relative_to(ROOT / "tests")
                assert (ROOT / place).is_dir(), f"tests/{place} tests no folder of that name"
