"""Keys of artefacts: what a stored result depends on.

The key is the sha256 of its name, the source of the modules that make it and of all their imports in this project, the
versions of the CAD kernel, the keys of the artefacts it depends on, and the parameters that were read, with their
values.
"""

import hashlib
import json
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cache
from importlib.metadata import PackageNotFoundError, distribution, version
from pathlib import Path

from stagecad.parameters.tracking import AccessPath

KERNEL = ("cadquery", "cadquery-ocp")
ROOT = Path(__file__).resolve().parents[3]


@cache
def _packages() -> frozenset[str]:
    """Top-level packages of this project, as its metadata lists them."""
    return frozenset((distribution("stagecad").read_text("top_level.txt") or "").split())


@cache
def _file(module: str) -> Path | None:
    """Source file of a module of this project; None for any other name."""
    if module.partition(".")[0] not in _packages():
        return None
    base = ROOT.joinpath(*module.split("."))
    return next((path for path in (base.with_suffix(".py"), base / "__init__.py") if path.is_file()), None)


_IMPORT = re.compile(
    r"^[ \t]*(?:from[ \t]+(?P<module>[\w.]+)[ \t]+import[ \t]*(?:\((?P<block>[^)]*)\)|(?P<line>[^\n(]+))"
    r"|import[ \t]+(?P<modules>[\w.][^\n]*))",
    re.MULTILINE,
)


def _names(source: str) -> Iterator[str]:
    """All names that a source imports, by a pattern, since syntax trees take seconds; one may be a module."""
    for match in _IMPORT.finditer(source):
        listed = match["modules"] or match["block"] or match["line"] or ""
        words = re.sub(r"#[^\n]*", "", listed).replace("\\\n", " ").split(",")
        names = [word.split()[0] for word in words if word.strip()]
        if match["module"]:
            yield match["module"]
            yield from (f"{match['module']}.{name}" for name in names)
        else:
            yield from names


@cache
def _imported(module: str) -> tuple[str, ...]:
    """Modules of this project that a module imports."""
    path = _file(module)
    names = _names(path.read_text("utf-8")) if path is not None else ()
    return tuple(sorted({name for name in names if _file(name) is not None}))


@cache
def source_digest(modules: tuple[str, ...]) -> str:
    """Sha256 of the source of `modules` and of all modules of this project that they import, directly or indirectly,
    each with the tables of its name (`threads.csv` of `threads.py`)."""
    pending: list[str] = list(modules)
    closure: set[str] = set()
    while pending:
        name = pending.pop()
        if name not in closure:
            closure.add(name)
            pending.extend(_imported(name))
    digest = hashlib.sha256()
    for name in sorted(closure):
        path = _file(name)
        files = [] if path is None else [path.with_suffix(suffix) for suffix in (".py", ".csv", ".toml")]
        for file in filter(Path.is_file, files):
            digest.update(name.encode() + b"\0" + file.read_bytes() + b"\0")
    return digest.hexdigest()


def versions(packages: Iterable[str]) -> dict[str, str]:
    """Installed versions by package name, from the metadata, without importing the packages."""
    return {package: _version(package) for package in packages}


@cache
def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "absent"


def sha256(data: bytes) -> str:
    """Hexadecimal sha256 of `data`."""
    return hashlib.sha256(data).hexdigest()


def root_key(name: str, modules: Sequence[str], depends: Iterable[str]) -> str:
    """Hash of all that an artefact depends on but the parameters."""
    words = [name, source_digest(tuple(modules)), versions(KERNEL), sorted(depends)]
    return sha256(json.dumps(words, sort_keys=True).encode())


def artefact_key(root: str, values: Mapping[AccessPath, str]) -> str:
    """Key of an artefact by its root and the values that were read of the parameters."""
    return sha256(json.dumps([root, sorted((repr(path), value) for path, value in values.items())]).encode())
