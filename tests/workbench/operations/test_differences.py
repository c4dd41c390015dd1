"""Designs from texts, and what differs between two of them."""

import json
from pathlib import Path

import pytest

import stagecad
from stagecad import InputError
from workbench.cli.dispatch import run_line

SMALLER = (
    'extends = "thesis"\n[actuator]\nstroke_amplitude = {value = "8.5 um", origin = "assumed: within the piezo"}\n'
)


def test_a_design_is_read_from_a_text() -> None:
    design = stagecad.load_design(text=SMALLER)
    assert design.si("actuator.stroke_amplitude") == pytest.approx(8.5e-6)
    assert design.values.entry("actuator.stroke_amplitude").origin == "assumed: within the piezo"
    thinner = design.with_values({"stage.thickness": "11 mm"})
    assert (thinner.si("stage.thickness"), thinner.si("actuator.stroke_amplitude")) == (0.011, pytest.approx(8.5e-6))
    with pytest.raises(InputError, match=r"rig\.toml: no parameter 'stage.thicknes'"):
        stagecad.load_design("rig.toml", text='extends = "thesis"\n[stage]\nthicknes = "1 mm"\n')


def test_a_design_that_violates_a_rule_is_read_where_that_is_asked_for() -> None:
    thin = {"stage.thickness": "6.1 mm"}
    with pytest.raises(InputError, match="thickness"):
        stagecad.load_design(values=thin)
    design = stagecad.load_design(values=thin, rules=False)
    assert design.with_values({"stage.width": "201 mm"}).si("stage.thickness") == pytest.approx(6.1e-3)
    with pytest.raises(InputError, match=r"^stage.thickness: '1 kg' has the wrong dimension"):
        stagecad.load_design(values={"stage.thickness": "1 kg"})


def test_the_differences_are_the_document_of_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    files = [str(tmp_path / name) for name in ("one.toml", "other.toml")]
    for file, text in zip(files, ('extends = "thesis"\n', SMALLER), strict=True):
        Path(file).write_text(text, "utf-8")
    found = stagecad.diff(*files, solids=False)
    assert run_line(["diff", *files, "--no-solids", "--json"]) == 0
    assert json.loads(json.dumps(found.to_json())) == json.loads(capsys.readouterr().out)
    row = found.to_dataframe().loc["actuator.stroke_amplitude"]
    assert (row["before"], row["after"]) == ("10 um", "8.5 um")
    stroke = found.margins.loc["piezo stroke of the drive"]
    assert (stroke["verdict_before"], stroke["verdict_after"]) == ("fails", "passes")
    assert stroke["margin_before"] < 0.0 <= stroke["margin_after"]
    assert ("verdict", "piezo stroke of the drive: fails -> passes") in found.summary()
    assert found.plot().axes and found.masses.empty and found.sheets.empty
    assert repr(found).startswith(f"<Differences of '{files[0]}' and '{files[1]}': 1 parameters, ")


def test_parameters_alone() -> None:
    design = stagecad.load_design()
    found = stagecad.diff(design, design.with_values({"stage.thickness": "13 mm"}), solids=False, margins=False)
    assert list(found.to_json()) == ["files", "parameters"]
    # What is computed from the thickness differs too.
    assert {"stage.thickness", "stage.payload_thread_depth"} <= set(found.parameters.index)
    with pytest.raises(InputError, match="no margin differs"):
        found.plot()
    with pytest.raises(InputError, match="a Design or its parameter file is required, not int"):
        stagecad.diff(3, design)  # pyright: ignore[reportArgumentType]
