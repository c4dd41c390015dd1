"""The cache remembers by what was read, forgets nothing it should know, and survives damage."""

import ast
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import pytest

from stagecad.parameters.tracking import TrackedDesign, path_text
from stagecad.solids.artefacts import key as key_module
from stagecad.solids.artefacts import store as store_module
from stagecad.solids.artefacts.key import ROOT, _file, _names
from stagecad.solids.artefacts.store import FILE, Artefact, ArtefactStore

MODULES = ("stagecad.solids.modelling.frame",)


@dataclass(frozen=True)
class Table:
    length: float = 3.0
    width: float = 4.0
    deep: bool = False
    depth: float = 1.0

    @property
    def area(self) -> float:
        return self.length * self.width

    def scaled(self, by: float) -> float:
        return self.length * by


@dataclass(frozen=True)
class Plan:
    plate: Table = field(default_factory=Table)
    other: Table = field(default_factory=Table)
    density: Any = field(default_factory=lambda: MappingProxyType({"iron": 7.9, "gold": 19.3}))


class Maker:
    """Counts how often it is asked to make, and reads what a part would."""

    def __init__(self) -> None:
        self.runs = 0

    def __call__(self, design: Any, folder: Path) -> None:
        self.runs += 1
        size = design.plate.area + design.plate.scaled(2.0) + design.density["iron"]
        if design.plate.deep:
            size += design.plate.depth
        (folder / "size.txt").write_text(repr(size))


@pytest.fixture
def store(tmp_path: Path) -> ArtefactStore:
    return ArtefactStore(tmp_path / "store")


def test_reading_notes_each_way_to_a_value() -> None:
    notes: dict[Any, str] = {}
    reading = TrackedDesign(Plan(), notes)
    assert reading.plate.length + reading.density["iron"] + reading.plate.scaled(by=2.0) == 3.0 + 7.9 + 6.0
    assert {path_text(steps): value for steps, value in notes.items()} == {
        "plate.length": "3.0",
        "density['iron']": "7.9",
        "plate.scaled(by=2.0)": "6.0",
    }


def test_what_is_read_is_noted_and_equal_files_are_equal_content(store: ArtefactStore) -> None:
    def make(design: Any, folder: Path) -> None:
        (folder / "length.txt").write_text(str(round(design.plate.length)))

    one, same, other = (
        store.make("length", replace(Plan(), plate=Table(length=length)), MODULES, make) for length in (3.0, 3.1, 4.0)
    )
    assert one.key != same.key and one.content == same.content != other.content

    def make(design: Any, folder: Path) -> None:
        (folder / "sum.txt").write_text(str(sum(design.density.values())))

    first = store.make("sum", Plan(), MODULES, make)
    changed = Plan(density=MappingProxyType({"iron": 7.9, "gold": 19.4}))
    assert store.make("sum", changed, MODULES, make).key != first.key


def test_the_store_is_searched_again_when_it_has_grown(store: ArtefactStore, monkeypatch: pytest.MonkeyPatch) -> None:
    searches: list[str] = []
    monkeypatch.setattr(ArtefactStore, "_remove_oldest", lambda self, keep: searches.append(keep))
    monkeypatch.setenv("STAGECAD_CACHE_MAX", "100000")
    for length in (1.0, 2.0, 3.0):
        store.make("part", Plan(plate=Table(length=length)), MODULES, Maker())
    assert len(searches) == 1

    def large(design: Any, folder: Path) -> None:
        (folder / "large.bin").write_bytes(bytes(int(design.plate.length * 600)))

    for length in (1.0, 1.01, 2.0):
        store.make("large", Plan(plate=Table(length=length)), MODULES, large)
    assert len(searches) == 3


