"""Statements of a diagnosis: shares of the rivals, and what to do next."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

from sysid.diagnose import Diagnosis
from sysid.diagnosis.decision import Decision, FreeCurve
from sysid.diagnosis.ledger import Ledger
from workbench.operations.measurement.statements import (
    diagnosis_statement,
    in_command,
    next_step_statement,
    rivals_text,
)


def _diagnosis(
    verdict: str, curve: FreeCurve | None, named: tuple[str, float] | None, left: float = 1.0, source: str = "given"
) -> Diagnosis:
    """A diagnosis of the experiment `rig` with this decision; nothing else of it is read."""
    best: Any = SimpleNamespace() if verdict == "missing-effect" else None
    problem = SimpleNamespace(
        experiment=SimpleNamespace(folder=Path("rig")), noise={"friction_force": SimpleNamespace(source=source)}
    )
    decision = Decision(verdict, best, cast(Ledger, None), "a reason", curve, named)
    found = SimpleNamespace(
        problem=problem,
        decision=decision,
        verdict=verdict,
        reason="a reason",
        best=best,
        ledger=SimpleNamespace(established=()),
        effect="cable_spring" if best else None,
        unexplained_share=left,
        maps=(),
    )
    return cast(Diagnosis, found)


def test_an_unexplained_misfit_states_the_shares_of_the_rivals() -> None:
    found = _diagnosis("unexplained", FreeCurve("position", 0.99), ("cable_spring", 0.6))
    assert rivals_text(found) == (
        "a free curve, a force of position, explains 99 % of the misfit, the best named effect, cable_spring, 60 %"
    )
    assert rivals_text(found) in diagnosis_statement(found)
    assert "'stagecad add rig cable_spring'" in next_step_statement(found)
    assert "a force of position ([model] custom)" in next_step_statement(found)
    assert "[noise]" not in next_step_statement(found)


def test_an_estimated_noise_may_be_stated() -> None:
    assert "[noise]" in next_step_statement(_diagnosis("unexplained", None, None, source="difference"))


def test_shares_of_nothing_are_not_stated() -> None:
    found = _diagnosis("unexplained", FreeCurve("contact_age", 0.01, "friction level"), ("viscous", 0.5))
    assert rivals_text(found) == "the best named effect, viscous, explains 50 % of the misfit"
    nothing = _diagnosis("unexplained", FreeCurve("contact_age", 0.01, "friction level"), None)
    assert rivals_text(nothing) == ""
    assert "a reason" in diagnosis_statement(nothing)
    assert next_step_statement(nothing) == ""


def test_the_named_effect_is_added_first_where_more_is_missing() -> None:
    text = next_step_statement(_diagnosis("missing-effect", FreeCurve("position", 0.99), ("cable_spring", 0.6), 0.4))
    assert "'stagecad add rig cable_spring', then 'stagecad diagnose rig'" in text
    assert next_step_statement(_diagnosis("missing-effect", None, None, 0.01)) == ""
    assert next_step_statement(_diagnosis("adequate", None, None, 0.0)) == ""


def test_a_folder_with_blanks_is_in_quotes_in_a_printed_command() -> None:
    assert f"stagecad add {in_command(Path('my rig'))} viscous" == 'stagecad add "my rig" viscous'
    assert in_command(Path("rig")) == "rig"
