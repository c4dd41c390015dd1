"""Cost of one step of the integrator as effects are added, up to 25 at once.

    python -m benchmarks.many_effects

A mass on a spring, pulled to and fro through stick and slip for 20 s. A step is one try of the integrator, accepted or
not: eight evaluations of every law, one of every slope, the linear solve and the error. The time is the processor's,
the median of several runs, set-up and output left out.
"""

import statistics
import time

import numpy as np

from sim import compose, simulate
from sim.integration import drive

EFFECTS = (
    *("lugre_causal", "viscous", "stribeck", "constant_bias", "cable_spring", "quadratic_drag", "run_in"),
    *("magnetic_cogging", "direction_asymmetry", "position_dependent_friction", "load_dependent_friction"),
    *("temperature_dependent_friction", "dwell_strengthening", "gravity_torque", "bristle_damping", "flexible_mode"),
    *("backlash", "drive_lag", "drive_delay", "frictional_lag", "sensor_lag", "sensor_delay", "sensor_nonlinearity"),
    *("sensor_drift", "sensor_quantisation"),
)
VALUES = {
    "cable_spring.stiffness": 0.05,
    "magnetic_cogging.amplitude": 0.05,
    "direction_asymmetry.viscous": 0.02,
    "gravity_torque.amplitude": 0.02,
    "frictional_lag.delay": 5e-3,
    "drive_delay.delay": 2e-3,
    "flexible_mode.frequency": 60.0,
    "temperature_dependent_friction.reference": 20.0,
    "load_dependent_friction.reference": 1.0,
}
TIME = np.linspace(0.0, 20.0, 41)
KNOTS = np.linspace(0.0, 20.0, 9)
PULL = drive.pulled_spring(KNOTS, 0.5 * np.abs((KNOTS / 5.0 + 1.0) % 2.0 - 1.0), 2.0)


def cost(count: int) -> tuple[float, int]:
    """Seconds a step and steps, with the first `count` effects."""
    names = list(EFFECTS[:count])
    known = {key: value for key, value in VALUES.items() if key.partition(".")[0] in names}
    model = compose(names, known)

    def run(tolerance: float, time_axis: np.ndarray) -> tuple[float, int]:
        begin = time.process_time()
        found = simulate(model, PULL, time_axis, load=1.2, temperature=22.0, tolerance=tolerance, forces=False)
        return time.process_time() - begin, found.steps + found.rejected

    run(1e-7, TIME)
    set_up = statistics.median(run(1e-2, np.array([0.0, 1e-9]))[0] for _ in range(9))
    spent, steps = zip(*[run(1e-7, TIME) for _ in range(9)])
    return (statistics.median(spent) - set_up) / steps[0], steps[0]


def main() -> None:
    print(" effects   us a step     steps")
    first = last = 0.0
    for count in (1, 3, 5, 10, 15, 20, len(EFFECTS)):
        last, steps = cost(count)
        first = first or last
        print(f"{count:8d} {last * 1e6:11.2f} {steps:9d}   ... {EFFECTS[count - 1]}")
    print(f"{len(EFFECTS)} effects at once: {last / first:.1f} times the step of one effect")


if __name__ == "__main__":
    main()