def test_an_artefact_is_made_once_for_what_was_read(store: ArtefactStore) -> None:
    maker, plan = Maker(), Plan()
    first = store.make("part", plan, MODULES, maker)
    again = ArtefactStore(store.folder).make("part", Plan(), MODULES, maker)
    assert (maker.runs, again.key, again.data("size.txt")) == (1, first.key, first.data("size.txt"))
    unread = replace(plan, other=Table(length=99.0), density=MappingProxyType({"iron": 7.9, "gold": 1.0}))
    unread = replace(unread, plate=replace(plan.plate, depth=5.0))
    assert store.make("part", unread, MODULES, maker).key == first.key
    assert store.make("part", replace(plan, plate=Table(width=5.0)), MODULES, maker).key != first.key
    assert maker.runs == 2
    shallow, deep = Plan(), Plan(plate=Table(deep=True))
    deeper = Plan(plate=Table(deep=True, depth=2.0))
    keys = [store.make("part", plan, MODULES, maker).key for plan in (shallow, deep, deeper)]
    assert len(set(keys)) == 3
    found = [store.find("part", plan, MODULES) for plan in (deeper, shallow, deep)]
    assert [entry.key if entry else None for entry in found] == [keys[2], keys[0], keys[1]]
    assert maker.runs == 4


def test_name_dependencies_and_versions_count(store: ArtefactStore, monkeypatch: pytest.MonkeyPatch) -> None:
    maker = Maker()
    store.make("part", Plan(), MODULES, maker)
    assert store.find("part", Plan(), MODULES, depends=["another"]) is None
    assert store.find("whole", Plan(), MODULES) is None
    monkeypatch.setattr(key_module, "versions", lambda packages: {"cadquery": "99"})
    assert store.find("part", Plan(), MODULES) is None


def test_source_of_what_a_module_imports_counts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    package = tmp_path / "stagecad"
    package.mkdir()
    (package / "__init__.py").write_text("")
    (package / "part.py").write_text("def build():\n    from stagecad import (\n        holes,  # drilled\n    )\n")
    (package / "holes.py").write_text("import stagecad.tables\n")
    (package / "tables.py").write_text("SIZE = 1\n")
    (package / "unrelated.py").write_text("SIZE = 1\n")
    monkeypatch.setattr(key_module, "ROOT", tmp_path)

    def digest() -> str:
        for function in (key_module._file, key_module._imported, key_module.source_digest):
            function.cache_clear()
        return key_module.source_digest(("stagecad.part",))

    before = digest()
    (package / "unrelated.py").write_text("SIZE = 2\n")
    (package / "unrelated.csv").write_text("2\n")
    assert digest() == before
    # A table that bears the name of a module is a part of it.
    (package / "holes.csv").write_text("2\n")
    assert (with_table := digest()) != before
    (package / "tables.py").write_text("SIZE = 2\n")
    assert digest() not in (before, with_table)
    monkeypatch.undo()
    for function in (key_module._file, key_module._imported, key_module.source_digest):
        function.cache_clear()


def test_a_failed_making_leaves_nothing(store: ArtefactStore) -> None:
    def fail(design: Any, folder: Path) -> None:
        (folder / "half.txt").write_text("half")
        raise RuntimeError("stopped")

    with pytest.raises(RuntimeError, match="stopped"):
        store.make("part", Plan(), MODULES, fail)
    assert store.find("part", Plan(), MODULES) is None and list((store.folder / "entries").iterdir()) == []


def test_a_damaged_artefact_is_repaired_while_another_run_reads_it(store: ArtefactStore) -> None:
    held: list[Artefact] = []

    def make(design: Any, folder: Path) -> None:
        # The other run's artefact is whole while this one makes it again.
        assert all(entry.data("good.bin") == b"good" for entry in held)
        (folder / "damaged.bin").write_bytes(b"right")
        (folder / "good.bin").write_bytes(b"good")

    held.append(store.make("part", Plan(), MODULES, make))
    held[0].path("damaged.bin").write_bytes(b"wrong")
    store.drop(held[0])
    assert store.find("part", Plan(), MODULES) is None
    again = store.make("part", Plan(), MODULES, make)
    assert again == held[0] and (again.data("damaged.bin"), again.data("good.bin")) == (b"right", b"good")


