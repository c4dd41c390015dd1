"""Fixtures that tests of several folders share."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from hypothesis import HealthCheck, settings

from stagecad import processes
from stagecad.blas_threads import use_one_thread

if TYPE_CHECKING:
    from stagecad.parameters.design import Design

# Before a test imports NumPy.
use_one_thread(os.environ)
PROCESSORS = processes.processors()

# A busy machine is no fault of a test.
settings.register_profile("busy", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("busy")

TOGETHER = {
    "browser": ("workbench/page/test_in_browser.py", "workbench/page/test_late_answers.py",
                "workbench/page/test_restart.py"),
    "cluster": ("commands/test_cluster.py", "stagecad/test_processes.py"),
    "sheets": ("drawings/export/test_dxf.py", "drawings/sheets/test_sheets_complete.py"),
    "loop": ("workbench/operations/test_experiments.py", "workbench/operations/test_machine_and_motions.py",
             "workbench/operations/test_whole_loop.py"),
    "machine": ("drawings/sheets/test_assembly_sheet.py", "stagecad/friction_stage/test_assembly.py",
                "stagecad/solids/assembly/test_interference.py", "stagecad/solids/export/test_export.py"),
}  # fmt: skip
"""Files whose tests one process runs, since they share a browser, a cluster, drawn sheets, a diagnosis, or the solids
of the machine. So it does for the tests of every other file."""
DEAR = (
    "browser", "recovery/hidden_effect/", "commands/test_loop_commands.py", "workbench/page/test_documents.py",
    "drawings/dimensions/", "sheets", "machine", "recovery/", "sysid/", "commands/", "loop", "robustness/",
)  # fmt: skip
"""Groups, files and folders that take longest begin first: else one process ends long after the other."""


SEVERAL_PROCESSES = (
    "commands/test_check_and_calc.py", "commands/test_cluster.py", "commands/test_simulate_command.py",
    "designcalc/optimisation/", "recovery/", "robustness/", "sim/integration/", "stagecad/test_processes.py",
    "sysid/diagnosis/test_ledger.py", "sysid/estimation/test_true_models.py",
    "sysid/estimation/test_variant_selection.py", "workbench/operations/",
)  # fmt: skip
"""Files whose tests start as many processes as a user does: each map of the program is in one of them. Those of the
others compute alone while other processes run tests: to start more costs a fifth of their time, and gains none."""


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    groups = {place: name for name, places in TOGETHER.items() for place in places}
    ranks = {}
    for item in items:
        place = item.path.relative_to(Path(__file__).parent).as_posix()
        group = groups.get(place, place)
        item.add_marker(pytest.mark.xdist_group(group))
        ranks[item] = next((rank for rank, name in enumerate(DEAR) if group.startswith(name)), len(DEAR))
    items.sort(key=ranks.__getitem__)


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    place = item.path.relative_to(Path(__file__).parent).as_posix()
    busy = int(os.environ.get("PYTEST_XDIST_WORKER_COUNT", "1")) >= PROCESSORS
    processes.processors = lambda: 1 if busy and not place.startswith(SEVERAL_PROCESSES) else PROCESSORS


@pytest.fixture(scope="session", autouse=True)
def own_state(tmp_path_factory: pytest.TempPathFactory) -> None:
    """Neither the consents given in tests nor the width of the lines are those of the user who runs them."""
    os.environ.pop("COLUMNS", None)
    os.environ["XDG_STATE_HOME"] = str(tmp_path_factory.mktemp("state"))


@pytest.fixture(scope="session", autouse=True)
def short_wait_for_a_cluster() -> None:
    """A cluster on this machine answers at once; one that is not there is not waited for."""
    processes.ANSWER_TIME = 1.0


class Command:
    """A command in this process."""

    def __init__(self, capsys: pytest.CaptureFixture[str]) -> None:
        self.capsys = capsys

    def __call__(self, *words: object, status: int = 0) -> Any:
        """What it prints to both streams, `out` and `err`; it has to end with this status."""
        from workbench.cli import run

        self.capsys.readouterr()
        ended = run([str(word) for word in words])
        printed = self.capsys.readouterr()
        assert ended == status, printed.err
        return printed

    def json(self, *words: object, status: int = 0) -> Any:
        """The document that it prints; what is for a person goes to the other stream."""
        return json.loads(self(*words, "--json", status=status).out)

    def refused(self, *words: object) -> str:
        """The line in which it refuses its input: status 2, and nothing but this line is printed."""
        printed = self(*words, status=2)
        assert printed.err.count("\n") == 1 and not printed.out, printed
        return printed.err


@pytest.fixture
def command(capsys: pytest.CaptureFixture[str]) -> Command:
    return Command(capsys)


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
    """Address of a dask cluster on this machine; one process runs its tests."""
    from distributed import LocalCluster

    with LocalCluster(
        n_workers=1, threads_per_worker=1, processes=True, host="127.0.0.1", dashboard_address="127.0.0.1:0"
    ) as made:
        yield made.scheduler_address
