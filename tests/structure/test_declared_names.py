"""Logic of the identification asks effects and rigs for what they declare, and never for their names."""

import ast
from pathlib import Path

from sim.effects.catalogue import ORDER
from sysid.experiment.rigs import RIGS

ROOT = Path(__file__).parents[2]
PARTS = ("prediction", "estimation", "diagnosis", "validation", "experiment_design")
FILES = [path for part in PARTS for path in sorted((ROOT / "sysid" / part).rglob("*.py"))]
FILES += sorted((ROOT / "sysid").glob("*.py"))
TABLES = {"CONTACT_EFFECTS"}
"""Declarations that list effects by name."""


def _names_in_logic(tree: ast.Module) -> list[str]:
    """Names of effects and kinds of rig among the strings of a module, but those that a rig declares."""
    declared: set[int] = set()
    for node in ast.walk(tree):
        targets = [t.id for t in node.targets if isinstance(t, ast.Name)] if isinstance(node, ast.Assign) else []
        if "name" in targets or TABLES & set(targets):
            declared |= {id(part) for part in ast.walk(node)}
    strings = (node for node in ast.walk(tree) if isinstance(node, ast.Constant) and isinstance(node.value, str))
    bare = (node.value.partition("@")[0].partition(":")[0] for node in strings if id(node) not in declared)
    return [name for name in bare if name in ORDER or name in RIGS]


def test_no_effect_and_no_kind_of_rig_is_named_in_logic() -> None:
    named = {path: _names_in_logic(ast.parse(path.read_text(encoding="utf-8"))) for path in FILES}
    assert not {str(path.relative_to(ROOT)): names for path, names in named.items() if names}


def test_a_name_in_logic_is_found() -> None:
    assert _names_in_logic(ast.parse('if effect.name == "sensor_lag@position" or kind == "force-drive": pass')) == [
        "sensor_lag",
        "force-drive",
    ]
    assert not _names_in_logic(ast.parse('name = "force-drive"'))
