"""The lock between processes: beside what it protects, never through a link, never over another file."""

import os
from pathlib import Path

import pytest

from stagecad.parameters.errors import InputError
from sysid.experiment.history import file_lock


def test_a_lock_is_reentrant_holds_the_process_number_and_is_removed(tmp_path: Path) -> None:
    lock = tmp_path / ".lock"
    with file_lock(lock, 0.1, "it"):
        with file_lock(lock, 0.1, "it"):
            pass
        assert lock.read_text().strip() == str(os.getpid())
    assert not lock.exists()


def test_a_link_in_place_of_a_lock_is_refused_and_its_file_stays(tmp_path: Path) -> None:
    victim = tmp_path / "thesis.txt"
    victim.write_text("years of work")
    (tmp_path / ".lock").symlink_to(victim)
    with pytest.raises(InputError, match=r"\.lock: is a link"), file_lock(tmp_path / ".lock", 0.1, "it"):
        pass
    assert victim.read_text() == "years of work"


def test_a_file_with_content_or_another_name_is_not_written_to(tmp_path: Path) -> None:
    victim = tmp_path / "numbers.txt"
    victim.write_text("123")
    os.link(victim, tmp_path / ".lock")
    with file_lock(tmp_path / ".lock", 0.1, "it"):
        assert victim.read_text() == "123"
    victim.write_text("years of work")
    os.link(victim, tmp_path / ".lock")
    with file_lock(tmp_path / ".lock", 0.1, "it"):
        pass
    assert victim.read_text() == "years of work"


def test_what_is_no_plain_file_is_refused(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / ".lock")
    with pytest.raises(InputError, match="is not a regular file"), file_lock(tmp_path / ".lock", 0.1, "it"):
        pass


def test_a_lock_left_by_a_killed_process_is_taken_over(tmp_path: Path) -> None:
    (tmp_path / ".lock").write_text("999999")
    with file_lock(tmp_path / ".lock", 0.1, "it"):
        assert (tmp_path / ".lock").read_text().strip() == str(os.getpid())
