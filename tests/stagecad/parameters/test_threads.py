"""Threads of the table: sizes that the standards print, and a tap drill that leaves a thread."""

import math

import pytest

from stagecad.parameters.errors import InputError
from stagecad.parameters.threads import thread, threads
from stagecad.solids.modelling.dimensioning import DimensionDeclarations
from tests.drawings.drawn import thesis


@pytest.mark.parametrize(
    ("name", "designation", "major", "pitch", "drill"),
    [
        ("m1_6", "M1.6x0.35", 1.6, 0.35, 1.25),
        ("m8", "M8x1.25", 8.0, 1.25, 6.8),
        ("m8x1", "M8x1", 8.0, 1.0, 7.0),
        ("m64", "M64x6", 64.0, 6.0, 58.0),
        ("unc_3_8", "3/8-16 UNC", 9.525, 1.5875, 8.0),
        ("unf_no_10", "No. 10-32 UNF", 4.826, 0.7938, 4.1),
        ("g_1_4", "G 1/4", 13.157, 1.337, 11.8),
        ("npt_1_2", "1/2-14 NPT", 21.336, 1.8143, 17.9),
    ],
)
def test_sizes_are_those_of_the_standards(
    name: str, designation: str, major: float, pitch: float, drill: float
) -> None:
    found = thread(name)
    assert (found.designation, found.major, found.tap_drill) == (designation, major, drill)
    assert math.isclose(found.pitch, pitch, abs_tol=1e-4)


def test_each_tap_drill_leaves_a_thread() -> None:
    """The height of engagement over that of the basic profile (ISO 68-1: 0.5413 pitches; ISO 228-1: 0.6403)."""
    for one in threads().values():
        if "NPT" not in one.designation:
            height = (0.6403 if one.designation.startswith("G") else 0.5413) * one.pitch
            engagement = (one.major - one.tap_drill) / 2 / height
            assert 0.6 < engagement < 1.06, one


def test_a_thread_that_the_machine_does_not_use_is_declared_by_its_name() -> None:
    declarations = DimensionDeclarations(thesis(), "stage")
    declarations.tapped("hole", "m8", (0.0, 0.0, 0.0), (0.0, 0.0, -1.0))
    (drill,) = declarations
    assert (drill.value, drill.note) == (6.8, "M8x1.25")
    with pytest.raises(InputError, match="no thread 'm80'"):
        declarations.tapped("hole", "m80", (0.0, 0.0, 0.0), (0.0, 0.0, -1.0))
