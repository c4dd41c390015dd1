"""Parameter files with one mistake each, and the line that tells the user what it is."""

import re
from collections.abc import Callable
from pathlib import Path

import pytest

from stagecad.parameters.errors import InputError
from stagecad.parameters.file import packaged_text
from stagecad.parameters.load import load_design

LENGTH = 'length = {value = "230 mm", tolerance = "X", origin = "assumed: drive surface longer'


def swap(old: str, new: str) -> Callable[[str], str]:
    def change(text: str) -> str:
        assert old in text, f"the packaged file has no {old!r} any more"
        return text.replace(old, new, 1)

    return change


def length(entry: str) -> Callable[[str], str]:
    """The stage's length entry replaced."""
    return lambda text: re.sub(r'(?m)^length = \{value = "230 mm".*$', lambda _: entry, text, count=1)


def head(line: str) -> Callable[[str], str]:
    return lambda text: f"{line}\n{text}"


BROKEN: list[tuple[str, Callable[[str], str], str]] = [
    (
        "unknown key",
        swap("corner_radius =", "corner_radios ="),
        r"no parameter 'stage.corner_radios'; did you mean 'stage.corner_radius'\?",
    ),
    ("unknown table", swap("[stage]", "[stge]"), r"no parameter 'stge.material'; did you mean 'stage.material'\?"),
    ("stray table", head("[lift]\nspeed = '2 m/s'\n"), r"no parameter 'lift.speed'; did you mean"),
    (
        "missing key",
        length(""),
        r"stage.length is missing \(along the travel\); add it, or begin the file with extends",
    ),
    ("empty file", lambda text: "", r"stage.material is missing"),
    ("wrong dimension", length('length = "230 kg"'), r"stage.length: '230 kg' has the wrong dimension; wanted 'mm'"),
    ("no unit", length('length = "230"'), r"stage.length: '230' has no unit"),
    ("bare number", length("length = 230"), r"stage.length: 230 has no unit"),
    ("unknown unit", length('length = "230 milimeter"'), r"unknown unit symbol 'milimeter'; did you mean"),
    ("no number", length('length = "long"'), r"stage.length: 'long' is not a quantity"),
    ("range as a value", length('length = "8..20mm"'), r"one number, then one unit"),
    ("negative size", length('length = "-230 mm"'), r"stage.length: '-230 mm' must be positive, and finite"),
    ("zero size", length('length = "0 mm"'), r"stage.length: '0 mm' must be positive"),
    ("infinite size", length('length = "inf"'), r"stage.length: 'inf' must be positive, and finite"),
    ("list", length('length = ["230 mm"]'), r"stage.length = a list is not a value"),
    ("date", length("length = 2020-01-01"), r"stage.length = a date is not a value"),
    ("truth for a length", length("length = true"), r"stage.length: true is not a quantity"),
    ("empty table", length("length = {}"), r"stage.length is missing"),
    ("table without value", length('length = {origin = "thesis 2"}'), r"stage.length: has no value"),
    (
        "unknown pedigree",
        length('length = {value = "230 mm", orgin = "thesis 2"}'),
        r"unknown field 'orgin'; did you mean 'origin'\?",
    ),
    (
        "unknown tolerance",
        length('length = {value = "230 mm", tolerance = "Q9"}'),
        r"tolerance = 'Q9'; allowed: X, X.X, X.XX",
    ),
    (
        "unknown origin",
        length('length = {value = "230 mm", origin = "I think"}'),
        r"origin = 'I think'; write one of: thesis SECTION",
    ),
    (
        "origin without reason",
        length('length = {value = "230 mm", origin = "assumed"}'),
        r"origin = 'assumed'; write one of",
    ),
    ("value a list", length("length = {value = [1]}"), r"value = a list is not a value"),
    (
        "key twice",
        length('length = "230 mm"\nlength = "240 mm"'),
        r"line \d+: 'length' is given twice; keep one of them",
    ),
    ("table twice", lambda text: text + "\n[stage]\nlength = '1 mm'\n", r"line \d+: '\[stage\]' is given twice"),
    ("not TOML", length("length = 230 mm"), r"line \d+: not TOML: .*length = 230 mm"),
    ("unclosed text", length('length = "230 mm'), r"line \d+: not TOML"),
    ("unclosed table head", swap("[pads]", "[pads"), r"line \d+: not TOML"),
    (
        "value outside tables",
        head('length = "230 mm"'),
        r"length = '230 mm' is outside a table; write it in a table like \[stage\]",
    ),
    ("table of tables", swap("[stage]", "[[stage]]"), r"stage = a list is outside a table"),
    ("unknown extends", head('extends = "other"'), r"extends = 'other': only 'thesis'"),
    (
        "fraction of a count",
        swap("payload_columns = {value = 4", "payload_columns = {value = 4.5"),
        r"stage.payload_columns: '4.5' must be a whole number from 2 to 100",
    ),
    (
        "count out of range",
        swap("count = {value = 3", "count = {value = 7"),
        r"pads.count: '7' must be a whole number from 3 to 4",
    ),
    (
        "no truth value",
        swap("fitted = {value = true", 'fitted = {value = "perhaps"'),
        r"teeth.fitted: 'perhaps' is neither true nor false",
    ),
    (
        "unknown material",
        swap('value = "sic"', 'value = "sick"'),
        r"bearing_way.material: no material 'sick'; did you mean 'sic'\?",
    ),
    (
        "unknown choice",
        swap('value = "square"', 'value = "squared"'),
        r"teeth.profile: no choice 'squared'; did you mean 'square'\?",
    ),
    ("number for text", swap('value = "Precision Stage"', "value = 3"), r"drawing.title: '3' is not a line of text"),
    ("empty text", swap('value = "Precision Stage"', 'value = "  "'), r"drawing.title: '  ' is not a line of text"),
    (
        "ratio out of bounds",
        swap("poisson_ratio = {value = 0.33", "poisson_ratio = {value = 0.7"),
        r"materials.al_6061_t6.poisson_ratio: '0.7' must lie between -1 and 0.5",
    ),
    (
        "material with a part missing",
        swap("[materials.sic]", "[materials.glass]\ndensity = '2500 kg/m^3'\n[materials.sic]"),
        r"materials.glass.description is missing",
    ),
    (
        "materials nested too deep",
        swap("[materials.sic]", "[materials.sic.more]\na = 1\n[materials.sic]"),
        r"no parameter 'materials.sic.more.a'",
    ),
    (
        "unit for a bare number",
        swap("slope = {value = 0.05", 'slope = {value = "0.05 mm"'),
        r"height_pin_1.slope: '0.05 mm' has a unit, but a bare number is needed",
    ),
    (
        "what does not go together",
        length('length = "205 mm"'),
        r"the tip of actuator 1 leaves the drive surface: stage.length = 205 mm must be at least 220 mm",
    ),
    (
        "a computed value that cannot be",
        swap('thickness = {value = "12 mm"', 'thickness = {value = "2 mm"'),
        r"stage.payload_drill_depth becomes -1 mm, from stage.thickness - stage.payload_floor; it must be",
    ),
]


