"""Compiled kernels: arguments in memory, and generated source that the cache never runs."""

import multiprocessing
import os
import time
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

from sim.integration.compiled import views
from sim.integration.compiled.views import OverViews, Packed, Part, Zeros
from tests.process_state import python

WRONG = [np.zeros(2, np.float32), np.zeros((3, 2)).T, np.zeros(2, bool), "text", None]
RIGHT = "[1.0, 10.0]"
"""The factor on a friction level, which this effect leaves as it is, and the force."""


class Inner(NamedTuple):
    count: Any
    vector: np.ndarray


class Outer(NamedTuple):
    factor: float
    inner: Inner
    matrix: np.ndarray
    block: np.ndarray
    places: np.ndarray


def _work(memory):
    outer, shift = memory[0]
    vector, matrix, block, places = outer.inner.vector, outer.matrix, outer.block, outer.places
    for i in range(outer.inner.count):
        vector[i] = outer.factor * matrix[i, 1] + shift
        row = block[i]
        last = row[1]
        last[2] += 10.0 * row[0, 1] + matrix[i][0]
    for i in range(places.shape[0]):
        places[i] = 100 * block.shape[0] + 10 * block.shape[1] + block.shape[2] + places[i]


def _arguments():
    random = np.random.default_rng(1)
    outer = Outer(3.0, Inner(2, np.zeros(2)), random.random((2, 3)), random.random((2, 2, 4)), np.array([7, -8]))
    return outer, 0.5


def test_arrays_are_views_of_one_memory_whose_sizes_need_no_other_kernel():
    compiled = OverViews(_work)
    outer, shift = _arguments()
    block = outer.block.copy()
    compiled(outer, shift)
    assert outer.inner.vector == pytest.approx(3.0 * outer.matrix[:, 1] + 0.5, rel=1e-15)
    block[:, 1, 2] += 10.0 * block[:, 0, 1] + outer.matrix[:, 0]
    np.testing.assert_allclose(outer.block, block, rtol=1e-15)
    assert outer.places.tolist() == [224 + 7, 224 - 8]
    compiled = OverViews(_work)
    outer, shift = _arguments()
    compiled(outer, shift)
    longer = Outer(np.float64(2.0), Inner(np.int64(3), np.zeros(3)), np.ones((3, 2)), np.ones((3, 2, 3)), np.array([0]))
    compiled(Packed(longer), 0.25)
    assert longer.inner.vector.tolist() == [2.25, 2.25, 2.25] and longer.places.tolist() == [323]


@pytest.mark.parametrize("wrong", WRONG, ids=str)
def test_what_compiled_code_would_misread_is_refused(wrong):
    outer, shift = _arguments()
    with pytest.raises(TypeError, match="must be"):
        OverViews(_work)(outer._replace(matrix=wrong), shift)


class Spare(NamedTuple):
    first: Zeros
    second: Zeros
    whole: Zeros


def _fill(memory):
    out, spare = memory[0]
    for i in range(2):
        out[0] += spare.first[i, 0] + spare.first[i, 1]
        spare.first[i, 1] = 1.0
    for i in range(3):
        out[0] += spare.second[i]
        spare.second[i] = 2.0
    for i in range(4):
        out[0] += spare.whole[i]
        spare.whole[i] = 7 // 2
    out[1] = spare.first[1, 1] + spare.second[0] + spare.second[2] + spare.whole[3]


def test_zeros_do_not_overlap_and_a_part_works_on_the_same_memory():
    compiled = OverViews(_fill)
    for _ in range(2):
        out = np.zeros(2)
        compiled(out, Spare(Zeros((2, 2)), Zeros((3,)), Zeros((4,), int)))
        assert out.tolist() == [0.0, 8.0]
    vector = np.array([0.0, 1.0, 2.0])
    OverViews(_by_parts, parts=[WEIGHTED])(vector)
    assert vector.tolist() == [10.0 * 2.0 + 0.5 + 10.0 * 3.0 + 0.5, 2.0, 3.0]


def _weighted(memory, arguments):
    weight, place = arguments
    vector, _ = memory[0]
    vector[place.row] += 1.0
    return weight * vector[place.row] + place.offset


class Place(NamedTuple):
    row: int
    offset: float


WEIGHTED = Part(_weighted, (0.0, Place(0, 0.0)))
_call_weighted = WEIGHTED.call


def _by_parts(memory):
    vector, parts = memory[0]
    for i in range(1, vector.shape[0]):
        vector[0] += _call_weighted(parts[0], memory, (10.0, Place(i, 0.5)))


def test_parts_compiled_by_another_process_are_found_on_the_disk(monkeypatch):
    calls = []

    def here(function):
        calls.append(function())

    monkeypatch.setattr(views, "forked", here)
    monkeypatch.setattr(views, "is_cached", lambda *_: bool(calls))
    begun = OverViews(_by_parts, parts=[WEIGHTED])
    for _ in range(2):
        begun.begin_parts(np.zeros(3))
    assert len(calls) == 1 and not begun.is_compiled
    vector = np.array([0.0, 1.0, 2.0])
    begun(vector)
    assert vector.tolist() == [10.0 * 2.0 + 0.5 + 10.0 * 3.0 + 0.5, 2.0, 3.0] and begun.is_compiled


def test_a_process_that_does_not_end_is_ended_and_its_parts_are_compiled_here(monkeypatch):
    process = multiprocessing.get_context("spawn").Process(target=time.sleep, args=(300.0,), daemon=True)
    process.start()
    monkeypatch.setattr(views, "forked", lambda function: process)
    monkeypatch.setattr(views, "is_cached", lambda *_: False)
    monkeypatch.setattr(views, "LONGEST_COMPILATION", 0.1)
    begun, vector = OverViews(_by_parts, parts=[WEIGHTED]), np.array([0.0, 1.0, 2.0])
    begun.begin_parts(np.zeros(3))
    begun(vector)
    assert vector.tolist() == [10.0 * 2.0 + 0.5 + 10.0 * 3.0 + 0.5, 2.0, 3.0]
    process.join(120.0)
    assert process.exitcode is not None


CALL = """\
import ctypes
import numpy as np
from sim.effects.catalogue import find
from sim.integration.compiled.kernels import compile_effect
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
    return python("-c", CALL, STAGECAD_CACHE=str(cache)).stdout.strip()


@pytest.fixture(scope="module")
def compiled(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A cache that each test finds, and leaves, whole."""
    cache = tmp_path_factory.mktemp("compiled")
    assert _force(cache) == RIGHT
    return cache


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
def test_a_changed_file_is_not_run_and_is_written_again(compiled: Path, tmp_path: Path, tamper) -> None:
    (file,) = compiled.rglob("effect_viscous_values.py")
    text, marker = file.read_bytes(), tmp_path / "ran"
    tamper(file, f"open({str(marker)!r}, 'w').close()")
    assert file.read_bytes() != text
    assert _force(compiled) == RIGHT
    assert not marker.exists() and file.read_bytes() == text


def test_a_link_in_its_place_is_removed_and_its_target_kept(compiled: Path, tmp_path: Path) -> None:
    (file,) = compiled.rglob("effect_viscous_values.py")
    text, other = file.read_bytes(), tmp_path / "other.py"
    other.write_text("raise SystemExit('run')\n")
    file.unlink()
    file.symlink_to(other)
    assert _force(compiled) == RIGHT
    assert other.read_text() == "raise SystemExit('run')\n"
    assert not file.is_symlink() and file.read_bytes() == text
