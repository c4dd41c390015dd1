"""Evaluations of rules and all checks per second: python -m benchmarks.evaluations [COUNT] [KEY=LOW:HIGH ...]

Random designs of the parameters marked free in the packaged file (and of those given), one process; the masses are
estimated from plain volumes. `stagecad optimize` makes such evaluations.
"""

import sys
import time

import numpy as np

from designcalc.optimisation.search import Evaluator, free_parameters
from stagecad.parameters.file import read_parameter_file
from stagecad.parameters.load import variations_of

GOAL = 10_000 / 300 / 2
"""Evaluations per second of one process, so that two make 10 000 in five minutes."""


def rate(evaluator: Evaluator, count: int, seed: int = 1) -> float:
    """Evaluations of all checks per second of processor time."""
    rng = np.random.default_rng(seed)
    evaluator.at(rng.random(len(evaluator.free)))  # what no free parameter changes is computed here
    began = time.process_time()
    for _ in range(count):
        evaluator.at(rng.random(len(evaluator.free)))
    return count / (time.process_time() - began)


def main() -> None:
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 100
    variations = variations_of(read_parameter_file())
    evaluator = Evaluator(variations, free_parameters(variations.design, sys.argv[2:]))
    found = rate(evaluator, count)
    print(f"{len(evaluator.checks)} checks, {len(evaluator.free)} free parameters, {count} random designs")
    print(f"{found:.1f} evaluations per second of one processor ({1e3 / found:.1f} ms each)")
    print(f"10 000 on two processors: {10_000 / found / 2 / 60:.1f} minutes (goal: 5, {GOAL:.1f} per second)")


if __name__ == "__main__":
    main()
