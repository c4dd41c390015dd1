"""`import stagecad`: quick, with every public name, typed by its stub; examples of its docstrings."""

import ast
import doctest
import importlib
import pkgutil
import subprocess
import sys
from pathlib import Path

import pytest

import stagecad
import workbench.operations

HEAVY = ("numpy", "pandas", "scipy", "matplotlib", "cadquery", "numba", "pyarrow", "click")


def test_the_import_loads_nothing_heavy() -> None:
    program = f"import sys, stagecad; print([name for name in {HEAVY} if name in sys.modules])"
    found = subprocess.run([sys.executable, "-S", "-c", program], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "[]"


@pytest.mark.parametrize("name", stagecad.__all__)
def test_a_public_name_is_there(name: str) -> None:
    found = getattr(stagecad, name)
    assert found.__name__ == name and found.__doc__


def test_the_stub_declares_the_public_names_of_the_same_modules() -> None:
    stub = Path(stagecad.__file__).with_suffix(".pyi")
    declared = {}
    for node in ast.parse(stub.read_text("utf-8")).body:
        if isinstance(node, ast.ImportFrom):
            declared |= {alias.asname: node.module for alias in node.names}
    assert declared == {name: getattr(stagecad, name).__module__ for name in stagecad.__all__}


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'diagnosis'"):
        _ = stagecad.diagnosis  # pyright: ignore[reportAttributeAccessIssue]
    assert "diagnose" in dir(stagecad)


MODULES = [info.name for info in pkgutil.walk_packages(workbench.operations.__path__, "workbench.operations.")]


@pytest.mark.parametrize("name", ["stagecad", *MODULES])
def test_examples_of_a_docstring(name: str) -> None:
    assert doctest.testmod(importlib.import_module(name)).failed == 0


def test_there_are_examples() -> None:
    tried = [doctest.testmod(importlib.import_module(name)).attempted for name in MODULES]
    assert sum(tried) >= 6
