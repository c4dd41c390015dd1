"""Imports found by a pattern, against the syntax tree."""

import ast
from collections.abc import Iterator

from stagecad.solids.artefacts.source_digest import ROOT, _file, _names


def _of_tree(source: str) -> Iterator[str]:
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def test_no_import_of_the_project_is_missed() -> None:
    files = [path for folder in ("stagecad", "drawings") for path in sorted((ROOT / folder).rglob("*.py"))]
    assert len(files) > 100
    for path in files:
        source = path.read_text("utf-8")
        missed = set(_of_tree(source)) - set(_names(source))
        assert not [name for name in missed if _file(name) is not None], path


def test_forms_of_an_import() -> None:
    source = "import a.b as c, d\n\n    from e.f import (\n        g,  # why, so\n        h as i,\n    )\n"
    source += "from j import k, l as m\n"
    assert set(_names(source)) == {"a.b", "d", "e.f", "e.f.g", "e.f.h", "j", "j.k", "j.l"}
