"""Effects of the user's own that cannot be tried, and laws chosen by their whole name."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from sim import Effect, Parameter
from sysid.add import add_effects
from sysid.diagnose import diagnose
from sysid.experiment.experiment import load_experiment
from tests.experiments import write_rig
from tests.refusals import refused
from tests.sysid.slide import SIGN, slide, slipping_spring

STRETCH, LEVEL, VISCOUS = 4e-6, 1.6, 900.0


def test_an_own_effect_that_is_not_finite_on_the_records_is_named(tmp_path: Path) -> None:
    own = Effect(
        "root",
        "root of the position",
        force=lambda axis, p: p.strength * np.sqrt(-1.0 - axis.position**2),
        parameters=(Parameter("strength", "N/m", 1.0, 0.0, 9.0, "size", "assumed"),),
    )
    problem = slide(tmp_path, 1.5 * SIGN, "coulomb")
    with np.errstate(invalid="ignore"):
        found = diagnose(replace(problem, custom=(own,)))
    assert [line for line in found.warnings if "'root' of your own was not tried" in line]
    assert not any("of your own" in line for line in diagnose(problem).warnings)


@pytest.fixture
def rig(tmp_path: Path) -> Path:
    """A slow slide over a contact of one ideal spring that slips at `STRETCH`, with a drag."""
    rng = np.random.default_rng(5)
    time = 1e-3 * np.arange(2500)
    position = 40e-6 * np.sin(2 * np.pi * time) + 9e-6 * np.sin(2 * np.pi * 3.1 * time)
    velocity = np.gradient(position, time)
    spring = slipping_spring(position, STRETCH, np.sign(position[1] - position[0]))
    force = LEVEL * spring + VISCOUS * velocity + 0.004 * rng.standard_normal(time.size)
    log = {"time": time, "position": position, "velocity": velocity, "friction_force": force}
    noise = {"friction_force": 0.004}
    return write_rig(tmp_path, "velocity-drive", {"fit": log}, ["coulomb", "viscous"], noise=noise)


def test_a_law_asked_for_replaces_the_core_and_wrong_ones_are_refused(rig: Path) -> None:
    before = load_experiment(rig)
    for law in ("presliding:maxwell_slip", "presliding:lugre"):
        step, after = add_effects(rig, [law]), load_experiment(rig)
        assert sorted(after.effects) == [law, "viscous"]
        assert {key.rpartition(".")[0] for key in after.parameters} == {law, "viscous"}
        assert step.revision.document["added"] == [law]
        assert step.revision.document["removed"] == [name for name in before.effects if name != "viscous"]
        parameters = step.revision.document["parameters"]
        assert parameters["presliding.force"]["value"] == pytest.approx(LEVEL, rel=0.1)
        if law == "presliding:maxwell_slip":
            # The law of these records; a LuGre bristle takes a part of the drag.
            assert parameters["viscous.coefficient"]["value"] == pytest.approx(VISCOUS, rel=0.2)
        before = after
    add_effects(rig, ["presliding:maxwell_slip"])
    text = (rig / "experiment.toml").read_text()
    refused("has 'presliding:maxwell_slip' already", add_effects, rig, ["presliding:maxwell_slip"])
    refused("did you mean 'maxwell_slip'", add_effects, rig, ["presliding:maxwell_slop"])
    assert (rig / "experiment.toml").read_text() == text
