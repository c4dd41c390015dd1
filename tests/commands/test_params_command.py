"""`stagecad params` as a script sees it, and all violated rules at once."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from stagecad.parameters.errors import ViolationsError
from stagecad.parameters.load import load_design
from stagecad.parameters.rules import violations
from tests.reference.tables import cases
from workbench.cli import run


def call(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, str, str]:
    status = run(["params", *arguments])
    streams = capsys.readouterr()
    return status, streams.out, streams.err


def test_the_document_holds_every_parameter_in_si(capsys: pytest.CaptureFixture[str]) -> None:
    status, out, _ = call(capsys, "--json", "--set", "stage.thickness=15 mm")
    document = json.loads(out)
    design = load_design(None, ["stage.thickness=15 mm"])
    assert status == 0
    assert document["digest"] == design.digest
    assert set(document["parameters"]) == {entry.key for entry in design.entries}
    thickness = document["parameters"]["stage.thickness"]
    assert (thickness["value"], thickness["unit"], thickness["tolerance"]) == (0.015, "m", "X.X")
    for entry in design.entries:
        shown = document["parameters"][entry.key]
        assert shown["origin"] == entry.origin
        if isinstance(entry.value, float):
            assert shown["value"] == design.si(entry.key)


@pytest.mark.parametrize("columns", [80, 140])
def test_keys_are_whole_in_any_width(columns: int, capsys, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", str(columns))
    _, out, _ = call(capsys)
    lines = out.splitlines()
    assert max(map(len, lines)) <= columns
    assert {entry.key for entry in load_design().entries} <= {line.split()[0] for line in lines if line.strip()}


def test_the_table_shows_value_tolerance_and_origin(capsys: pytest.CaptureFixture[str]) -> None:
    status, out, _ = call(capsys, "actuator", "stage.thickness")
    assert status == 0
    rows = {line.split()[0]: line for line in out.splitlines() if line.split() and "." in line.split()[0]}
    assert set(rows) >= {"actuator.piezo_spacing", "stage.thickness"}
    assert "stage.length" not in rows
    assert "46 mm" in rows["actuator.piezo_spacing"]
    assert "thesis 4.1" in rows["actuator.piezo_spacing"]


def test_what_differs(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    other = tmp_path / "other.toml"
    status, out, err = call(capsys, "--write", str(other), "--set", "stage.thickness=15 mm", "--set", "pads.count=4")
    assert (status, out) == (0, "")
    assert str(other) in err
    status, out, _ = call(capsys, "--json", "--diff", str(other))
    differences = {item["key"]: item for item in json.loads(out)["differences"]}
    follows = {"stage.payload_drill_depth", "stage.payload_thread_depth", "interferometer.beam_height", "mirror.height"}
    assert set(differences) == {"stage.thickness", "pads.count"} | follows
    assert differences["stage.thickness"]["before"]["value"] == 0.012
    assert differences["stage.thickness"]["after"]["value"] == 0.015
    status, out, _ = call(capsys, "--params", str(other), "--diff", str(other))
    assert "do not differ" in out
    status, _, err = call(capsys, "--write", str(other))
    assert status == 2
    assert "is there already" in err


@pytest.mark.parametrize(("arguments", "words"), cases("mistakes", "params"))
def test_a_mistake_is_one_line_and_exit_2(capsys: pytest.CaptureFixture[str], arguments: list[str], words: str) -> None:
    status, out, err = call(capsys, *arguments, "--json")
    assert (status, out) == (2, "")
    assert words in err
    assert err.count("\n") == 1


SET = ["stage.width=100 mm", "pads.height=0.1 mm", "holder.floor=40 mm"]


def _run(*arguments: str, folder: Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "workbench.cli", *arguments]
    return subprocess.run(command, capture_output=True, text=True, cwd=folder, check=False)


@pytest.mark.parametrize("json_wanted", [False, True])
def test_one_line_for_each_violation(tmp_path: Path, json_wanted: bool) -> None:
    overrides = [word for text in SET for word in ("--set", text)]
    done = _run("check", *overrides, *(["--json"] if json_wanted else []), folder=tmp_path)
    assert done.returncode == 2
    found = violations(load_design(None, SET, rules=False))
    lines = done.stderr.splitlines()
    assert len(lines) == len(found) > 5
    assert lines[0].startswith(f"stagecad: thesis.toml: {found[0].message}")
    assert all(line.startswith("stagecad: thesis.toml: ") for line in lines)
    assert list(tmp_path.iterdir()) == []
    if not json_wanted:
        assert done.stdout == ""
        return
    document = json.loads(done.stdout)["violations"]
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
