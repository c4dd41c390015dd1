"""What a machine states of its checks: subjects, requirements, tolerance chains. Found by the machine's name."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from stagecad.parameters.machine import content

if TYPE_CHECKING:
    from designcalc.checks.chain import Chain
    from designcalc.checks.check import CheckFunction
    from designcalc.checks.inputs import DesignInputs
    from designcalc.drive.suspension import Suspension
    from designcalc.errors.dynamic_budget import DynamicBudget
    from designcalc.errors.error_budget import Budget
    from stagecad.parameters.design import Design


@dataclass(frozen=True)
class Studies:
    """What the report of the checks shows besides them.

    Args:
        suspensions: alternatives by rank.
        budgets: error budgets.
        dynamic: dynamic error budgets.
    """

    suspensions: Sequence[Suspension] = ()
    budgets: Sequence[Budget] = ()
    dynamic: Sequence[DynamicBudget] = ()


def _nothing(design: Design) -> tuple[str, ...]:
    return ()


def _no_studies(r: DesignInputs) -> Studies:
    return Studies()


def _no_values(r: DesignInputs) -> dict[str, float | None]:
    return {}


@dataclass(frozen=True)
class Subjects:
    """Checks of a kind of machine.

    Args:
        checks: of a design by subject, in the order of the report.
        chains: tolerance chains of a design.
        scaled_masses: masses of a design, given another one that it differs from by tolerances, and that one's.
        changed_masses: the same for a design with any other values, for a search.
        mass_keys: beginnings of the keys that these masses depend on.
        requirements: names that checks refer to, with their text.
        not_made: subjects of alternatives that are not made: their tolerances do not matter.
        studies: for the report.
        procedure_values: calculated numbers of the assembly procedure.
        figures: names of the figures of the checks (`workbench.figures.checks`) that a design has.
        experiments: names of the friction experiments of the thesis that are run with the design's values.
    """

    checks: Mapping[str, Callable[[Design], list[CheckFunction]]]
    chains: Callable[[Design], tuple[Chain, ...]]
    scaled_masses: Callable[[Design, Design, Any], Any]
    changed_masses: Callable[[Design, Design, Any], Any]
    mass_keys: tuple[str, ...] = ()
    requirements: Mapping[str, str] = field(default_factory=dict)
    not_made: tuple[str, ...] = ()
    studies: Callable[[DesignInputs], Studies] = _no_studies
    procedure_values: Callable[[DesignInputs], dict[str, float | None]] = _no_values
    figures: Callable[[Design], tuple[str, ...]] = _nothing
    experiments: tuple[str, ...] = ()


def subjects_of(design: Design) -> Subjects:
    """The checks of a design's machine."""
    return content("designcalc", design.machine, "subjects").SUBJECTS
