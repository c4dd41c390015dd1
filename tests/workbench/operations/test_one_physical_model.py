"""Checks, simulation, experiments and procedure read one physical model of the design."""

from pathlib import Path

import numpy as np
import pytest

import stagecad.solids.assembly.built_machine
from designcalc.checks import report
from designcalc.checks.check import DesignInputs
from designcalc.checks.report import shown
from designcalc.checks.run import Studies, run_checks
from designcalc.friction_stage.checks import assembly_values
from designcalc.friction_stage.physics.loads import load
from designcalc.friction_stage.physics.tip_dynamics import contact_stiffness
from sim.friction_stage.stage_machine import flexible_machine, stage_machine
from sim.stage.constants import make_constants
from sim.stage.statics import over_drive_surface
from stagecad.parameters.load import load_design
from stagecad.parameters.mass_properties import BodyMasses, MassProperties
from stagecad.solids.artefacts.store import ArtefactStore
from sysid.experiment.known import DesignValue
from workbench.cli.options import Run
from workbench.operations.drawings import stored_values
from workbench.operations.measurement.design_values import as_design_values
from workbench.operations.result import render

BODY = MassProperties(7e-4, 2.0, (0, 0, 0.033), np.diag([0.012, 0.009, 0.02]), ((-0.1, -0.1, 0.02), (0.1, 0.1, 0.04)))
TIP = MassProperties(8.5e-6, 0.023, (0, 0, 0.004), np.eye(3) * 4e-6, ((-0.03, -0.02, 0), (0.03, 0.03, 0.02)))
MASSES = BodyMasses(BODY, TIP)
PULL = 78.7
"""Of the packaged magnets, N."""


@pytest.mark.parametrize(
    "overrides, load",
    [
        ((), 3.0 * 9.80665 + PULL),
        (("environment.gravity=1.62 m/s^2",), 3.0 * 1.62 + PULL),
        (("payload.mass=4 kg",), 6.0 * 9.80665 + PULL),
        (("preload.force=7 N",), 3.0 * 9.80665 + PULL),
        (("magnet.remanence=0.6 T",), 3.0 * 9.80665 + PULL / 4),
        (("teeth.fitted=false", "preload.force=5 N"), 3.0 * 9.80665 + 5.0),
        (("materials.al_6061_t6.youngs_modulus=35 GPa",), 3.0 * 9.80665 + PULL),
        (("materials.al_6061_t6.poisson_ratio=0.1",), 3.0 * 9.80665 + PULL),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, tuple) else "",
)
def test_every_reader_has_the_same_load_contact_and_pads(overrides, load, monkeypatch):
    for name in ("body_masses", "packaged_masses"):
        monkeypatch.setattr(stagecad.solids.assembly.built_machine, name, lambda design: MASSES)
    run = Run(None, overrides, Path("build"), None)
    design = run.design.values
    checks = {check.name: check for check in run_checks(design, MASSES)}
    machine = stage_machine(design, MASSES)
    assert machine.load == pytest.approx(load, rel=2e-3)
    # Loads of the checks: sliding heat mu N v, force on the piezos, shares of the pads.
    assert checks["heat of sliding at full speed"].value == pytest.approx(0.05 * machine.load * 0.2)
    assert checks["force of the piezos against the load"].value == pytest.approx(machine.load)
    # The contact: the simulated one at this load has the stiffness that check and experiment state.
    depth = (machine.load / machine.contact.rate) ** (2 / 3)
    normal = 1.5 * machine.load / depth
    assert checks["tip contact against piezo stiffness"].value == pytest.approx(normal)
    experiment = as_design_values(run.design)
    assert experiment("contact_stiffness").value == pytest.approx(normal * machine.contact.tangential_ratio)
    assert experiment("mass").value == pytest.approx(machine.stage.mass)
    # The pads: stiffness of the checks is that of the simulated springs, but for unequal pad loads.
    pads = machine.pads
    springs = 1.5 * pads.contact_rate * (load / 3 / pads.contact_rate) ** (1 / 3) * 3
    more = 0.1 * design.payload.mass * machine.gravity
    deflection = checks["deflection of the pads under a tenth of the payload"].value
    assert more / deflection == pytest.approx(springs, rel=0.03)
    # The procedure's wear goes as the root of the heaviest pad's load.
    wear = assembly_values(DesignInputs(design, MASSES))["run_in_wear"]
    heaviest = float(checks["lightest pad load over the mean"].note.split(" load ")[1].split(" ")[0])
    assert wear == pytest.approx(np.sqrt(3e-13 * heaviest * 1200 / (np.pi * 2)), rel=1e-3)
    # Position loop of checks and simulated positioning, and the report's table, of the same load.
    held = machine.surroundings.held_resonance
    assert f"resonance {shown(held, 'Hz')} " in checks["stability of the position loop with the interferometer"].note
    row = f"| force of the piezos against the load | {shown(machine.load, 'N')} |"
    words = {"checks": list(checks.values()), "found": Studies(), "observation": 1.0, "stated": {}}
    assert row in render("checks.md", report=report, **words)


