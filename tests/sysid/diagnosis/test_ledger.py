"""Ledger: states by the evidence, several effects found at once, copies of a periodic effect, what is no candidate."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from sim.effects.catalogue import find
from sim.effects.effect import Effect
from sim.integration.compiled.kernels import is_built_in
from stagecad.parameters.errors import InputError
from sysid.add import add_all
from sysid.diagnose import Diagnosis, diagnose
from sysid.diagnosis.held_out import Transfer
from sysid.diagnosis.ledger import Entry, Evidence, _judged_set, _Set, above_noise, exchanged, judge
from sysid.diagnosis.model_search import ModelSearch
from sysid.documents import ledger_json
from sysid.estimation.misfit import ChannelMisfit
from sysid.estimation.reference_fit import fit_stated_model
from sysid.prediction.model import public_name, variant_group
from sysid.prediction.problem import load_problem
from tests.experiments import write_rig
from tests.sysid.axis_with_pitch import uneven, write

CERTAIN = Evidence(5.0, 0.3, 0.9, 6.0, Transfer(1.0, 15.0, 100.0), Transfer(1.0, 15.0, 100.0))
WEAK = Transfer(1.0, 1.0, 5.0)


@pytest.mark.parametrize(
    "changed,explained,state",
    [
        ({}, 0.95, "established"),
        ({"share": 0.01}, 0.95, "established"),
        ({"own_share": 0.2}, 0.95, "possible"),
        ({"own_share": 0.4}, 0.95, "established"),
        ({"own_share": 0.4}, 0.7, "possible"),
        ({"own_share": 0.4, "similar": True}, 0.95, "possible"),
        ({"own_share": 0.6, "similar": True}, 0.95, "established"),
        ({"above_noise": 0.9}, 0.95, "possible"),
        ({"form": 0.11}, 0.95, "possible"),
        ({"form": 0.08}, 0.95, "established"),
        ({"form": 0.08, "margin": 0.5}, 0.45, "possible"),
        ({"floor": 6.0}, 0.95, "possible"),
        ({"sized": False}, 0.95, "possible"),
        ({"form_of": "position"}, 0.95, "possible"),
        ({"held": Transfer(0.4, 15.0, 100.0)}, 0.95, "possible"),
        ({"held": Transfer(1.0, 4.0, 9.0), "fit": Transfer(1.0, 3.0, 9.0)}, 0.95, "established"),
        ({"held": Transfer(1.0, 4.0, 9.0), "fit": Transfer(1.0, 3.0, 9.0)}, 0.6, "possible"),
        ({"held": Transfer(1.0, 4.0, 9.0), "fit": Transfer(1.0, 3.0, 9.0), "own_share": 0.4}, 0.95, "possible"),
        ({"held": Transfer(1.0, 5.2, 9.0), "fit": Transfer(1.0, 5.2, 9.0)}, 0.6, "established"),
        ({"held": Transfer(1.0, 5.2, 900.0), "fit": Transfer(1.0, 5.2, 900.0)}, 0.6, "possible"),
        ({"held": WEAK, "exchanged": Transfer(1.0, 6.0, 9.0)}, 0.95, "established"),
        ({"held": WEAK}, 0.95, "refused"),
        ({"fit": WEAK}, 0.95, "refused"),
        ({"implausible": "at its bound"}, 0.95, "refused"),
    ],
)
def test_state_by_the_evidence(changed: dict[str, object], explained: float, state: str) -> None:
    assert judge(replace(CERTAIN, **changed), explained)[0] == state  # pyright: ignore[reportArgumentType]


@pytest.mark.parametrize(
    "known,left,expected",
    [(True, 0.95, 0.9 / 0.33), (True, 0.5, 0.9 / 1.1), (False, 0.95, 0.9 / 0.375), (False, 0.8, 0.72)],
)
def test_the_noise_is_no_more_than_the_best_single_effect_leaves(known: bool, left: float, expected: float) -> None:
    """The level of the noise may be too high: then less than the noise of the sensor is left."""
    misfit = {"drive_force": ChannelMisfit(1.0, 1.0, 99.0, 1000, over_sensor_noise=left)}
    best = SimpleNamespace(held_out=SimpleNamespace(loss=0.8), fit_loss=0.3, after_validate=misfit)
    search = SimpleNamespace(problem=SimpleNamespace(noise_is_known=known), ranked=[best])
    assert above_noise(search, (0.85, 0.9)) == pytest.approx(expected)  # pyright: ignore[reportArgumentType]


def test_a_gain_on_some_of_the_records_only_is_said() -> None:
    reason = judge(replace(CERTAIN, held=WEAK), 0.95)[1]
    assert reason == (
        f"its gain is significant on some of the records only ({CERTAIN.fit.z:.1f} standard deviations on the records "
        f"of the fit, {WEAK.z:.1f} on others)"
    )


def test_copies_have_names_and_a_free_curve_leaves_an_effect_possible() -> None:
    assert judge(CERTAIN, 0.6, "a free curve of velocity explains more than all effects found") == (
        "possible",
        "a free curve of velocity explains more than all effects found",
    )
    effect = find("magnetic_cogging:overtone#2")
    assert (public_name(effect.name), variant_group(effect.name)) == ("magnetic_cogging", "magnetic_cogging#2")
    for wrong in ("viscous#2", "magnetic_cogging#1", "magnetic_cogging#x"):
        with pytest.raises(InputError, match="only a periodic effect has copies"):
            find(wrong)


@pytest.mark.parametrize("form,kept", [(0.12, True), (0.0, False)])
def test_what_is_certain_beside_an_effect_of_another_law_remains(
    monkeypatch: pytest.MonkeyPatch, form: float, kept: bool
) -> None:
    mimic, hidden, clear = (find(name) for name in ("dwell_strengthening", "presliding", "constant_bias"))

    def model(*effects: Effect) -> SimpleNamespace:
        return SimpleNamespace(added=effects, implausible=None)

    def without(one: SimpleNamespace, name: str) -> SimpleNamespace:
        return model(*(effect for effect in one.added if effect.name != name))

    def judged(whole: _Set, effect: Effect) -> Entry:
        """Beside the mimic the hidden effect is certain; without it, what the mimic explained is left."""
        evidence = {
            mimic.name: replace(CERTAIN, form=form, gain=2.0, floor=3.0),
            hidden.name: CERTAIN if mimic in whole.model.added else replace(CERTAIN, own_share=0.1, form=1.8),
            clear.name: replace(CERTAIN, gain=60.0),
        }[effect.name]
        return Entry(effect, *judge(evidence, 0.95), whole.model, evidence)

    monkeypatch.setattr("sysid.diagnosis.ledger._judged", judged)
    search = SimpleNamespace(without=without, stated=model())
    whole = _Set(search, 1.0, (), model(), frozenset(), None)  # pyright: ignore[reportArgumentType]
    found, entries = _judged_set(whole, model(mimic, hidden, clear))  # pyright: ignore[reportArgumentType]
    states = {entry.name: entry.state for entry in entries}
    assert states == {
        "dwell_strengthening": "possible",
        "presliding": "established" if kept else "possible",
        "constant_bias": "established",
    }
    assert found.model.added == ((hidden, clear) if kept else (clear,))


class _Losses:
    """Residuals of unit steps: the gain of one model over another is their difference, at 10 deviations per unit."""

    def __init__(self, loss: float) -> None:
        self.loss = loss

    def gain_of(self, other: "_Losses") -> SimpleNamespace:
        gain = self.loss - other.loss
        # A part of the difference of two models may gain significantly where all of it loses.
        return SimpleNamespace(loss=gain, z=10.0 * gain if gain > -0.3 else 5.0)


@pytest.mark.parametrize(
    "in_place,beside,recurring,coordinate",
    [
        (1.2, 1.1, {"position"}, "position"),
        (1.2, 0.9, {"position"}, ""),
        (1.2, 1.6, {"position"}, "position"),
        (1.9, 1.1, {"position"}, ""),
        (1.2, 1.1, {"velocity"}, ""),
    ],
)
def test_an_effect_that_a_free_curve_of_a_larger_one_replaces(
    in_place: float, beside: float, recurring: set[str], coordinate: str
) -> None:
    """A spring with an error of its form, 3.0 without it, and a small effect beside it: 2.0 without, 1.5 with both."""
    spring, small, curve = find("cable_spring"), find("sensor_nonlinearity"), find("magnetic_cogging")

    def model(loss: float, *effects: Effect) -> SimpleNamespace:
        return SimpleNamespace(added=effects, held_out=_Losses(loss))

    both, below = model(1.5, spring, small), {small.name: model(2.0, spring), spring.name: model(3.0, small)}
    curves = {1: [model(in_place, spring, curve)], 2: [model(beside, spring, small, curve)]}
    search = SimpleNamespace(
        without=lambda one, name: below[name],
        with_curves=lambda one, names: curves[len(one.added)] if names else [],
    )
    whole = _Set(search, 1.0, (), both, frozenset(recurring), None)  # pyright: ignore[reportArgumentType]
    assert whole.replaced_by_form(small) == coordinate
    assert whole.replaced_by_form(spring) == ""


@pytest.mark.parametrize("name", ["magnetic_cogging#2", "magnetic_cogging:overtone#3"])
def test_copies_have_the_compiled_laws_of_the_library(name: str) -> None:
    assert is_built_in(find(name))
    assert not is_built_in(replace(find(name), force=lambda axis, p: 0.0))


def _states(found: Diagnosis) -> dict[str, str]:
    return {entry.name: entry.state for entry in found.ledger.entries}


@pytest.mark.slow
def test_two_effects_are_established_at_once_and_added_in_order(tmp_path: Path) -> None:
    rig = write(tmp_path, uneven)
    found, steps = add_all(rig)
    assert _states(found) == {"position_dependent_friction": "established", "cable_spring": "established"}
    document = ledger_json(found)
    assert [row["effect"] for row in document["ledger"]] == [step.revision.document["added"][0] for step in steps]
    assert document["remainder"]["over_noise"] == pytest.approx(1.0, abs=0.1)
    last = steps[-1].after_validate["friction_force"].over_noise
    assert last == pytest.approx(document["remainder"]["over_noise"], rel=0.02)
    assert diagnose(rig).verdict == "adequate"


def test_chain_in_which_gravity_hides_the_friction(tmp_path: Path) -> None:
    """A warming arm with unequal directions: before its gravity is known its friction is zero, and what multiplies that
    has no effect; the residual beside it is less than a small error of the gravity's form would leave."""
    time, records = np.arange(1000) * 0.02, {}
    for seed, role in enumerate(("fit", "validate")):
        random = np.random.default_rng(seed)
        parts = zip((0.8, 0.35, 0.2), (0.11, 0.29, 0.53), random.uniform(0.0, 6.0, 3), strict=True)
        angle = sum(a * np.sin(2.0 * np.pi * f * time + phase) for a, f, phase in parts)
        speed, temperature = np.gradient(angle, time), 21.0 + 20.0 * (1.0 - np.exp(-time / 12.0))
        side, warm = np.sign(speed), np.exp(1800.0 * (1.0 / (temperature + 273.15) - 1.0 / 294.15))
        friction = warm * side * (0.55 * (1.0 + 0.18 * side) + 0.09 * np.abs(speed) * (1.0 + 0.3 * side))
        torque = 1.4 * np.sin(angle) + friction + 1e-3 * random.normal(size=time.size)
        columns = {"time": time, "position [rad]": angle, "velocity [rad/s]": speed}
        records[role] = columns | {"friction_force [N*m]": torque, "temperature": temperature}
    rig = write_rig(tmp_path, "velocity-drive", records, ["coulomb", "viscous"], noise={"friction_force": "1 mN*m"})
    names = ("gravity_torque", "temperature_dependent_friction", "direction_asymmetry")
    assert _states(diagnose(rig)) == dict.fromkeys(names, "established")


