"""Datums and dimension declarations refuse what no drawing could show."""

import math

import pytest

from stagecad.parameters.dimension import Datum, DatumFeature, Dimension, GeometricTolerance


@pytest.mark.parametrize(
    ("normal", "x_direction"),
    [((0.0, 0.0, 2.0), (1.0, 0.0, 0.0)), ((0.0, 0.0, 1.0), (0.0, 0.6, 0.8)), ((0.0, 0.0, 1.0), (0.0, 0.0, 0.0))],
)
def test_a_crooked_frame_is_refused(normal: tuple[float, ...], x_direction: tuple[float, ...]) -> None:
    with pytest.raises(ValueError, match="datum 'seat'"):
        Datum("seat", (0.0, 0.0, 0.0), normal, x_direction)  # type: ignore[arg-type]


def test_dimensions_without_ends_value_or_features_are_refused() -> None:
    ends = ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0))
    assert Dimension("length", "linear", 1.0, "stage.length", ends).count == 1
    with pytest.raises(ValueError, match="two points"):
        Dimension("length", "linear", 1.0, "stage.length", ends[:1])
    with pytest.raises(ValueError, match="no value"):
        Dimension("length", "linear", math.nan, "stage.length", ends)
    with pytest.raises(ValueError, match="0 features"):
        Dimension("bore", "diameter", 1.0, "stage.length", count=0)
    with pytest.raises(ValueError, match="one parameter, or is derived"):
        Dimension("bore", "diameter", 1.0, "")
    with pytest.raises(ValueError, match="one parameter, or is derived"):
        Dimension("bore", "diameter", 1.0, "stage.length", derived_from=("stage.width",))


def test_requirements_without_zone_datum_or_letter_are_refused() -> None:
    face = ((0.0, 0.0, 0.0),), (0.0, 0.0, 1.0), "front"
    assert GeometricTolerance("top", "flatness", 0.01, "stage.length", *face).datums == ()
    with pytest.raises(ValueError, match="no width"):
        GeometricTolerance("top", "flatness", 0.0, "stage.length", *face)
    with pytest.raises(ValueError, match="refers to 0 datums"):
        GeometricTolerance("top", "parallelism", 0.01, "stage.length", *face)
    with pytest.raises(ValueError, match="refers to 1 datums"):
        GeometricTolerance("top", "flatness", 0.01, "stage.length", *face, datums=("A",))
    with pytest.raises(ValueError, match="capital"):
        DatumFeature("a", *face)
