"""Fixtures that tests of several folders share."""

from __future__ import annotations

import os
from pathlib import Path
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
    import stagecad.cluster

    stagecad.cluster.ANSWER_TIME = 1.0


@pytest.fixture(scope="session")
def design() -> Design:
    from stagecad.parameters.load import load_design

    return load_design()


@pytest.fixture(scope="session")
def store(tmp_path_factory: pytest.TempPathFactory):
    """The artefact store of the session: each solid is made once, by the worker that needs it first."""
    from stagecad.solids.artefacts.store import ArtefactStore

    base = tmp_path_factory.getbasetemp()
    # The workers of one session have sibling folders: the store stands in their parent.
    shared = base.parent if os.environ.get("PYTEST_XDIST_WORKER") else base
    return ArtefactStore(Path(shared) / "solids_cache")


@pytest.fixture(scope="session")
def machine(design: Design, store):
    from stagecad.solids.assembly.machine import build_machine

    return build_machine(design, store)


@pytest.fixture(scope="session")
def cluster():
    """Address of a dask cluster on this machine; its tests are in the group "cluster", so that one process runs it."""
    from distributed import LocalCluster

    with LocalCluster(
        n_workers=1, threads_per_worker=1, processes=True, host="127.0.0.1", dashboard_address="127.0.0.1:0"
    ) as made:
        yield made.scheduler_address
