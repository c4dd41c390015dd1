"""Folders of this user alone, and a user's files that have the names of the program's packages."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from stagecad import private
from stagecad.private import cache_root, make_private, user_folder


def test_a_private_folder_is_closed_to_others(tmp_path: Path) -> None:
    assert make_private(tmp_path / "new").stat().st_mode & 0o777 == 0o700
    (tmp_path / "open").mkdir(mode=0o755)
    assert make_private(tmp_path / "open").stat().st_mode & 0o777 == 0o700


@pytest.mark.parametrize("planted", ["root", "kernels"])
def test_a_cache_that_another_user_owns_is_passed_over(tmp_path, monkeypatch, planted: str) -> None:
    shared = tmp_path / "shared"
    (shared / "kernels").mkdir(parents=True)
    owner = {"root": shared, "kernels": shared / "kernels"}[planted]
    real = Path.stat

    def stat(path: Path, **given: bool) -> os.stat_result:
        found = real(path, **given)
        return os.stat_result((*found[:4], 12345, *found[5:])) if path == owner else found

    monkeypatch.setattr(Path, "stat", stat)
    monkeypatch.setenv("STAGECAD_CACHE", str(shared))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "mine"))
    assert cache_root() == tmp_path / "mine" / "stagecad"


@pytest.mark.parametrize("mode", [0o777, 0o770, 0o1777])
def test_what_others_could_write_is_not_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, mode: int) -> None:
    shared = tmp_path / "shared" / "kernels"
    shared.mkdir(parents=True)
    shared.chmod(mode)
    monkeypatch.setenv("STAGECAD_CACHE", str(shared.parent))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "mine"))
    (shared / "index.nbi").write_bytes(b"planted")
    assert cache_root() == tmp_path / "mine" / "stagecad"
    with pytest.raises(PermissionError, match="other users could write"):
        make_private(shared)
    # Empty, nothing can have been planted: it is closed and used.
    (shared / "index.nbi").unlink()
    shared.chmod(mode)
    assert cache_root() == shared.parent and shared.stat().st_mode & 0o777 == 0o700


@pytest.mark.skipif(os.getuid() != 0, reason="only root can give a folder away")
@pytest.mark.parametrize("given", ["root", "kernels", "target of a link", "link"])
def test_a_cache_given_to_another_user_is_passed_over(tmp_path, monkeypatch, given: str) -> None:
    shared, real = tmp_path / "shared", tmp_path / "real"
    shared.mkdir(mode=0o755)
    real.mkdir(mode=0o700)
    kernels = shared / "kernels"
    if "link" in given:
        kernels.symlink_to(real)
    else:
        kernels.mkdir(mode=0o700)
    monkeypatch.setenv("STAGECAD_CACHE", str(shared))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "mine"))
    assert cache_root() == shared
    planted = {"root": shared, "kernels": kernels, "target of a link": real, "link": kernels}[given]
    os.chown(planted, 65534, 65534, follow_symlinks=False)
    assert cache_root() == tmp_path / "mine" / "stagecad"


def test_a_link_of_this_user_leads_to_a_closed_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    real = tmp_path / "disk"
    (real / "kernels").mkdir(mode=0o755, parents=True)
    (tmp_path / "link").symlink_to(real)
    monkeypatch.setenv("STAGECAD_CACHE", str(tmp_path / "link"))
    assert cache_root() == tmp_path / "link"
    assert (real / "kernels").stat().st_mode & 0o777 == 0o700


def test_a_cache_whose_folders_others_may_rename_is_passed_over(tmp_path, monkeypatch) -> None:
    shared = tmp_path / "shared"
    shared.mkdir()
    monkeypatch.setenv("STAGECAD_CACHE", str(shared))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "mine"))
    for mode, used in ((0o777, tmp_path / "mine" / "stagecad"), (0o1777, shared), (0o755, shared)):
        shared.chmod(mode)
        assert cache_root() == used


def test_without_a_home_folder_a_temporary_cache_is_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def nobody() -> Path:
        raise RuntimeError("no home")

    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setenv("STAGECAD_CACHE", "")
    monkeypatch.setattr(Path, "home", nobody)
    monkeypatch.setattr(private.tempfile, "mkdtemp", lambda prefix: str(tmp_path))
    assert user_folder("XDG_CACHE_HOME", ".cache") is None
    assert cache_root() == tmp_path and os.environ["STAGECAD_CACHE"] == str(tmp_path)


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
    assert done.stdout.startswith("sim.") and str(folder) not in done.stdout


def test_a_module_imported_before_is_named(tmp_path: Path) -> None:
    (tmp_path / "sim.py").write_text("", encoding="utf-8")
    done = _run(tmp_path, "import sim, stagecad")
    assert done.returncode == 1
    last = done.stderr.strip().splitlines()[-1]
    assert str(tmp_path / "sim.py") in last and "sim/__init__.py" in last.replace("\\", "/")
