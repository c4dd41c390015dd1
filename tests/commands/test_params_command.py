"""`stagecad params` and `stagecad optimize` as a script sees them, and all violated rules at once."""

import json
import re
from pathlib import Path
from typing import Any

import pytest

from stagecad.parameters.errors import ViolationsError
from stagecad.parameters.load import load_design
from stagecad.parameters.rules import violations

SET = ["stage.width=100 mm", "pads.height=0.1 mm", "holder.floor=40 mm"]
FREE = ["--free", "actuator.stroke_amplitude=4 um:12 um"]


def test_the_document_holds_every_parameter_in_si_and_the_table_value_and_origin(command: Any) -> None:
    document = command.json("params", "--set", "stage.thickness=15 mm")
    design = load_design(None, ["stage.thickness=15 mm"])
    assert document["digest"] == design.digest
    assert set(document["parameters"]) == {entry.key for entry in design.entries}
    thickness = document["parameters"]["stage.thickness"]
    assert (thickness["value"], thickness["unit"], thickness["tolerance"]) == (0.015, "m", "X.X")
    for entry in design.entries:
        shown = document["parameters"][entry.key]
        assert shown["origin"] == entry.origin
        if isinstance(entry.value, float):
            assert shown["value"] == design.si(entry.key)
    out = command("params", "actuator", "stage.thickness").out
    rows = {line.split()[0]: line for line in out.splitlines() if line.split() and "." in line.split()[0]}
    assert set(rows) >= {"actuator.piezo_spacing", "stage.thickness"} and "stage.length" not in rows
    assert "46 mm" in rows["actuator.piezo_spacing"] and "thesis 4.1" in rows["actuator.piezo_spacing"]


@pytest.mark.parametrize("columns", [80, 140])
def test_keys_are_whole_in_any_width(columns: int, command: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", str(columns))
    lines = command("params").out.splitlines()
    assert max(map(len, lines)) <= columns
    assert {entry.key for entry in load_design().entries} <= {line.split()[0] for line in lines if line.strip()}


@pytest.mark.parametrize("words", ["effects presliding", "calc rail"])
def test_a_table_without_titles_has_them_in_no_width(words: str, command: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    lines = command(*words.split()).out.splitlines()
    assert max(map(len, lines)) <= 80 and not [line for line in lines if line.lstrip().startswith(":")]


def test_a_machine_of_other_parts_has_no_parameters_of_the_packaged_one(command: Any) -> None:
    example = Path(__file__).parents[2] / "examples" / "mirror_mount" / "stage.toml"
    document = command.json("params", "--params", example)
    tables = [key.partition(".")[0] for key in document["parameters"]]
    own = ["back_plate", "front_plate", "adjuster", "foot", "steel_ball"]
    assert list(dict.fromkeys(tables)) == [*own, "threads", "making", "requirements", "drawing", "materials"]


def test_what_differs(command: Any, tmp_path: Path) -> None:
    other = tmp_path / "other.toml"
    printed = command("params", "--write", other, "--set", "stage.thickness=15 mm", "--set", "pads.count=4")
    assert printed.out == "" and str(other) in printed.err
    differences = {item["key"]: item for item in command.json("params", "--diff", other)["differences"]}
    follows = {"stage.payload_drill_depth", "stage.payload_thread_depth", "interferometer.beam_height", "mirror.height"}
    assert set(differences) == {"stage.thickness", "pads.count"} | follows
    assert differences["stage.thickness"]["before"]["value"] == 0.012
    assert differences["stage.thickness"]["after"]["value"] == 0.015
    assert "do not differ" in command("params", "--params", other, "--diff", other).out
    assert "is there already" in command("params", "--write", other, status=2).err


def test_one_line_for_each_violation(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, command: Any) -> None:
    monkeypatch.chdir(tmp_path)
    words = ("check", *(word for text in SET for word in ("--set", text)))
    plain, told = command(*words, status=2), command(*words, "--json", status=2)
    found = violations(load_design(None, SET, rules=False))
    lines = plain.err.splitlines()
    assert len(lines) == len(found) > 5 and lines[0].startswith(f"stagecad: thesis.toml: {found[0].message}")
    assert all(line.startswith("stagecad: thesis.toml: ") for line in lines)
    assert list(tmp_path.iterdir()) == []
    assert (plain.out, told.err) == ("", plain.err)
    document = json.loads(told.out)["violations"]
    assert {(one["rule"], one["message"]) for one in document} == {(one.rule, one.message) for one in found}
    parts = [one["part"] for one in document]
    assert parts == sorted(parts, key=parts.index)  # each part's violations stand together
    assert all(one["part"] == one["keys"][0].split(".")[0] for one in document)
    for one in document:
        for remedy in one["satisfied_by"]:
            design = load_design(None, [*SET, f"{remedy['key']}={remedy['value']}"], rules=False)
            assert one["message"] not in [v.message for v in violations(design)]
            assert not [v for v in violations(design) if v.rule == one["rule"] and v.keys == tuple(one["keys"])]
    assert sum(bool(one["satisfied_by"]) for one in document) > len(document) / 2


def test_the_error_lists_all_and_its_text_is_the_first() -> None:
    with pytest.raises(ViolationsError) as caught:
        load_design(None, SET)
    assert str(caught.value) == caught.value.lines[0]
    assert str(caught.value).endswith(f"(and {len(caught.value.lines) - 1} more)")


def _document(command: Any, *words: str) -> dict:
    said = command("optimize", "--no-solids", "--budget", "30", *words, "--json")
    # While it searches.
    assert re.match(r"best so far: \d+ rules violated, \d+ of \d+ checks failed: ", said.err), said.err
    return json.loads(said.out)


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    # No parameter of this file is marked free.
    amplitude = 'stroke_amplitude = {value = "10 um", origin = "thesis 4.1"}'
    Path("stage.toml").write_text(f'extends = "thesis"\n# why so much\n[actuator]\n{amplitude}\n', encoding="utf-8")


def test_writes_a_design_whose_origins_state_the_reasons(project: None, command: Any) -> None:
    found = _document(command, *FREE, "--keep", "piezo stroke of the drive", "--write", "new.toml")
    assert found["feasible"]
    change = next(one for one in found["changes"] if one["key"] == "actuator.stroke_amplitude")
    assert change["from"] == "10 um" and "piezo stroke of the drive" in change["reason"]
    margin = next(one for one in found["margins"] if one["check"] == "piezo stroke of the drive")
    assert (margin["before"]["verdict"], margin["after"]["verdict"]) == ("fails", "passes")
    text = Path("new.toml").read_text("utf-8")
    assert "# why so much" in text
    entry = load_design("new.toml").entry("actuator.stroke_amplitude")
    assert entry.origin.startswith("assumed: optimised from") and "piezo stroke of the drive" in entry.origin
    assert "is there already" in command("optimize", *FREE, "--write", "new.toml", status=2).err


def test_says_what_cannot_be_met(project: None, command: Any) -> None:
    found = _document(command, *FREE, "--keep", "LVDT range", "--write", "new.toml")
    assert not found["feasible"] and found["conflicts"] == [["LVDT range"]]
    (relax,) = found["relax"]
    assert (relax["check"], relax["limit"]["value"]) == ("LVDT range", 0.2)
    assert relax["needed"]["value"] == pytest.approx(0.0254)
    assert not Path("new.toml").exists()
    printed = command("optimize", "--no-solids", "--no-figures", *FREE, "--keep", "LVDT range", "--budget", "30")
    assert "no design within the ranges meets all 1 requirements" in printed.out
