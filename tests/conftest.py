"""Fixtures that tests of several folders share."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

import pytest

from stagecad.blas_threads import use_one_thread

if TYPE_CHECKING:
    from stagecad.parameters.design import Design

# Before a test imports NumPy.
use_one_thread(os.environ)


@pytest.fixture(scope="session", autouse=True)
def own_state(tmp_path_factory: pytest.TempPathFactory) -> None:
    """The consents given in tests are not those of the user who runs them."""
    os.environ["XDG_STATE_HOME"] = str(tmp_path_factory.mktemp("state"))


@pytest.fixture(scope="session", autouse=True)
def short_wait_for_a_cluster() -> None:
    """A cluster on this machine answers at once; one that is not there is not waited for."""
    import stagecad.processes

    stagecad.processes.ANSWER_TIME = 1.0


@pytest.fixture(scope="session")
def design() -> Design:
    from stagecad.parameters.load import load_design

    return load_design()


@pytest.fixture(scope="session")
def store():
    """The artefact store that the commands use too: each solid is made once, by the process that needs it first."""
    from stagecad.solids.artefacts.store import ArtefactStore

    return ArtefactStore()


@pytest.fixture(scope="session")
def machine(design: Design, store):
    from stagecad.solids.assembly.built_machine import build_machine

    return build_machine(design, store)


@pytest.fixture(scope="session")
def cluster():
    """Address of a dask cluster on this machine; its tests are in the group "cluster", so that one process runs it."""
    from distributed import LocalCluster

    with LocalCluster(
        n_workers=1, threads_per_worker=1, processes=True, host="127.0.0.1", dashboard_address="127.0.0.1:0"
    ) as made:
        yield made.scheduler_address
