"""What is installed: dependencies in ranges, and the software bill of materials."""

import json
import tomllib
from pathlib import Path

from packaging.requirements import Requirement

from tests.process_state import python

ROOT = Path(__file__).parents[2]
DEPENDENCIES = [
    Requirement(text) for text in tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["dependencies"]
]


def test_every_dependency_has_a_lower_bound_and_none_a_single_version() -> None:
    for one in DEPENDENCIES:
        assert ">=" in {part.operator for part in one.specifier} <= {">=", "<"}, one


def test_the_bill_of_materials_has_every_dependency_with_its_version() -> None:
    found = python(".ci/bill_of_materials.py", folder=ROOT)
    parts = {part["name"].lower(): part for part in json.loads(found.stdout)["components"]}
    for one in DEPENDENCIES:
        assert one.specifier.contains(parts[one.name.lower()]["version"])
    assert " packages, " in found.stderr
