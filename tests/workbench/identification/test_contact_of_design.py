"""The contact stiffness of the design as a known quantity of an experiment."""

from __future__ import annotations

from pathlib import Path

import pytest

import workbench.identification.design_values
from designcalc.machine.inputs import DesignInputs
from designcalc.machine.tip_contact import contact_without_payload
from sysid.experiment.known import DesignValue
from workbench.identification.design_values import design_values
from workbench.options import Run

MASS = 1.8


def test_an_experiment_takes_the_stiffness_with_a_note(monkeypatch: pytest.MonkeyPatch, capsys):
    monkeypatch.setattr(workbench.identification.design_values, "_design_mass", lambda run: MASS)
    run = Run(None, (), Path("build"), None)
    expected = contact_without_payload(DesignInputs(run.design), MASS)
    value = design_values(run)("contact_stiffness")
    assert value == DesignValue(pytest.approx(expected.tangential), pytest.approx(0.2 * expected.tangential))
    printed = " ".join(capsys.readouterr())
    assert "note: contact_stiffness = " in printed
    assert "(Mindlin)" in printed
    assert "(Hertz)" in printed
