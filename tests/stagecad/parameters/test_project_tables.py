"""Hardware tables of a project: what their rows give to a design, and what is refused."""

import re
from pathlib import Path

import pytest

from stagecad.friction_stage.parameters.ranges import kinds
from stagecad.parameters.errors import InputError
from stagecad.parameters.file import read_parameter_file
from stagecad.parameters.load import load_design, variations_of
from tests.reference.tables import cases
from tests.refusals import refused
from workbench.operations.templates import table_text

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
