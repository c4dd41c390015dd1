"""The report of `stagecad make`: the machine in pictures, its checks, parameters and files, as one HTML page."""

from __future__ import annotations

import base64
import hashlib
import json
import os
from collections.abc import Mapping, Sequence
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from designcalc.checks import report
from designcalc.checks.check import Check, DesignInputs
from designcalc.checks.run import subjects_of
from stagecad import __version__
from stagecad.parameters.atomic import atomic_write_text
from stagecad.parameters.design import Design
from stagecad.parameters.mass_properties import Masses
from stagecad.parameters.rules import present_entries
from stagecad.parameters.units import format_quantity
from stagecad.solids.artefacts.key import sha256
from stagecad.solids.artefacts.store import ArtefactStore
from stagecad.solids.assembly.interference import Interference
from workbench.operations.drawings import SMALL, reduced_sheet
from workbench.operations.result import finite, render


@cache
def templates_digest() -> str:
    """Sha256 of the packaged templates of pages."""
    digest = hashlib.sha256()
    for path in sorted((Path(__file__).resolve().parents[1] / "templates").glob("*.*")):
        digest.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()


def data_url(png: bytes) -> str:
    """A PNG as an address that contains it."""
    return "data:image/png;base64," + base64.b64encode(png).decode("ascii")


def embedded(path: Path) -> str:
    """A PNG file as an address that contains it."""
    return data_url(path.read_bytes())


def link(file: Path, page: Path) -> dict[str, str]:
    """Name and relative address of a file for a page."""
    return {"name": file.name, "href": Path(os.path.relpath(file, page.parent)).as_posix()}


def write_check_files(
    checks: Sequence[Check], design: Design, masses: Masses | None, folder: Path, figures: Mapping[str, Path] = {}
) -> None:
    """Write `checks.md`, `checks.json`, `checks.html`, and `dynamic_budget.json` of a machine that has such budgets."""
    subjects, observation = subjects_of(design), design.loop.observation
    found = subjects.studies(DesignInputs(design, masses))
    words = {"checks": checks, "found": found, "observation": observation, "stated": subjects.requirements}
    atomic_write_text(folder / "checks.md", render("checks.md", report=report, **words))
    if dynamic := finite(report.dynamic_document(found.dynamic, 1 / observation)):
        atomic_write_text(folder / "dynamic_budget.json", json.dumps(dynamic, indent=1, allow_nan=False) + "\n")
    document = finite([check.as_json() for check in checks])
    atomic_write_text(folder / "checks.json", json.dumps(document, indent=1, allow_nan=False) + "\n")
    pictures = [(name, embedded(path)) for name, path in figures.items()]
    about = {"title": design.file, "figures": pictures, "digest": design.digest, "version": __version__}
    atomic_write_text(folder / "checks.html", render("checks.html", report=report, **about, **words))


REPORT = "report.html"
TEMPLATE = "machine.html"
SIMULATIONS = {
    "tip": "Tip path of the actuator",
    "presliding": "Presliding",
    "hysteresis": "Hysteresis",
    "stick_slip": "Stick-slip",
}


def write_report(design: Design, out: Path, results: Mapping[str, Any]) -> Path:
    """Write `OUT/report.html`, which opens without server or network: pictures are in it, files are linked.

    Results are `parts` and `drawings`, the documents of their commands; `pictures` and `check_figures`, PNG by name and
    by title; `simulation_figures`; `checks`, `interferences`, the `procedure` of assembly, rows of the `bill`.
    """
    target = out / REPORT
    document, pictures, checks = results["parts"], results["pictures"], results["checks"]
    tables: dict[str, list[Any]] = {}
    for entry in present_entries(design):
        tables.setdefault(entry.key.rpartition(".")[0], []).append(entry)
    page = render(
        TEMPLATE,
        title=design.drawing.title,
        description=design.machine.declaration.description if design.machine.declaration else "",
        file=design.file,
        assembly=embedded(pictures["assembly"]),
        exploded=embedded(pictures["assembly_exploded"]),
        interferences=_by_kind(results["interferences"]),
        clashes=sum(pair.clash for pair in results["interferences"]),
        assembly_files=[link(Path(file), target) for file in document["parts"]["assembly"]["files"]],
        moving_mass=_mass(document["moving_body"]["mass"]["value"]) if "moving_body" in document else "",
        whole_mass=_mass(document["parts"]["assembly"]["mass"]["value"]),
        measures=[
            (
                k.replace("_", " "),
                f"{1e6 * q['value']:.1f} mm²" if q["unit"] == "m^2" else format_quantity(q["value"], q["unit"]),
            )
            for k, q in document.get("measures", {}).items()
        ],
        parts=_parts(document["parts"], pictures, target),
        bill=results["bill"],
        procedure=results["procedure"],
        sheets=_sheets(results["drawings"], target, design),
        checks=checks,
        report=report,
        check_figures=[(name, embedded(path)) for name, path in results["check_figures"].items()],
        simulation_figures=[(_caption(path), embedded(path)) for path in results["simulation_figures"]],
        entries=list(tables.items()),
        digest=design.digest,
        versions=versions(),
    )
    atomic_write_text(target, page)
    return target


