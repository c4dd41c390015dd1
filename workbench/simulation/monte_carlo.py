"""Simulations of many machines drawn from what the parameter file leaves open: deviations and tolerances."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from statistics import NormalDist
from typing import TYPE_CHECKING, Any

import numpy as np

from stagecad.parameters.errors import InputError
from workbench.cluster import run_all
from workbench.machine.margins import Source, source_of
from workbench.options import Run
from workbench.simulation.sweep import Wanted, run_of
from workbench.simulation.uncertain_parameters import Open, open_parameters, reads

if TYPE_CHECKING:
    from stagecad.parameters.design import Design
    from stagecad.parameters.mass_properties import BodyMasses

Way = tuple[str, ...]
"""Experiment, model, perhaps case, and feature."""

POINTS = 201
"""Points of a curve that a draw keeps."""


@dataclass(frozen=True)
class Curve:
    """Something of an experiment over time (or over a period): `y` at `x`, SI, shape (n,)."""

    x: np.ndarray
    y: np.ndarray


@dataclass(frozen=True)
class Draw:
    """What one drawn machine does: features and curves by their `Way`; or a reason."""

    features: Mapping[Way, Any]
    curves: Mapping[Way, np.ndarray]
    refused: str = ""


@dataclass(frozen=True)
class Spread:
    """One feature over the draws. SI.

    Args:
        nominal: of the design as it stands; None where it has none (a mass that does not slip).
        values: of each draw, (draws,); NaN where it has none.
        unit: SI.
        leading: the drawn parameter it follows most, by rank correlation, and that correlation; an empty name where
            that is no more than chance.
    """

    nominal: float | None
    values: np.ndarray
    unit: str
    leading: tuple[str, float]

    @property
    def found(self) -> np.ndarray:
        """Values of the draws that have the feature."""
        return self.values[np.isfinite(self.values)]

    @property
    def moves(self) -> bool:
        """Whether the draws change it at all, beyond rounding."""
        found = self.found
        return found.size > 1 and float(np.ptp(found)) > 1e-12 * float(np.abs(found).max())

    def as_json(self) -> dict[str, Any]:
        """The nominal value, mean and standard deviation over the draws, and the band that 95 % of them lie in."""
        found = self.found
        low, high = np.quantile(found, [0.025, 0.975]) if found.size else (np.nan, np.nan)
        return {
            "value": self.nominal,
            "unit": self.unit,
            "mean": float(found.mean()) if found.size else None,
            "std": float(found.std(ddof=1)) if found.size > 1 else None,
            "low": float(low),
            "high": float(high),
            "draws": int(found.size),
            "follows": {"key": self.leading[0], "rank_correlation": self.leading[1]} if self.leading[0] else None,
        }


def followed(spread: Spread) -> str:
    """What a feature follows most, with the rank correlation; empty where nothing stands out."""
    key, correlation = spread.leading
    return f"{key} ({correlation:+.2f})" if key else ""


@dataclass(frozen=True)
class Study:
    """All draws of a command.

    Args:
        opened: the parameters drawn.
        values: (draws, parameters), each in its own unit.
        nominal: the design as it stands.
        abscissae: of the curves.
        draws: one for each row of `values`.
        spreads: of each feature, over the draws.
    """

    opened: tuple[Open, ...]
    values: np.ndarray
    nominal: Draw
    abscissae: Mapping[Way, np.ndarray]
    draws: tuple[Draw, ...]
    spreads: Mapping[Way, Spread]

    @property
    def refused(self) -> list[tuple[int, str]]:
        """Number and reason of the draws that do not stand."""
        return [(k, draw.refused) for k, draw in enumerate(self.draws) if draw.refused]


def draw_machines(run: Run, wanted: Wanted, count: int, seed: int, scheduler: str | None) -> Study:
    """Simulate `count` machines drawn about the design, side by side on the local cores or on a cluster.

    The values are drawn here, from `seed`, before anything is sent: the same answer wherever it is worked out.

    Raises:
        InputError: nothing is open, the design itself does not stand, or no draw does.
    """
    opened = open_parameters(run.design, wanted.names, own_mass=wanted.mass is None)
    if not opened:
        raise InputError(
            f"--draws: nothing that {', '.join(wanted.names)} read has a tolerance or a '+-'; give one, like "
            '--set "friction.breakaway=1.5 +- 0.1 N"'
        )
    random = np.random.default_rng(seed)
    values = np.column_stack([one.drawn(random, count) for one in opened])
    source, wanted, masses = source_of(run), _with_mass(run, wanted), _masses(run, wanted)
    nominal, abscissae = _simulated(run.design, wanted, masses)
    common = _Common(source, wanted, opened, run.design, masses)
    with run.progress() as progress:
        task = progress.add_task("draws", total=count)
        # A few draws at a time: each is short beside the sending.
        size = max(1, min(8, count // 16))
        rows = [values[k : k + size] for k in range(0, count, size)]
        found = run_all(drawn, rows, scheduler, lambda: progress.update(task, advance=size), common=common)
    draws = tuple(draw for some in found for draw in some)
    if all(draw.refused for draw in draws):
        raise InputError(f"--draws: no draw stands: {draws[0].refused}")
    return Study(opened, values, nominal, abscissae, draws, _spreads(opened, values, nominal, draws))


@dataclass(frozen=True)
class _Common:
    """What every draw needs, sent once."""

    source: Source
    wanted: Wanted
    opened: tuple[Open, ...]
    base: Design
    masses: BodyMasses | None


def drawn(common: _Common, rows: np.ndarray) -> list[Draw]:
    """What the machines with the values of each row do, (k, parameters)."""
    from designcalc.checks.analysis.tolerance import scaled_masses
    from sim.integration.simulate import SimulationError

    found = []
    for row in rows:
        more = [f"{one.key}={value!r} {one.unit}".rstrip() for one, value in zip(common.opened, row.tolist())]
        try:
            # As in a study of tolerances: rules across values speak of what is drawn, not of what is made.
            design = common.source.design(*more, rules=False)
            masses = scaled_masses(design, common.base, common.masses)
            found.append(_simulated(design, common.wanted, masses)[0])
        except (InputError, SimulationError) as refused:
            found.append(Draw({}, {}, " ".join(str(refused).split())))
    return found


def _with_mass(run: Run, wanted: Wanted) -> Wanted:
    """With the mass of the design's own body as a number, so that no draw makes solids for it."""
    from workbench.simulation.inputs import moving_mass

    if wanted.mass != "design" or not set(wanted.names) - {"tip", "stage"}:
        return wanted
    return replace(wanted, mass=f"{moving_mass(run, wanted.mass)!r} kg")


