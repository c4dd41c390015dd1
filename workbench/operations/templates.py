"""`new`: templates of what a user makes, and the hardware table of a machine."""

import csv
import hashlib
import io
import json
import shutil
import tempfile
import tomllib
from collections.abc import Iterator
from importlib.metadata import distribution
from importlib.resources import as_file, files
from itertools import chain, count
from pathlib import Path
from typing import Any

from sim.effects.catalogue import library, valid_name
from stagecad.consent import give_consent
from stagecad.parameters.atomic import atomic_write_bytes, atomic_write_text
from stagecad.parameters.design import Design
from stagecad.parameters.errors import InputError, require, require_known
from stagecad.parameters.input_file import read_input
from stagecad.parameters.machine import packaged_machine
from stagecad.parameters.names import identifier
from stagecad.parameters.project_tables import HARDWARE, NAME, ROW, SOURCE, Kind
from stagecad.parameters.units import from_si, to_si

FOLDER = Path(__file__).parents[1] / "templates"
TEMPLATES = {
    "part": "NAME.py: a part in cadquery with its dimensions; `stagecad drawings --part NAME.py` draws it.",
    "check": "checks/NAME.py: a design check; `stagecad check` runs those beside the parameter file.",
    "effect": "NAME.py: a physical effect, for `[model] custom` of an experiment.",
    "example": "NAME/: a copy of a packaged example "
    "(demo, own_effect, own_rig, two_axis_stage, ball_screw_slide, mirror_mount, improved_stage).",
    "machine": "NAME/: a project folder with stage.toml, a check of its own and a part of its own.",
}
"""What each kind of template writes."""


def shared_folder() -> Path:
    """The folder of README.md, `docs` and `examples`: that of the packages in a checkout, else that of the wheel."""
    root = Path(__file__).resolve().parents[2]
    if (root / "pyproject.toml").is_file():
        return root
    index = "share/stagecad/docs/index.md"
    for file in distribution("stagecad").files or ():
        if file.as_posix().endswith(index):
            return Path(str(file.locate())).resolve().parents[1]
    raise InputError("documentation and examples are not installed; they are in the source of stagecad")


def template(kind: str, name: str) -> str:
    """Text of a template with the user's name in it."""
    if kind == "effect" and name in library():
        raise InputError(f"new effect '{name}': is an effect of the library; choose another name")
    identifier(name, f"new {kind} '{name}'")
    text = (FOLDER / f"{kind}.{'toml' if kind == 'machine' else 'py'}.txt").read_text("utf-8")
    return text.replace(f"my_{kind}", name).replace(f"my {kind}", name.replace("_", " "))


def write_effect(path: Path) -> str:
    """Write the template of an effect to a new file, and return the name of the effect, which is the file's."""
    name = path.stem
    require(path.suffix == ".py", f"{path}: must end in .py")
    require(valid_name(name), f"{path}: the effect is named after its file: lower-case words joined by underscores")
    require(name not in library(), f"{path}: a built-in effect is named '{name}'; choose another")
    require(not path.exists(), f"{path}: is there already; name a new file")
    atomic_write_text(path, template("effect", name))
    return name


def write_new(path: Path, text: str) -> Path:
    """Write a file that is not there yet; its folder is made."""
    require(not path.exists(), f"{path}: is there already; choose another name")
    path.parent.mkdir(parents=True, exist_ok=True)
    atomic_write_text(path, text)
    return path


def write_template(kind: str, name: str) -> list[str]:
    """Write a template under the user's name; what was written, in lines."""
    if kind == "example":
        folder = copy_example(name, Path(name))
        measured = (folder / "experiment.toml").is_file()
        words = f"stagecad compare {folder}" if measured else f"cd {folder}, then: stagecad check"
        return [f"written: {folder}", f"{EXAMPLES[name]}; see examples.html of 'stagecad docs'", f"next: {words}"]
    if kind == "machine":
        return [*(f"written: {file}" for file in write_machine(name)), f"next: cd {name}, then: stagecad check"]
    return [f"written: {write_new(Path('checks' if kind == 'check' else '', f'{name}.py'), template(kind, name))}"]


