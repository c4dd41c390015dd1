"""The examples in the docstrings of the Python interface."""

import doctest
import importlib
import pkgutil

import pytest

import workbench.operations

MODULES = [info.name for info in pkgutil.walk_packages(workbench.operations.__path__, "workbench.operations.")]


@pytest.mark.parametrize("name", ["stagecad", *MODULES])
def test_examples_of_a_docstring(name: str) -> None:
    assert doctest.testmod(importlib.import_module(name)).failed == 0


def test_there_are_examples() -> None:
    tried = [doctest.testmod(importlib.import_module(name)).attempted for name in MODULES]
    assert sum(tried) >= 6
