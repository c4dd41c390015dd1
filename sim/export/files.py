"""The files of an exported model: Python, C, MATLAB, Modelica, a table of steady sliding, a co-simulation unit.

The unit of FMI 2.0 has C source, description, and a library where it is built.

Source: FMI for Model Exchange and Co-Simulation 2.0.4, sections 2 and 4.
"""

import ast
import shutil
import subprocess
import sys
import tempfile
import uuid
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined

from sim.export.language_syntax import C, Language, Matlab, Modelica, locals_of
from sim.export.program import ForceFunction, Program
from stagecad.parameters.atomic import atomic_write_bytes
from stagecad.parameters.errors import InputError

ARGUMENTS = ("dt", "position", "velocity", "acceleration", "load", "temperature")
SIGNS = (
    "The force opposes the motion: it is positive where it acts against positive velocity.",
    "mass * acceleration = drive force - force. SI units; on a rotary axis rad for m, N*m for N, kg*m^2 for kg.",
    "Call start once, then step once per sample: dt is the time since the sample before.",
    "load (N) and temperature (degC) matter only to effects that depend on them.",
)


@dataclass(frozen=True)
class Exported:
    """What is written."""

    program: Program  # the step
    mass: float  # kg; zero where it is not known
    about: tuple[str, ...]  # lines on the origin of the model

    @property
    def comments(self) -> list[str]:
        """Lines at the head of each file."""
        left = [f"Left out: {line}." for line in self.program.left_out]
        states = [f"state {k}: {meaning}" for k, meaning in enumerate(self.program.states)]
        return [*self.about, "", *SIGNS, *left, "", *states]

    def check(self) -> tuple[list[list[float]], list[float]]:
        """Inputs of a self-test, rows of `ARGUMENTS`, and the force that the program gives, N."""
        time = np.arange(60) * 1e-3
        position = 2e-4 * np.sin(2 * np.pi * 18.0 * time) * time / time[-1]
        velocity = np.gradient(position, time)
        acceleration = np.gradient(velocity, time)
        load, temperature = 10.0 + np.cos(40.0 * time), 20.0 + 50.0 * time
        force = ForceFunction(self.program.source)(time, position, velocity, load, temperature)
        steps = np.diff(time, prepend=time[0])
        return np.column_stack([steps, position, velocity, acceleration, load, temperature]).tolist(), force.tolist()


PRINTERS: dict[str, type[Language]] = {"c": C, "matlab": Matlab, "modelica": Modelica}
SUFFIXES = {"python": ("py",), "c": ("h", "c"), "matlab": ("m",), "modelica": ("mo",)}
"""Files of a language, `templates/model.SUFFIX.jinja`."""


def files_of(exported: Exported, language: str) -> dict[str, str]:
    """Text by file name."""
    name = exported.program.name
    if language == "table":
        return {f"{name}.csv": _table(exported)}
    words = words_of(exported, language)
    return {f"{name}.{suffix}": filled(f"model.{suffix}", words) for suffix in SUFFIXES[language]}


def filled(template: str, words: dict[str, Any]) -> str:
    """A file from its template."""
    environment = Environment(
        loader=PackageLoader("sim.export"),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters["commented"] = lambda lines, sign: "\n".join(f"{sign} {line}".rstrip() for line in lines)
    return environment.get_template(f"{template}.jinja").render(words)


def words_of(exported: Exported, language: str) -> dict[str, Any]:
    """What the templates of a language are filled with: the program, translated, and its self-test."""
    program, (rows, force) = exported.program, exported.check()
    words: dict[str, Any] = {"name": program.name, "program": program, "mass": exported.mass, "arguments": [*ARGUMENTS]}
    words |= {"comments": exported.comments, "rows": rows, "force": force}
    if language in PRINTERS:
        printer, tree = PRINTERS[language](), ast.parse(program.source).body
        functions = {node.name: node for node in tree if isinstance(node, ast.FunctionDef)}
        step = functions["step"]
        assigned = {n.id for n in ast.walk(step) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}
        words |= {
            "functions": [printer.function(one) for name, one in functions.items() if name not in ("start", "step")],
            "body": printer.block(step.body, "  "),
            "locals": locals_of(step),
            "changed": [name for name in ("position", "velocity") if name in assigned],
            "doubles": ", ".join(f"double {argument}" for argument in ARGUMENTS),
            "table": [(*row, f) for row, f in zip(rows, force)],
        }
    return words


def _table(exported: Exported) -> str:
    """Force over velocity in steady sliding from rest at position zero, both directions."""
    force = ForceFunction(exported.program.source)
    speeds = np.geomspace(1e-6, 1.0, 61)
    rows = [f"# {line}".rstrip() for line in exported.comments] + ["velocity [m/s],force [N]"]
    for velocity in (*-speeds[::-1], *speeds):
        time = np.linspace(0.0, 0.02 / abs(velocity), 400)
        value = float(force(time, velocity * time, np.full(400, velocity))[-1])
        rows.append(f"{velocity:.9g},{value:.9g}")
    return "\n".join(rows) + "\n"


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
