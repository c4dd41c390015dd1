"""A design that the CAD kernel refuses ends with one line that names the parameters."""

import pickle
from pathlib import Path

import pytest

from stagecad.parameters.design import Design
from stagecad.parameters.errors import PartError
from stagecad.parameters.load import load_design
from stagecad.solids.artefacts.part import CRASHED
from workbench.cli import run
from workbench.operations.parts import MOST_NAMED, refusal_line


def test_the_parameters_of_the_part_come_first_with_the_packaged_values() -> None:
    design = load_design(None, ["stage.thickness=13 mm", "tip.hub_diameter=24 mm"], rules=False)
    error = pickle.loads(pickle.dumps(PartError("tip", design, "StdFail_NotDone: BRep_API: command not done")))
    line = refusal_line(error)
    assert line is not None
    assert "no valid solid of 'tip' with tip.hub_diameter = 24 mm (packaged: 22 mm), stage.thickness = 13 mm" in line
    assert "StdFail_NotDone" in line


def test_many_changes_are_counted() -> None:
    keys = [entry.key for entry in load_design().entries if entry.unit == "mm" and entry.key.startswith("base.")][:9]
    packaged = load_design()
    design = load_design(None, [f"{key}={1.01 * packaged.value(key):.6g} mm" for key in keys], rules=False)
    line = refusal_line(PartError("base", design, "failed"))
    assert line is not None and line.count("(packaged: ") == MOST_NAMED and " more; bring them" in line


def test_the_packaged_design_is_a_fault_of_the_program(design: Design) -> None:
    assert refusal_line(PartError("tip", design, "failed")) is None
    assert refusal_line(PartError("tip", design, CRASHED)) == f"part 'tip': {CRASHED}; is there enough memory?"


def test_the_command_ends_with_that_line(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    import workbench.cli.commands.parts as command

    def refused(*arguments: object) -> None:
        raise PartError("tip", load_design(None, ["tip.hub_diameter=24 mm"]), "failed")

    monkeypatch.setattr(command, "parts", refused)
    assert run(["parts"]) == 2
    assert capsys.readouterr().err.startswith("stagecad: thesis.toml: the CAD kernel makes no valid solid of 'tip'")


@pytest.mark.slow
def test_the_kernel_refuses_a_magnet_that_its_chamfers_consume(tmp_path) -> None:
    from stagecad.solids.artefacts.part import build_part
    from stagecad.solids.artefacts.store import ArtefactStore

    design = load_design(None, ["magnet.edge_chamfer=4 mm"], rules=False)
    with pytest.raises(PartError) as caught:
        build_part(ArtefactStore(tmp_path), "magnet", design)
    line = refusal_line(caught.value)
    assert line is not None and "magnet.edge_chamfer = 4 mm (packaged: 0.3 mm)" in line


@pytest.mark.slow
def test_what_no_rule_forbids_and_the_kernel_refuses(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Slots of the clamps that cut the base in two."""
    words = ["parts", "base", "--set", "base.clamp_reach=347.2 mm", "--out", str(tmp_path)]
    assert run(words) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1 and "'base' with base.clamp_reach = 347.2 mm (packaged: 69.5 mm)" in said
    assert list(tmp_path.iterdir()) == []
