"""A slide with a Stribeck curve, measured twice, whose model lacks the curve; each step of the loop run once."""

from __future__ import annotations

import pytest

import stagecad
from tests.workbench.operations.slide_log import NOISE, slide_log


@pytest.fixture(scope="session")
def slide() -> stagecad.Experiment:
    pandas = pytest.importorskip("pandas")
    return stagecad.Experiment.from_dataframes(
        {"one": pandas.DataFrame(slide_log(1)), "two": slide_log(2)},
        rig="velocity-drive",
        model=["coulomb", "viscous"],
        noise={"friction_force": f"{NOISE} N"},
        validate=["two"],
        name="slide",
    )


@pytest.fixture(scope="session")
def comparison(slide: stagecad.Experiment) -> stagecad.Comparison:
    return stagecad.compare(slide)


@pytest.fixture(scope="session")
def diagnosis(slide: stagecad.Experiment) -> stagecad.Diagnosis:
    return stagecad.diagnose(slide)


@pytest.fixture(scope="session")
def addition(slide: stagecad.Experiment, diagnosis: stagecad.Diagnosis) -> stagecad.Addition:
    assert diagnosis.effect is not None
    return stagecad.add(slide, diagnosis.effect)
