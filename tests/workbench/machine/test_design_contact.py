"""The contact of tip and stage by the design's numbers, for an experiment that says `"design"`."""

from __future__ import annotations

from pathlib import Path

import pytest

import workbench.identification.design_values
from stagecad.parameters.load import load_design
from sysid.experiment.known import DesignValue
from workbench.identification.design_values import design_values
from workbench.machine.design_contact import tip_contact
from workbench.options import Run

MASS = 1.8


def test_on_a_stage_of_the_tips_material_mindlin_is_a_known_part_of_hertz():
    material = load_design(None, ()).value("tip.material")
    design = load_design(None, (f"stage.material={material}",))
    steel = design.materials[material]
    found = tip_contact(design, MASS)
    load = MASS * 9.80665 + design.si("preload.force")
    assert found.load == pytest.approx(load)
    # A sphere on a flat: F = (4/3) E* sqrt(R) d^1.5, and the slope of that at the load.
    modulus = steel.youngs_modulus / (2.0 * (1.0 - steel.poisson_ratio**2))
    normal = (6.0 * modulus**2 * design.si("tip.nose_radius") * load) ** (1.0 / 3.0)
    assert found.normal == pytest.approx(normal, rel=1e-6)
    nu = steel.poisson_ratio
    assert found.tangential == pytest.approx(normal * 2.0 * (1.0 - nu) / (2.0 - nu), rel=1e-6)


def test_an_experiment_takes_the_stiffness_and_is_told_it(monkeypatch: pytest.MonkeyPatch, capsys):
    monkeypatch.setattr(workbench.identification.design_values, "design_mass", lambda run: MASS)
    run = Run(None, (), Path("build"), None)
    expected = tip_contact(run.design, MASS)
    told = design_values(run)("contact_stiffness")
    assert told == DesignValue(pytest.approx(expected.tangential), pytest.approx(0.2 * expected.tangential))
    said = " ".join(capsys.readouterr())
    assert "note: contact_stiffness = " in said
    assert "(Mindlin)" in said
    assert "(Hertz)" in said