@pytest.mark.parametrize("damage", ["digit", "cut", "missing", "record", "reads"])
def test_what_the_disk_has_changed_is_made_again(store: ArtefactStore, monkeypatch, damage: str) -> None:
    maker = Maker()
    file = store.make("part", Plan(), MODULES, maker).path("entry.json" if damage == "record" else "size.txt")
    text = file.read_text()
    if damage == "missing":
        file.unlink()
    elif damage == "reads":
        for path in (store.folder / "reads").iterdir():
            path.write_text("nonsense(")
    else:
        file.write_text({"digit": text.replace("5", "7"), "cut": text[:2], "record": text[:20]}[damage])
    # As in another process, which has not looked at it.
    monkeypatch.setattr(store_module, "_verified", set())
    again = ArtefactStore(store.folder).make("part", Plan(), MODULES, maker)
    assert maker.runs == 2 and again.data("size.txt") == b"25.9"


def test_a_result_is_compared_once_in_a_process(store: ArtefactStore, monkeypatch: pytest.MonkeyPatch) -> None:
    maker, hashed, sha256 = Maker(), [], store_module.sha256
    store.make("part", Plan(), MODULES, maker)
    monkeypatch.setattr(store_module, "_verified", set())
    monkeypatch.setattr(store_module, "sha256", lambda data: hashed.append(data) or sha256(data))
    for _ in range(3):
        ArtefactStore(store.folder).make("part", Plan(), MODULES, maker)
    assert maker.runs == 1 and hashed.count(b"25.9") == 1


def test_each_file_of_an_artefact_is_there_at_each_moment_of_its_repair(store, monkeypatch) -> None:
    entry = store.make("part", Plan(), MODULES, Maker())
    store.drop(entry)
    seen: list[bytes] = []
    for name in ("rename", "replace", "unlink"):
        real = getattr(Path, name)

        def look(self: Path, *rest: Any, real: Any = real, **named: Any) -> Any:
            result = real(self, *rest, **named)
            seen.append(entry.data("size.txt"))
            return result

        monkeypatch.setattr(Path, name, look)
    assert store.make("part", Plan(), MODULES, Maker()) == entry
    assert len(seen) >= 2 and set(seen) == {b"25.9"}


def test_what_another_run_finds_meanwhile_is_not_removed(store: ArtefactStore, monkeypatch: pytest.MonkeyPatch) -> None:
    plans = [Plan(plate=Table(length=float(index))) for index in range(3)]
    entries = [store.make("part", plan, MODULES, Maker()) for plan in plans]
    for index, entry in enumerate(entries):
        os.utime(entry.folder, (1e9 + index, 1e9 + index))
    monkeypatch.setenv("STAGECAD_CACHE_MAX", "1")
    removed, remove = [], ArtefactStore._discard

    def discard(self: ArtefactStore, folder: Path) -> None:
        # Between the look at all ages and the removal of the next artefact.
        assert self.find("part", plans[1], MODULES) is not None
        removed.append(folder)
        remove(self, folder)

    monkeypatch.setattr(ArtefactStore, "_discard", discard)
    store.make("another", Plan(), MODULES, Maker())
    assert removed == [entries[0].folder, entries[2].folder] and entries[1].data("size.txt")


def test_a_file_that_another_run_removes_meanwhile_stops_nothing(store: ArtefactStore) -> None:
    (store.folder / "reads").mkdir(parents=True)
    (store.folder / "reads" / "gone").symlink_to("nowhere")
    assert store.make("part", Plan(), MODULES, Maker()).data("size.txt") == b"25.9"


def test_the_unfinished_folder_of_a_killed_run_is_removed_when_it_is_old(store: ArtefactStore) -> None:
    (store.folder / "entries").mkdir(parents=True)
    for name, age in ((".making-old", store_module.ABANDONED + 60.0), (".making-new", 60.0)):
        (store.folder / "entries" / name).mkdir()
        os.utime(store.folder / "entries" / name, (time.time() - age, time.time() - age))
    store.make("another", Plan(), MODULES, Maker())
    assert [path.name for path in (store.folder / "entries").glob(".*")] == [".making-new"]


