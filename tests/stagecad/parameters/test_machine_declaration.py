"""The table [machine] of a parameter file; datums and dimensions refuse what no drawing could show."""

import math
import tomllib
from functools import partial
from pathlib import Path

import pytest

from stagecad.consent import give_consent
from stagecad.declared.construction import put_together
from stagecad.parameters.dimension import Datum, DatumFeature, Dimension, GeometricTolerance
from stagecad.parameters.file import parse_parameter_text, read_parameter_file
from stagecad.parameters.load import load_design, part_design
from stagecad.parameters.machine import MachineDeclaration
from stagecad.parameters.machine_declaration import placed_values, read_machine
from tests.reference.tables import cases
from tests.refusals import refused

TEXT = """
[machine]
overlaps = [["block", "plate"]]
[machine.parts]
plate = {file = "plate.py"}
block = {file = "block.py", parameters = {length = "5.0 mm", way.height = "1 mm"}}
[machine.mates]
two = {part = "block", datum = "bottom", on = "one.top", turn = "90 deg"}
one = {part = "block", datum = "bottom", on = "plate.top", offset = ["3 mm", "=-piezo.length", "1 mm"]}
plate = {}
"""


def _read(text: str) -> MachineDeclaration:
    table = parse_parameter_text(text, "mill.toml").machine
    assert table is not None
    return read_machine(table, "mill.toml", Path("."))


def test_mates_and_offsets_put_instances_where_they_are_declared() -> None:
    machine = _read(TEXT)
    assert [mate.name for mate in machine.mates] == ["plate", "one", "two"]
    assert placed_values(load_design(), machine.mates[1]) == (pytest.approx((3.0, -36.0, 1.0)), 0.0)
    assert machine.parts[1].parameters == {"length": "5.0 mm", "way.height": "1 mm"}
    assert machine.overlaps == {frozenset(("block", "plate"))}
    up, down, x = (0.0, 0.0, 1.0), (0.0, 0.0, -1.0), (1.0, 0.0, 0.0)
    block = {"bottom": Datum("bottom", (0, 0, 0), down, x), "top": Datum("top", (0.0, 0.0, 20.0), up, x)}
    plate = {"top": Datum("top", (10.0, 0.0, 8.0), up, x)}
    instances = put_together(_read(TEXT), {"plate": plate, "block": block}, load_design())
    frames = {one.name: one.frame for one in instances}
    assert frames["one"].shift == pytest.approx((13.0, -36.0, 9.0))
    assert frames["two"].shift == pytest.approx((13.0, -36.0, 29.0))
    assert frames["two"].direction(x) == pytest.approx((0.0, 1.0, 0.0))
    said = r"machine.mates.one.on: part 'plate' has no datum 'top'"
    refused(said, put_together, _read(TEXT), {"plate": {}, "block": block}, load_design())
    plate = {f"hole_{i}": Datum(f"hole_{i}", (10.0 * i, 0.0, 8.0), up, x) for i in (1, 2, 3)}
    screw = {"seat": Datum("seat", (0, 0, 0), down, x), "top": Datum("top", (0.0, 0.0, 5.0), up, x)}
    datums = {"plate": plate, "screw": screw, "cap": {"bottom": Datum("bottom", (0, 0, 0), down, x)}}
    places = {one.name: one.frame.shift for one in put_together(_read(PATTERN), datums, load_design())}
    assert list(places) == ["plate", "screws_1", "screws_2", "screws_3", "cap"]
    assert places["screws_3"] == pytest.approx((30.0, 0.0, 8.0)) and places["cap"] == pytest.approx((20.0, 0.0, 13.0))
    refused("part 'plate' has no datum 'hole_", put_together, _read(PATTERN), {**datums, "plate": {}}, load_design())
    refused("no part 'screws'; did you mean 'screws_1'", _read, PATTERN.replace("screws_2.top", "screws.top"))


def test_parts_alone_without_mates_or_as_text(tmp_path: Path) -> None:
    part = Path(__file__).parents[2] / "drawings" / "parts" / "housing.py"
    give_consent((part,))
    assert part_design(read_parameter_file(), (), part).drawing.title == "-"
    (tmp_path / "stage.toml").write_text('extends = "thesis"\n[drawing]\ntitle = "Mill"\n', "utf-8")
    assert part_design(read_parameter_file(tmp_path / "stage.toml"), (), part).drawing.title == "Mill"
    unmated = TEXT.replace("[machine.mates]", 'pin = {file = "pin.py"}\n[machine.mates]')
    refused(r"mill.toml: machine.parts.pin: no mate puts it into the machine", _read, unmated)
    assert set(tomllib.loads(TEXT)["machine"]) == {"overlaps", "parts", "mates"}


def _placed(text: str) -> None:
    for mate in _read(text).mates:
        placed_values(load_design(), mate)


@pytest.mark.parametrize("old, new, words", cases("mistakes", "machine_declaration"))
def test_mistakes(old: str, new: str, words: str) -> None:
    assert old in TEXT
    refused(words, _placed, TEXT.replace(old, new))


PATTERN = """
[machine.parts]
plate = {file = "plate.py"}
screw = {file = "screw.py"}
cap = {file = "cap.py"}
[machine.mates]
plate = {}
screws = {part = "screw", datum = "seat", on = "plate.hole_*"}
cap = {datum = "bottom", on = "screws_2.top"}
"""


@pytest.mark.parametrize(
    ("normal", "x_direction"),
    [((0.0, 0.0, 2.0), (1.0, 0.0, 0.0)), ((0.0, 0.0, 1.0), (0.0, 0.6, 0.8)), ((0.0, 0.0, 1.0), (0.0, 0.0, 0.0))],
)
def test_a_crooked_frame_is_refused(normal: tuple[float, ...], x_direction: tuple[float, ...]) -> None:
    with pytest.raises(ValueError, match="datum 'seat'"):
        Datum("seat", (0.0, 0.0, 0.0), normal, x_direction)  # type: ignore[arg-type]


def test_dimensions_and_requirements_that_say_too_little_are_refused() -> None:
    ends = ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0))
    assert Dimension("length", "linear", 1.0, "stage.length", ends).count == 1
    face = ((0.0, 0.0, 0.0),), (0.0, 0.0, 1.0), "front"
    assert GeometricTolerance("top", "flatness", 0.01, "stage.length", *face).datums == ()
    length, bore = partial(Dimension, "length", "linear"), partial(Dimension, "bore", "diameter", 1.0)
    flat = partial(GeometricTolerance, "top", "flatness")
    for words, make in {
        "two points": lambda: length(1.0, "stage.length", ends[:1]),
        "no value": lambda: length(math.nan, "stage.length", ends),
        "0 features": lambda: bore("stage.length", count=0),
        "one parameter, or is derived": lambda: bore(""),
        "parameter, or is derived": lambda: bore("stage.length", derived_from=("stage.width",)),
        "no width": lambda: flat(0.0, "stage.length", *face),
        "has 0 datums": lambda: GeometricTolerance("top", "parallelism", 0.01, "stage.length", *face),
        "has 1 datums": lambda: flat(0.01, "stage.length", *face, datums=("A",)),
        "capital": lambda: DatumFeature("a", *face),
    }.items():
        with pytest.raises(ValueError, match=words):
            make()
