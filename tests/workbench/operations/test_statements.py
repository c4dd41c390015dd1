"""Statements and tables of an identification: the same in the terminal and in the report."""

import io
import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest
from rich.console import Console

from sim.effects.catalogue import library
from sysid.compare import Comparison
from sysid.diagnose import Diagnosis
from sysid.diagnosis.decision import Decision, FreeCurve
from sysid.diagnosis.ledger import Ledger
from sysid.estimation.misfit import ChannelMisfit
from workbench import cli
from workbench.cli.console import rich_table, show
from workbench.cli.options import Run
from workbench.operations.measurement.statements import (
    comparison_statement,
    diagnosis_statement,
    in_command,
    next_step_statement,
    rivals_text,
    unphysical_statements,
)
from workbench.operations.measurement.tables import (
    ladder_table,
    parameter_table,
    ranking_table,
    revision_text,
    simulation_table,
)
from workbench.operations.result import plain_table
from workbench.operations.templates import fresh_copy

SETTLED = {"value": 1.2, "unit": "N", "low": 1.1, "high": 1.3}
VARIANTS = ("", "position_dependent_friction:gradient", "presliding:free_maxwell_slip", "stribeck:rational")


def _diagnosis(
    verdict: str, curve: FreeCurve | None, named: tuple[str, float] | None, left: float = 1.0, source: str = "given"
) -> Diagnosis:
    """A diagnosis of the experiment `rig` with this decision; nothing else of it is read."""
    best: Any = SimpleNamespace() if verdict == "missing-effect" else None
    noise = {"friction_force": SimpleNamespace(source=source)}
    problem = SimpleNamespace(experiment=SimpleNamespace(folder=Path("rig")), noise=noise)
    ledger = cast(Ledger, SimpleNamespace(established=()))
    decision = vars(Decision(verdict, best, ledger, "a reason", curve, named))
    found = {"effect": "cable_spring" if best else None, "unexplained_share": left, "maps": ()}
    return cast(Diagnosis, SimpleNamespace(problem=problem, **decision, **found))


@pytest.mark.parametrize(("rotary", "unit"), [(False, "N*s/m"), (True, "N*m*s/rad")])
def test_a_value_beyond_its_range_is_in_the_unit_of_the_axis(rotary: bool, unit: str) -> None:
    effect = library()["viscous"]
    trial = SimpleNamespace(effect=effect, public_name="viscous", reductions=(0.0, 0.5))
    problem = SimpleNamespace(experiment=SimpleNamespace(rig=SimpleNamespace(rotary=rotary)), custom=())
    found = SimpleNamespace(unexplained_share=1.0, best=None, trials=[trial], problem=problem)
    (line,) = unphysical_statements(cast(Diagnosis, found))
    assert line.endswith(f"only with a coefficient below 0 {unit}, which is not physical.")


@pytest.mark.parametrize("percent", [-998.0, 40.0, float("nan")])
def test_a_negative_fit_is_explained(percent: float) -> None:
    error = ChannelMisfit(1.0, 50.0, percent, 100)
    found = cast(Comparison, SimpleNamespace(fit={"position": error}, validate={"position": error}, maps=()))
    assert ("A fit below 0 %" in comparison_statement(found)) == (percent < 0.0)


@pytest.mark.parametrize(
    "coordinate, fitted", [("acceleration", "rig.mass"), ("velocity", "rig.mass"), ("acceleration", "coulomb.force")]
)
def test_a_mass_that_may_be_shifted_is_to_be_stated(coordinate: str, fitted: str) -> None:
    found: Any = _diagnosis("unexplained", None, None)
    found.maps = (SimpleNamespace(coordinate=coordinate, share=0.5),)
    found.problem.experiment.rig = SimpleNamespace(rotary=True)
    found.problem.start = SimpleNamespace(unknowns=(SimpleNamespace(key=fitted),))
    shifted = coordinate == "acceleration" and fitted == "rig.mass"
    assert ("state the inertia under [rig.known]" in next_step_statement(found)) == shifted


