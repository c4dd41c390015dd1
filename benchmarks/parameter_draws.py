"""A thousand parameter draws of the stick-slip model, on one core and on all of them.

    python -m benchmarks.parameter_draws

The gain is in elapsed time; on a machine that others use too it shows less of it than there is.
"""

from __future__ import annotations

import os
import time

import numpy as np

from sim.integration import drive
from sim.integration.draws import simulate_draws

DRAWS = 1000
TIME = np.linspace(0.0, 20.0, 2001)
PULL = drive.pulled_spring([0.0, 20.0], [0.0, 2.0], 2.0)
EFFECTS = ("lugre_causal", "stribeck", "viscous")


def main() -> None:
    random = np.random.default_rng(4)
    values = {
        "lugre_causal.force": random.normal(1.0, 0.05, DRAWS),
        "stribeck.force": random.normal(0.5, 0.05, DRAWS),
        "stribeck.velocity": random.uniform(0.5e-3, 2e-3, DRAWS),
        "viscous.coefficient": random.uniform(0.2, 0.6, DRAWS),
    }
    few = {key: column[:2] for key, column in values.items()}
    simulate_draws(EFFECTS, few, PULL, TIME)
    cores = len(os.sched_getaffinity(0))
    print(f"{DRAWS} draws of 20 s of stick-slip")
    alone = 0.0
    for workers in (1, cores):
        elapsed, spent = [], []
        for _ in range(3):
            begin, used = time.perf_counter(), time.process_time()
            run = simulate_draws(EFFECTS, values, PULL, TIME, workers=workers)
            elapsed.append(time.perf_counter() - begin)
            spent.append(time.process_time() - used)
        best = int(np.argmin(elapsed))
        alone = alone or elapsed[best]
        print(
            f"  {workers} threads: {elapsed[best]:.2f} s elapsed, {spent[best]:.2f} s of processor, "
            f"{spent[best] / elapsed[best]:.2f} cores at work, faster by {alone / elapsed[best]:.2f}; "
            f"{len(run.failures)} failed"
        )


if __name__ == "__main__":
    main()