def test_two_effects_that_gain_little_alone_are_found_together(tmp_path: Path) -> None:
    """A seal under a load of its own in each record, with a bias: alone, neither the load nor the bias lowers the error
    of the record that is held out as much as a drift does, since its load lies between those of the others."""
    records, time = {}, np.arange(500) * 0.04
    for seed, (name, load) in enumerate({"fit_1": 50.0, "fit_2": 250.0, "fit_3": 350.0, "validate": 150.0}.items()):
        position = 0.02 * np.sin(0.5 * np.pi * time + 0.4 * seed)
        velocity = np.gradient(position, time)
        force = 12.0 * (load / 350.0) ** 0.7 * np.tanh(velocity / 2e-4) + 3.0
        force += 0.1 * np.random.default_rng(seed).normal(size=time.size)
        columns = {"time": time, "position": position, "velocity": velocity, "normal_load": 0.0 * time + load}
        records[name] = columns | {"friction_force": force}
    rig = write_rig(tmp_path, "velocity-drive", records, ["coulomb", "viscous"], noise={"friction_force": 0.1})
    assert _states(diagnose(rig)) == dict.fromkeys(("load_dependent_friction", "constant_bias"), "established")


def _cogging(folder: Path) -> Path:
    """Torque of a motor over one turn, two runs, with harmonics of 8, 16 and 11 periods a turn."""
    records = {}
    for seed, role in enumerate(("fit", "validate")):
        time = np.arange(400) * 0.1
        angle = 2.0 * np.pi * time / time[-1] + 0.003 * seed
        torque = sum(a * np.sin(n * angle + n) for n, a in ((8, 4e-3), (16, 2.9e-3), (11, 1.9e-3)))
        torque = torque + 2e-2 + 2.5e-4 * np.random.default_rng(seed).normal(size=time.size)
        records[role] = {"time": time, "position [rad]": angle, "friction_force [N*m]": torque}
    return write_rig(folder, "velocity-drive", records, ["coulomb"], noise={"friction_force": "0.25 mN*m"})


