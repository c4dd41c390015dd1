"""`stagecad simulate stage` as a user runs it."""

import csv
import json

import pytest

from designcalc.checks.run import run_checks
from sim.friction_stage.studies import stage_drive
from sim.stage.studies.positioning import LOOPS, move_to
from stagecad.parameters.load import load_design
from stagecad.solids.assembly.built_machine import body_masses
from tests.reference.tables import cases
from workbench.cli import run


@pytest.mark.slow
def test_steps_and_coupling_with_data_and_figures(tmp_path):
    target = tmp_path / "stage.json"
    chosen = ["--study", "steps", "--study", "coupling"]
    assert run(["simulate", "stage", *chosen, "--out", str(tmp_path), "--json", str(target)]) == 0
    document = json.loads(target.read_text())["stage"]
    assert list(document) == ["steps", "coupling"]
    steps = document["steps"]
    assert steps["count"]["value"] == pytest.approx(2 * 20 / 46 * 17e-6 / 2**16)
    # The stage makes about what springs in series let through of a count, some tenths of a nanometre.
    expected = steps["static_ratio"]["value"] * steps["count"]["value"]
    assert steps["step_1_count"] == {"value": pytest.approx(expected, rel=0.05), "unit": "m"}
    coupling = document["coupling"]
    assert abs(coupling["linear_piezos_across"]["value"]) < 1e-3 * coupling["linear_piezos_travel"]["value"]
    assert coupling["as_designed_across"]["value"] > 10e-6
    folder = tmp_path / "simulate"
    assert {"stage_steps.png", "stage_coupling.png"} <= {path.name for path in folder.iterdir()}
    with open(folder / "stage_steps_10nm.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) > 1000
    assert float(rows[-1]["time [s]"]) == pytest.approx(0.26, abs=1e-3)


def test_a_sweep_over_the_tips_height(tmp_path):
    target = tmp_path / "sweep.json"
    asked = ["--sweep", "actuator.tip_height=18mm:20mm:2", "--no-figures"]
    assert run(["simulate", "tip", *asked, "--out", str(tmp_path), "--json", str(target)]) == 0
    swept = json.loads(target.read_text())["sweep"]
    assert [value["value"] for value in swept["values"]] == pytest.approx([0.018, 0.020])
    # x = -h (d2 - d1)/D: at a phase of pi/1.5 the ellipse lies along x, and its half axis goes with h.
    low, high = (point["tip"]["8.5um"]["pi/1.5"]["semi_major"]["value"] for point in swept["points"])
    assert high / low == pytest.approx(20 / 18, rel=1e-6)
    header = (tmp_path / "simulate" / "sweep.csv").read_text().splitlines()[0]
    assert header.startswith('"actuator.tip_height [m]"')


@pytest.mark.parametrize(
    "asked",
    [
        pytest.param(["tip", "--sweep", "actuator.tip_height=18mm:20mm:3"], id="tip"),
        pytest.param(
            ["stage", "--study", "steps", "--sweep", "drive.friction=0.2:0.3:2"], id="stage", marks=pytest.mark.slow
        ),
    ],
)
def test_a_sweep_on_a_cluster_gives_what_the_local_cores_give(asked, tmp_path, cluster):
    found = []
    for where in ([], ["--scheduler", cluster]):
        target = tmp_path / f"sweep_{len(where)}.json"
        words = [*asked, "--no-figures", "--out", str(tmp_path), "--json", str(target)]
        assert run(["simulate", *words, *where]) == 0
        found.append(json.loads(target.read_text())["sweep"])
    assert found[1] == found[0]


@pytest.mark.parametrize(("arguments", "said"), cases("mistakes", "simulate_stage"))
def test_a_mistake_is_one_line(arguments, said, tmp_path, capsys):
    assert run(["simulate", *arguments, "--out", str(tmp_path)]) == 2
    message = capsys.readouterr().err.strip()
    assert said in message
    assert len(message.splitlines()) == 1


def test_without_teeth_the_preload_is_a_weight():
    magnets = _drive().single.machine
    alone = _drive("teeth.fitted=false").single.machine
    # The pull of the magnets, not the preload that is required.
    assert magnets.stage.preload == pytest.approx(78.7, rel=2e-3)
    assert magnets.stage.guide_stiffness > 0.0
    assert alone.stage.preload == 0.0
    assert alone.stage.guide_stiffness == 0.0
    # The irons and magnets are gone, and 3 N of ballast has come.
    assert alone.stage.mass == pytest.approx(magnets.stage.mass + 3.0 / magnets.gravity, abs=0.15)


def _drive(*overrides):
    design = load_design(None, overrides)
    return stage_drive(design, body_masses(design))


def test_the_studies_have_a_bending_stage_on_swaying_stacks():
    drive = _drive()
    for machine in (drive.single.machine, drive.triple.machine):
        assert machine.stage.bending.frequencies.size > 10
        assert machine.tip.sway_stiffness == pytest.approx(0.5e6, rel=0.02)
        assert machine.tip.sway_play == pytest.approx(32e-6, rel=0.02)


@pytest.mark.slow
def test_a_simulated_move_settles_within_the_time_of_the_check():
    """From the end of the drive until every period is within the coarse resolution, with the filtered probe."""
    design = load_design(None, ())
    masses = body_masses(design)
    drive = stage_drive(design, masses)
    move = move_to(drive.single, LOOPS["interferometer_and_probe"])
    settled = move.within(design.requirements.resolution_coarse)
    assert move.taken_over is not None and settled is not None
    check = next(c for c in run_checks(design, masses) if c.name == "settling after a move")
    assert check.value is not None and 0.4 * check.value < settled - move.taken_over < check.value < check.limit
    # Half of the time of a move over the travel at full speed.
    assert check.limit == pytest.approx(0.5 * 0.2 / 0.2)
