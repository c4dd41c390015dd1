"""`parts`: the parts of a design and their assembly as solids."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any, TypeVar

from stagecad.deferred import pd
from stagecad.parameters.design import Design as Values
from stagecad.parameters.errors import PartError
from stagecad.parameters.file import Entry
from stagecad.parameters.mass_properties import Masses
from stagecad.solids.artefacts.part import CRASHED, build_parts
from stagecad.solids.artefacts.store import (
    ArtefactStore,
    DamagedError,
    sha256,
    write_manifest,
    write_stored,
    write_text,
)
from stagecad.solids.assembly.bill_of_materials import csv_text
from stagecad.solids.assembly.bill_of_materials import document as bill_document
from stagecad.solids.assembly.built_machine import (
    BuiltMachine,
    assemble,
    body_masses,
    build_machine,
    find_machine,
    part_mass,
)
from stagecad.solids.modelling.part import ASSEMBLY, chosen, construction, part_names
from workbench.operations.design import Design, load_design
from workbench.operations.result import (
    Line,
    ProgressCallback,
    Result,
    counted,
    finite,
    frame,
    plain_table,
    remark,
    silent,
)

MANIFEST = "parts_manifest.json"
BILL = "bill_of_materials"
MOST_NAMED = 6
"""Largest number of parameters named where the kernel makes no solid."""
SHARED = ("threads", "screws", "making", "teeth", "actuator")
"""Tables that shape several parts."""
Written = TypeVar("Written")


def with_repair(store: ArtefactStore, write: Callable[[], Written]) -> Written:
    """`write()`, begun again after each damaged artefact that it meets, which the store then makes again."""
    dropped: set[str] = set()
    while True:
        try:
            return write()
        except DamagedError as damage:
            if damage.entry.key in dropped:
                raise OSError(f"the cache in {store.folder} does not keep what is written to it") from None
            dropped.add(damage.entry.key)
            store.drop(damage.entry)
            remark("a stored result was damaged; it is made again")


def built_machine(values: Values, progress: ProgressCallback = silent) -> BuiltMachine:
    """Parts and assembly, from the cache or made now."""
    machine = find_machine(values)
    if machine is not None:
        return machine
    steps = len(part_names(values)) + 1
    progress("parts", 0, steps)
    return build_machine(values, None, counted(progress, "", steps))


def masses_of_solids(values: Values) -> Masses | None:
    """Masses of the solids, which are made when missing; None where no solids can be made at all."""
    try:
        return body_masses(values)
    except ImportError as error:
        remark(f"no solids can be made here ({error}): masses are estimated from plain volumes")
        return None


class Parts(Result):
    """The parts of a design as solids, with their mass properties.

    Attributes:
        design: of the parts.
        names: of the parts, and `assembly`.
    """

    def __init__(self, design: Design, names: tuple[str, ...], machine: BuiltMachine | None = None) -> None:
        self.design, self.names = design, names
        self._machine = machine

    @property
    def machine(self) -> BuiltMachine:
        """Parts and assembly, from the cache or made now."""
        if self._machine is None:
            self._machine = built_machine(self.design.values)
        return self._machine

    def __getstate__(self) -> dict[str, Any]:
        # Solids do not pickle; another process finds them in the cache.
        return {"design": self.design, "names": self.names, "_machine": None}

    @property
    def moving_body(self) -> dict[str, Any] | None:
        """Mass properties of the parts that move, SI; None where none does."""
        body = self.machine.moving_body
        return finite(body.as_json()) if body else None

    @cached_property
    def _masses(self) -> dict[str, Any]:
        machine = self.machine
        masses = {name: machine.whole if name == ASSEMBLY else machine.masses[name] for name in self.names}
        return finite({name: mass.as_json() for name, mass in masses.items()})

    def to_dataframe(self) -> pd.DataFrame:
        """A row for each part: mass, volume, and size along x, y, z; SI."""
        rows = []
        for name, part in self._masses.items():
            low, high = part["bounding_box"]["value"]
            size = {f"size_{axis}": b - a for axis, a, b in zip("xyz", low, high, strict=True)}
            rows.append({"part": name, "mass": part["mass"]["value"], "volume": part["volume"]["value"], **size})
        return frame(rows, "part")

    def to_json(self) -> dict[str, Any]:
        """The document of `stagecad parts --json`, without files: `write` gives those."""
        more = construction(self.design.values).documents(self.machine)
        return {"parts": {name: {**part, "files": []} for name, part in self._masses.items()}, **finite(more)}

    def write(self, folder: str | Path) -> dict[str, Any]:
        """Write STEP, STL and GLB of the parts into a folder; the document of `stagecad parts --json`."""
        document, _, _ = self.write_changed(Path(folder))
        return document

    def write_changed(self, folder: Path) -> tuple[dict[str, Any], list[str], int]:
        """Like `write`; also the names of the files that differed, and the number of all."""
        return with_repair(ArtefactStore(), lambda: self._write(folder))

    def _write(self, folder: Path) -> tuple[dict[str, Any], list[str], int]:
        machine, document = self.machine, self.to_json()
        stored = {}
        for name, part in document["parts"].items():
            made = machine.assembly if name == ASSEMBLY else machine.parts[name]
            stored.update(dict.fromkeys(made.files, made.entry))
            part["files"] = [str(folder / file) for file in made.files]
        changed = write_stored(folder, stored)
        hashes = {name: entry.hashes[name] for name, entry in stored.items()}
        if ASSEMBLY in self.names:
            rows = machine.bill_of_materials
            texts = {
                f"{BILL}.csv": csv_text(rows, construction(self.design.values).accessories(self.design.values)),
                f"{BILL}.json": json.dumps(bill_document(rows), indent=1) + "\n",
            }
            changed += [name for name, text in texts.items() if write_text(folder / name, text)]
            hashes |= {name: sha256(text.encode("utf-8")) for name, text in texts.items()}
            document["parts"][ASSEMBLY]["files"] += [str(folder / name) for name in texts]
        write_manifest(folder / MANIFEST, hashes)
        return document, changed, len(hashes)

    def lines(self) -> list[Line]:
        """Mass, volume and size of each part."""
        rows = []
        for name, part in self._masses.items():
            low, high = part["bounding_box"]["value"]
            size = " x ".join(f"{1000 * (b - a):.1f}" for a, b in zip(low, high, strict=True))
            mass, volume = part["mass"]["value"], part["volume"]["value"] * 1e6
            shown = f"{mass:8.3f} kg" if mass >= 1.0 else f"{1000 * mass:8.2f} g "
            rows.append((name, shown, f"{volume:8.2f} cm^3", f"{size} mm"))
        return [plain_table("", "part|mass|volume|size", rows, "part|size")]

    def __repr__(self) -> str:
        return f"<Parts of '{self.design.values.file}': {', '.join(self.names)}>"


def parts(design: Design | None = None, names: Sequence[str] = (), progress: ProgressCallback = silent) -> Parts:
    """The parts of a design as solids; they come from the cache, or are made now.

    Args:
        design: the packaged machine when left out.
        names: of parts, or `assembly`; all of them when left out.
        progress: called with the name of a part, the parts done, and their number.

    Raises:
        InputError: no such part.
    """
    design = design or load_design()
    return Parts(design, chosen(tuple(names), design.values), built_machine(design.values, progress))


def solids(design: Design, progress: ProgressCallback = silent) -> dict[str, Any]:
    """The parts of a design, from the cache or made now in this process, which keeps the CAD kernel loaded: mass
    properties, key of the mesh in the cache and what it reads of each; its instances with the (3 x 4) rows of rotation
    and shift, mm, seated and in the exploded view; and the masses of the moving body and of the tip."""
    values = design.values
    names = part_names(values)
    advance = counted(progress, "", len(names))
    made = build_parts(ArtefactStore(), names, values, lambda name: advance(name.replace("_", " ")), isolate=False)
    documents = {
        name: {
            **part_mass(part, values).as_json(),
            "key": part.entry.key,
            "material": part.material,
            "description": part.description,
            "reads": [path for path in part.entry.reads if "." in path],
        }
        for name, part in made.items()
    }
    instances = [
        {"name": item.name, "part": item.part, "frame": _rows(item.frame), "exploded": _rows(item.exploded)}
        for item in assemble(made, values)
    ]
    masses = body_masses(values).as_json()
    return finite({"digest": values.digest, "parts": documents, "instances": instances, **masses})


def _rows(frame: Any) -> list[list[float]]:
    return [[*row, shift] for row, shift in zip(frame.rotation, frame.shift)]


def refusal_line(error: PartError) -> str | None:
    """Advice for a design that the rules accept, but of which the CAD kernel makes no valid solid: the parameters that
    may be at fault, those of the part first.

    Where all are the packaged design's, the part is the user's own, or the kernel may have been ended for lack of
    memory; None if it was not ended.
    """
    thesis = load_design().values
    packaged = {entry.key: entry for entry in thesis.entries}

    def place(entry: Entry) -> int:
        table = entry.key.split(".")[0]
        return (error.part, *SHARED, table).index(table)

    changed = [
        entry
        for entry in error.design.entries
        if isinstance(entry.value, float | int) and entry.key in packaged and entry.value != packaged[entry.key].value
    ]
    crashed = error.reason == CRASHED
    reason = f"{error.reason}; is there enough memory?" if crashed else error.reason
    if not changed:
        return f"part '{error.part}': {reason}" if crashed or error.part not in part_names(thesis) else None
    changed.sort(key=place)
    named = ", ".join(
        f"{entry.key} = {entry.text} (packaged: {packaged[entry.key].text})" for entry in changed[:MOST_NAMED]
    )
    more = f" and {len(changed) - MOST_NAMED} more" if len(changed) > MOST_NAMED else ""
    return (
        f"{error.design.file}: the CAD kernel makes no valid solid of '{error.part}' with {named}{more}; bring them "
        f"nearer to the packaged values ({reason})"
    )
