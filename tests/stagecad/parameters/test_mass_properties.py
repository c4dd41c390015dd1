"""Mass properties: textbook bodies, and bodies put together from pieces."""

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stagecad.parameters.mass_properties import MassProperties, combined
from tests.refusals import refused


def block(low: tuple[float, float, float], high: tuple[float, float, float], density: float = 1000.0) -> MassProperties:
    """A box by the textbook: I_xx = m (b^2 + c^2) / 12."""
    a, b, c = (h - k for h, k in zip(high, low))
    mass = a * b * c * density
    inertia = np.diag([b * b + c * c, a * a + c * c, a * a + b * b]) * mass / 12
    return MassProperties(a * b * c, mass, tuple((h + k) / 2 for h, k in zip(high, low)), inertia, (low, high))


edge = st.floats(0.05, 2.0)


@given(a=edge, b=edge, c=edge, cut=st.floats(0.1, 0.9))
def test_a_box_is_the_sum_of_its_halves(a: float, b: float, c: float, cut: float) -> None:
    whole = block((0.1, -0.2, 0.3), (0.1 + a, -0.2 + b, 0.3 + c))
    middle = 0.1 + cut * a
    far = (0.1 + a, -0.2 + b, 0.3 + c)
    together = combined([block((0.1, -0.2, 0.3), (middle, *far[1:])), block((middle, -0.2, 0.3), far)])
    assert together.mass == pytest.approx(whole.mass) and together.volume == pytest.approx(whole.volume)
    assert together.centre_of_mass == pytest.approx(whole.centre_of_mass)
    assert np.allclose(together.inertia, whole.inertia, rtol=1e-9, atol=1e-12 * whole.mass)
    assert np.allclose(together.bounding_box, whole.bounding_box)


def test_inertia_about_a_point_by_summing_small_pieces() -> None:
    body = block((0.0, 0.0, 0.0), (0.2, 0.3, 0.1), 2700.0)
    point = (0.5, -0.4, 0.25)
    n = 60
    axes = [(np.arange(n) + 0.5) / n * size for size in (0.2, 0.3, 0.1)]
    x, y, z = (part.ravel() - at for part, at in zip(np.meshgrid(*axes, indexing="ij"), point))
    dm = body.mass / n**3
    places = np.stack([x, y, z])
    expected = dm * (np.sum(places**2) * np.eye(3) - places @ places.T)
    assert np.allclose(body.inertia_about(point), expected, rtol=2e-4)


def test_moving_writing_and_nothing() -> None:
    body = block((0.0, 0.0, 0.0), (0.2, 0.3, 0.1))
    moved = body.moved((1.0, 2.0, 3.0))
    assert moved.inertia == body.inertia and moved.centre_of_mass == pytest.approx((1.1, 2.15, 3.05))
    assert moved.bounding_box[0] == pytest.approx((1.0, 2.0, 3.0))
    document = json.loads(json.dumps(body.as_json()))
    assert MassProperties.from_json(document) == body
    assert document["mass"] == {"value": pytest.approx(6.0), "unit": "kg"}
    del document["mass"]
    refused("mass", MassProperties.from_json, document)
    with pytest.raises(ValueError, match="no body"):
        combined([])
