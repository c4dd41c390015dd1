"""Masses computed from the moving parts alone equal those of the whole assembly."""

import numpy as np

from stagecad.solids.assembly.built_machine import body_masses


def test_masses_of_single_parts_equal_those_of_the_machine(design, store, machine, monkeypatch):
    monkeypatch.setenv("STAGECAD_CACHE", str(store.folder))
    found = body_masses(design)
    for one, other in ((found.moving, machine.moving_body), (found.tip, machine.masses["tip"])):
        for name in ("volume", "mass", "centre_of_mass", "inertia", "bounding_box"):
            np.testing.assert_allclose(getattr(one, name), getattr(other, name), rtol=1e-12, atol=1e-15)
