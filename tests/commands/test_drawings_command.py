"""`stagecad drawings` as a user meets it: names, files, exit statuses, and that nothing is drawn twice."""

import csv
import json
from pathlib import Path
from typing import Any

import ezdxf
import pytest

from drawings.draw_sheets import chosen_sheets, digest, sheet_names
from drawings.friction_stage.sheets import sheet_plans
from stagecad.parameters.design import Design
from stagecad.parameters.load import load_design
from tests.refusals import refused
from workbench.cli import run
from workbench.operations.drawings import Drawings


def test_sheets_scales_and_names_of_the_machine(design: Design) -> None:
    names = sheet_names(design)
    assert names["base"] == ("base_1", "base_2", "base_3")
    assert set(names) >= {"tip", "holder", "stage", "bearing_way", "height_pin_1", "height_pin_2", "assembly"}
    scales = {plan.name: plan.scale for part in names if part in PARTS for plan in sheet_plans(part, design)}
    assert scales == PARTS_SCALES
    (detail,) = [view for plan in sheet_plans("base", design) for view in plan.views if view.letter == "X"]
    assert detail.scale == 1.0
    assert chosen_sheets(["base_2", "tip"], design) == {"tip": ("tip",), "base": ("base_2",)}
    assert chosen_sheets(["base_2", "base"], design) == {"base": ("base_1", "base_2", "base_3")}
    assert chosen_sheets([], design) == sheet_names(design)
    plain = load_design(None, ["teeth.fitted=false"])
    assert "magnet" not in sheet_names(plain)
    refused("no magnetic teeth", chosen_sheets, ["magnet"], plain)
    reads = ("tip.arm_width", "tolerance('tip.arm_width')", "tip.nose_radius")
    other = load_design(None, ["tip.arm_width=11.5 mm"])
    unread = load_design(None, ["stage.thickness=13 mm"])
    assert digest(design, reads) == digest(unread, reads) != digest(other, reads)


# Other than the thesis: 1:1 of the pins and 1:5 and 0.35 of the base are too small for leaders and holes.
PARTS_SCALES = {"tip": 1.0, "holder": 1.0, "height_pin_1": 2.0, "height_pin_2": 2.0, "stage": 0.5, "bearing_way": 0.25}
PARTS_SCALES |= {"base_1": 0.5, "base_2": 0.5, "base_3": 0.5}
PARTS = {name.rstrip("_123") if name.startswith("base") else name for name in PARTS_SCALES}


@pytest.fixture(scope="module")
def drawn(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path, dict[str, Any]]:
    """The magnet's sheet, drawn from nothing: folder, cache, and the document."""
    folder = tmp_path_factory.mktemp("drawings")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("STAGECAD_CACHE", str(folder / "cache"))
        assert run(["drawings", "magnet", "--lint", "--out", str(folder), "--json", str(folder / "told.json")]) == 0
    return folder, folder / "cache", json.loads((folder / "told.json").read_text("utf-8"))


def test_a_sheet_comes_in_four_formats_with_its_model_definition_and_parameters(drawn) -> None:
    folder, _, document = drawn
    sheet = document["sheets"]["magnet"]
    names = [f"magnet.{kind}" for kind in ("dxf", "svg", "pdf", "png")] + ["magnet_ap242.step", "magnet_definition.csv"]
    assert [Path(file).name for file in sheet["files"]] == names
    assert all((folder / name).stat().st_size > 1000 for name in names)
    assert sheet["hits"] == [] and (sheet["part"], sheet["paper"], sheet["scale"]) == ("magnet", "A3", "5:1")
    assert set(json.loads((folder / "drawings_manifest.json").read_text("utf-8"))["files"]) == set(names)
    with (folder / "magnet_definition.csv").open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    # A block with twelve chamfered edges.
    assert [row["face"] for row in rows] == [str(number) for number in range(1, 27)]
    assert all(row["size"] and row["place"] and row["form"] and row["finish"] for row in rows)
    (path,) = map(Path, document["parameters"])
    assert path.name.removeprefix("magnet_").removesuffix(".toml") in texts_of(folder, "magnet").splitlines()
    assert load_design(path).digest == load_design().digest


def texts_of(folder: Path, sheet: str) -> str:
    entities = ezdxf.readfile(folder / f"{sheet}.dxf").paperspace().query("TEXT")  # type: ignore[attr-defined]
    return "\n".join(entity.dxf.text for entity in entities)


def test_title_block_and_revisions_of_a_design_changed_by_set(drawn: tuple[Path, Path, Any], tmp_path, monkeypatch):
    monkeypatch.setenv("STAGECAD_CACHE", str(drawn[1]))
    earlier = tmp_path / "issue_a.toml"
    earlier.write_text('extends = "thesis"\n[magnet]\nlength = {value = "38 mm", origin = "assumed: first issue"}\n')
    issue = ["--revision=B", "--date=2026-11-23", "--drawn=A. Hale", "--checked=M. Ott", "--approved=C. Ng"]
    words = ["--since", str(earlier), "--set", "magnet.edge_chamfer=0.4 mm", "--lint", "--out", str(tmp_path)]
    assert run(["drawings", "magnet", *issue, *words]) == 0
    shown = texts_of(tmp_path, "magnet")
    for text in ("2026-11-23", "A. Hale", "M. Ott", "C. Ng", "Revision B, 2026-11-23: changes"):
        assert text in shown
    assert "magnet.length: 38 mm, now 40 mm" in shown
    title = "Precision Stage, changed: magnet.edge_chamfer = 0.4 mm"
    assert title in shown and "changed:" not in texts_of(drawn[0], "magnet")
    (path,) = (tmp_path / "parameters").glob("magnet_*.toml")
    assert load_design(path).magnet.edge_chamfer == 0.4


def test_nothing_is_drawn_twice(drawn: tuple[Path, Path, dict[str, Any]], monkeypatch, command) -> None:
    folder, cache, _ = drawn
    monkeypatch.setenv("STAGECAD_CACHE", str(cache))
    monkeypatch.setattr("drawings.draw_sheets.parallel_map", None)
    # A parameter that the magnet does not read changes nothing either.
    for words in ((), ("--set", "stage.thickness=13 mm")):
        assert command.json("drawings", "magnet", "--out", folder, *words)["changed"] == []


def test_a_lint_hit_is_exit_status_1(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, command) -> None:
    sheet = {"part": "tip", "paper": "A3", "scale": "1:1", "views": [], "files": [], "hits": ["'20.0' lies over 'A'"]}
    found = Drawings(load_design(), {"sheets": {"tip": sheet}, "changed": [], "files": 0}, tmp_path)
    monkeypatch.setattr("workbench.cli.commands.drawings.drawings", lambda *rest: found)
    assert "tip: '20.0' lies over 'A'" in command("drawings", "tip", "--lint", status=1).err
    command("drawings", "tip")
