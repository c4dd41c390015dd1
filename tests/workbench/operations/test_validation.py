"""Correlation, information criteria and k-step prediction as results."""

import numpy as np
import pytest

import stagecad
from stagecad import Comparison, Diagnosis, Experiment, InputError, Rig


def test_the_correlation_of_a_residual(comparison: Comparison, addition: stagecad.Addition) -> None:
    before, after = comparison.correlation(), addition.correlation(part="validate")
    assert not before.is_white and "not white" in repr(before)
    assert before.to_dataframe().loc[("residual", 0.0), "correlation"] == pytest.approx(1.0, abs=1e-12)
    assert abs(after.computed.autocorrelation[1]) < before.computed.autocorrelation[1]
    assert len(before.plot().axes) == 3
    with pytest.raises(InputError, match="no channel 'force'"):
        comparison.correlation("force")


def test_information_criteria_rank_the_effect_first(comparison: Comparison, diagnosis: Diagnosis) -> None:
    assert comparison.to_json()["information"]["parameters"] == 3
    assert comparison.criteria.aic == comparison.to_json()["information"]["aic"]
    changes = diagnosis.ranking["bic_change"].dropna()
    assert changes.idxmin() == "stribeck" and changes.min() < -10.0


def _pulled_mass(rows: int = 500) -> dict[str, np.ndarray]:
    """A mass of 1.5 kg with 6 N*s/m of drag and no other friction under a force of two sines: exact motion."""
    t = np.arange(rows) * 0.002
    force, x = np.zeros(rows), np.zeros(rows)
    for size, w in ((3.0, 7.0), (2.0, 19.0)):
        force += size * np.cos(w * t)
        response = size / (1.5 * (1j * w) ** 2 + 6.0 * 1j * w)
        x += np.real(response * np.exp(1j * w * t))
    return {"time [s]": t, "drive_force [N]": force, "position [m]": x}


def test_k_step_errors_of_a_known_motion() -> None:
    experiment = Experiment.from_dataframes(
        {"a": _pulled_mass()},
        Rig("force-drive", {"mass": "1.5 kg"}, input_hold="linear"),
        ["viscous"],
        noise={"position": "1e-7 m", "drive_force": "0.001 N"},
    )
    found = stagecad.compare(experiment)
    assert found.parameters.loc["viscous.coefficient", "value"] == pytest.approx(6.0, rel=1e-3)
    errors = found.prediction_errors((0.02, 0.1))
    rms = errors.xs(("fit", "position"), level=("records", "channel"))["rms"]
    assert list(rms.index) == ["0.02 s", "0.1 s", "free run"]
    # Errors grow with the horizon, and stay far below the motion of 40 mm.
    assert rms["0.02 s"] < rms["0.1 s"] < 1e-4
    table = found.free_run
    difference = table["position"] - table["position_simulated"]
    assert difference.loc["a"].abs().max() < 1e-3
    with pytest.raises(InputError, match="above zero"):
        found.prediction_errors((0.0,))