def write_machine(name: str) -> list[Path]:
    """Write a project folder with stage.toml, a check and a part; it appears complete, by renaming. The consent to run
    its Python files is stored, since their content is this program's until the user edits them."""
    folder = Path(name)
    texts = {
        "stage.toml": template("machine", name),
        f"checks/{name}_check.py": template("check", f"{name}_check").replace('"stage.', '"plate.'),
        f"{name}_part.py": template("part", f"{name}_part"),
    }
    require(not folder.exists(), f"{folder}: is there already; choose another name")
    with tempfile.TemporaryDirectory(prefix=f".{name}-", dir=folder.absolute().parent) as temporary:
        made = Path(temporary) / name
        for file, text in texts.items():
            atomic_write_text(made / file, text)
        made.rename(folder)
    written = [folder / file for file in texts]
    give_consent(tuple(file for file in written if file.suffix == ".py"))
    return written


_UNITS = {"m": "um", "m^2": "mm^2", "kg": "g", "Pa": "MPa", "F": "uF"}
"""Units of the columns whose keys are kept in others."""


def table_text(design: Design, kind: str) -> str:
    """The table of a kind with one row for each piece of hardware in the design."""
    declared = design.machine.kinds()[kind]
    # Optional columns of a kind with names are for rows that the parameter file has no keys for.
    free = declared.optional if declared.names else ()
    columns = [column for column, one in declared.columns.items() if not one.computed and column not in free]
    memory = io.StringIO()
    writer = csv.writer(memory, lineterminator="\n")
    kept = {column: declared.columns[column].unit for column in columns}
    units = {column: _UNITS.get(unit, unit) for column, unit in kept.items()}
    writer.writerow([NAME, *(f"{one} [{unit}]" if unit else one for one, unit in units.items()), SOURCE])
    for name, keys in dict(_rows(design, kind, declared, columns)).items():
        values = [design.value(key) for key in keys]
        cells = [_cell(value, kept[column], units[column]) for column, value in zip(columns, values, strict=True)]
        writer.writerow([name, *cells, f"assumed: as in {design.file}"])
    return memory.getvalue()


def write_table_of(design: Design, kind: str) -> list[str]:
    """Write KIND.csv with the pieces of hardware of the design; what was written, and how it is used."""
    kinds = packaged_machine().kinds()
    require_known(kind, kinds, f"new hardware '{kind}': no such kind of table")
    written = write_new(Path(f"{kind}.csv"), table_text(design, kind))
    lines = [f"written: {written}", f'then, in the parameter file: [{HARDWARE}] {kind} = "{kind}.csv"']
    return [*lines, *(f"and the name of a row as {slot}.{ROW}" for slot in kinds[kind].slots[:1])]


def _rows(design: Design, kind: str, declared: Kind, columns: list[str]) -> Iterator[tuple[str, list[str]]]:
    """Names of the rows with the keys of their values."""
    for slot in declared.slots:
        yield str(design.value(f"{slot}.part_number")), [f"{slot}.{column}" for column in columns]
    for name in declared.names:
        if design.has(f"{kind}.{name}_{columns[0]}"):
            yield name, [f"{kind}.{name}_{column}" for column in columns]
    if kind == "materials":
        for name in design.materials:
            yield name, [f"{kind}.{name}.{column}" for column in columns]


def _cell(value: Any, kept: str, unit: str) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return f"{from_si(to_si(value, kept), unit):.10g}" if isinstance(value, float) else str(value)


