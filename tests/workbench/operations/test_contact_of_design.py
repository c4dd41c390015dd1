"""The contact stiffness of the design as a known quantity of an experiment."""

from pathlib import Path

import pytest

import workbench.operations.measurement.design_values
from designcalc.checks.check import DesignInputs
from designcalc.friction_stage.physics.loads import load
from designcalc.friction_stage.physics.tip_dynamics import contact_stiffness
from sysid.experiment.known import DesignValue
from workbench.cli.options import Run
from workbench.operations.measurement.design_values import as_design_values


def test_an_experiment_takes_the_stiffness_with_a_note(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    run = Run(None, (), Path("build"), None)
    monkeypatch.setattr(
        workbench.operations.measurement.design_values, "_inputs", lambda design: DesignInputs(design.values)
    )
    r = DesignInputs(run.design.values)
    expected = contact_stiffness(r, load(r))
    value = as_design_values(run.design)("contact_stiffness")
    assert value == DesignValue(pytest.approx(expected.tangential), pytest.approx(0.2 * expected.tangential))
    printed = caplog.text
    assert "note: contact_stiffness = " in printed
    assert "(Mindlin)" in printed
    assert "(Hertz)" in printed
