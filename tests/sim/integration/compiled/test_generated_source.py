"""Generated source of the kernels in the cache: what a file there holds is never run."""

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

CALL = """\
import ctypes
import numpy as np
from sim.effects.catalogue import find
from sim.integration.compiled.kernel_source import compile_effect
from sim.effects.effect import Axis

kernel = compile_effect(find("viscous"), [])
axis = np.array([2.0 if name == "velocity" else 0.0 for name in Axis._fields])
p, out = np.array([5.0]), np.zeros(64)
pointers = [array.ctypes.data_as(ctypes.POINTER(ctypes.c_double)) for array in (axis, p, out)]
ctypes.CFUNCTYPE(None, *[ctypes.POINTER(ctypes.c_double)] * 3, ctypes.c_int64)(kernel.address)(*pointers, 0)
print(out[np.nonzero(out)].tolist())
"""


def _force(cache: Path) -> str:
    """What another process, with this cache, prints for 5 N*s/m of viscous friction at 2 m/s."""
    environment = {**os.environ, "STAGECAD_CACHE": str(cache)}
    run = subprocess.run([sys.executable, "-c", CALL], env=environment, capture_output=True, text=True, check=True)
    return run.stdout.strip()


def _appended(path: Path, line: str) -> None:
    path.write_text(f"{path.read_text('utf-8')}\n{line}\n", "utf-8")


def _replaced(path: Path, line: str) -> None:
    """The same size and time stamp, so that numba finds its compiled code up to date."""
    before = path.stat()
    path.write_text(f"{line}\n".ljust(before.st_size, "#"), "utf-8")
    os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))


def _undecodable(path: Path, line: str) -> None:
    path.write_bytes(b"\xff\xfe" + line.encode())


@pytest.mark.parametrize("tamper", [_appended, _replaced, _undecodable])
def test_a_changed_file_is_not_run_and_is_written_again(tmp_path: Path, tamper: Callable[[Path, str], None]) -> None:
    right = _force(tmp_path / "cache")
    # The factor on a friction level, which this effect leaves as it is, and the force.
    assert right == "[1.0, 10.0]"
    (file,) = (tmp_path / "cache").rglob("effect_viscous_values.py")
    text, marker = file.read_bytes(), tmp_path / "ran"
    tamper(file, f"open({str(marker)!r}, 'w').close()")
    assert file.read_bytes() != text
    assert _force(tmp_path / "cache") == right
    assert not marker.exists()
    assert file.read_bytes() == text


@pytest.mark.skipif(sys.platform == "win32", reason="a link needs a right there")
def test_a_link_in_its_place_is_removed_and_its_target_kept(tmp_path: Path) -> None:
    right = _force(tmp_path / "cache")
    (file,) = (tmp_path / "cache").rglob("effect_viscous_values.py")
    text, other = file.read_bytes(), tmp_path / "other.py"
    other.write_text("raise SystemExit('run')\n")
    file.unlink()
    file.symlink_to(other)
    assert _force(tmp_path / "cache") == right
    assert other.read_text() == "raise SystemExit('run')\n"
    assert not file.is_symlink() and file.read_bytes() == text
