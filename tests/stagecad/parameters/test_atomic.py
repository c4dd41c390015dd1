"""Atomic writing: links, permissions, failures, and the order in which data and names reach the disk."""

import errno
import os
from pathlib import Path

import pytest

from stagecad.parameters.atomic import atomic_path, atomic_write_text


def test_links_umask_and_folders_in_the_place_of_a_file(tmp_path: Path) -> None:
    (tmp_path / "store").mkdir()
    real = tmp_path / "store" / "stage.toml"
    real.write_text("old")
    link = tmp_path / "stage.toml"
    link.symlink_to(Path("store") / "stage.toml")
    atomic_write_text(link, "new")
    assert link.is_symlink() and real.read_text() == "new"
    real.unlink()
    atomic_write_text(link, "again")
    assert link.is_symlink() and real.read_text() == "again"
    before = os.umask(0o027)
    try:
        atomic_write_text(tmp_path / "new.txt", "text")
    finally:
        os.umask(before)
    assert (tmp_path / "new.txt").stat().st_mode & 0o777 == 0o640
    (tmp_path / "out").mkdir()
    with pytest.raises(IsADirectoryError) as caught:
        atomic_write_text(tmp_path / "out", "text")
    assert caught.value.filename == str(tmp_path / "out")


@pytest.mark.parametrize("mode", [0o600, 0o640, 0o664, 0o755])
def test_permissions_of_a_file_are_kept(tmp_path: Path, mode: int) -> None:
    path = tmp_path / "stage.toml"
    path.write_text("old")
    path.chmod(mode)
    atomic_write_text(path, "new")
    assert path.stat().st_mode & 0o777 == mode


def test_the_data_are_flushed_before_the_rename_and_the_folder_after_it(tmp_path, monkeypatch) -> None:
    path = tmp_path / "experiment.toml"
    path.write_text("old")
    seen: list[tuple[str, str]] = []

    def fsync(handle: int) -> None:
        name = Path(os.readlink(f"/proc/self/fd/{handle}"))
        seen.append(("folder" if name.is_dir() else "file", path.read_text()))

    if not Path("/proc/self/fd").is_dir():
        pytest.skip("needs /proc")
    monkeypatch.setattr(os, "fsync", fsync)
    atomic_write_text(path, "new")
    assert seen == [("file", "old"), ("folder", "new")]


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EFBIG, errno.EIO])
def test_a_failed_write_names_the_file_and_leaves_the_old_one(tmp_path: Path, number: int) -> None:
    path = tmp_path / "out.csv"
    path.write_text("old")
    with pytest.raises(OSError) as caught, atomic_path(path):
        raise OSError(number, os.strerror(number))
    assert (caught.value.errno, caught.value.filename) == (number, str(path))
    assert path.read_text() == "old" and [p.name for p in tmp_path.iterdir()] == ["out.csv"]
