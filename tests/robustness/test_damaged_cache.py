"""Compiled kernels that the disk has changed are compiled again, and are never taken as they are."""

import random
import shutil
import sys
import types
from pathlib import Path

import pytest

from tests.process_state import python

PROGRAM = """
from sim.numerics.compilation import compile_callback
from numba import types
def law(x):
    return 2.0 * x + 1.0
import ctypes
found = compile_callback(law, types.float64(types.float64))
print(ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_double)(found.address)(3.0), found.cache_hits)
"""


def test_a_kernel_for_a_type_whose_module_has_moved_is_compiled_again(tmp_path, monkeypatch) -> None:
    """A signature in the cache names its types by their modules, as they were when it was written."""
    from numba.core import caching

    from sim.numerics import compilation

    monkeypatch.setattr(caching, "IndexDataCacheFile", caching.IndexDataCacheFile)
    compilation._numba_parts.__wrapped__()
    files = caching.IndexDataCacheFile(str(tmp_path), "kernel", source_stamp="unchanged")
    module = types.ModuleType("before_the_move")
    module.Loads = type("Loads", (), {"__module__": module.__name__})  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, module.__name__, module)
    files.save(module.Loads, "machine code")
    files.save("plain", module.Loads)
    assert files.load(module.Loads) == "machine code"
    monkeypatch.delitem(sys.modules, module.__name__)
    with pytest.raises(OSError):
        files._load_data(files._data_name(2))
    assert files.load("plain") is None
    files.save("plain", "compiled again")
    assert files.load("plain") == "compiled again"


@pytest.mark.slow
def test_a_damaged_kernel_is_compiled_again(tmp_path: Path) -> None:
    """Machine code with flipped bytes would end the process as it runs."""
    program = tmp_path / "program.py"
    program.write_text(PROGRAM)

    def run() -> str:
        return python(program, STAGECAD_CACHE=str(tmp_path / "cache")).stdout.strip()

    assert [run(), run()] == ["7.0 0", "7.0 1"]
    shutil.copytree(tmp_path / "cache", tmp_path / "kept")
    generator = random.Random(1)
    for suffix in (".nbi", ".nbc", ".sha256"):
        for file in (tmp_path / "cache" / "kernels").rglob(f"*{suffix}"):
            data = bytearray(file.read_bytes())
            data[generator.randrange(len(data))] ^= 0x55
            file.write_bytes(data)
            assert run() == "7.0 0"
