"""Designs from texts, what differs between two of them, and results that go to other processes."""

import json
import math
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from scipy.signal import StateSpace, lsim

import stagecad
from designcalc.checks import run
from stagecad import InputError
from stagecad.parameters.load import load_design
from stagecad.solids.artefacts.part import build_part
from stagecad.solids.artefacts.store import ArtefactStore
from stagecad.solids.assembly.built_machine import part_mass
from tests.refusals import refused
from workbench.operations.calculate import calculate
from workbench.operations.checks import chains, ranges_of, sweep
from workbench.operations.design import Design
from workbench.operations.diff import mark_changes, volume_changes
from workbench.operations.result import Result
from workbench.operations.templates import template

AMPLITUDE = 'stroke_amplitude = {value = "8.5 um", origin = "assumed: within the piezo"}'
SMALLER = f'extends = "thesis"\n[actuator]\n{AMPLITUDE}\n'
THICKER = 'extends = "thesis"\n[stage]\nthickness = {value = "14 mm", origin = "assumed: stiffer"}\n'


def test_a_design_is_read_from_a_text_and_by_wish_against_a_rule() -> None:
    design = stagecad.load_design(text=SMALLER)
    assert design.si("actuator.stroke_amplitude") == pytest.approx(8.5e-6)
    assert design.values.entry("actuator.stroke_amplitude").origin == "assumed: within the piezo"
    thinner = design.with_values({"stage.thickness": "11 mm"})
    assert (thinner.si("stage.thickness"), thinner.si("actuator.stroke_amplitude")) == (0.011, pytest.approx(8.5e-6))
    with pytest.raises(InputError, match=r"rig\.toml: no parameter 'stage.thicknes'"):
        stagecad.load_design("rig.toml", text='extends = "thesis"\n[stage]\nthicknes = "1 mm"\n')
    thin = {"stage.thickness": "6.1 mm"}
    refused("thickness", stagecad.load_design, values=thin)
    design = stagecad.load_design(values=thin, rules=False)
    assert design.with_values({"stage.width": "201 mm"}).si("stage.thickness") == pytest.approx(6.1e-3)
    with pytest.raises(InputError, match=r"^stage.thickness: '1 kg' has the wrong dimension"):
        stagecad.load_design(values={"stage.thickness": "1 kg"})


def test_the_differences_are_the_document_of_the_command(tmp_path: Path, command: Any) -> None:
    files = [str(tmp_path / name) for name in ("one.toml", "other.toml")]
    for file, text in zip(files, ('extends = "thesis"\n', SMALLER), strict=True):
        Path(file).write_text(text, "utf-8")
    found = stagecad.diff(*files, solids=False)
    assert json.loads(json.dumps(found.to_json())) == command.json("diff", *files, "--no-solids")
    row = found.to_dataframe().loc["actuator.stroke_amplitude"]
    assert (row["before"], row["after"]) == ("10 um", "8.5 um")
    stroke = found.margins.loc["piezo stroke of the drive"]
    assert (stroke["verdict_before"], stroke["verdict_after"]) == ("fails", "passes")
    assert stroke["margin_before"] < 0.0 <= stroke["margin_after"]
    assert ("verdict", "piezo stroke of the drive: fails -> passes") in found.summary()
    assert "bearing way stiffness" not in found.margins.index
    for one in (files[0], "thesis"):
        assert command("diff", one, files[0], "--no-solids").out.strip() == f"{one} and {files[0]} do not differ"
    assert "c.toml: no such parameter file" in command("diff", files[0], "c.toml", status=2).err
    assert found.plot().axes and found.masses.empty and found.sheets.empty
    assert repr(found).startswith(f"<Differences of '{files[0]}' and '{files[1]}': 1 parameters, ")


def test_parameters_alone() -> None:
    design = stagecad.load_design()
    found = stagecad.diff(design, design.with_values({"stage.thickness": "13 mm"}), solids=False, margins=False)
    assert list(found.to_json()) == ["files", "parameters"]
    # What is computed from the thickness differs too.
    assert {"stage.thickness", "stage.payload_thread_depth"} <= set(found.parameters.index)
    refused("no margin differs", found.plot)
    with pytest.raises(InputError, match="a Design or its parameter file is required, not int"):
        stagecad.diff(3, design)  # pyright: ignore[reportArgumentType]


def test_marked_picture_has_new_lines_red_and_old_ones_blue(tmp_path: Path) -> None:
    before, after = np.full((300, 400), 255, np.uint8), np.full((300, 400), 255, np.uint8)
    before[100, 50:150] = after[200, 50:350] = before[50, 300:320] = after[50, 300:320] = 0
    for name, array in (("a.png", before), ("b.png", after)):
        Image.fromarray(array).save(tmp_path / name)
    assert mark_changes(tmp_path / "a.png", tmp_path / "b.png", tmp_path / "out" / "m.png") == 2
    marked = np.asarray(Image.open(tmp_path / "out" / "m.png"))
    colours = [tuple(marked[place]) for place in ((200, 200), (100, 100), (50, 310))]
    assert colours == [(200, 0, 0), (120, 160, 255), (0, 0, 0)]


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