def test_shares_of_rivals_and_of_nothing_in_the_statement_of_a_misfit() -> None:
    found = _diagnosis("unexplained", FreeCurve("position", 0.99), ("cable_spring", 0.6))
    assert rivals_text(found) == (
        "a free curve, a force of position, explains 99 % of the misfit, the best named effect, cable_spring, 60 %"
    )
    assert rivals_text(found) in diagnosis_statement(found)
    assert "'stagecad add rig cable_spring'" in next_step_statement(found)
    assert "a force of position ([model] custom)" in next_step_statement(found)
    assert "[noise]" not in next_step_statement(found)
    assert "[noise]" in next_step_statement(_diagnosis("unexplained", None, None, source="difference"))
    found = _diagnosis("unexplained", FreeCurve("contact_age", 0.01, "friction level"), ("viscous", 0.5))
    assert rivals_text(found) == "the best named effect, viscous, explains 50 % of the misfit"
    nothing = _diagnosis("unexplained", FreeCurve("contact_age", 0.01, "friction level"), None)
    assert rivals_text(nothing) == "" and "a reason" in diagnosis_statement(nothing)
    assert next_step_statement(nothing) == ""


@pytest.mark.parametrize(
    ("fit", "held_out", "words"),
    [(1.0, 1.1, ""), (1.7, 1.8, " The error is 1.80 ×"), (1.03, 1.67, "and 1.03 × on those of the fit: they differ")],
)
def test_an_adequate_model_states_an_error_above_the_noise(fit: float, held_out: float, words: str) -> None:
    found: Any = _diagnosis("adequate", None, None)
    found.before_fit, found.before_validate = ({"force": SimpleNamespace(over_noise=x)} for x in (fit, held_out))
    statement = diagnosis_statement(found)
    assert statement.startswith("Nothing is missing: a reason.") and words in statement
    assert ("The error is" in statement) == bool(words)


def test_the_next_command_adds_the_named_effect_first_and_quotes_its_folder() -> None:
    text = next_step_statement(_diagnosis("missing-effect", FreeCurve("position", 0.99), ("cable_spring", 0.6), 0.4))
    assert "'stagecad add rig cable_spring', then 'stagecad diagnose rig'" in text
    assert next_step_statement(_diagnosis("missing-effect", None, None, 0.01)) == ""
    assert next_step_statement(_diagnosis("adequate", None, None, 0.0)) == ""
    assert f"stagecad add {in_command(Path('my rig'))} viscous" == 'stagecad add "my rig" viscous'
    assert in_command(Path("rig")) == "rig"
    row = {"effect": "viscous", "expected_reduction": 0.0, "reduction": -0.0004, "p_value": 0.9, "over_noise": 3.0}
    shares = {f"presliding.share_{k}": {"value": float(k > 1), "unit": "1", "at_bound": k < 2} for k in (1, 2)}
    _, _, reached, *_, values = ranking_table([row | {"parameters": shares}], 1).rows[0]
    assert (reached, values) == ("0.0 %", "share 2 1")


@pytest.mark.parametrize(
    ("quantity", "interval", "remark"),
    [
        (SETTLED, "1.1 N .. 1.3 N", ""),
        ({**SETTLED, "low": -0.1}, "-100 mN .. 1.3 N", "not distinguishable from zero"),
        ({**SETTLED, "low": None, "high": None}, "", "not identifiable from these records"),
        ({**SETTLED, "high": None}, "", "not identifiable from these records"),
        ({**SETTLED, "low": None, "high": None, "at_bound": True}, "", "at its bound"),
        ({**SETTLED, "at_bound": True}, "1.1 N .. 1.3 N", "at its bound"),
    ],
)
def test_a_value_has_its_interval_and_a_remark(quantity, interval, remark):
    table = parameter_table({"coulomb.force": quantity})
    assert table.rows == (("coulomb.force", "1.2 N", interval, *([remark] if remark else [])),)
    columns = [str(column.header) for column in rich_table(table).columns]
    assert columns == ["parameter", "value", "95 % interval", *(["remark"] if remark else [])]


@pytest.mark.parametrize(
    ("number", "added", "removed", "text"),
    [
        (0, [], [], "the beginning"),
        (1, ["stribeck"], [], "stribeck"),
        (2, ["presliding", "stribeck"], ["coulomb"], "presliding, stribeck, without coulomb"),
        (3, [], ["viscous", "backlash"], "without viscous and backlash"),
        (4, [], [], "[model] edited by hand"),
    ],
)
def test_revision_text(number: int, added: list[str], removed: list[str], text: str) -> None:
    assert revision_text({"rung": number, "added": added, "removed": removed}, "the beginning") == text


