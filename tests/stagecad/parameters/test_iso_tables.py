"""Fits of ISO 286 and threads, against the tables of the standards."""

import math
import re
import tomllib
from fractions import Fraction
from pathlib import Path

import pytest

from stagecad.parameters.iso286 import deviations, is_class
from stagecad.parameters.load import design_from_text, load_design
from stagecad.parameters.threads import Thread, thread, threads
from stagecad.solids.modelling.dimensioning import DimensionDeclarations
from tests.drawings.drawn import thesis
from tests.reference.tables import cases
from tests.refusals import refused

ROWS = """name,designation,major [mm],pitch [mm],tap_drill [mm],source
tr8,Tr8x1.5,8,1.5,6.6,ISO 2904
"""


# ISO 286-2:2010, tables 5, 6, 8 and 17 to 21, um.
@pytest.mark.parametrize(("size", "tolerance", "low", "high"), cases("iso286", "deviations"))
def test_deviations_are_those_of_the_standard(size: float, tolerance: str, low: float, high: float) -> None:
    assert deviations(size, tolerance) == pytest.approx((low / 1000, high / 1000), abs=1e-9)


TRANSCRIPT = tomllib.loads((Path(__file__).parents[2] / "reference" / "iso286_transcript.toml").read_text())


def test_an_independent_transcript_of_the_tables_has_the_same_numbers() -> None:
    def agree(sizes: list[float], letter: str, grade: int, expected: list[float], end: int, sign: int = 1) -> int:
        known = [(size, value) for size, value in zip(sizes, expected, strict=True) if not math.isnan(value)]
        for size, value in known:
            found = deviations(size, f"{letter}{grade}")[end] * 1000
            assert found == pytest.approx(sign * value, abs=1e-6), (size, letter, grade)
        return len(known)

    ranges, fine = TRANSCRIPT["ranges"], TRANSCRIPT["fine_ranges"]
    count = 0
    for grade, row in TRANSCRIPT["grades"].items():
        count += agree(ranges, "H", int(grade), row, 1) + agree(ranges, "h", int(grade), row, 0, -1)
        for letter, above in TRANSCRIPT["holes_above"].items():
            count += agree(ranges, letter, int(grade), above, 0)
            count += agree(ranges, letter.lower(), int(grade), above, 1, -1)
        for letter, above in TRANSCRIPT["shafts_above"].items():
            if letter != "k" or int(grade) < 8:
                count += agree(fine, letter, int(grade), above, 0)
            # The rules of clause 4.3.2.5 hold from grade 9 (M) or 8 (P to ZC) on: a hole mirrors the shaft.
            if letter not in "kn" and int(grade) > (8 if letter == "m" else 7):
                count += agree(fine, letter.upper(), int(grade), above, 1, -1)
    for letter, table, end in (("j", "j_shafts", 0), ("J", "j_holes", 1)):
        for grade, row in TRANSCRIPT[table].items():
            count += agree(ranges, letter, int(grade), row, end)
    assert count > 4000


def test_only_classes_of_the_table_are_accepted_in_one_clear_line() -> None:
    assert all(is_class(text) for text in ("H7", "js6", "JS9", "h12", "k6", "zc8"))
    assert not any(is_class(text) for text in ("H4", "Hg7", "I7", "7H", ""))
    with pytest.raises(ValueError, match="no tolerance class H7 for 260 mm"):
        deviations(260.0, "H7")
    design = load_design()
    assert design.deviations("base.pin_2_bore") == pytest.approx((0.0, 0.018))
    assert design.deviations("height_pin_2.diameter") == pytest.approx((-0.017, -0.006))
    assert design.plus_minus("height_pin_2.diameter") == pytest.approx(0.0055)
    for entry, words in (
        ('[stage]\nlength = {value = "300 mm", tolerance = "H7"}', "up to 250 mm, not for 300 mm"),
        ('[stage]\ndowel_diameter = {value = "5 mm", tolerance = "I7"}', "or a class of ISO 286 like H7 or g6"),
    ):
        refused(words, design_from_text, f'extends = "thesis"\n{entry}\n', "mine.toml")


@pytest.mark.parametrize(("name", "designation", "major", "pitch", "drill"), [
    ("m1_6", "M1.6x0.35", 1.6, 0.35, 1.25), ("m8", "M8x1.25", 8.0, 1.25, 6.8), ("m8x1", "M8x1", 8.0, 1.0, 7.0),
    ("m64", "M64x6", 64.0, 6.0, 58.0), ("unc_3_8", "3/8-16 UNC", 9.525, 1.5875, 8.0),
    ("unf_no_10", "No. 10-32 UNF", 4.826, 0.7938, 4.1), ("g_1_4", "G 1/4", 13.157, 1.337, 11.8),
    ("npt_1_2", "1/2-14 NPT", 21.336, 1.8143, 17.9),
])  # fmt: skip
def test_sizes_are_those_of_the_standards(name: str, designation: str, major: float, pitch: float, drill: float):
    found = thread(name)
    assert (found.designation, found.major, found.tap_drill) == (designation, major, drill)
    assert math.isclose(found.pitch, pitch, abs_tol=1e-4)


PIPE_TOLERANCE = {28: 0.282, 19: 0.445, 14: 0.541, 11: 0.640}
"""Tolerance of the minor diameter of an internal pipe thread by its pitches in 25.4 mm, mm: ISO 228-1, table 1."""
GAUGE = {
    0.405: 0.1615, 0.54: 0.2278, 0.675: 0.24, 0.84: 0.32, 1.05: 0.339, 1.315: 0.4, 1.66: 0.42, 1.9: 0.42,
    2.375: 0.436,
}  # fmt: skip
"""Length of engagement by hand L1 of a taper pipe thread by its outside diameter, in: ASME B1.20.1, table 2."""