def test_least_recently_used_artefacts_are_removed(store: ArtefactStore, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("STAGECAD_CACHE_MAX", "30000")
    monkeypatch.setattr(store_module, "MINIMUM_AGE", 0.0)

    def make(design: Any, folder: Path) -> None:
        (folder / "block.bin").write_bytes(b"\0" * 10_000 + str(design.plate.length).encode())

    start = time.time() - 1000.0
    for index in range(6):
        entry = store.make("block", Plan(plate=Table(length=float(index))), MODULES, make)
        os.utime(entry.folder, (start + index, start + index))
    found = [store.find("block", Plan(plate=Table(length=float(index))), MODULES) for index in range(6)]
    assert [entry is not None for entry in found] == [False] * 4 + [True] * 2


def test_two_runs_at_once_agree(tmp_path: Path) -> None:
    program = """
import sys, time
from pathlib import Path
from types import SimpleNamespace
from stagecad.solids.artefacts.store import ArtefactStore
def make(design, folder):
    (folder / "value.txt").write_text(str(design.value))
    time.sleep(0.2)
store, modules = ArtefactStore(Path(sys.argv[1])), ("stagecad.solids.modelling.frame",)
entries = [store.make(f"part{n}", SimpleNamespace(value=n), modules, make) for n in range(3)]
print([entry.data("value.txt") for entry in entries])
"""
    runs = [
        subprocess.Popen([sys.executable, "-c", program, str(tmp_path)], stdout=subprocess.PIPE, text=True)
        for _ in range(2)
    ]
    outputs = [run.communicate(timeout=240)[0] for run in runs]
    assert [run.returncode for run in runs] == [0, 0]
    assert outputs[0] == outputs[1] == "[b'0', b'1', b'2']\n"
    assert len([path for path in (tmp_path / "entries").iterdir() if not path.name.startswith(".")]) == 3


def test_the_folder_follows_the_environment_and_keeps_what_is_written(monkeypatch, tmp_path) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.delenv("STAGECAD_CACHE", raising=False)
    assert ArtefactStore().folder == tmp_path / "stagecad"
    monkeypatch.setenv("STAGECAD_CACHE", str(tmp_path / "own"))
    assert ArtefactStore().folder == tmp_path / "own"
    monkeypatch.setattr(Artefact, "data", lambda self, name: b"another")
    with pytest.raises(OSError, match="does not keep"):
        lengths(ArtefactStore(tmp_path), Plate(), [])


@dataclass(frozen=True)
class Plate:
    length: float = 3.0
    width: float = 4.0


def lengths(store: ArtefactStore, plate: Plate, computed: list[float]) -> tuple[float, ...]:
    def compute(tracked: Any) -> tuple[float, ...]:
        computed.append(tracked.length)
        return tracked.length, 2 * tracked.length

    return store.computed("lengths", plate, MODULES, compute)


def test_values_are_computed_once_and_again_when_damaged(tmp_path: Path) -> None:
    store, computed = ArtefactStore(tmp_path), []
    assert lengths(store, Plate(), computed) == (3.0, 6.0)
    assert lengths(store, Plate(width=5.0), computed) == (3.0, 6.0)
    assert lengths(store, Plate(length=4.0), computed) == (4.0, 8.0) and computed == [3.0, 4.0]
    store, computed = ArtefactStore(tmp_path / "damaged"), []
    lengths(store, Plate(), computed)
    (file,) = store.folder.glob(f"entries/*/{FILE}")
    file.write_bytes(b"cos\nsystem\n(S'exit 1'\ntR.")
    assert lengths(store, Plate(), computed) == (3.0, 6.0) and computed == [3.0, 3.0]
    assert lengths(store, Plate(), computed) == (3.0, 6.0) and computed == [3.0, 3.0]


def _of_tree(source: str) -> Iterator[str]:
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def test_imports_in_every_form_are_seen() -> None:
    files = [path for folder in ("stagecad", "drawings") for path in sorted((ROOT / folder).rglob("*.py"))]
    assert len(files) > 100
    for path in files:
        source = path.read_text("utf-8")
        missed = set(_of_tree(source)) - set(_names(source))
        assert not [name for name in missed if _file(name) is not None], path
    source = "import a.b as c, d\n\n    from e.f import (\n        g,  # why, so\n        h as i,\n    )\n"
    source += "from j import k, l as m\n"
    assert set(_names(source)) == {"a.b", "d", "e.f", "e.f.g", "e.f.h", "j", "j.k", "j.l"}
