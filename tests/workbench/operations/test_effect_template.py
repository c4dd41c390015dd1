"""`stagecad effects --write`: the file to start from is an effect as it stands."""

import json
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from sim.effects.custom import load_custom
from workbench.cli import run


def test_the_file_written_is_an_effect_that_can_be_fitted(tmp_path, capsys):
    file = tmp_path / "leaf_spring.py"
    assert run(["effects", "--write", str(file), "--json"]) == 0
    printed = capsys.readouterr()
    assert json.loads(printed.out)["name"] == "leaf_spring"
    assert 'custom = ["leaf_spring.py"]' in printed.err
    (effect,) = load_custom(file)
    assert effect.force is not None
    axis: Any = SimpleNamespace(position=np.array([-0.01, 0.0, 0.02]))
    values: Any = SimpleNamespace(strength=2e4)
    np.testing.assert_allclose(effect.force(axis, values), [-0.02, 0.0, 0.16])


@pytest.mark.parametrize(
    ("name", "wrong"),
    [
        ("there.py", "is there already; name a new file"),
        ("there.txt", "must end in .py"),
        ("Leaf-Spring.py", "lower-case words joined by underscores"),
        ("viscous.py", "a built-in effect is named 'viscous'"),
    ],
)
def test_a_file_that_would_be_no_effect_is_refused(tmp_path, capsys, name, wrong):
    (tmp_path / "there.py").write_text("kept")
    assert run(["effects", "--write", str(tmp_path / name)]) == 2
    assert wrong in capsys.readouterr().err
    assert (tmp_path / "there.py").read_text() == "kept"
    assert [file.name for file in tmp_path.iterdir()] == ["there.py"]
