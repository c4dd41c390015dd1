"""Two designs compared."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from designcalc.checks.run import run_checks
from stagecad.parameters.load import load_design
from stagecad.solids.artefacts.part import build_part
from stagecad.solids.artefacts.store import ArtefactStore
from stagecad.solids.assembly.built_machine import part_mass
from workbench.cli import run as run_line
from workbench.operations.diff import margin_changes, mark_changes, volume_changes

THICKER = 'extends = "thesis"\n[stage]\nthickness = {value = "14 mm", origin = "assumed: stiffer"}\n'


def test_margins_that_differ() -> None:
    one, other = load_design(), load_design(None, ["actuator.stroke_amplitude=8.5 um"])
    found = {change.name: change for change in margin_changes(run_checks(one), run_checks(other))}
    assert found["piezo stroke of the drive"].verdicts == ("fails", "passes")
    assert "bearing way stiffness" not in found
    assert margin_changes(run_checks(one), run_checks(one)) == []


def test_marked_picture_has_new_lines_red_and_old_ones_blue(tmp_path: Path) -> None:
    before, after = np.full((300, 400), 255, np.uint8), np.full((300, 400), 255, np.uint8)
    before[100, 50:150] = after[200, 50:350] = before[50, 300:320] = after[50, 300:320] = 0
    for name, array in (("a.png", before), ("b.png", after)):
        Image.fromarray(array).save(tmp_path / name)
    assert mark_changes(tmp_path / "a.png", tmp_path / "b.png", tmp_path / "out" / "m.png") == 2
    marked = np.asarray(Image.open(tmp_path / "out" / "m.png"))
    assert tuple(marked[200, 200]) == (200, 0, 0)
    assert tuple(marked[100, 100]) == (120, 160, 255)
    assert tuple(marked[50, 310]) == (0, 0, 0)


class _Parts:
    """A machine of one part."""

    def __init__(self, *overrides: str) -> None:
        design = load_design(None, overrides)
        self.parts = {"height_pin_2": build_part(ArtefactStore(), "height_pin_2", design)}
        self.masses = {name: part_mass(part, design) for name, part in self.parts.items()}


def test_volumes_of_the_differences_of_a_longer_pin() -> None:
    """Two cylinders of 16 mm, one 1 mm longer at its foot: nothing is removed but the moved chamfer."""
    short, long = _Parts(), _Parts("height_pin_2.length=21 mm")
    (change,) = volume_changes(short, long)  # type: ignore[arg-type]
    assert change["removed"] is not None and change["added"] is not None
    assert change["added"] - change["removed"] == pytest.approx(math.pi / 4 * 0.016**2 * 0.001, rel=1e-6)
    assert change["after"] - change["before"] == pytest.approx(change["added"] - change["removed"], rel=1e-9)
    assert volume_changes(short, short) == []  # type: ignore[arg-type]


def test_command_without_solids(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a.toml").write_text('extends = "thesis"\n', encoding="utf-8")
    Path("b.toml").write_text(THICKER, encoding="utf-8")
    assert run_line(["diff", "a.toml", "b.toml", "--no-solids", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert {item["key"] for item in document["parameters"]} >= {"stage.thickness", "stage.payload_drill_depth"}
    sag = next(item for item in document["margins"] if item["name"] == "sag of the drive surface over the travel")
    assert (sag["before"]["verdict"], sag["after"]["verdict"]) == ("fails", "passes")
    assert run_line(["diff", "a.toml", "a.toml", "--no-solids"]) == 0
    assert capsys.readouterr().out.strip() == "a.toml and a.toml do not differ"
    assert run_line(["diff", "thesis", "a.toml", "--no-solids"]) == 0
    assert capsys.readouterr().out.strip() == "thesis and a.toml do not differ"
    assert run_line(["diff", "a.toml", "c.toml"]) == 2
    assert "c.toml: no such parameter file" in capsys.readouterr().err


@pytest.mark.slow
def test_command_with_solids_and_sheets(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a.toml").write_text('extends = "thesis"\n', encoding="utf-8")
    Path("b.toml").write_text(THICKER, encoding="utf-8")
    assert run_line(["diff", "a.toml", "b.toml", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    masses = {item["name"] for item in document["masses"]}
    # The mirror at the end of the stage is as high as the stage.
    assert masses == {"stage", "mirror", "moving body", "assembly"}
    volumes = {item["part"]: item["added"]["value"] for item in document["volumes"]}
    assert set(volumes) == {"stage", "mirror"}
    assert volumes["stage"] == pytest.approx(0.23 * 0.27 * 0.002, rel=0.1)
    sheets = {item["sheet"]: item for item in document["sheets"]}
    assert "stage_1" in sheets or "stage" in sheets
    assert all(Path(item["marked"]).is_file() and item["regions"] for item in sheets.values())
    assert not any(name.startswith(("tip", "holder")) for name in sheets)
