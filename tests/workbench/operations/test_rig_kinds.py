"""A kind of rig of the user's own as an object: as its declaration file says, in memory, saved, and on the ladder."""

import hashlib
import json
import shutil
from pathlib import Path

import numpy as np
import pytest

import stagecad
from stagecad import Experiment, InputError, Rig, RigKind

EXAMPLE = Path(__file__).parents[3] / "examples" / "own_rig"
COIL = RigKind(
    "force-drive",
    channels={"coil_current": "A"},
    known={"force_constant": "N/A", "flexure_stiffness": {"unit": "N/m", "default": "0 N/m"}},
    balance={"drive_force": "known.force_constant * channel.coil_current - known.flexure_stiffness * channel.position"},
)
KNOWN = {"force_constant": "8 N/A", "flexure_stiffness": "300 N/m", "mass": "0.5 kg"}


def _experiment(kind: RigKind = COIL) -> Experiment:
    """A slide of 0.5 kg on a flexure of 300 N/m with 0.4 N of friction: the current by Newton's law."""
    t = np.arange(1500) * 2e-3
    x, v, a = 0.02 * np.sin(5.0 * t), 0.1 * np.cos(5.0 * t), -0.5 * np.sin(5.0 * t)
    current = (0.5 * a + 300.0 * x + 0.4 * np.tanh(v / 1e-5)) / 8.0
    log = {"time [s]": t, "position [m]": x, "coil_current [A]": current}
    return Experiment.from_dataframes({"one": log}, Rig(kind, KNOWN), ["coulomb"], noise={"position": "1e-7 m"})


def test_an_own_kind_in_memory_is_fitted_saved_and_grown(tmp_path: Path) -> None:
    experiment = _experiment()
    found = stagecad.compare(experiment)
    assert found.parameters.loc["coulomb.force", "value"] == pytest.approx(0.4, rel=0.02)
    assert experiment.rig == Rig(COIL, KNOWN)
    grown = stagecad.add(experiment, "viscous").experiment
    assert grown.rig == experiment.rig and grown.stated.effects == ("coulomb", "viscous")
    saved = experiment.save(tmp_path / "rig")
    assert saved.rig == experiment.rig
    np.testing.assert_array_equal(saved.to_dataframe(), experiment.to_dataframe())


def test_the_object_says_what_the_declaration_file_says() -> None:
    from_file = Experiment.load(EXAMPLE).stated.records[0].balance
    own = _experiment().stated.records[0].balance
    assert from_file is not None and own is not None
    assert {key: str(one) for key, one in from_file.kind.balance.items()} == {
        key: str(one) for key, one in own.kind.balance.items()
    }
    assert list(from_file.kind.own) == list(own.kind.own) and from_file.kind.inputs == own.kind.inputs


@pytest.mark.parametrize(
    ("kind", "message"),
    [
        (RigKind("force-drive"), r"rig\.kind\.balance: is missing"),
        (RigKind("force-driv", COIL.channels, COIL.balance), r"rig\.kind\.base: .*did you mean 'force-drive'"),
        (RigKind("force-drive", {"coil_current": "Amp"}, COIL.balance, COIL.known), r"rig\.kind\.channels.*Amp"),
        (RigKind("force-drive", COIL.channels, COIL.balance), r"there is no 'known\.force_constant'"),
    ],
)
def test_a_fault_of_the_declaration_is_one_line(kind: RigKind, message: str) -> None:
    with pytest.raises(InputError, match=message) as caught:
        _experiment(kind)
    assert "\n" not in str(caught.value)


def test_a_rung_keeps_the_hash_of_the_declaration_file(tmp_path: Path) -> None:
    rig = Path(shutil.copytree(EXAMPLE, tmp_path / "rig"))
    stagecad.add(rig, "stribeck")
    digest = hashlib.sha256((rig / "voice_coil.toml").read_bytes()).hexdigest()
    for number in ("000", "001"):
        assert json.loads((rig / "ladder" / f"{number}.json").read_text())["rig"] == {"voice_coil.toml": digest}