def test_a_softer_plate_lowers_modes_and_stiffness_in_checks_and_simulation():
    found = []
    for overrides in ((), ("materials.al_6061_t6.youngs_modulus=35 GPa",)):
        values = Run(None, overrides, Path("build"), None).design.values
        checks = {c.name: c for c in run_checks(values, MASSES)}
        lowest = checks["resonances of the stage on its pads against the drive"].note.split("modes ")[1].split(" ")[0]
        settling = checks["settling after a move"].note.split("first mode ")[1].split(" ")[0]
        simulated = flexible_machine(values, MASSES).stage.bending.frequencies[0]
        bent = checks["bending of the stage above the tip"].value
        found.append((float(lowest), bent, float(simulated), float(settling)))
    # A plate on pads that are stiffer by far: frequencies with the root of the modulus, deflections inversely.
    assert found[1][0] / found[0][0] == pytest.approx(np.sqrt(35 / 68.9), rel=0.03)
    assert found[1][1] / found[0][1] == pytest.approx(68.9 / 35, rel=0.03)
    assert found[1][2] / found[0][2] == pytest.approx(np.sqrt(35 / 68.9), rel=1e-6)
    assert found[1][3] / found[0][3] == pytest.approx(np.sqrt(35 / 68.9), rel=0.03)


def test_pads_and_tip_of_solid_checks_and_simulation_are_the_same():
    design = Run(None, ("pads.height=3 mm",), Path("build"), None).design.values
    machine = stage_machine(design, MASSES)
    assert machine.pads.height == pytest.approx(3e-3)
    centre = machine.stage.centre
    rest = over_drive_surface(machine, 0.0, -1e-4)
    assert make_constants(machine, rest).pad_at[:, 2] == pytest.approx(-3e-3 - centre[2])
    design = Run(None, (), Path("build"), None).design.values
    tip = stage_machine(design, MASSES).tip
    found = {check.name: check for check in run_checks(design, MASSES, ("piezo actuator",))}
    stated = found["drive frequency against the tip's resonances"].substituted
    up = np.sqrt(3 * tip.stiffness / tip.mass) / (2 * np.pi)
    rocking = np.sqrt(tip.stiffness * 0.046**2 / 2 / tip.inertia) / (2 * np.pi)
    assert f"min({up / 1e3:.4g} kHz, {rocking / 1e3:.4g} kHz)/3" in stated


def test_an_experiment_takes_the_stiffness_with_a_note(monkeypatch, caplog) -> None:
    run = Run(None, (), Path("build"), None)
    inputs = "workbench.operations.measurement.design_values._inputs"
    monkeypatch.setattr(inputs, lambda design: DesignInputs(design.values))
    r = DesignInputs(run.design.values)
    expected = contact_stiffness(r, load(r))
    value = as_design_values(run.design)("contact_stiffness")
    assert value == DesignValue(pytest.approx(expected.tangential), pytest.approx(0.2 * expected.tangential))
    printed = caplog.text
    assert "note: contact_stiffness = " in printed and "(Mindlin)" in printed and "(Hertz)" in printed


def test_stored_values_are_reused_until_an_input_changes(tmp_path: Path) -> None:
    store, masses = ArtefactStore(tmp_path), MASSES
    first = stored_values(store, load_design(), masses)
    assert first == assembly_values(DesignInputs(load_design(), masses))
    entries = sorted((tmp_path / "entries").iterdir())
    assert stored_values(store, load_design(overrides=["holder.well_diameter=19 mm"]), masses) == first
    assert sorted((tmp_path / "entries").iterdir()) == entries
    other = stored_values(store, load_design(overrides=["screws.way.torque=16 N*m"]), masses)
    assert other["way_preload"] == pytest.approx(16 / 15 * first["way_preload"])
