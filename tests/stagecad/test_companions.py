"""Files of a user that have the names of the program's packages do not take their place."""

import subprocess
import sys
from pathlib import Path

import pytest


def _run(folder: Path, code: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-c", code], cwd=folder, capture_output=True, text=True, check=False)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name in ("sim", "drawings", "workbench", "sysid", "designcalc"):
        (tmp_path / f"{name}.py").write_text("raise RuntimeError('a file of the user')\n", encoding="utf-8")
    return tmp_path


def test_the_packages_of_the_program_are_found_beside_files_of_their_names(folder: Path) -> None:
    done = _run(folder, "import stagecad; print(stagecad.Effect.__module__); import sysid; print(sysid.__file__)")
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("sim.")
    assert str(folder) not in done.stdout


def test_a_module_imported_before_is_named(tmp_path: Path) -> None:
    (tmp_path / "sim.py").write_text("", encoding="utf-8")
    done = _run(tmp_path, "import sim, stagecad")
    assert done.returncode == 1
    last = done.stderr.strip().splitlines()[-1]
    assert str(tmp_path / "sim.py") in last and "sim/__init__.py" in last.replace("\\", "/")