def _masses(run: Run, wanted: Wanted) -> BodyMasses | None:
    from stagecad.solids.assembly.machine import body_masses

    return body_masses(run.design) if "stage" in wanted.names else None


def _simulated(design: Design, wanted: Wanted, masses: BodyMasses | None) -> tuple[Draw, dict[Way, np.ndarray]]:
    """One machine: its features and curves, and the abscissae of the curves."""
    from workbench.simulation.inputs import moving_mass
    from workbench.simulation.jobs import features_document, features_of, simulated

    run = run_of(design)
    mass = moving_mass(run, wanted.mass) if set(wanted.names) - {"tip", "stage"} else 1.0
    document: dict[str, Any] = {}
    curves: dict[Way, Curve] = {}
    for name in wanted.names:
        if name == "stage":
            from sim.experiments.stage import STUDIES, run_serially, stage_drive

            assert masses is not None
            drive = stage_drive(design, masses)
            document[name] = features_document({one: STUDIES[one](drive, run_serially) for one in wanted.studies})
            continue
        results = simulated(run, name, wanted.models, mass)
        document[name] = features_of(results)
        curves |= curves_of(name, results)
    draw = Draw(_flat(document), {key: curve.y for key, curve in curves.items()})
    return draw, {key: curve.x for key, curve in curves.items()}


def curves_of(name: str, results: Mapping[str, Any]) -> dict[Way, Curve]:
    """What is drawn of an experiment as a band: position in time, or friction over the last period of a loop."""
    if name == "presliding":
        return {(name, model): _in_time(found.simulation, 4.0) for model, found in results.items()}
    if name == "stick-slip":
        from sim.experiments.stick_slip import SHOWN

        return {(name, model): _in_time(found.simulation, SHOWN) for model, found in results.items()}
    if name == "hysteresis":
        return {
            (name, model, case): _last_period(found)
            for model, cases in results.items()
            for case, found in cases.items()
        }
    return {}


def _in_time(run: Any, end: float) -> Curve:
    time = np.linspace(0.0, end, POINTS)
    return Curve(time, np.interp(time, run.time, run.position))


def _last_period(found: Any) -> Curve:
    """Friction over the second of two periods; the abscissa is the part of the period gone."""
    run, period = found.simulation, 2.0 * np.pi / found.frequency
    part = np.linspace(0.0, 1.0, POINTS)
    return Curve(part, np.interp((1.0 + part) * period, run.time, run.friction))


def _flat(document: Mapping[str, Any], before: Way = ()) -> dict[Way, Any]:
    """Every feature, a quantity or none, by its way."""
    found: dict[Way, Any] = {}
    for name, inner in document.items():
        if isinstance(inner, Mapping) and "unit" not in inner:
            found |= _flat(inner, (*before, name))
        else:
            found[(*before, name)] = inner
    return found


def _spreads(opened: Sequence[Open], values: np.ndarray, nominal: Draw, draws: Sequence[Draw]) -> dict[Way, Spread]:
    spreads = {}
    names = dict.fromkeys([*nominal.features, *(name for draw in draws for name in draw.features)])
    for name in names:
        cells = [draw.features.get(name) for draw in draws]
        unit = next((cell["unit"] for cell in (nominal.features.get(name), *cells) if cell is not None), None)
        if unit is None:
            continue
        column = np.array([np.nan if cell is None else cell["value"] for cell in cells], dtype=float)
        own = nominal.features.get(name)
        spread = Spread(None if own is None else float(own["value"]), column, unit, ("", 0.0))
        if spread.moves:
            read = [k for k, one in enumerate(opened) if reads(name[0], one.key)]
            spread = replace(spread, leading=_leading([opened[k].key for k in read], values[:, read], column))
        spreads[name] = spread
    return spreads


def _leading(keys: Sequence[str], values: np.ndarray, column: np.ndarray) -> tuple[str, float]:
    """The parameter a feature follows most, by Spearman's rank correlation; none where the largest may be chance."""
    ok = np.isfinite(column)
    y = _ranks(column[ok])
    found = [float(_ranks(x) @ y) for x in values[ok].T]
    best = int(np.argmax(np.abs(found)))
    # What the largest of so many rank correlations of independent columns passes in one case of a hundred.
    chance = NormalDist().inv_cdf(1.0 - 0.005 / len(keys)) / np.sqrt(ok.sum() - 1)
    return (keys[best], found[best]) if abs(found[best]) > chance else ("", 0.0)


def _ranks(column: np.ndarray) -> np.ndarray:
    """Ranks, centred and of norm one."""
    ranks = np.argsort(np.argsort(column, kind="stable"), kind="stable").astype(float)
    ranks -= ranks.mean()
    return ranks / np.linalg.norm(ranks)
