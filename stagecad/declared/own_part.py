"""A part of the user's own, from a Python file.

The file follows the interface of a part (`stagecad.solids.modelling.part`). Its parameters are declared in the file
itself, as in a parameter file: ``PARAMETERS = {"length": "60 mm", "hole": "6.6 mm"}``; tolerance classes follow from
the decimals. It may read those of the machine too. The file is Python code: it runs after `--trust`.
"""

import hashlib
import re
from collections.abc import Iterable
from dataclasses import dataclass, replace
from difflib import get_close_matches
from functools import lru_cache, partial
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

from stagecad.consent import give_consent, require_consent
from stagecad.parameters.design import Design
from stagecad.parameters.dimension import Datum, DatumFeature, Dimension, GeometricTolerance, SurfaceTexture
from stagecad.parameters.errors import InputError, nearest, require
from stagecad.parameters.input_file import read_named
from stagecad.parameters.machine import DeclaredPart
from stagecad.parameters.names import is_identifier
from stagecad.parameters.own_code import own_code

REQUIRED = ("NAME", "PARAMETERS", "build", "material")
TEXT = r"[^\0-\t\v-\x1f\x7f]*"
NUMBER = r"-?\d+(\.\d+)?(e-\d+)?"
POINT = f"( {NUMBER}){{3}}"
CUT = f"| half({POINT}){{1,2}}| aligned({POINT}){{2}}| offset({POINT})+"
"""Kinds of section through points, after the name of a view."""
VALUES: dict[str, tuple[Any, str]] = {
    "TREATMENT": ("anodised", TEXT),
    "PART_NUMBER": ("A-1", TEXT),
    "SYMMETRIC": ("xy", "[xyz]*"),
    "TURNED": (1, "[1-9][0-9]*"),
    "BY_MODEL": (True, "True|False"),
    "FACES_BY_MODEL": (("plane at 0, 0, 12.5",), rf"[a-z]+ at {NUMBER}(, {NUMBER}){{2}}"),
    "NOTES": (("Two off, alike.",), TEXT),
    "VIEWS": (("front", "top", "right section"), f"iso|(front|back|left|right|top|bottom)( section| hidden{CUT})?"),
}
"""Values that a part may state, with examples, and the form of each or of each item."""


def run_file(path: Path, trust: bool, what: str, accepted: bytes | None = None) -> ModuleType:
    """Run a Python file of the user's, with consent, and return it as a module; `accepted` is its content where another
    process has the consent. The module has what was run as `__content__`."""
    data = read_named(path) if accepted is None else accepted
    if trust:
        give_consent((path,))
    if accepted is None:
        require_consent(path, data, what)
    module = ModuleType(path.stem)
    module.__file__ = str(path)
    module.__content__ = data  # type: ignore[attr-defined]
    module.SHOWN = []  # type: ignore[attr-defined]
    # A script of cadquery's editor shows its result by a function of the editor.
    module.show_object = lambda shown, *more, **options: module.SHOWN.append((shown, more, options))  # type: ignore[attr-defined]
    module.debug = lambda *shown, **options: None  # type: ignore[attr-defined]
    with own_code(path):
        exec(compile(data, str(path), "exec"), vars(module))
    return module


@dataclass(frozen=True)
class OwnDefinition:
    """The definition of a part in a user's file: what the file has, with its errors as one line each."""

    path: Path  # of the file
    module: Any  # that the file gives
    text: str = ""  # description for the list of parts; empty for the first line of the file

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        found = getattr(self.module, name)
        return partial(self._called, found) if callable(found) else found

    def _called(self, function: Any, *arguments: Any) -> Any:
        """Result of a function of the file."""
        with own_code(self.path):
            return function(*arguments)

    def _items(self, word: str, design: Any, *kinds: type) -> tuple[Any, ...]:
        """The items that a function of the file gives; none where it has no such function."""
        with own_code(self.path):
            found = getattr(self.module, word, lambda design: ())(design)
            items = tuple(found) if isinstance(found, Iterable) and not isinstance(found, str) else (found,)
        if not all(isinstance(one, kinds) for one in items):
            names = " or ".join(kind.__name__ for kind in kinds)
            raise InputError(f"{self.path}: {word}(design) must return {names} objects")
        return items

    def build(self, design: Any) -> Any:
        """The one valid solid that the file builds, mm."""
        return _solid(self.path, self._called(self.module.build, design))

    def material(self, design: Any) -> str:
        """Name of its material."""
        name = self._called(self.module.material, design)
        if not isinstance(name, str) or name not in design.materials:
            raise InputError(
                f"{self.path}: material '{name}' is not in [materials]{nearest(str(name), design.materials)}"
            )
        return name

    def datums(self, design: Any) -> dict[str, Datum]:
        """Its datums; none where the file declares none."""
        found = self._called(self.module.datums, design) if hasattr(self.module, "datums") else {}
        if not isinstance(found, dict) or not all(isinstance(one, Datum) for one in found.values()):
            raise InputError(f"{self.path}: datums(design) must return Datum objects by name: named(Datum(...), ...)")
        return found

    def dimensions(self, design: Any) -> tuple[Any, ...]:
        """Its dimensions."""
        return self._items("dimensions", design, Dimension)

    def requirements(self, design: Any) -> tuple[Any, ...]:
        """Its requirements on faces; none where the file states none."""
        return self._items("requirements", design, DatumFeature, GeometricTolerance, SurfaceTexture)

    def notes(self, design: Any) -> tuple[str, ...]:
        """Of its sheet."""
        return self._items("notes", design, str) or tuple(getattr(self.module, "NOTES", ()))

    def description(self, design: Any) -> str:
        """In words: as declared, or the first line of the file."""
        first = (self.module.__doc__ or self.module.NAME).strip().splitlines()[0]
        return self.text or first.partition(":")[2].strip().rstrip(".") or first

    def part_number(self, design: Any) -> str:
        """Of a catalogue; empty for a part that is made."""
        return getattr(self.module, "PART_NUMBER", "")


