"""Odd surroundings: closed streams, limits, no home folder, a plain locale, Ctrl-C at any time; what is installed."""

import json
import os
import signal
import subprocess
import sys
import time
import tomllib
from pathlib import Path

import pytest
from packaging.requirements import Requirement

from sysid.experiment.experiment import load_experiment
from tests.process_state import PROGRAM as WORDS
from tests.process_state import begun, group_runs, python, wait_until
from tests.sysid.slide import SIGN, slide

PROGRAM = f"{sys.executable} -m workbench.cli"


def _shell(line: str, folder: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    whole = {**os.environ, "PYTHONPATH": os.getcwd(), **environment}
    return subprocess.run(["bash", "-c", line], cwd=folder, env=whole, capture_output=True, text=True, timeout=240)


@pytest.mark.parametrize("streams", [">&-", "2>&-", "<&- >&- 2>&-"])
def test_closed_streams(tmp_path: Path, streams: str) -> None:
    found = _shell(f"{PROGRAM} params stage {streams}", tmp_path)
    assert found.returncode == 0 and "Traceback" not in found.stderr


def test_where_the_kernel_ends_the_process_the_line_of_the_script_is_printed(tmp_path: Path) -> None:
    (tmp_path / "crash.py").write_text("import os\nos.kill(os.getpid(), 11)\n", "utf-8")
    found = _shell(f"{PROGRAM} drawings --part crash.py --trust", tmp_path, XDG_CONFIG_HOME=str(tmp_path))
    assert found.returncode != 0 and 'crash.py", line 2 in <module>' in found.stderr


@pytest.mark.parametrize("columns", ["80", "140"])
def test_a_reader_that_has_gone_is_no_error(tmp_path: Path, columns: str) -> None:
    found = _shell(f"set -o pipefail; {PROGRAM} params | head -1", tmp_path, COLUMNS=columns)
    assert (found.returncode, found.stderr) == (0, "")


@pytest.mark.parametrize("words", ["parts tip", "drawings tip"])
def test_a_limit_on_the_size_of_files_in_commands_with_solids(tmp_path: Path, words: str) -> None:
    line = f"ulimit -f 20; exec {PROGRAM} {words} --out out"
    found = _shell(line, tmp_path, STAGECAD_CACHE=str(tmp_path / "cache"))
    assert found.returncode == 2 and "Traceback" not in found.stderr and found.stderr.strip().count("\n") == 0


@pytest.mark.parametrize("megabytes", [500, 700, 800])
def test_too_little_memory_for_solids_is_no_fault_of_the_design(tmp_path: Path, megabytes: int) -> None:
    line = f"ulimit -v {megabytes}000; {PROGRAM} parts tip --set stage.thickness=12.3mm"
    found = _shell(line, tmp_path, STAGECAD_CACHE=str(tmp_path / "cache"))
    assert found.returncode == 2 and "not enough memory" in found.stderr.splitlines()[-1], found.stderr
    assert "no valid solid" not in found.stderr


def test_a_plain_locale_and_a_limit_on_the_size_of_files(tmp_path: Path) -> None:
    found = _shell(f"{PROGRAM} params --set 'drawing.title=Bühne' drawing.title", tmp_path, LC_ALL="C")
    assert found.returncode == 0 and "Traceback" not in found.stderr
    found = _shell(f"ulimit -f 1; {PROGRAM} params --write stage.toml", tmp_path)
    assert (found.returncode, found.stderr) == (2, "stagecad: stage.toml: File too large\n")
    assert list(tmp_path.iterdir()) == []


def test_without_a_home_folder_the_cache_is_temporary_and_removed(tmp_path: Path) -> None:
    nobody = """
from pathlib import Path
def home(): raise RuntimeError("no home")
Path.home = home
from stagecad.private import cache_root
print(cache_root())
"""
    clean = "unset HOME XDG_CACHE_HOME STAGECAD_CACHE"
    found = _shell(f"{clean}; {sys.executable} - <<'END'\n{nobody}\nEND", tmp_path, TMPDIR=str(tmp_path))
    assert Path(found.stdout.strip()).parent == tmp_path, found.stderr
    assert list(tmp_path.iterdir()) == []


def _by_nobody(folder: Path, *words: str) -> None:
    """A container may run a user id without an entry in the table of users, and without a home folder."""
    nobody = f"""
import os, pwd, sys
def unknown(number): raise KeyError("getpwuid(): uid not found")
pwd.getpwuid = unknown
for name in ("HOME", "USER", "LOGNAME", "XDG_CACHE_HOME", "XDG_STATE_HOME", "XDG_CONFIG_HOME"):
    os.environ.pop(name, None)
from workbench.cli import run
sys.exit(run({list(words)}))
"""
    found = _shell(f"{sys.executable} - <<'END'\n{nobody}\nEND", folder)
    assert found.returncode == 0 and "Traceback" not in found.stderr, found.stderr


@pytest.mark.slow
def test_solids_and_sheets_of_a_user_without_a_home_folder(tmp_path: Path) -> None:
    _by_nobody(tmp_path, "drawings", "magnet", "--out", "out")


def test_values_are_written_back_by_a_user_without_a_name(tmp_path: Path) -> None:
    slide(tmp_path / "rig", 1.3 * SIGN, "coulomb", held_out=True)
    (tmp_path / "stage.toml").write_text(
        'extends = "thesis"\n[friction]\ncoulomb = {value = "1.2 N", origin = "assumed: a guess"}\n'
    )
    _by_nobody(tmp_path, "add", "rig", "constant_bias", "--write-back", "friction.coulomb")
    assert load_experiment(tmp_path / "rig").effects == ("coulomb", "constant_bias")
    assert 'origin = "measured: rig, rung 001"' in (tmp_path / "stage.toml").read_text("utf-8")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_a_folder_that_is_read_only(tmp_path: Path) -> None:
    tmp_path.chmod(0o555)
    try:
        found = _shell(f"{PROGRAM} params --write stage.toml", tmp_path)
        assert (found.returncode, found.stderr) == (2, "stagecad: stage.toml: Permission denied\n")
    finally:
        tmp_path.chmod(0o755)


@pytest.mark.slow
@pytest.mark.parametrize("end", [signal.SIGKILL, signal.SIGTERM])
def test_the_processes_that_make_parts_end_with_their_parent(tmp_path: Path, end: signal.Signals) -> None:
    for wait in (1.0, 3.0, 6.0, 10.0):
        started = begun(*WORDS, "parts", "--out", tmp_path / "out", STAGECAD_CACHE=str(tmp_path / "cache"))
        time.sleep(wait)
        started.send_signal(end)
        started.communicate(timeout=240)
        wait_until(lambda group=started.pid: not group_runs(group))


@pytest.mark.slow
@pytest.mark.parametrize("wait", [0.0, 2.0, 5.0])
def test_make_that_is_interrupted_says_so_in_a_word(tmp_path: Path, wait: float) -> None:
    """Ctrl-C as a terminal sends it: to the program and to every process that it has started."""
    words = [*WORDS, "make", "--no-simulations", "--out", tmp_path / "out"]
    started = begun(*words, STAGECAD_CACHE=str(tmp_path / "cache"))
    wait_until(lambda: list((tmp_path / "cache").glob("entries/.making-*")))
    time.sleep(wait)
    os.killpg(started.pid, signal.SIGINT)
    said = started.communicate(timeout=240)[1]
    assert started.returncode == 130 and said.endswith("stopped\n") and "Traceback" not in said
    assert not group_runs(started.pid)


@pytest.mark.slow
def test_the_assembly_of_two_clean_caches_is_the_same_to_the_byte(tmp_path: Path) -> None:
    made = []
    for name in ("one", "two"):
        found = _shell(f"{PROGRAM} parts --out {name}", tmp_path, STAGECAD_CACHE=str(tmp_path / f"cache {name}"))
        assert found.returncode == 0, found.stderr
        made.append({path.name: path.read_bytes() for path in (tmp_path / name).iterdir()})
    assert "assembly.step" in made[0] and made[0] == made[1]


INTERRUPTED_IMPORT = """
import sys

class Interrupt:
    def find_spec(self, name, path=None, target=None):
        if name == {name!r}:
            raise KeyboardInterrupt

sys.meta_path.insert(0, Interrupt())
from workbench.cli import main
sys.argv = ["stagecad", *{words!r}]
main()
"""


@pytest.mark.parametrize(("name", "words"), [
    ("click", ["--help"]), ("stagecad.parameters.errors", ["check"]),
    ("workbench.cli.commands.simulate", ["simulate", "tip"]), ("numpy", ["simulate", "tip"]),
])  # fmt: skip
def test_an_interrupt_while_python_imports_prints_no_traceback(name, words):
    found = python("-c", INTERRUPTED_IMPORT.format(name=name, words=words), status=130)
    assert (found.stderr.strip(), found.stdout) == ("stopped", "")


def test_an_interrupt_of_parallel_runs_ends_their_processes(tmp_path):
    """As a terminal sends it: to the program and to every process it has started."""
    words = [*WORDS, "simulate", "stick-slip", "--draws", "100000", "--set", "friction.breakaway=1.5 +- 0.01 N"]
    started = begun(*words, "--out", tmp_path)
    try:
        wait_until(lambda: _children(started.pid) >= 3)
        time.sleep(0.5)
        os.killpg(started.pid, signal.SIGINT)
        error = started.communicate(timeout=240)[1]
    finally:
        if started.poll() is None:
            os.killpg(started.pid, signal.SIGKILL)
            started.wait()
    assert started.returncode == 130 and error.strip() == "stopped"
    # The helper that multiprocessing keeps for its semaphores notices a moment later that it is alone.
    wait_until(lambda: not group_runs(started.pid))
    assert list(tmp_path.rglob("draws.csv")) == []


def _children(group: int) -> int:
    found = subprocess.run(["ps", "-o", "pid=", "--ppid", str(group)], capture_output=True, text=True)
    return 1 + len(found.stdout.split())


ROOT = Path(__file__).parents[2]
DEPENDENCIES = [
    Requirement(text) for text in tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["dependencies"]
]


def test_every_dependency_has_a_lower_bound_and_none_a_single_version() -> None:
    for one in DEPENDENCIES:
        assert ">=" in {part.operator for part in one.specifier} <= {">=", "<"}, one


def test_the_bill_of_materials_has_every_dependency_with_its_version() -> None:
    found = python(".ci/bill_of_materials.py", folder=ROOT)
    parts = {part["name"].lower(): part for part in json.loads(found.stdout)["components"]}
    for one in DEPENDENCIES:
        assert one.specifier.contains(parts[one.name.lower()]["version"])
    assert " packages, " in found.stderr
