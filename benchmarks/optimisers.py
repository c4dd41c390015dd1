"""Optimisers compared on the search for the nearest design: python -m benchmarks.optimisers [COUNT] [SEEDS] [NAME...]

Each one minimises the same merit (distance of a satisfying design; 100 and more for another one) from the present
design, with the same number of evaluations. The requirements are failing checks of the packaged design that can be met.
Needs `pip install -e .[peers]`.
"""

import sys
import time
import warnings
from collections.abc import Callable
from contextlib import suppress

import numpy as np
from numpy.typing import NDArray

from designcalc.optimisation.search import Best, Evaluator, cma_es, free_parameters
from stagecad.parameters.file import read_parameter_file
from stagecad.parameters.load import variations_of

Array = NDArray[np.float64]

REQUIRED = (
    "tip contact pressure",
    "piezo stroke of the drive",
    "pad pressure",
    "sag of the drive surface over the travel",
    "drive frequency against the tip's resonances",
    "smoothness of the way as drawn",
    "capacitive probe noise after its filter",
    "range of the adjustment against the thickest shim",
)


class ExhaustedError(Exception):
    """The evaluations are used up."""


def run_cobyla(function: Callable[[Array], float], start: Array, budget: int, seed: int) -> None:
    """Linear models in a trust region, of scipy; the choice of nevergrad for this number of evaluations."""
    from scipy.optimize import minimize

    bounds = [(0.0, 1.0)] * len(start)
    options = {"rhobeg": 0.25, "maxiter": budget, "tol": 1e-4}
    minimize(function, start, method="COBYLA", bounds=bounds, options=options)


def run_scipy(function: Callable[[Array], float], start: Array, budget: int, seed: int) -> None:
    """Differential evolution."""
    from scipy.optimize import differential_evolution

    bounds = [(0.0, 1.0)] * len(start)
    differential_evolution(function, bounds, x0=start, seed=seed, popsize=2, maxiter=10_000, polish=False, tol=0)


def run_nevergrad(function: Callable[[Array], float], start: Array, budget: int, seed: int) -> None:
    """The choice of nevergrad itself."""
    import nevergrad

    space = nevergrad.p.Array(init=start).set_bounds(0.0, 1.0)
    space.random_state.seed(seed)
    nevergrad.optimizers.NGOpt(space, budget=budget).minimize(function)


def run_pymoo(function: Callable[[Array], float], start: Array, budget: int, seed: int) -> None:
    """Genetic algorithm."""
    from pymoo.algorithms.soo.nonconvex.ga import GA
    from pymoo.core.problem import ElementwiseProblem
    from pymoo.optimize import minimize

    class Merit(ElementwiseProblem):
        def __init__(self) -> None:
            super().__init__(n_var=len(start), n_obj=1, xl=0.0, xu=1.0)

        def _evaluate(self, x: Array, out: dict[str, float], *args: object, **kwargs: object) -> None:
            out["F"] = function(x)

    rng = np.random.default_rng(seed)
    first = np.vstack([start, rng.random((19, len(start)))])
    minimize(Merit(), GA(pop_size=20, sampling=first), ("n_eval", budget), seed=seed)


METHODS = {"cma": cma_es, "cobyla": run_cobyla, "scipy": run_scipy, "nevergrad": run_nevergrad, "pymoo": run_pymoo}


def merit_of(method: str, budget: int, seed: int) -> float:
    """Merit of the best design after a number of evaluations."""
    variations = variations_of(read_parameter_file())
    evaluator = Evaluator(variations, free_parameters(variations.design, ()))
    best = Best(evaluator, REQUIRED, alone=True)

    def function(point: Array) -> float:
        if evaluator.count >= budget:
            raise ExhaustedError
        return best.offer(evaluator.at(np.asarray(point, float), best.run))

    with suppress(ExhaustedError):
        METHODS[method](function, np.clip(evaluator.start, 0.02, 0.98), budget, seed)
    return best.merit(best.found)


def main() -> None:
    budget, seeds = (int(word) for word in (sys.argv[1:3] + ["400", "3"][len(sys.argv[1:3]) :]))
    warnings.simplefilter("ignore")
    print(f"{budget} evaluations, {seeds} seeds: merit of the best design (below 100: all requirements are met)")
    print(f"{'optimiser':12}{'median':>10}{'worst':>10}{'s':>8}")
    for method in sys.argv[3:] or METHODS:
        began = time.perf_counter()
        found = [merit_of(method, budget, seed) for seed in range(1, seeds + 1)]
        print(f"{method:12}{np.median(found):10.3f}{max(found):10.3f}{time.perf_counter() - began:8.1f}")


if __name__ == "__main__":
    main()
