"""Parameter files and hardware tables with one mistake each, TOML of hostile shape, and the line that tells it."""

import re
from collections.abc import Callable
from pathlib import Path

import pytest

from stagecad.friction_stage.parameters.ranges import kinds
from stagecad.parameters.errors import LONGEST, InputError
from stagecad.parameters.file import packaged_text, read_parameter_file
from stagecad.parameters.input_file import load_toml
from stagecad.parameters.load import design_from_text, load_design, variations_of
from tests.reference.tables import cases
from tests.refusals import refused
from workbench.cli import run
from workbench.operations.templates import table_text

LENGTH = 'length = {value = "230 mm", tolerance = "X", origin = "assumed: drive surface longer'


def swap(old: str, new: str) -> Callable[[str], str]:
    def change(text: str) -> str:
        assert old in text, f"the packaged file has no {old!r} any more"
        return text.replace(old, new, 1)

    return change


def length(entry: str) -> Callable[[str], str]:
    return lambda text: re.sub(r'(?m)^length = \{value = "230 mm".*$', lambda _: entry, text, count=1)


def head(line: str) -> Callable[[str], str]:
    return lambda text: f"{line}\n{text}"


TABLE = "broken_parameter_files"
BROKEN: list[tuple[str, Callable[[str], str], str]] = [
    *((name, length(entry), line) for name, entry, line in cases(TABLE, "length")),
    *((name, swap(old, new), line) for name, old, new, line in cases(TABLE, "swapped")),
    *((name, head(first), line) for name, first, line in cases(TABLE, "first_line")),
    ("empty file", lambda text: "", r"stage.material is missing"),
    ("table twice", lambda text: text + "\n[stage]\nlength = '1 mm'\n", r"line \d+: '\[stage\]' is given twice"),
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
    refused(r"none.toml: no such parameter file", load_design, tmp_path / "none.toml")
    refused(r"is a folder, not a parameter file", load_design, tmp_path)
    binary = tmp_path / "binary.toml"
    binary.write_bytes(b"[stage]\nlength = '\xff\xfe'\n")
    refused(r"binary.toml: line 2: not UTF-8", load_design, binary)
    nested = tmp_path / "nested.toml"
    nested.write_text("a = " + "[" * 5000, "utf-8")
    refused(r"nested.toml: ", load_design, nested)


@pytest.mark.parametrize(("override", "line"), cases(TABLE, "overrides"))
def test_bad_overrides(override: str, line: str) -> None:
    with pytest.raises(InputError, match=line) as caught:
        load_design(None, [override])
    assert str(caught.value).isprintable()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a = " + "9" * 5000, "has a whole number of thousands of digits"),
        ("[t]\na = " + "9" * 400, "t.a: is a whole number of more than 64 bits"),
        ("[t]\na = 9223372036854775808", "t.a: is a whole number of more than 64 bits"),
        ("a = [[1, 99999999999999999999]]", "a: is a whole number of more than 64 bits"),
        ("[" + "a." * 1200 + "a]\nb = 1", "is nested too deeply"),
        ("a = " + "[" * 5000 + "]" * 5000, "has tables nested too deeply"),
    ],
)
def test_a_document_beyond_the_limits(text: str, said: str) -> None:
    refused(said, load_toml, text, "f.toml")
    with pytest.raises(InputError):
        design_from_text(text, "f.toml")


def test_messages_are_one_bounded_line_and_the_largest_integers_are_read() -> None:
    assert load_toml("a = -9223372036854775808\nb = 9223372036854775807", "f.toml")["a"] == -(2**63)
    text = str(InputError("a\x1b[31m\n\tb\u202e" + "x" * 100_000 + " the end"))
    assert text.startswith(r"a\x1b[31m b\u202exxx") and text.endswith("the end")
    assert text.isprintable() and len(text) < LONGEST


@pytest.mark.parametrize("name", ["\x1b]0;owned\x07", "a\nb", "\u202e"])
def test_control_characters_never_reach_the_terminal(name: str, capsys, tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "stage.toml").write_text(f'extends = "thesis"\n[stage]\nmaterial = {name!r}\n', "utf-8")
    for words in (["check"], ["compare", name], ["calc", name], [name], ["params", "--set", f"stage.{name}=1"]):
        assert run(words) == 2
        said = capsys.readouterr().err
        assert said.endswith("\n") and said[:-1].isprintable()


PIEZOS = """name,part_number,description,material,diameter [mm],length [mm],end_radius [mm],stroke [um],\
blocking_force [N],highest_voltage [V],capacitance [uF],element_area [mm^2],moving_mass [g],source
# stacks of the same height
long stroke,P-1,"stack, long",pzt,10,36,20,38,950,120,3.1,25,3,maker A 2024
short stroke,P-2,stack,pzt,10,36,20,12,1.2 kN,120,1.9,25,3,assumed: as told by the maker
"""
STAGE = """extends = "thesis"
[hardware]
piezos = "piezos.csv"
[piezo]
row = {value = "long stroke", origin = "assumed: stroke", free = "long stroke | short stroke"}
"""


