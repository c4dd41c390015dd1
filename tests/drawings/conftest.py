"""Solids are made once for all tests of a session, by whichever worker needs them first."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from stagecad.parameters.design import Design, load_design
from stagecad.solids.cache import Store
from stagecad.solids.machine import Machine, make_machine


@pytest.fixture(scope="session")
def design() -> Design:
    return load_design()


@pytest.fixture(scope="session")
def machine(design: Design, tmp_path_factory: pytest.TempPathFactory) -> Machine:
    base = tmp_path_factory.getbasetemp()
    # Workers of one session have sibling folders: the store stands above them, and other tests use it as well.
    shared = base.parent if os.environ.get("PYTEST_XDIST_WORKER") else base
    return make_machine(design, Store(Path(shared) / "solids_cache"))
