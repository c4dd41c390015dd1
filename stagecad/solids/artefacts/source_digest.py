"""Hash of a module's source and of all it imports of this project, found without importing anything."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterable
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]

_OURS = r"((?:stagecad|drawings|designcalc|workbench)[\w.]*)"
_IMPORT = re.compile(rf"^[ \t]*(?:from[ \t]+{_OURS}[ \t]+import[ \t]+(\([^)]*\)|[^\n]*)|import[ \t]+{_OURS})", re.M)


@cache
def _file(module: str) -> Path | None:
    base = ROOT.joinpath(*module.split("."))
    for path in (base.with_suffix(".py"), base / "__init__.py"):
        if path.is_file():
            return path
    return None


@cache
def _imported(module: str) -> tuple[str, ...]:
    """Modules of this project that the source of `module` names in an import, wherever the import stands."""
    path = _file(module)
    if path is None:
        return ()
    found: set[str] = set()
    for package, names, plain in _IMPORT.findall(path.read_text("utf-8")):
        found.add(package or plain)
        words = re.findall(r"\w+", re.sub(r"#[^\n]*|\bas\s+\w+", "", names))
        found.update(f"{package}.{word}" for word in words if package)
    return tuple(sorted(name for name in found if _file(name) is not None))


@cache
def source_digest(modules: tuple[str, ...]) -> str:
    """Sha256 over the source of `modules` and of everything of this project they import, directly or not."""
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
        if path is not None:
            digest.update(name.encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()


def versions(packages: Iterable[str]) -> dict[str, str]:
    """Installed versions by package name, read from their metadata, so that nothing is imported."""
    return {package: _version(package) for package in packages}


@cache
def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "absent"