EXAMPLES = {
    "demo": "A slide whose records contain two hidden effects; the model knows Coulomb and viscous friction",
    "own_effect": "A bellows, which the library does not contain: an effect in a Python file beside the records",
    "own_rig": "A voice coil: a kind of rig in a declaration file beside the records, logged as a spreadsheet writes",
    "emps": "A ball-screw axis in closed loop, a public benchmark",
    "reciprocating_tribometer": "Presliding and slip over 0.24 mm of stroke, a public record",
    "two_axis_stage": "A machine of one's own: two slides at right angles",
    "ball_screw_slide": "A machine of one's own, with a part and a check in Python",
    "mirror_mount": "A machine of one's own: five parts with sheets, screws by designation",
    "improved_stage": "The stage of the thesis as the optimisation improves it",
}
"""What each packaged example shows."""


def examples(experiments: bool = False) -> list[str]:
    """Names of the examples, or of those with an experiment, whose records are on this computer."""
    return [name for name in EXAMPLES if name == "demo" or _files(name, experiments)]


def copy_example(name: str, target: Path) -> Path:
    """Copy an example to `target`, or to the next free name; returns the folder."""
    require_known(name, examples(), f"no example '{name}'")
    if name == "demo":
        return fresh_demo(target)
    free = next(folder for folder in _numbered(target) if not folder.exists())
    for path in _files(name):
        atomic_write_bytes(free / path.relative_to(shared_folder() / "examples" / name), path.read_bytes())
    return free


def _files(name: str, experiment: bool = False) -> list[Path]:
    """Files of an example; none unless all of its records are there."""
    folder = shared_folder() / "examples" / name
    stated = folder / "experiment.toml"
    if not stated.is_file():
        files = sorted(path for path in folder.rglob("*") if path.is_file() and path.suffix != ".pyc")
        return [] if experiment else files
    records = [folder / record["file"] for record in tomllib.loads(stated.read_text("utf-8")).get("record", ())]
    if not all(record.is_file() and record.parent == folder for record in records):
        return []
    return sorted(path for path in folder.iterdir() if path.is_file() and path.name != "make_records.py")


STATE = ".demo.json"
"""File in a folder of the demonstration: the hash of each file of the experiment as the demonstration left it."""


def fresh_demo(folder: str | Path) -> Path:
    """Copy the packaged demonstration to a folder, or to the next free one; returns the folder."""
    return fresh_copy(free_folder(Path(folder)))


def free_folder(folder: Path) -> Path:
    """`folder`, or the first of FOLDER_2, FOLDER_3, ... that does not exist or is as a demonstration left it."""
    return next(one for one in _numbered(folder) if not (one.exists() or one.is_symlink()) or _as_left(one))


def _numbered(folder: Path) -> Iterator[Path]:
    yield from chain([folder], (folder.with_name(f"{folder.name}_{number}") for number in count(2)))


def fresh_copy(folder: Path) -> Path:
    """The packaged experiment in its initial state in `folder`, which is new or one that `free_folder` has found."""
    for left_over in ("ladder", "sections"):
        if (folder / left_over).is_dir():
            shutil.rmtree(folder / left_over)
    with as_file(files("workbench") / "demo_records") as packaged:
        for path in sorted(packaged.iterdir()):
            if path.suffix in (".toml", ".csv"):
                atomic_write_bytes(folder / path.name, path.read_bytes())
    remember(folder)
    return folder


def remember(folder: Path) -> None:
    """Store the state of the experiment in `folder`, by which the next demonstration recognises an unchanged folder."""
    atomic_write_text(folder / STATE, json.dumps(dict(_hashes(folder)), indent=1) + "\n")


def _as_left(folder: Path) -> bool:
    try:
        return not folder.is_symlink() and json.loads(read_input(folder / STATE)) == dict(_hashes(folder))
    except (OSError, ValueError):
        return False


def _hashes(folder: Path) -> Iterator[tuple[str, str]]:
    """Name and hash of each file of the experiment; reports and figures can be made again and do not count."""
    beside = [path for path in folder.iterdir() if path.suffix in (".toml", ".csv", ".parquet", ".mat", ".py")]
    for path in sorted(path for path in (*beside, *(folder / "ladder").rglob("*")) if path.is_file()):
        yield path.relative_to(folder).as_posix(), hashlib.sha256(path.read_bytes()).hexdigest()
