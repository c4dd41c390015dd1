"""Error of the form of a law: how well one published form of an effect stands for another one.

Where an effect has several laws in the library, a record of the first form is fitted by the second one: values by
least squares from several starts, beside a constant and a slope of velocity, which every model has. The relative form
error is the rms of what remains over the rms of the effect itself (without that constant and slope). It is the error
that a law of the right effect and of another form leaves; `FORM_ERROR` in sysid/diagnosis/constants.py is of its size.

    python -m benchmarks.form_errors
"""

from collections.abc import Iterator
from itertools import permutations

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table
from scipy.optimize import least_squares

from sim.effects.catalogue import library
from sim.effects.effect import Axis, Effect, Parameter

STEP = 0.01
ROWS = 2000
STARTS = 12
SPECIAL_CASE = 1e-5
"""Form error below which a law contains the other one: left out of the median."""
ANOTHER_EFFECT = 0.5
"""Form error above which a law does not stand for the other one at all: left out of the median."""


def motion() -> Axis:
    """Quantities along a record that resolves the laws: speeds of four decades, 30 K, loads of a factor of five."""
    n = np.arange(ROWS)
    time = STEP * n
    share = n / ROWS
    velocity = 10.0 ** (-5.0 + 4.0 * np.abs(np.sin(5.0 * np.pi * share))) * np.sign(np.sin(7.0 * np.pi * share + 0.1))
    return Axis(
        time=time,
        position=np.cumsum(velocity) * STEP,
        velocity=velocity,
        acceleration=np.gradient(velocity, STEP),
        load=30.0 + 20.0 * np.sin(2.0 * np.pi * 1.3 * share),
        temperature=20.0 + 15.0 * np.sin(2.0 * np.pi * 0.7 * share + 1.0),
        contact_age=20.0 * share**2,
        reversal_distance=np.abs(velocity),
        travelled=np.cumsum(np.abs(velocity)) * STEP,
        direction=np.sign(velocity),
    )


def contribution(effect: Effect, values: NDArray[np.float64], axis: Axis) -> NDArray[np.float64]:
    """What a law with these free values adds, of shape (n,), as relative level, force or sensor signal."""
    names = [p.name for p in free_parameters(effect)]
    p = effect.values(**dict(zip(names, values, strict=True)), **references(effect, axis))
    if effect.factor is not None:
        return effect.factor(axis, p) - 1.0 + np.zeros(ROWS)
    if effect.level is not None:
        return effect.level(axis, p) + np.zeros(ROWS)
    if effect.force is not None:
        return effect.force(axis, p) + np.zeros(ROWS)
    assert effect.signal is not None
    return effect.signal(np.zeros(ROWS), STEP, p)


def free_parameters(effect: Effect) -> list[Parameter]:
    return [p for p in effect.parameters if p.role != "reference" and not (p.fixed and p.role != "shape")]


def references(effect: Effect, axis: Axis) -> dict[str, float]:
    """Values that a diagnosis takes from the record."""
    of = {"degC": float(np.mean(axis.temperature)), "N": float(np.mean(axis.load)), "s": STEP * ROWS}
    return {p.name: of[p.unit] for p in effect.parameters if p.role == "reference"}


def laws(effect: Effect) -> list[Effect]:
    """The laws of an effect that have the same form of contribution and no memory, with their exponents free."""
    family = list({one.equation: one for one in reversed((effect, *effect.variants))}.values())
    kinds = ("factor", "level", "force", "signal")
    kind = next((k for k in kinds if getattr(effect, k) is not None), None)
    same = [one for one in family if kind and getattr(one, kind) is not None and not one.refinement]
    static = [one for one in same if one.memory is None and one.friction_state is None and one.acts_on != "structure"]
    return [one for one in static if kind != "signal" or one.added_to_output]


def pairs() -> Iterator[tuple[Effect, Effect]]:
    """Laws of one name that differ in form."""
    for effect in library().values():
        yield from permutations(laws(effect), 2)


def form_error(made: Effect, fitted: Effect, axis: Axis) -> float:
    """Rms that the best fit of `fitted` leaves of `made` at its default values, over the rms of `made`."""
    base = np.column_stack([np.ones(ROWS), axis.velocity])

    def remaining(x: NDArray[np.float64]) -> NDArray[np.float64]:
        return x - base @ np.linalg.lstsq(base, x, rcond=None)[0]

    start = np.array([p.default or 1.0 for p in free_parameters(made)])
    target = remaining(contribution(made, start, axis))
    size = float(np.sqrt(np.mean(target**2)))
    parameters = free_parameters(fitted)
    first = np.array([p.default or 1.0 for p in parameters])
    low, high = (np.array([getattr(p, end) for p in parameters]) for end in ("low", "high"))
    random = np.random.default_rng(0)
    least = np.inf
    for trial in range(STARTS):
        factor = 10.0 ** random.uniform(-1.0, 1.0, first.size) if trial else 1.0
        begin = np.clip(first * factor, low + 1e-9 * np.abs(first), high - 1e-9 * np.abs(first))
        found = least_squares(
            lambda values: (
                remaining(np.clip(np.nan_to_num(contribution(fitted, values, axis)), -1e9, 1e9) - target) / size
            ),
            begin,
            bounds=(low, high),
            x_scale=np.abs(first),
        )
        least = min(least, 2.0 * found.cost / ROWS)
    return float(np.sqrt(least))


def main() -> None:
    axis = motion()
    table = Table("effect that made the record", "law that is fitted", "relative form error")
    errors = []
    for made, fitted in pairs():
        error = form_error(made, fitted, axis)
        if error < SPECIAL_CASE or error > ANOTHER_EFFECT:
            table.add_row(made.name, fitted.name, "contained" if error < SPECIAL_CASE else "another effect")
            continue
        errors.append(error)
        table.add_row(made.name, fitted.name, f"{100.0 * error:.2g} %")
    console = Console(width=120)
    console.print(table)
    low, middle, high = np.quantile(errors, [0.25, 0.5, 0.75])
    console.print(f"{len(errors)} pairs: median {100 * middle:.2g} %, quartiles {100 * low:.2g} to {100 * high:.2g} %")


if __name__ == "__main__":
    main()
