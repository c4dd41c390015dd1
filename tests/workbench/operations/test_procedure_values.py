"""The calculated values of the assembly procedure in the store of artefacts."""

from pathlib import Path

import pytest

from designcalc.checks.check import DesignInputs
from designcalc.friction_stage.physics.assembly_values import assembly_values
from stagecad.parameters.load import load_design
from stagecad.parameters.mass_properties import BodyMasses, MassProperties
from stagecad.solids.artefacts.store import ArtefactStore
from workbench.operations.drawings import stored_values


def test_stored_values_are_reused_until_an_input_changes(tmp_path: Path) -> None:
    store, masses = ArtefactStore(tmp_path), estimate()
    first = stored_values(store, load_design(), masses)
    assert first == assembly_values(DesignInputs(load_design(), masses))
    entries = sorted((tmp_path / "entries").iterdir())
    assert stored_values(store, load_design(overrides=["holder.well_diameter=19 mm"]), masses) == first
    assert sorted((tmp_path / "entries").iterdir()) == entries
    other = stored_values(store, load_design(overrides=["screws.way.torque=16 N*m"]), masses)
    assert other["way_preload"] == pytest.approx(16 / 15 * first["way_preload"])


def estimate() -> BodyMasses:
    cube = ((-0.1, -0.1, 0.0), (0.1, 0.1, 0.1))
    still = ((0.01, 0.0, 0.0), (0.0, 0.01, 0.0), (0.0, 0.0, 0.01))
    return BodyMasses(
        MassProperties(8e-4, 2.0, (0, 0, 0.03), still, cube), MassProperties(1e-5, 0.03, (0, 0, 0), still, cube)
    )