def _minor(one: Thread) -> tuple[float, float]:
    """Least and largest minor diameter of the internal thread, mm."""
    d, p = one.major, one.pitch
    inch, pitch = d / 25.4, p / 25.4
    if one.name.startswith("m"):  # ISO 965-1: grade 6.
        least = d - 1.0825318 * p
        return least, least + (433 * p - 190 * p**1.22 if p < 1 else 230 * p**0.7) / 1000
    if one.name.startswith("un"):  # ASME B1.1: class 2B.
        fine, coarse = 0.05 * pitch ** (2 / 3) + 0.03 * pitch / inch - 0.002, 0.25 * pitch - 0.4 * pitch**2
        small = max(min(fine, 0.394 * pitch), coarse)
        least = d - 1.0825318 * p
        return least, least + 25.4 * (small if inch < 0.25 else coarse)
    if one.name.startswith("g"):  # ISO 228-1: height of the profile 0.640327 P.
        least = d - 2 * 0.640327 * p
        return least, least + PIPE_TOLERANCE[round(25.4 / p)]
    # ASME B1.20.1: at the depth L1 and at the mouth of the taper thread.
    least = 25.4 * (inch - (0.05 * inch + 1.1) * pitch - 0.8 * pitch)
    return least, least + 25.4 * GAUGE[round(inch, 3)] / 16


def test_threads_follow_from_designations_and_series() -> None:
    """Major diameter and pitch as the designation and the standards' series say."""
    pipe = {"1/8": (9.728, 28), "1/4": (13.157, 19), "3/8": (16.662, 19), "1/2": (20.955, 14), "3/4": (26.441, 14)}
    pipe |= {"1": (33.249, 11), "1 1/4": (41.910, 11), "1 1/2": (47.803, 11), "2": (59.614, 11)}
    for one in threads().values():
        if one.name.startswith("m"):
            major, pitch = map(float, one.designation[1:].split("x"))
        elif one.name.startswith("g"):
            major, count = pipe[one.designation.removeprefix("G ")]
            pitch = 25.4 / count
        else:
            size, _, count = one.designation.split(" U")[0].removesuffix(" NPT").rpartition("-")
            number = re.fullmatch(r"No\. (\d+)", size)
            inch = 0.06 + 0.013 * int(number[1]) if number else float(sum(map(Fraction, size.split())))
            # Outside diameters of pipes, ASME B36.10.
            pipes = dict(zip(pipe, GAUGE, strict=True))
            major, pitch = 25.4 * (pipes[size] if one.name.startswith("npt") else inch), 25.4 / float(count)
        assert one.major == pytest.approx(major, abs=1e-3), one
        assert one.pitch == pytest.approx(pitch, abs=5e-4), one  # printed to 0.001
    # ISO 261, also as transcribed in github.com/shaise/FreeCAD_FastenersWB (FsData/iso262def.csv).
    series = {
        0.35: (1.6,), 0.4: (2,), 0.45: (2.5,), 0.5: (3,), 0.6: (3.5,), 0.7: (4,), 0.8: (5,), 1: (6, 7), 1.25: (8,),
    }  # fmt: skip
    series |= {1.5: (10,), 1.75: (12,), 2: (14, 16), 2.5: (18, 20, 22), 3: (24, 27), 3.5: (30, 33), 4: (36, 39)}
    series |= {4.5: (42, 45), 5: (48, 52), 5.5: (56, 60), 6: (64,)}
    coarse = [one for one in threads().values() if "coarse" in one.source]
    assert {(one.major, one.pitch) for one in coarse} == {(d, p) for p, sizes in series.items() for d in sizes}
    for one in threads().values():
        least, largest = _minor(one)
        assert least <= one.tap_drill <= largest, (one, least, largest)
    declarations = DimensionDeclarations(thesis(), "stage")
    declarations.tapped("hole", "m8", (0.0, 0.0, 0.0), (0.0, 0.0, -1.0))
    (drill,) = declarations
    assert (drill.value, drill.note) == (6.8, "M8x1.25")
    refused("no thread 'm80'", declarations.tapped, "hole", "m80", (0.0, 0.0, 0.0), (0.0, 0.0, -1.0))


def test_a_row_of_ones_own_table_is_a_thread(tmp_path: Path) -> None:
    (tmp_path / "threads.csv").write_text(ROWS)
    file = tmp_path / "stage.toml"
    file.write_text('extends = "thesis"\n[hardware]\nthreads = "threads.csv"\n')
    declarations = DimensionDeclarations(load_design(file), "stage")
    declarations.tapped("hole", "tr8", (0.0, 0.0, 0.0), (0.0, 0.0, -1.0))
    (drill,) = declarations
    assert (drill.value, drill.note, drill.major) == (6.6, "Tr8x1.5", 8.0)
    (tmp_path / "threads.csv").write_text("name,pitch [mm],tap_drill [mm]\nm8,1.25,6.9\n")
    found = load_design(file).thread("m8")
    assert (found.tap_drill, found.major, found.designation) == (6.9, 8.0, "M8x1.25")
    (tmp_path / "threads.csv").write_text("name,pitch [mm],tap_drill [mm]\ntr8,1.5,6.6\n")
    refused(r"row 2: 'tr8' .* give its designation and major", load_design, file)