@pytest.mark.parametrize(("change", "line"), [pytest.param(c, m, id=i) for i, c, m in BROKEN])
def test_one_line_names_file_key_and_what_is_right(change: Callable[[str], str], line: str, tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text(change(packaged_text()), "utf-8")
    with pytest.raises(InputError) as caught:
        load_design(file)
    message = str(caught.value)
    assert message.startswith(f"{file}: ")
    assert re.search(line, message), message
    assert message.isprintable()


def test_files_that_are_no_text(tmp_path: Path) -> None:
    missing = tmp_path / "none.toml"
    with pytest.raises(InputError, match=r"none.toml: no such parameter file"):
        load_design(missing)
    with pytest.raises(InputError, match=r"is a folder, not a parameter file"):
        load_design(tmp_path)
    binary = tmp_path / "binary.toml"
    binary.write_bytes(b"[stage]\nlength = '\xff\xfe'\n")
    with pytest.raises(InputError, match=r"binary.toml: line 2: not UTF-8"):
        load_design(binary)
    nested = tmp_path / "nested.toml"
    nested.write_text("a = " + "[" * 5000, "utf-8")
    with pytest.raises(InputError, match=r"nested.toml: "):
        load_design(nested)


OVERRIDES = [
    ("stage.length", r"write KEY=VALUE"),
    ("=3 mm", r"write KEY=VALUE"),
    ("stage.length=", r"write KEY=VALUE"),
    ("stage.lenght=3 mm", r"no parameter 'stage.lenght'; did you mean 'stage.length'\?"),
    ("stage=3 mm", r"\[stage\] is a table: name a key in it"),
    ("stage.length=3 kg", r"--set stage.length: '3 kg' has the wrong dimension"),
    ("materials.glas.density=3 kg/m^3", r"no parameter 'materials.glas.density'; allowed: al_6061_t6"),
    ("base.material=sus_416", r"no material 'sus_416'; did you mean 'sus416'\?"),
    ("pads.count=three", r"--set pads.count: 'three' is not a quantity"),
]


@pytest.mark.parametrize(("override", "line"), OVERRIDES)
def test_bad_overrides(override: str, line: str) -> None:
    with pytest.raises(InputError, match=line) as caught:
        load_design(None, [override])
    assert str(caught.value).isprintable()
