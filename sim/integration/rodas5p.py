"""One step of Rodas5P, an L-stable Rosenbrock method of order 5 in 8 stages with dense output of order 4; compiled.

In the form that needs no matrix products (Hairer and Wanner, Solving ODEs II, IV.7): with W = I/(gamma h) - J

    W k_i = f(t + c_i h, y + sum_j A_ij k_j) + sum_j C_ij k_j / h + h d_i df/dt

The last three stages share the point t + h; y_new adds k_6, k_7 and k_8 in turn, and k_8 is the error estimate.
Dense output: y(s) = (1 - s) y + s (y_new + (1 - s) (D_1 + s (D_2 + s D_3))), D_i = sum_j H_ij k_j.

Source: Steinebach 2023, BIT Numerical Mathematics 63:27, Construction of Rosenbrock-Wanner method Rodas5P.
"""

import math

import numpy as np

from sim.integration.arrowhead import factorise, solve
from sim.integration.compiled.views import Part
from sim.integration.dense_output import delayed_speed
from sim.integration.problem import BRANCH, VALUES, inlined
from sim.integration.right_hand_side import friction_terms, rates_of_change

STAGES = 8
GAMMA = 0.21193756319429014

_A = (
    (),
    (3.0,),
    (2.849394379747939, 0.45842242204463923),
    (-6.954028509809101, 2.489845061869568, -10.358996098473584),
    (2.8029986275628964, 0.5072464736228206, -0.3988312541770524, -0.04721187230404641),
    (-7.502846399306121, 2.561846144803919, -11.627539656261098, -0.18268767659942256, 0.030198172008377946),
)
_C = (
    (),
    (-14.155112264123755,),
    (-17.97296035885952, -2.859693295451294),
    (147.12150275711716, -1.41221402718213, 71.68940251302358),
    (165.43517024871676, -0.4592823456491126, 42.90938336958603, -5.961986721573306),
    (24.854864614690072, -3.0009227002832186, 47.4931110020768, 5.5814197821558125, -0.6610691825249471),
    (
        30.91273214028599,
        -3.1208243349937974,
        77.79954646070892,
        34.28646028294783,
        -19.097331116725623,
        -28.087943162872662,
    ),
    (
        37.80277123390563,
        -3.2571969029072276,
        112.26918849496327,
        66.9347231244047,
        -40.06618937091002,
        -54.66780262877968,
        -9.48861652309627,
    ),
)
_H = (
    (
        25.948786856663858,
        -2.5579724845846235,
        10.433815404888879,
        -2.3679251022685204,
        0.524948541321073,
        1.1241088310450404,
        0.4272876194431874,
        -0.17202221070155493,
    ),
    (
        -9.91568850695171,
        -0.9689944594115154,
        3.0438037242978453,
        -24.495224566215796,
        20.176138334709044,
        15.98066361424651,
        -6.789040303419874,
        -6.710236069923372,
    ),
    (
        11.419903575922262,
        2.8879645146136994,
        72.92137995996029,
        80.12511834622643,
        -52.072871366152654,
        -59.78993625266729,
        -0.15582684282751913,
        4.883087185713722,
    ),
)


def _lower(rows: tuple[tuple[float, ...], ...]) -> np.ndarray:
    full = np.zeros((STAGES, STAGES))
    for i, row in enumerate(rows):
        full[i, : len(row)] = row
    return full


A = _lower(_A)
# Stages 7 and 8 start from stage 6's point, with k_6 and then k_7 added.
A[6, :5] = A[5, :5]
A[6, 5] = 1.0
A[7, :5] = A[5, :5]
A[7, 5:7] = 1.0
C = _lower(_C)
TIME = np.array([0.0, 0.6358126895828704, 0.4095798393397535, 0.9769306725060716, 0.4288403609558664, 1.0, 1.0, 1.0])
TIME_SLOPE = np.array(
    [
        0.21193756319429014,
        -0.42387512638858027,
        -0.3384627126235924,
        1.8046452872882734,
        2.325825639765069,
        0.0,
        0.0,
        0.0,
    ]
)
H = np.array(_H)


@inlined
def _stage_point(i, size, inverse_h, work):
    """Point y + sum_j A_ij k_j of stage `i`, and its coupling sum_j C_ij k_j / h to the earlier stages."""
    increments = work.increments
    for j in range(size):
        point, coupling = 0.0, 0.0
        for m in range(i):
            point += A[i, m] * increments[m, j]
            coupling += C[i, m] * increments[m, j]
        work.point[j] = work.y[j] + point
        work.coupling[j] = coupling * inverse_h


@inlined
def evaluate(t, y, branch, problem, work, f):
    """Rates f at one instant, without slopes."""
    delayed = (0.0, 0.0)
    if problem.body.friction_delay > 0.0:
        delayed = delayed_speed(t - problem.body.friction_delay, work)
    friction_terms(t, y, branch.direction, delayed, VALUES, problem, work.terms)
    rates_of_change(t, y, branch, problem, work.terms, f)


@inlined
def _squared_error(size, tolerance, work):
    """Mean square of the error estimate, the last increment, over the tolerance of each state."""
    error = 0.0
    for j in range(size):
        scale = tolerance.absolute[j] + tolerance.relative * max(abs(work.y[j]), abs(work.fresh[j]))
        off = work.increments[STAGES - 1, j] / scale
        error += off * off
    error /= tolerance.counted
    return error if math.isfinite(error) else math.inf


def _step(memory, arguments):
    """The increments of all stages, and the state after the step, into `work`; returns the error estimate, as
    `_squared_error`, or -1 where a number is not finite."""
    t, h, branch = arguments
    problem, tolerance, _, work, _ = memory[0]
    size, v = problem.layout.size, work.y[1]
    factors = factorise(GAMMA * h, branch, problem, work.jacobian)
    for i in range(STAGES):
        k = work.increments[i]
        late = h * TIME_SLOPE[i]
        if i == 0:
            for j in range(size):
                k[j] = work.rates[j] + late * work.jacobian.time[j]
        else:
            at = t + TIME[i] * h
            _stage_point(i, size, 1.0 / h, work)
            evaluate(at, work.point, branch, problem, work, k)
            for j in range(size):
                k[j] += work.coupling[j] + late * work.jacobian.time[j]
        if not math.isfinite(solve(k, v, branch, factors, problem, work.jacobian)):
            return -1.0
    for j in range(size):
        work.fresh[j] = work.point[j] + work.increments[STAGES - 1, j]
    return _squared_error(size, tolerance, work)


STEP = Part(_step, (0.0, 0.0, BRANCH))
"""One step from `t` of length `h` on a branch."""


@inlined
def dense_coefficients(j, work):
    """Coefficients D of the dense output of state `j`."""
    for i in range(3):
        total = 0.0
        for m in range(STAGES):
            total += H[i, m] * work.increments[m, j]
        work.dense[j, i] = total
