"""The co-simulation unit of an exported model (FMI 2.0): C source, description, and a library built on this machine.

Source: FMI for Model Exchange and Co-Simulation 2.0.4, sections 2 and 4.
"""

import shutil
import subprocess
import sys
import tempfile
import uuid
import zipfile
from pathlib import Path

from sim.export.languages import Exported, files_of, filled, words_of
from stagecad.parameters.atomic import atomic_write_bytes
from stagecad.parameters.errors import InputError

UNITS = {"position": "m", "velocity": "m/s", "acceleration": "m/s2", "load": "N", "temperature": "degC"}
"""Inputs of the unit with their units."""


def write_fmu(exported: Exported, folder: Path) -> Path:
    """Write NAME.fmu with sources, description, and the library built by the compiler of this machine."""
    name = exported.program.name
    files = files_of(exported, "c")
    guid = str(uuid.uuid5(uuid.NAMESPACE_OID, files[f"{name}.c"]))
    words = {**words_of(exported, "c"), "guid": guid, "units": UNITS}
    source = filled("fmu.c", words)
    library, place = _built(name, source, files[f"{name}.h"])
    target = folder / f"{name}.fmu"
    with tempfile.TemporaryDirectory() as scratch:
        packed = Path(scratch) / "packed.fmu"
        with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
            archive.writestr("modelDescription.xml", filled("modelDescription.xml", words))
            archive.writestr(f"sources/{name}.c", source)
            archive.writestr(f"sources/{name}.h", files[f"{name}.h"])
            archive.writestr(place, library)
        atomic_write_bytes(target, packed.read_bytes())
    return target


def _built(name: str, source: str, header: str) -> tuple[bytes, str]:
    """The shared library, and its place in the unit."""
    compiler = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
    if compiler is None:
        raise InputError("--to fmu: needs a C compiler (cc, gcc or clang) on the path; --to c writes the sources")
    system, suffix = ("darwin64", "dylib") if sys.platform == "darwin" else ("linux64", "so")
    with tempfile.TemporaryDirectory() as scratch:
        (Path(scratch) / f"{name}.c").write_text(source, encoding="utf-8")
        (Path(scratch) / f"{name}.h").write_text(header, encoding="utf-8")
        words = [compiler, "-std=c99", "-O2", "-shared", "-fPIC", f"{name}.c", "-o", f"{name}.{suffix}", "-lm"]
        done = subprocess.run(words, cwd=scratch, capture_output=True, text=True, check=False)
        if done.returncode:
            raise InputError(f"--to fmu: {compiler} fails: {done.stderr.strip().splitlines()[0]}")
        return (Path(scratch) / f"{name}.{suffix}").read_bytes(), f"binaries/{system}/{name}.{suffix}"
