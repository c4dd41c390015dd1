"""Checks while a parameter is dragged are those of a full run, whatever the order of the changes."""

from dataclasses import replace

import numpy as np
import pytest

from designcalc.checks.run import run_checks
from stagecad.parameters.load import load_design
from stagecad.parameters.mass_properties import BodyMasses, MassProperties
from workbench.operations.live_checks import LiveChecks

CHANGES = (["stage.length=240 mm", "pads.length=24 mm"], ["pads.length=24 mm", "stage.material=invar_36"])


def test_incremental_checks_equal_a_full_run() -> None:
    live = LiveChecks()
    live.update(load_design(), 1e9)
    for overrides in CHANGES:
        design = load_design(None, overrides, rules=False)
        result = live.update(design, 1e9)
        assert result.pending == ()
        known = live.all_known()
        full = run_checks(design)
        assert [known[k].margin for k in range(len(full))] == pytest.approx([one.margin for one in full], nan_ok=True)
        assert [known[k].name for k in range(len(full))] == [one.name for one in full]


def test_masses_of_the_solids_reach_the_checks_that_read_them() -> None:
    design = load_design()
    live = LiveChecks()
    live.update(design, 1e9)
    # A plate of 230 x 270 x 12 mm on the ways, somewhat heavier than one of aluminium.
    inertia = 2.5 / 12.0 * np.diag([0.27**2 + 0.012**2, 0.23**2 + 0.012**2, 0.23**2 + 0.27**2])
    box = ((-0.115, -0.135, 0.034), (0.115, 0.135, 0.046))
    body = MassProperties(7.5e-4, 2.5, (0.0, 0.0, 0.04), inertia, box)
    masses = BodyMasses(body, replace(body, mass=0.023))
    live.set_masses(design, masses)
    live.update(design, 1e9)
    full = run_checks(design, masses)
    known = live.all_known()
    assert [known[k].margin for k in range(len(full))] == [one.margin for one in full]


def test_an_answer_within_a_limit_is_completed_by_the_next() -> None:
    live = LiveChecks()
    base = live.update(load_design(), 1e9)
    changed = load_design(None, ["stage.thickness=13 mm"], rules=False)
    first = live.update(changed, 0.0, base.version)
    assert 0 < len(first.checks) < base.count and first.pending
    assert set(first.checks).isdisjoint(first.pending)
    second = live.update(changed, 1e9, first.version)
    assert second.pending == () and set(second.checks) == set(first.pending)
    # A page that knows nothing yet is answered with everything.
    assert len(live.update(changed, 0.0).checks) == base.count
