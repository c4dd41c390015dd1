"""The moving body weighed on its own solids is that of the whole assembly."""

from __future__ import annotations

import numpy as np

from workbench.moving_body import moving_body_of


def test_moving_body_of_three_parts_is_that_of_the_machine(design, store, machine, monkeypatch):
    monkeypatch.setenv("STAGECAD_CACHE", str(store.folder))
    found, whole = moving_body_of(design), machine.moving_body
    for name in ("volume", "mass", "centre_of_mass", "inertia", "bounding_box"):
        np.testing.assert_allclose(getattr(found, name), getattr(whole, name), rtol=1e-12, atol=1e-15)
