"""The thesis's experiments and the stage's studies on one design: results and features."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from sim.experiments.friction_models import Friction
from stagecad.parameters.errors import InputError

if TYPE_CHECKING:
    from stagecad.parameters.design import Design
    from stagecad.parameters.mass_properties import BodyMasses

EXPERIMENTS = ("tip", "presliding", "hysteresis", "stick-slip", "stage")
EXTRA = ("passivity",)
"""Run only when named."""

FeaturePath = tuple[str, ...]
"""Experiment, model or study, perhaps case, and feature."""


@dataclass(frozen=True)
class Selection:
    """Selection of the simulations: experiments, friction models, the moving mass as given, the stage's studies."""

    names: tuple[str, ...]
    models: tuple[str, ...]
    mass: str | None
    studies: tuple[str, ...]

    @property
    def friction_experiments(self) -> tuple[str, ...]:
        """The experiments on one body with friction: those that need a mass."""
        return tuple(name for name in self.names if name not in ("tip", "stage"))

    def reads(self, key: str) -> bool:
        """Whether any of the experiments may depend on a parameter of the design."""
        if key == "friction.mass" and self.mass is not None:
            return False
        return any(reads(name, key) for name in self.names)


def reads(experiment: str, key: str) -> bool:
    """Whether an experiment may depend on a parameter: the friction ones on their table, the stage on all."""
    if experiment == "tip":
        return key in ("actuator.piezo_spacing", "actuator.tip_height")
    return experiment == "stage" or key.startswith("friction.")


def friction_of(design: Design) -> Friction:
    """The design's table `friction` (the thesis's Table 3 unless set otherwise), SI."""
    return Friction(**{field.name: getattr(design.friction, field.name) for field in dataclasses.fields(Friction)})


def moving_mass(design: Design, given: str | None) -> float:
    """Mass of the body in the friction experiments, kg.

    Args:
        design: the design.
        given: None for `friction.mass` (the thesis's 1 kg), `design` for the design's moving body with its payload,
            or a quantity.
    """
    if given is None:
        return design.friction.mass
    if given != "design":
        return parse_mass(given)
    from designcalc.checks.inputs import DesignInputs
    from designcalc.friction_stage.physics.loads import moved_mass
    from stagecad.friction_stage.assembly.machine import body_masses

    return moved_mass(DesignInputs(design, body_masses(design)))


def parse_mass(text: str) -> float:
    """Mass written as a quantity, kg.

    Raises:
        InputError: no mass, or none above zero.
    """
    from stagecad.parameters.units import parse_quantity

    mass = parse_quantity(text, "kg", "--mass")
    if not 0.0 < mass < float("inf"):
        raise InputError(f"--mass {text}: must be positive and finite")
    return mass


def simulate_experiment(
    design: Design, name: str, models: tuple[str, ...], mass: float, advance: Callable[[], None] = lambda: None
) -> dict[str, Any]:
    """Results of one experiment (not `stage`): by model (and case or motion); those of `tip` by stroke and phase.

    Args:
        design: the design.
        name: of the experiment.
        models: friction models.
        mass: kg.
        advance: called after each model.
    """
    if name == "tip":
        from sim.experiments.tip import PHASES, STROKES, tip_ellipse

        spacing, height = design.actuator.piezo_spacing * 1e-3, design.actuator.tip_height * 1e-3
        ellipses = {
            stroke: {phase: tip_ellipse(spacing, height, size, lag) for phase, lag in PHASES.items()}
            for stroke, size in STROKES.items()
        }
        advance()
        return ellipses
    friction = friction_of(design)
    results: dict[str, Any] = {}
    for model in models:
        if name == "presliding":
            from sim.experiments.presliding import presliding

            results[model] = presliding(friction, model, mass)
        elif name == "stick-slip":
            from sim.experiments.stick_slip import stick_slip

            results[model] = stick_slip(friction, model, mass)
        elif name == "hysteresis":
            from sim.experiments.hysteresis import CASES, hysteresis

            results[model] = {case: hysteresis(friction, model, case) for case in CASES}
        else:
            from sim.experiments.passivity import MOTIONS, audit

            results[model] = {motion: audit(friction, model, motion) for motion in MOTIONS}
        advance()
    return results


def simulate_selection(design: Design, selection: Selection, masses: BodyMasses | None = None) -> dict[str, Any]:
    """Results of all selected experiments in this process, by experiment.

    Args:
        design: the design.
        selection: of experiments, models and studies.
        masses: of the moving bodies, for the stage; computed from the solids when left out.
    """
    mass = moving_mass(design, selection.mass) if selection.friction_experiments else 1.0
    results: dict[str, Any] = {}
    for name in selection.names:
        if name == "stage":
            from sim.friction_stage.studies import STUDIES, run_serially, stage_drive
            from stagecad.friction_stage.assembly.machine import body_masses

            drive = stage_drive(design, masses or body_masses(design))
            results[name] = {study: STUDIES[study](drive, run_serially) for study in selection.studies}
        else:
            results[name] = simulate_experiment(design, name, selection.models, mass)
    return results


def features_of(results: Mapping[str, Any]) -> dict[str, Any]:
    """Features of results, nested as they are, as JSON quantities; None where a result has no such feature."""
    return {
        name: features_of(found)
        if isinstance(found, Mapping)
        else {
            key: None if feature is None else {"value": feature[0], "unit": feature[1]}
            for key, feature in found.features().items()
        }
        for name, found in results.items()
    }


def flat_features(features: Mapping[str, Any], before: FeaturePath = ()) -> dict[FeaturePath, Any]:
    """Every feature, a quantity or None, by its path."""
    found: dict[FeaturePath, Any] = {}
    for name, inner in features.items():
        if isinstance(inner, Mapping) and "unit" not in inner:
            found |= flat_features(inner, (*before, name))
        else:
            found[(*before, name)] = inner
    return found
