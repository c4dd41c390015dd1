"""The bill of materials, and the files and document of `stagecad parts`."""

import csv
import io
import json
import os
import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from stagecad.friction_stage.construction import PURCHASED
from stagecad.parameters.design import Design
from stagecad.solids.artefacts.store import ArtefactStore
from stagecad.solids.assembly.bill_of_materials import csv_text
from stagecad.solids.assembly.built_machine import BuiltMachine
from tests.process_state import python

CATALOGUE = {
    "piezo": "ASB170C801NP0",
    "way_screw": "91251A624",
    "clamp_screw_long": "91251A648",
    "clamp_screw_short": "91251A642",
    "set_screw": "91375A904",
    "spring": "9657K26",
}
"""Part numbers of the thesis, section 1 of its digest."""


@pytest.fixture
def cached(machine: BuiltMachine, store: ArtefactStore, monkeypatch: pytest.MonkeyPatch) -> ArtefactStore:
    monkeypatch.setenv("STAGECAD_CACHE", str(store.folder))
    return store


def test_the_list_has_each_part_once_and_its_masses_add_up(machine: BuiltMachine) -> None:
    rows = {row.part: row for row in machine.bill_of_materials}
    assert len(rows) == len(machine.bill_of_materials)
    assert sum(row.quantity for row in rows.values()) == len(machine.assembly.instances)
    assert {name: rows[name].part_number for name in CATALOGUE} == CATALOGUE
    assert {name for name, row in rows.items() if row.purchased} == set(PURCHASED)
    total = sum(row.quantity * row.mass for row in machine.bill_of_materials)
    assert total == pytest.approx(machine.whole.mass, rel=1e-12)
    table = list(csv.reader(io.StringIO(csv_text(machine.bill_of_materials))))
    assert table[-1][1] == "total" and float(table[-1][-1]) == pytest.approx(total, abs=1e-4)


@pytest.mark.parametrize("text", ["=cmd|' /C calc'!A0", "+1", "-1", "@SUM(1)", "\t=1"])
def test_a_part_number_that_a_spreadsheet_would_calculate_is_text(machine: BuiltMachine, text: str) -> None:
    row = replace(machine.bill_of_materials[0], part_number=text)
    cells = list(csv.reader(io.StringIO(csv_text([row]))))[1]
    assert f"'{text}" in cells and text not in cells


def test_command_writes_files_document_and_manifest(cached, machine: BuiltMachine, tmp_path, command) -> None:
    document = command.json("parts", "--out", tmp_path)
    assert set(document["parts"]) == {*machine.parts, "assembly"}
    stage = document["parts"]["stage"]
    assert stage["mass"] == {"value": pytest.approx(machine.masses["stage"].mass), "unit": "kg"}
    assert [Path(file).name for file in stage["files"]] == ["stage.step", "stage.stl", "stage.glb"]
    assert document["moving_body"]["mass"]["value"] == pytest.approx(machine.moving_body.mass)
    listed = json.loads((tmp_path / "parts_manifest.json").read_text())["files"]
    assert set(listed) == {path.name for path in tmp_path.iterdir()} - {"parts_manifest.json"}
    assert all(Path(file).is_file() for part in document["parts"].values() for file in part["files"])


def test_command_leaves_good_files_alone_and_mends_others(cached: ArtefactStore, tmp_path: Path, command) -> None:
    command("parts", "stage", "piezo", "--out", tmp_path)
    names = {path.name for path in tmp_path.iterdir()}
    assert names == {f"{part}.{kind}" for part in ("stage", "piezo") for kind in ("step", "stl", "glb")} | {
        "parts_manifest.json"
    }
    before = {name: (tmp_path / name).stat().st_mtime_ns for name in names}
    good = (tmp_path / "piezo.step").read_bytes()
    (tmp_path / "piezo.step").write_bytes(good[:100])
    command("parts", "stage", "piezo", "--out", tmp_path)
    assert (tmp_path / "piezo.step").read_bytes() == good
    changed = {name for name in names if (tmp_path / name).stat().st_mtime_ns != before[name]}
    assert changed == {"piezo.step"}


def test_command_makes_again_what_is_damaged_in_the_cache(machine, store, tmp_path, monkeypatch, command) -> None:
    # A cache of its own: other tests read the common one meanwhile.
    shutil.copytree(store.folder, tmp_path / "cache", ignore=shutil.ignore_patterns(".*"), copy_function=os.link)
    monkeypatch.setenv("STAGECAD_CACHE", str(tmp_path / "cache"))
    common = machine.parts["magnet"].entry.path("magnet.stl")
    good = common.read_bytes()
    own = tmp_path / "cache" / common.relative_to(store.folder)
    own.unlink()
    own.write_bytes(good[:-1] + b"x")
    assert "damaged" in command("parts", "magnet", "--out", tmp_path).err
    assert (tmp_path / "magnet.stl").read_bytes() == good


def test_unknown_part_names_the_nearest(cached: ArtefactStore, tmp_path, command) -> None:
    error = command.refused("parts", "stag", "--out", tmp_path)
    assert "no part 'stag'" in error and "did you mean 'stage'" in error
    assert list(tmp_path.iterdir()) == []


def test_nothing_changed_needs_no_kernel(cached: ArtefactStore, design: Design, tmp_path: Path) -> None:
    program = (
        "import sys; from workbench.cli import run; status = run(sys.argv[1:]); "
        "bad = {'cadquery', 'OCP', 'vtk', 'numba', 'scipy', 'pandas'} & set(sys.modules); "
        "sys.exit(status or (f'imported {sorted(bad)}' if bad else 0))"
    )
    python("-c", program, "parts", "--out", tmp_path)
    assert (tmp_path / "assembly.step").is_file()
