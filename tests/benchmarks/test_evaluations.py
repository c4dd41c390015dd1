"""Speed of the evaluations that an optimisation makes."""

from __future__ import annotations

import pytest

from benchmarks.evaluations import GOAL, rate
from designcalc.optimisation.evaluation import Evaluator
from designcalc.optimisation.space import free_parameters
from stagecad.parameters.load import load_variations


@pytest.mark.slow
def test_ten_thousand_evaluations_take_less_than_five_minutes_on_two_processors() -> None:
    variations = load_variations()
    assert rate(Evaluator(variations, free_parameters(variations.design, ())), 100) > GOAL