def _parts(parts: Mapping[str, Any], pictures: Mapping[str, Path], page: Path) -> list[dict[str, Any]]:
    shown = []
    for name, part in parts.items():
        if name in pictures and name != "assembly":
            entry = {"title": name.replace("_", " "), "mass": _mass(part["mass"]["value"])}
            entry["size"] = _size(part["bounding_box"]["value"])
            entry["picture"] = embedded(pictures[name])
            entry["below"] = embedded(pictures[f"{name}_below"]) if f"{name}_below" in pictures else ""
            shown.append({**entry, "files": [link(Path(file), page) for file in part["files"]]})
    return shown


def versions() -> dict[str, str]:
    """Versions of what made the page, read without importing it."""
    found = {"stagecad": __version__}
    for name in ("cadquery", "cadquery-ocp", "ezdxf", "numpy", "scipy", "numba", "trimesh", "matplotlib"):
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found


def _sheets(drawings: Mapping[str, Any], page: Path, design: Design) -> list[dict[str, Any]]:
    """The drawing sheets, each as a small picture that leads to the one that can be magnified."""
    shown = []
    for name, sheet in drawings["sheets"].items():
        files = {Path(file).suffix: Path(file) for file in sheet["files"]}
        # Small enough for an overview.
        small = reduced_sheet(ArtefactStore(), design, files[".png"], sha256(files[".png"].read_bytes()))
        entry = {key: sheet[key] for key in ("paper", "scale", "hits")}
        entry |= {"title": name.replace("_", " "), "picture": data_url(small.data(SMALL))}
        entry |= {"opens": link(files[".svg"], page)["href"], "files": [link(file, page) for file in files.values()]}
        shown.append(entry)
    return shown


def _mass(kilograms: float) -> str:
    return f"{kilograms:.3f} kg" if kilograms >= 1.0 else f"{1000.0 * kilograms:.1f} g"


def _size(box: Sequence[Sequence[float]]) -> str:
    return " × ".join(f"{1000.0 * (high - low):.1f}" for low, high in zip(*box, strict=True)) + " mm"


def _caption(path: Path) -> str:
    stem = path.stem
    return next((words for key, words in SIMULATIONS.items() if stem.startswith(key)), stem.replace("_", " "))


def _by_kind(interferences: Sequence[Interference]) -> list[dict[str, Any]]:
    """Pairs of parts by kind of meeting, at mid-travel and mid-height, with least clearance and common volume."""
    rows: dict[tuple[str, str, str], dict[str, Any]] = {}
    for m in interferences:
        first, second = (name.rstrip("0123456789").rstrip("_ ") for name in (m.first, m.second))
        row = rows.setdefault(
            (m.kind, first, second),
            {"kind": m.kind, "first": first, "second": second, "count": 0, "clearance": None, "volume": 0.0},
        )
        row["count"] += m.travel == 0 and m.height == 0
        row["volume"] = max(row["volume"], m.common_volume)
        if m.clearance is not None:
            row["clearance"] = m.clearance if row["clearance"] is None else min(row["clearance"], m.clearance)
    return [rows[key] for key in sorted(rows)]
