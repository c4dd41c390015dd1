"""The loop on a driven stage, on records it did not make: named, added, the error down."""

import pytest

from benchmarks.generators.driven_stage import HIDDEN, write_case
from sysid.diagnose import diagnose
from sysid.estimation.misfit import ChannelMisfit
from sysid.ladder import add_effects

ROWS = 2000


def _over_noise(by_channel: dict[str, ChannelMisfit]) -> float:
    return by_channel["position"].over_noise


@pytest.mark.slow
def test_where_nothing_is_hidden_the_model_is_called_adequate_though_only_the_mass_is_known(tmp_path):
    truth = write_case(tmp_path, "nothing", "lift", 1, ROWS)
    found = diagnose(tmp_path)
    assert found.verdict == "adequate"
    assert found.effect is None
    assert _over_noise(found.before_validate) == pytest.approx(1.0, abs=0.06)
    values = found.base.fitted.model.values
    # Inertia tells the stiffness of the contact, and with it every force.
    assert values["rig.contact_stiffness"] == pytest.approx(truth["stiffness"], rel=0.02)
    assert values["coulomb.force"] == pytest.approx(truth["pads"], rel=0.02)
    assert values["rig.gain"] == pytest.approx(truth["gain"], rel=1e-3)


@pytest.mark.parametrize(
    ("hidden", "motion", "seed", "left"),
    [
        pytest.param("gain_mismatch", "lift", 1, 0.1, marks=pytest.mark.slow),
        pytest.param("contact.coulomb", "sawtooth", 1, 0.1, marks=pytest.mark.slow),
        pytest.param("piezo_hysteresis", "lean", 1, 0.0, marks=pytest.mark.slow),
        pytest.param("contact.viscous", "sawtooth", 1, 0.0, marks=pytest.mark.slow),
        pytest.param("presliding", "walk", 1, 0.0, marks=pytest.mark.slow),
    ],
)
def test_the_hidden_effect_is_named_added_and_the_held_out_error_falls(tmp_path, hidden, motion, seed, left):
    write_case(tmp_path, hidden, motion, seed, ROWS)
    found = diagnose(tmp_path)
    assert found.verdict == "missing-effect"
    assert {found.effect, *found.indistinguishable} & set(HIDDEN[hidden].accept)
    start = _over_noise(found.before_validate)
    step = add_effects(tmp_path, [found.effect or ""])
    assert _over_noise(step.after_validate) < max(1.3, left * start)
