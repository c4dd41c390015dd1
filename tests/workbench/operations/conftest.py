"""A slide with a Stribeck curve, measured twice, whose model lacks the curve; each step of the loop run once."""

from typing import Any

import pytest

import stagecad
from tests.workbench.operations.slide_log import NOISE, slide_log


@pytest.fixture(scope="session")
def slide() -> stagecad.Experiment:
    records = {"one": pytest.importorskip("pandas").DataFrame(slide_log(1)), "two": slide_log(2)}
    given: Any = {"noise": {"friction_force": f"{NOISE} N"}, "validate": ["two"], "name": "slide"}
    return stagecad.Experiment.from_dataframes(records, "velocity-drive", ["coulomb", "viscous"], **given)


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