@pytest.mark.slow
def test_command_with_solids_and_sheets(tmp_path: Path, command: Any, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a.toml").write_text('extends = "thesis"\n', encoding="utf-8")
    Path("b.toml").write_text(THICKER, encoding="utf-8")
    document = command.json("diff", "a.toml", "b.toml")
    masses = {item["name"] for item in document["masses"]}
    # The mirror at the end of the stage is as high as the stage.
    assert masses == {"stage", "mirror", "moving body", "assembly"}
    volumes = {item["part"]: item["added"]["value"] for item in document["volumes"]}
    assert set(volumes) == {"stage", "mirror"} and volumes["stage"] == pytest.approx(0.23 * 0.27 * 0.002, rel=0.1)
    sheets = {item["sheet"]: item for item in document["sheets"]}
    assert "stage_1" in sheets or "stage" in sheets
    assert all(Path(item["marked"]).is_file() and item["regions"] for item in sheets.values())
    assert not any(name.startswith(("tip", "holder")) for name in sheets)


@pytest.fixture(scope="module")
def results() -> dict[str, Result]:
    design = stagecad.load_design()
    thicker = design.with_values({"stage.thickness": "14 mm"})
    return {
        "design": thicker,
        "checks": stagecad.checks(design, solids=False, proposals=False),
        "diff": stagecad.diff(design, thicker, solids=False),
        "sweep": sweep(design, ranges_of(design, ["stage.thickness=12mm:14mm:2"]), solids=False),
        "chains": chains(design),
        "calculation": calculate("hertz", design, {"load": "20 N"}),
    }


@pytest.mark.parametrize("name", ["design", "checks", "diff", "sweep", "chains", "calculation"])
def test_a_pickled_result_is_the_same(results: dict[str, Result], name: str) -> None:
    result = results[name]
    other = pickle.loads(pickle.dumps(result))
    assert repr(other) == repr(result) and "<table" in other._repr_html_()
    assert other.to_json() == result.to_json() and len(other.to_dataframe()) == len(result.to_dataframe()) > 0


def test_chains_state_the_distribution_and_sizes_that_cancel_are_zero(results: dict[str, Result]) -> None:
    (table,) = results["chains"].lines()
    text = repr(table)
    assert "99.73 %, sizes uniform" in text and "e-09" not in text


def test_a_pickled_design_needs_no_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "stage.toml"
    file.write_text(THICKER)
    monkeypatch.chdir(tmp_path)
    design = Design.chosen(None, ("stage.width=272 mm",))
    assert design.path == Path("stage.toml") and Design.chosen(file).path == file
    own = tmp_path / "checks" / "span.py"
    own.parent.mkdir()
    own.write_text(template("check", "span"))
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    monkeypatch.setattr(run, "OWN", {})
    run.register(design.check_files, trust=True)
    data = pickle.dumps(design)
    # Another process, which knows the check of another project of the same name.
    monkeypatch.setattr(run, "OWN", {"checks/span.py": ("other", len), "checks/other.py": ("other", len)})
    monkeypatch.setattr(run, "CONTENTS", {"checks/span.py": b"other"})
    own.unlink()
    file.unlink()
    other = pickle.loads(data)
    assert other.si("stage.thickness") == 0.014 and other.si("stage.width") == pytest.approx(0.272)
    assert other.values_with("stage.thickness=13 mm").si("stage.thickness") == 0.013
    assert {name: subject for name, (subject, _) in run.OWN.items()} == {"checks/span.py": "own checks"}
    assert Design.chosen(None).path is None


def test_covariance_and_samples_have_the_deviations_of_the_parameters(comparison, addition) -> None:
    # The standard deviation of a sample of n has the relative standard deviation 1 / sqrt(2 n).
    n = 20_000
    for result in (comparison, addition):
        stds, sample = result.parameters["std"], result.sample(n, seed=3)
        assert np.allclose(np.sqrt(np.diag(result.covariance)), stds[list(result.covariance)], 1e-9, equal_nan=True)
        known = stds.notna()
        assert len(sample) == n and np.allclose((sample.std() / stds)[known], 1.0, atol=5.0 / np.sqrt(2.0 * n))
        # Plain friction alone does not determine the drag of this slide.
        assert (sample.loc[:, ~known].std() == 0.0).all() and known.sum() == (1 if result is comparison else len(stds))
        assert sample.equals(result.sample(n, seed=3)) and not sample.equals(result.sample(n, seed=4))


def test_exported_functions_and_short_reprs(comparison: stagecad.Comparison, tmp_path: Path) -> None:
    time = np.linspace(0.0, 2.0, 500)
    position = 3e-3 * np.sin(4.0 * time)
    exported = stagecad.export(comparison.experiment, "python", tmp_path).function()
    assert np.array_equal(comparison.function()(time, position), exported(time, position))
    for one in (comparison, comparison.fitted, comparison.fitted.model, comparison.problem):
        assert len(repr(one)) < 120


def test_the_linear_part_of_a_driven_mass_has_the_poles_of_the_truth(comparison: stagecad.Comparison) -> None:
    """The truth is the closed form of `scipy.signal`, which shares nothing with the program."""
    mass, drag, stiffness = 2.0, 5.0, 300.0
    truth = StateSpace([[0.0, 1.0], [-stiffness / mass, -drag / mass]], [[0.0], [1.0 / mass]], [[1.0, 0.0]], [[0.0]])
    time = np.arange(0.0, 10.0, 1e-3)
    force = 20.0 * np.sin(9.0 * time) + 10.0 * np.sin(17.0 * time) + 5.0 * np.sign(np.sin(3.0 * time))
    _, position, _ = lsim(truth, force, time, interp=False)
    noise = 1e-6 * np.random.default_rng(1).standard_normal(time.size)
    record = {"time [s]": time, "drive_force [N]": force, "position [m]": position + noise}
    given = ["viscous", "cable_spring"], {"position": "1e-6 m"}
    found = stagecad.compare(stagecad.Experiment.from_dataframes({"fit": record}, "force-drive", *given))
    assert np.allclose(found.to_statespace().A, truth.A, rtol=0.01, atol=0.05)
    assert np.allclose(found.to_statespace().B, truth.B, rtol=0.01)
    refused("has no mass", comparison.to_statespace)
