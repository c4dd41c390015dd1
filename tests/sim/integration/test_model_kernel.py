"""One kernel for all laws of a model: it gives what the laws give one by one, and takes what models without it take."""

import ctypes

import numpy as np
import pytest

from benchmarks.many_effects import EFFECTS, PULL, TIME, VALUES
from sim import Effect, compose, simulate
from sim.integration import layout
from sim.integration.layout import plan_of
from sim.library.effect import Axis

RANDOM = np.random.default_rng(11)
MANY = compose(EFFECTS, dict(VALUES))
TYPE = ctypes.CFUNCTYPE(
    None, *[ctypes.c_double, ctypes.c_void_p, ctypes.c_double, ctypes.c_double], *[ctypes.c_void_p] * 4
)


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_it_gives_what_the_laws_give_one_by_one(direction: float) -> None:
    laid_out = plan_of(MANY, PULL, 1.0, 1.2, 22.0)
    assert laid_out.at_once[0] != 0 and laid_out.head == 4
    kernel = TYPE(int(laid_out.at_once[0]))
    t, lagged = 0.7, 3e-4
    y = np.array([2e-3, 1e-3 * direction, 0.03, 0.2, *RANDOM.uniform(-1e-6, 1e-6, 2)])
    elements, out = np.zeros((2, 8)), np.zeros(4)
    kernel(
        t, y.ctypes.data, direction, lagged, laid_out.base.ctypes.data, int(laid_out.at_once[1]), elements.ctypes.data,
        out.ctypes.data,
    )  # fmt: skip

    here = Axis(t, y[0], y[1], np.nan, 1.2, 22.0, y[3], np.nan, y[2], direction)
    late = here._replace(velocity=direction * lagged)
    level, factor, force = 0.0, 1.0, 0.0
    for effect, p in zip(MANY.effects, MANY.values):
        # Only friction that depends on the speed sees the lagged one, so all levels may be shown it.
        level += effect.level(late, p) if effect.level is not None else 0.0
        factor *= effect.factor(late, p) if effect.factor is not None else 1.0
        force += effect.force(here, p) if effect.force is not None and effect.parallel_element is None else 0.0
    by_name = dict(zip(MANY.names, zip(MANY.effects, MANY.values)))
    core, p = by_name["lugre_causal"]
    bristle = core.friction_state.law(0, y[4], y[1], direction, level * factor, p)
    damper, p = by_name["bristle_damping"]
    damping = damper.parallel_element.law(0, y[5], y[1], direction, level * factor, p)
    assert out == pytest.approx([level * factor, bristle[1], force, damping[1]], rel=1e-13)
    assert elements[:, :2] == pytest.approx(np.array([bristle, damping]), rel=1e-13)


def test_a_motion_is_the_same_without_it(monkeypatch: pytest.MonkeyPatch) -> None:
    def run() -> np.ndarray:
        found = simulate(MANY, PULL, TIME, load=1.2, temperature=22.0, tolerance=1e-9)
        return np.array([found.position, found.velocity, found.level, found.core_force, found.friction])

    together = run()
    monkeypatch.setattr(layout, "FEWEST", 1000)
    assert plan_of(MANY, PULL, 1.0, 1.2, 22.0).at_once[0] == 0
    assert together == pytest.approx(run(), rel=1e-9, abs=1e-12)


def test_a_law_of_the_users_own_is_called_beside_the_others() -> None:
    own = Effect("own_drag", "a drag of the user's own", force=lambda axis, p: 0.1 * axis.velocity)
    names = [name for name in EFFECTS if name not in ("frictional_lag", "viscous")]
    values = {key: value for key, value in VALUES.items() if key.partition(".")[0] in names}
    given = compose([*names, own], values)
    assert plan_of(given, PULL, 1.0, 1.2, 22.0).at_once[0] == 0
    same = compose([*names, "viscous"], {**values, "viscous.coefficient": 0.1})
    assert plan_of(same, PULL, 1.0, 1.2, 22.0).at_once[0] != 0
    ends = [
        simulate(m, PULL, np.linspace(0.0, 0.5, 6), load=1.2, temperature=22.0, tolerance=1e-9).position
        for m in (given, same)
    ]
    assert ends[0] == pytest.approx(ends[1], rel=1e-6, abs=1e-12)


def test_few_laws_are_not_worth_a_compilation() -> None:
    assert plan_of(compose(["lugre_causal", "stribeck", "viscous"]), PULL, 1.0, 1.0, 20.0).at_once[0] == 0