@pytest.mark.slow
def test_harmonics_of_a_force_are_copies_of_one_effect(tmp_path: Path) -> None:
    found, steps = add_all(_cogging(tmp_path / "rig"))
    assert found.effect == "magnetic_cogging"
    laws = {effect.name for effect in found.ledger.model.fitted.model.effects}
    assert laws == set(steps[-1].revision.effects)
    values = found.ledger.model.fitted.model.values
    turns = sorted(2.0 * np.pi / values[f"{entry.effect.name}.pitch"] for entry in found.ledger.established)
    assert turns == pytest.approx([8.0, 11.0, 16.0], rel=0.01)
    assert found.unexplained_share < 0.05


def test_no_delay_is_named_where_nothing_drives_the_axis(tmp_path: Path) -> None:
    """A falling arm: with a constant drive, a delay of a channel makes the compared torque vanish."""
    records = {}
    for seed, role in enumerate(("fit", "validate")):
        time, step, angle, speed = np.arange(0.0, 2.0, 0.01), 1e-3, 1.4 - 0.1 * seed, 0.0
        angles = []
        for _ in time:
            angles.append(angle)
            for _ in range(10):
                speed += step * (-0.9 * np.sin(angle) - 0.03 * speed) / 0.02
                angle += step * speed
        noisy = np.array(angles) + 1e-4 * np.random.default_rng(seed).normal(size=time.size)
        records[role] = {"time": time, "position [rad]": noisy, "drive_force [N*m]": 0.0 * time}
    write_rig(tmp_path, "force-drive", records, ["coulomb", "viscous"], known={"inertia": "0.02 kg*m^2"})
    found = diagnose(tmp_path)
    assert found.effect in (None, "gravity_torque", "cable_spring")
    assert not any(trial.effect.signal is not None for trial in found.trials)


