"""The table [machine] of a parameter file."""

from __future__ import annotations

import tomllib

import pytest

from stagecad.parameters.dimension import Datum
from stagecad.parameters.errors import InputError
from stagecad.parameters.file import parse_parameter_text
from stagecad.parameters.load import load_design
from stagecad.solids.assembly.declared import put_together
from stagecad.solids.assembly.machine_declaration import MachineDeclaration, read_machine

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
    return read_machine(table, "mill.toml", load_design())


def test_mates_follow_the_parts_they_are_put_on() -> None:
    machine = _read(TEXT)
    assert [mate.name for mate in machine.mates] == ["plate", "one", "two"]
    assert machine.mates[1].offset == pytest.approx((3.0, -36.0, 1.0))
    assert machine.parts[1].parameters == {"length": "5.0 mm", "way.height": "1 mm"}
    assert machine.overlaps == {frozenset(("block", "plate"))}


def test_instances_are_where_mates_and_offsets_put_them() -> None:
    up, down, x = (0.0, 0.0, 1.0), (0.0, 0.0, -1.0), (1.0, 0.0, 0.0)
    block = {"bottom": Datum("bottom", (0, 0, 0), down, x), "top": Datum("top", (0.0, 0.0, 20.0), up, x)}
    plate = {"top": Datum("top", (10.0, 0.0, 8.0), up, x)}
    instances = put_together(_read(TEXT), {"plate": plate, "block": block}, "mill.toml")
    frames = {one.name: one.frame for one in instances}
    assert frames["one"].shift == pytest.approx((13.0, -36.0, 9.0))
    assert frames["two"].shift == pytest.approx((13.0, -36.0, 29.0))
    assert frames["two"].direction(x) == pytest.approx((0.0, 1.0, 0.0))
    with pytest.raises(InputError, match=r"machine.mates.one.on: part 'plate' has no datum 'top'"):
        put_together(_read(TEXT), {"plate": {}, "block": block}, "mill.toml")


@pytest.mark.parametrize(
    "old, new, words",
    [
        ("plate = {}", "", "one part is fixed"),
        ('"one.top"', '"ones.top"', "did you mean 'one'"),
        ('"plate.top"', '"two.top"', "is put on parts that are put on it"),
        ('part = "block", datum', 'part = "blok", datum', "did you mean 'block'"),
        ('file = "plate.py"', 'file = "../plate.py"', "outside the folder"),
        ('"3 mm"', '"3 kg"', "wrong dimension"),
        ('"=-piezo.length"', '"=-piezo.lenght"', "piezo.length"),
        ("overlaps", "overlap", "did you mean 'overlaps'"),
    ],
)
def test_mistakes(old: str, new: str, words: str) -> None:
    assert old in TEXT
    with pytest.raises(InputError, match=words):
        _read(TEXT.replace(old, new))


def test_text_is_toml() -> None:
    assert set(tomllib.loads(TEXT)["machine"]) == {"overlaps", "parts", "mates"}
