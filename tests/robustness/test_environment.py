"""Odd surroundings: closed streams, limits of the system, no home folder, a plain locale, a read-only folder."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="needs a POSIX shell")
PROGRAM = f"{sys.executable} -m workbench.cli"


def _shell(line: str, folder: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    whole = {**os.environ, "PYTHONPATH": os.getcwd(), **environment}
    return subprocess.run(["bash", "-c", line], cwd=folder, env=whole, capture_output=True, text=True, timeout=120)


@pytest.mark.parametrize("streams", [">&-", "2>&-", "<&- >&- 2>&-"])
def test_closed_streams(tmp_path: Path, streams: str) -> None:
    found = _shell(f"{PROGRAM} params stage {streams}", tmp_path)
    assert found.returncode == 0
    assert "Traceback" not in found.stderr


def test_a_limit_on_the_size_of_files(tmp_path: Path) -> None:
    found = _shell(f"ulimit -f 1; {PROGRAM} params --write stage.toml", tmp_path)
    assert found.returncode == 2
    assert found.stderr == "stagecad: stage.toml: File too large\n"
    assert list(tmp_path.iterdir()) == []


def test_a_plain_locale(tmp_path: Path) -> None:
    found = _shell(f"{PROGRAM} params --set 'drawing.title=Bühne' drawing.title", tmp_path, LC_ALL="C")
    assert found.returncode == 0 and "Traceback" not in found.stderr


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


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may write anywhere")
def test_a_folder_that_is_read_only(tmp_path: Path) -> None:
    tmp_path.chmod(0o555)
    try:
        found = _shell(f"{PROGRAM} params --write stage.toml", tmp_path)
        assert found.returncode == 2
        assert found.stderr == "stagecad: stage.toml: Permission denied\n"
    finally:
        tmp_path.chmod(0o755)


@pytest.mark.slow
@pytest.mark.parametrize("end", [signal.SIGKILL, signal.SIGTERM])
def test_the_processes_that_make_parts_end_with_their_parent(tmp_path: Path, end: signal.Signals) -> None:
    environment = {**os.environ, "PYTHONPATH": os.getcwd(), "STAGECAD_CACHE": str(tmp_path / "cache")}
    for wait in (1.0, 3.0, 6.0, 10.0):
        started = subprocess.Popen(
            [sys.executable, "-m", "workbench.cli", "parts", "--out", str(tmp_path / "out")],
            env=environment,
            start_new_session=True,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        time.sleep(wait)
        started.send_signal(end)
        started.wait()
        deadline = time.monotonic() + 15.0
        while _alive(started.pid) and time.monotonic() < deadline:
            time.sleep(0.2)
        assert not _alive(started.pid)


def _alive(group: int) -> bool:
    found = subprocess.run(["ps", "-eo", "pgid=,stat="], capture_output=True, text=True).stdout.split()
    return any(int(one) == group and not state.startswith("Z") for one, state in zip(found[::2], found[1::2]))