def own_definition(path: Path, text: str = "", names: frozenset[str] = frozenset()) -> OwnDefinition:
    """The definition in a file that the user has consented to run."""
    module = _module(path, file_digest(path))
    for word in REQUIRED:
        what = word if word.isupper() else f"function {word}(design)"
        require(hasattr(module, word), f"{path}: has no {what}; `stagecad new part NAME` writes a file that has all")
    for word, (example, form) in VALUES.items():
        found = getattr(module, word, example)
        several, items = isinstance(example, tuple), found if isinstance(found, tuple | list) else (found,)
        fits = (type(one) is (str if several else type(example)) and re.fullmatch(form, str(one)) for one in items)
        require(several == (items is found) and all(fits), f"{path}: {word} = {found!r}; write it like {example!r}")
    for word in filter(str.isupper, vars(module)):
        meant = get_close_matches(word, VALUES, n=1, cutoff=0.8)
        if meant and not hasattr(module, meant[0]):
            raise InputError(f"{path}: a part has no {word}; did you mean {meant[0]}?")
    name = module.NAME
    if not is_identifier(name) or name in names:
        raise InputError(
            f"{path}: NAME = {name!r}; write small letters, digits and _, and no name of the machine's own"
        )
    return OwnDefinition(path, module, text)


def file_digest(path: Path) -> str:
    """Sha256 of a file."""
    return hashlib.sha256(read_named(path)).hexdigest()


_SOLID_FILE = re.compile(rb"[\"']([\w.-]+\.(?:step|stp))[\"']", re.IGNORECASE)


def used_files(path: Path) -> tuple[Path, ...]:
    """STEP files beside a part's file that it names."""
    names = {match[1].decode() for match in _SOLID_FILE.finditer(read_named(path))}
    return tuple(path.parent / name for name in sorted(names) if (path.parent / name).is_file())


@lru_cache(maxsize=64)
def _module(path: Path, digest: str) -> ModuleType:
    return run_file(path, False, "this part")


def own_design(part: DeclaredPart, design: Design) -> Design:
    """The design as a part's file reads it: the parameters of the part below its own `NAME`."""
    declaration = design.machine.declaration
    table = declaration.tables.get(part.key, part.part) if declaration else part.part
    if table == part.part:
        return design
    renamed = [
        replace(entry, key=f"{part.part}.{entry.key.partition('.')[2]}")
        for entry in design.entries
        if entry.key.startswith(f"{table}.")
    ]
    values = getattr(design, table, SimpleNamespace())
    own = ((part.part, values), *(item for item in design.own if item[0] != part.part))
    kept = (entry for entry in design.entries if not entry.key.startswith(f"{part.part}."))
    return replace(design, entries=(*kept, *renamed), own=own)


def _solid(path: Path, found: Any) -> Any:
    """The one solid that the file has built, also from a workplane."""
    shape = found.val() if hasattr(found, "val") else found
    if hasattr(shape, "Solids") and len(shape.Solids()) == 1:
        shape = shape.Solids()[0]
    if getattr(shape, "ShapeType", lambda: "")() != "Solid" or not shape.isValid() or shape.Volume() <= 0:
        raise InputError(f"{path}: build(design) must return one valid closed solid")
    return shape
