"""`stagecad compare --bootstrap`: on a cluster and on the local cores alike, also with an effect of the user's own."""

import json
from pathlib import Path

import pytest

from workbench.cli import run

EXAMPLE = Path(__file__).parents[2] / "examples" / "own_effect"


@pytest.mark.slow
def test_refits_on_a_cluster_are_those_of_the_local_cores(capsys, tmp_path, cluster):
    """With an effect whose file the workers do not have."""
    for name in ("bellows.py", "fit.csv", "validate.csv"):
        (tmp_path / name).write_bytes((EXAMPLE / name).read_bytes())
    text = (EXAMPLE / "experiment.toml").read_text("utf-8")
    (tmp_path / "experiment.toml").write_text(text.replace('"viscous"]', '"viscous", "bellows"]'), "utf-8")
    words = ["compare", str(tmp_path), "--trust", "--bootstrap", "24", "--out", str(tmp_path / "out"), "--json"]
    assert run(words) == 0
    printed = capsys.readouterr()
    here = json.loads(printed.out)
    assert "Intervals of 24 refits" in printed.err
    assert run([*words, "--no-figures", "--scheduler", cluster]) == 0
    there = json.loads(capsys.readouterr().out)
    assert there["bootstrap"] == here["bootstrap"]
    values = here["bootstrap"]["parameters"]
    assert set(values) == set(here["parameters"])
    for key, one in values.items():
        linear = here["parameters"][key]
        assert one["value"] == linear["value"]
        assert one["unit"] == linear["unit"]
        assert one["std"] == pytest.approx(linear["std"], rel=0.6)
    picture = next((tmp_path / "out").glob("*/compare_bootstrap.png")).read_bytes()
    assert picture.startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--scheduler", "tcp://127.0.0.1:9"], "--scheduler: only --bootstrap has many independent runs"),
        (["--bootstrap", "3"], "--bootstrap"),
        (["--bootstrap", "20", "--scheduler", "tcp://127.0.0.1:9"], "no cluster answers there"),
    ],
)
def test_a_mistake_ends_in_status_two(capsys, tmp_path, words, message):
    assert run(["compare", str(EXAMPLE), "--trust", *words, "--no-figures", "--out", str(tmp_path)]) == 2
    assert message in capsys.readouterr().err.splitlines()[-1]