def test_a_dropped_effect_is_listed_as_removed(tmp_path: Path, command) -> None:
    folder = fresh_copy(tmp_path / "rig")
    said = command("add", folder, "--drop", "viscous", "--json")
    assert "Rung 001: - viscous" in said.err
    document = json.loads(said.out)
    assert (document["added"], document["removed"]) == ([], ["viscous"])
    said = command("ladder", folder, "--out", tmp_path / "out", "--json")
    assert "without viscous" in said.err and "by hand" not in said.err
    assert [rung["removed"] for rung in json.loads(said.out)] == [[], ["viscous"]]
    report = tmp_path / "out" / "rig" / "report.html"
    assert "without viscous" in report.read_text(encoding="utf-8")
    # The report follows each change of the model.
    assert cli.run(["add", str(folder), "stribeck", "--out", str(tmp_path / "out")]) == 0
    assert "in 2 steps" in report.read_text(encoding="utf-8")
    for left in ("in one step", "model and measurement"):
        assert cli.run(["add", str(folder), "--undo", "--out", str(tmp_path / "out")]) == 0
        assert left in report.read_text(encoding="utf-8")
    assert "The ladder" not in report.read_text(encoding="utf-8")
    assert cli.run(["add", str(folder), "--drop", "viscous", "--out", str(tmp_path / "other")]) == 0
    assert not (tmp_path / "other").exists()


def test_no_name_and_no_quantity_is_cut_on_a_terminal_of_eighty_letters():
    names = ("position_dependent_friction", "magnetic_cogging", "sensor_quantisation")
    row = {"expected_reduction": 0.9, "p_value": {"below": 0.001}, "over_noise": 1.2, "reduction": 0.5}
    row |= {"angle": {"value": 1.0}, "validate_error": {"value": 0.475, "unit": "N"}}
    values = {"a.phase": {"value": -2.929, "unit": "rad"}, "a.pitch": {"value": 927.3e-6, "unit": "m"}}
    ranking = ranking_table([row | {"effect": name, "parameters": values} for name in names], 3)
    stream = io.StringIO()
    shown = SimpleNamespace(console=Console(file=stream, width=80), echo=lambda text: stream.write(f"{text}\n"))
    show(cast(Run, shown), [ranking])
    lines = stream.getvalue().splitlines()
    assert max(map(len, lines)) <= 80 and "…" not in stream.getvalue()
    for name in names:
        (first,) = (line for line in lines if line.startswith(f"{name} "))
        assert "475 mN" in first and "< 0.001" in first
        assert f"{name}: phase -2.929 rad; pitch 927.3 um" in lines
    assert str(rich_table(ranking, 140).columns[-1].header) == "values"
    error = {"friction_force": {"rms": {"value": 0.3394, "unit": "N"}, "over_noise": 102.0, "fit": 90.0}}
    rungs = [
        {"rung": k, "added": [name], "before": {"fit": error, "validate": error}} for k, name in enumerate(VARIANTS)
    ]
    stream.truncate(0)
    show(cast(Run, shown), [ladder_table(rungs)])
    assert all(f" {name} " in stream.getvalue() for name in VARIANTS[1:])
    long = "clearance_of_the_" * 6 + "guide"
    for table in (
        plain_table("", "parameter|value|meaning", [(long, "12 mm", "gap")]),
        parameter_table({long: SETTLED}),
    ):
        stream.truncate(0)
        show(cast(Run, shown), [table])
        assert long in stream.getvalue().splitlines() or f"{long}  12 mm  gap" in stream.getvalue()


def test_a_simulation_that_diverged_is_shown_as_failed() -> None:
    lost = {"fit": {"position": {"rms": {"value": None, "unit": "m"}, "over_noise": None}}}
    found = simulation_table({"form": "force balance", "free_run": lost, "horizon": {"1 s": lost}})
    assert [list(row) for row in found.as_json()["rows"]] == [["fit", "position", "failed", "", "failed", ""]]
