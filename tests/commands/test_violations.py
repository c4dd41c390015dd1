"""All violated rules at once, on standard error and in JSON."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from stagecad.parameters.errors import ViolationsError
from stagecad.parameters.load import load_design
from stagecad.parameters.rules.registry import violations

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