def test_variant_of_an_effect_is_exchanged_beside_another_effect(tmp_path: Path) -> None:
    """Friction that grows with the root of the load, one direction apart: the linear law is no end of the search."""
    random, records = np.random.default_rng(3), {}
    for name, load in (("a", 20.0), ("b", 200.0), ("c", 400.0), ("validate", 100.0)):
        time = np.arange(600) * 0.01
        position, velocity = 5e-3 * np.sin(np.pi * time), 5e-3 * np.pi * np.cos(np.pi * time)
        force = 0.5 * np.sqrt(load) * (1.0 + 0.3 * (velocity > 0.0)) * np.sign(velocity)
        columns = {"time": time, "position": position, "velocity": velocity, "normal_load": 0.0 * time + load}
        records[name] = columns | {"friction_force": force + 0.02 * random.normal(size=time.size)}
    noise = {"friction_force": 0.02}
    problem = load_problem(write_rig(tmp_path, "velocity-drive", records, ["coulomb"], noise=noise))
    search = ModelSearch(problem, fit_stated_model(problem))
    names = {"direction_asymmetry", "load_dependent_friction"}
    load = next(c for c in search.singles if c.names == ("load_dependent_friction",))
    linear = next(c for c in search.step(load) if {*c.names} == names)
    found = exchanged(search, linear)
    assert {*found.families} == names and "load_dependent_friction:power" in found.names
    assert found.held_out.loss == pytest.approx(1.0, abs=0.1)
    assert linear.held_out.loss > 10.0