@pytest.fixture
def project(tmp_path: Path) -> Path:
    (tmp_path / "piezos.csv").write_text(PIEZOS, "utf-8")
    (tmp_path / "stage.toml").write_text(STAGE, "utf-8")
    return tmp_path / "stage.toml"


def test_the_chosen_row_gives_values_with_origin_and_all_that_follows(project: Path, design) -> None:
    mine = load_design(project)
    assert (mine.piezo.stroke, mine.piezo.part_number) == (38e-6, "P-1")
    assert mine.piezo.stiffness == pytest.approx(950 / 38e-6)  # computed from the row
    assert mine.entry("piezo.stroke").origin == "catalogue maker A 2024"
    # A column that the table does not have, and the tolerance of the assembly, are those of the file.
    assert mine.entry("piezo.creep") == design.entry("piezo.creep")
    assert mine.tolerance("piezo.length") == design.tolerance("piezo.length")
    other = load_design(project, ["piezo.row=short stroke", "piezo.capacitance=2 uF"])
    assert (other.piezo.stroke, other.piezo.blocking_force, other.piezo.capacitance) == (12e-6, 1200.0, 2e-6)
    assert other.entry("piezo.stroke").origin == "assumed: as told by the maker"
    plain = load_design(project, ["piezo.row=none"])
    assert {entry.key for entry in plain.entries if entry.value != design.value(entry.key)} == set()
    changed = variations_of(read_parameter_file(project)).changed({"piezo.row": "short stroke"})
    again = load_design(project, ["piezo.row=short stroke"])
    assert {entry.key: entry.value for entry in changed.entries} == {entry.key: entry.value for entry in again.entries}
    assert changed.piezo == again.piezo


def test_tables_of_the_packaged_hardware_and_materials_without_a_row(tmp_path: Path, design) -> None:
    named = []
    for kind in kinds():
        (tmp_path / f"{kind}.csv").write_text(table_text(design, kind), "utf-8")
        named.append(f'{kind} = "{kind}.csv"')
    slots = [slot for kind in kinds().values() for slot in kind.slots]
    rows = [f'[{slot}]\nrow = "{design.value(f"{slot}.part_number")}"' for slot in slots]
    (tmp_path / "s.toml").write_text('extends = "thesis"\n[hardware]\n' + "\n".join([*named, *rows]) + "\n", "utf-8")
    mine = load_design(tmp_path / "s.toml")
    values = {entry.key: entry.value for entry in design.entries if not entry.key.endswith(".row")}
    assert {key: mine.value(key) for key in values} == pytest.approx(values, rel=1e-9)
    assert mine.entry("materials.sic.density").origin == "assumed: as in thesis.toml"
    header = "name, description, density [g/cm^3], youngs_modulus [GPa], poisson_ratio, expansion [1/K], strength [MPa]"
    steel = "steel_416, EN 1.4005, 7.75, 200, 0.28, 1e-5, 275, yield, FALSE"
    (tmp_path / "m.csv").write_text(f"{header}, strength_kind, magnetic\n\n{steel}\n", "utf-8")
    (tmp_path / "t.csv").write_text("name,tap_drill [mm],pitch [mm]\nm6,5.1,1\n", "utf-8")
    file = tmp_path / "s.toml"
    text = 'extends = "thesis"\n[hardware]\nmaterials = "m.csv"\nthreads = "t.csv"\n[stage]\nmaterial = "steel_416"\n'
    file.write_text(text, "utf-8")
    design = load_design(file)
    material = design.material("stage.material")
    assert (material.density, material.magnetic, material.treatment) == (pytest.approx(7750.0), False, "none")
    assert design.threads.m6_tap_drill == 5.1 and design.threads.m5_tap_drill == load_design().threads.m5_tap_drill


@pytest.mark.parametrize("old, new, message", cases("hardware_tables", "rows"))
def test_a_mistake_in_a_table_is_one_line_with_row_and_column(project: Path, old: str, new: str, message: str) -> None:
    text = PIEZOS.replace('"stack, long"', "long")
    assert old in text
    (project.parent / "piezos.csv").write_text(text.replace(old, new), "utf-8")
    refused(re.escape(message), load_design, project)


@pytest.mark.parametrize("name", ["../piezos.csv", "/etc/passwd", "link.csv", "."])
def test_tables_are_read_from_the_project_folder_alone(project: Path, tmp_path_factory, name: str) -> None:
    outside = tmp_path_factory.mktemp("outside") / "piezos.csv"
    outside.write_text(PIEZOS, "utf-8")
    (project.parent / "link.csv").symlink_to(outside)
    project.write_text(STAGE.replace("piezos.csv", name), "utf-8")
    refused("outside the folder of the parameter file", load_design, project)


@pytest.mark.parametrize("text, message", cases("hardware_tables", "files"))
def test_a_mistake_in_the_parameter_file_names_what_is_allowed(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "s.toml").write_text(f'extends = "thesis"\n{text}', "utf-8")
    with pytest.raises(InputError) as error:
        load_design(tmp_path / "s.toml")
    assert message in str(error.value)
