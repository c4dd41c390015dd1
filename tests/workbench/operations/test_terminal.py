"""What a user is told: progress, waits of the CAD kernel, designs that it refuses; statements of an identification."""

import io
import json
import pickle
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest
from rich.console import Console
from rich.progress import Progress

import workbench.cli.commands.parts as parts_command
from sim.effects.catalogue import library
from stagecad.parameters.design import Design
from stagecad.parameters.errors import PartError
from stagecad.parameters.load import load_design
from stagecad.solids.artefacts.part import CRASHED
from stagecad.solids.artefacts.store import ArtefactStore, DamagedError, write_stored
from sysid.compare import Comparison
from sysid.diagnose import Diagnosis, diagnose
from sysid.diagnosis.decision import Decision, FreeCurve
from sysid.diagnosis.ledger import Ledger
from sysid.estimation.misfit import ChannelMisfit
from workbench import cli
from workbench.cli.commands.parts import KERNEL
from workbench.cli.console import rich_table, search_progress, show
from workbench.cli.options import Run
from workbench.operations import parts
from workbench.operations.measurement import statements, tables
from workbench.operations.parts import MOST_NAMED, refusal_line
from workbench.operations.result import plain_table
from workbench.operations.templates import fresh_copy


def test_a_bar_counts_what_is_done_and_then_runs_on() -> None:
    now = 0.0
    with Progress(console=Console(file=io.StringIO()), get_time=lambda: now, auto_refresh=False) as progress:
        show = search_progress(progress, "afterwards")
        assert progress.tasks[0].total is None
        seen = []
        for count in range(3):
            now += 5.0
            show(f"effect {count}", count, 2)
            (task,) = progress.tasks
            seen.append((task.description, task.completed, task.total, task.elapsed))
    assert seen == [("effect 0", 0, 2, 5.0), ("effect 1", 1, 2, 10.0), ("afterwards", 0, None, 15.0)]


@pytest.mark.slow
def test_a_diagnosis_knows_from_the_first_step_how_many_it_counts(tmp_path: Path) -> None:
    steps: list[tuple[str, int, int]] = []
    found = diagnose(fresh_copy(tmp_path / "rig"), progress=lambda *step: steps.append(step))
    assert len({total for _, _, total in steps}) == 1
    total = steps[0][2]
    assert [count for _, count, _ in steps] == list(range(total + 1))
    # The screening is counted: each effect is scored, and the promising ones are fitted.
    assert found.best.name in [name for name, _, _ in steps]
    assert steps[-1] == ("", total, total)


def test_what_cannot_be_counted_shows_that_it_runs_on_a_terminal_alone(tmp_path, monkeypatch, command) -> None:
    folder = fresh_copy(tmp_path / "rig")
    assert "fitting the model" not in command("compare", folder, "--no-figures").err
    monkeypatch.setenv("FORCE_COLOR", "1")
    assert "fitting the model as it stands" in command("compare", folder, "--no-figures").err
    assert "fitting the model without viscous" in command("add", folder, "--drop", "viscous").err


def test_changes_of_a_refusal_are_of_the_part_first_and_counted() -> None:
    design = load_design(None, ["stage.thickness=13 mm", "tip.hub_diameter=24 mm"], rules=False)
    error = pickle.loads(pickle.dumps(PartError("tip", design, "StdFail_NotDone: BRep_API: command not done")))
    line = refusal_line(error)
    assert line is not None
    assert "no valid solid of 'tip' with tip.hub_diameter = 24 mm (packaged: 22 mm), stage.thickness = 13 mm" in line
    assert "StdFail_NotDone" in line
    keys = [entry.key for entry in load_design().entries if entry.unit == "mm" and entry.key.startswith("base.")][:9]
    packaged = load_design()
    design = load_design(None, [f"{key}={1.01 * packaged.value(key):.6g} mm" for key in keys], rules=False)
    line = refusal_line(PartError("base", design, "failed"))
    assert line.count("(packaged: ") == MOST_NAMED and " more; bring them" in line


def test_the_packaged_design_is_a_fault_of_the_program(design: Design) -> None:
    assert refusal_line(PartError("tip", design, "failed")) is None
    # A part of one's own is no part of the packaged design.
    assert refusal_line(PartError("bracket", design, "not meshed")) == "part 'bracket': not meshed"
    assert refusal_line(PartError("tip", design, CRASHED)) == f"part 'tip': {CRASHED}; is there enough memory?"


def test_the_command_ends_with_that_line(monkeypatch: pytest.MonkeyPatch, command: Any) -> None:
    def refused(*arguments: object) -> None:
        raise PartError("tip", load_design(None, ["tip.hub_diameter=24 mm"]), "failed")

    monkeypatch.setattr(parts_command, "parts", refused)
    said = command("parts", status=2).err
    assert said.startswith("stagecad: thesis.toml: the CAD kernel makes no valid solid of 'tip'")


@pytest.mark.slow
def test_what_no_rule_forbids_and_the_kernel_refuses(tmp_path: Path, command: Any) -> None:
    """Slots of the clamps that cut the base in two."""
    said = command.refused("parts", "base", "--set", "base.clamp_reach=347.2 mm", "--out", tmp_path)
    assert "'base' with base.clamp_reach = 347.2 mm (packaged: 69.5 mm)" in said
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("cached", "terminal", "notes"), [(False, True, 1), (False, False, 0), (True, True, 0)])
def test_the_wait_is_told_on_a_terminal_before_the_kernel_begins(monkeypatch, capsys, cached, terminal, notes):
    stored, made = object(), object()
    monkeypatch.setattr(parts, "find_machine", lambda design: stored if cached else None)
    monkeypatch.setattr(parts, "build_machine", lambda design, store, advance: made)
    monkeypatch.setattr(parts, "part_names", lambda design: ("tip",))
    bar = Progress(console=Console(file=io.StringIO()), disable=not terminal)
    monkeypatch.setattr(Run, "progress", lambda run: bar)
    with Run(None, (), Path("build"), None).reporting(note=KERNEL) as report:
        machine = parts.built_machine(cast(Any, None), report)
    assert machine is (stored if cached else made)
    assert capsys.readouterr().err.count("Ctrl-C") == notes


def test_every_damaged_artefact_is_made_again(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    store = ArtefactStore(tmp_path / "cache")

    def write() -> list[str]:
        modules = ("stagecad.solids.modelling.frame",)
        entries = {
            f"{name}.txt": store.make(name, object(), modules, lambda _, folder, name=name: _text(folder, name))
            for name in ("one", "two", "three")
        }
        for name in damaged:
            entries[name].path(name).write_text("damaged")
        damaged.clear()
        return write_stored(tmp_path / "out", entries)

    damaged = ["one.txt", "three.txt"]
    parts.with_repair(store, write)
    assert [(tmp_path / "out" / f"{name}.txt").read_text() for name in ("one", "two", "three")] == ["good"] * 3
    assert caplog.messages == ["a stored result was damaged; it is made again"] * 2


def test_a_cache_that_never_keeps_what_it_stores_is_one_line(tmp_path: Path) -> None:
    entry: Any = SimpleNamespace(key="a")
    store: Any = SimpleNamespace(folder=tmp_path, drop=lambda entry: None)

    def write() -> None:
        raise DamagedError(entry)

    with pytest.raises(OSError, match="does not keep what is written to it"):
        parts.with_repair(store, write)


def _text(folder: Path, name: str) -> None:
    (folder / f"{name}.txt").write_text("good")


SETTLED = {"value": 1.2, "unit": "N", "low": 1.1, "high": 1.3}
VARIANTS = ("", "position_dependent_friction:gradient", "presliding:free_maxwell_slip", "stribeck:rational")


def _diagnosis(
    verdict: str, curve: FreeCurve | None, named: tuple[str, float] | None, left: float = 1.0, source: str = "given"
) -> Diagnosis:
    """A diagnosis of the experiment `rig` with this decision; nothing else of it is read."""
    best: Any = SimpleNamespace() if verdict == "missing-effect" else None
    noise = {"friction_force": SimpleNamespace(source=source)}
    problem = SimpleNamespace(experiment=SimpleNamespace(folder=Path("rig")), noise=noise)
    ledger = cast(Ledger, SimpleNamespace(established=(), entries=()))
    decision = vars(Decision(verdict, best, ledger, "a reason", curve, named))
    found = {"effect": "cable_spring" if best else None, "unexplained_share": left, "maps": ()}
    return cast(Diagnosis, SimpleNamespace(problem=problem, **decision, **found))


@pytest.mark.parametrize(("rotary", "unit"), [(False, "N*s/m"), (True, "N*m*s/rad")])
def test_a_value_beyond_its_range_is_in_the_unit_of_the_axis(rotary: bool, unit: str) -> None:
    effect = library()["viscous"]
    trial = SimpleNamespace(effect=effect, public_name="viscous", reductions=(0.0, 0.5))
    problem = SimpleNamespace(experiment=SimpleNamespace(rig=SimpleNamespace(rotary=rotary)), custom=())
    found = SimpleNamespace(unexplained_share=1.0, best=None, trials=[trial], problem=problem)
    (line,) = statements.unphysical_statements(cast(Diagnosis, found))
    assert line.endswith(f"only with a coefficient below 0 {unit}, which is not physical.")


@pytest.mark.parametrize("percent", [-998.0, 40.0, float("nan")])
def test_a_negative_fit_is_explained(percent: float) -> None:
    error = ChannelMisfit(1.0, 50.0, percent, 100)
    found = cast(Comparison, SimpleNamespace(fit={"position": error}, validate={"position": error}, maps=()))
    assert ("A fit below 0 %" in statements.comparison_statement(found)) == (percent < 0.0)


@pytest.mark.parametrize(
    "coordinate, fitted", [("acceleration", "rig.mass"), ("velocity", "rig.mass"), ("acceleration", "coulomb.force")]
)
def test_a_mass_that_may_be_shifted_is_to_be_stated(coordinate: str, fitted: str) -> None:
    found: Any = _diagnosis("unexplained", None, None)
    found.maps = (SimpleNamespace(coordinate=coordinate, share=0.5),)
    found.problem.experiment.rig = SimpleNamespace(rotary=True)
    found.problem.start = SimpleNamespace(unknowns=(SimpleNamespace(key=fitted),))
    shifted = coordinate == "acceleration" and fitted == "rig.mass"
    assert ("state the inertia under [rig.known]" in statements.next_step_statement(found)) == shifted


def test_shares_of_rivals_and_of_nothing_in_the_statement_of_a_misfit() -> None:
    found = _diagnosis("unexplained", FreeCurve("position", 0.99), ("cable_spring", 0.6))
    assert statements.rivals_text(found) == (
        "a free curve, a force of position, explains 99 % of the misfit, the best named effect, cable_spring, 60 %"
    )
    assert statements.rivals_text(found) in statements.diagnosis_statement(found)
    assert "'stagecad add rig cable_spring'" in statements.next_step_statement(found)
    assert "a force of position ([model] custom)" in statements.next_step_statement(found)
    assert "[noise]" not in statements.next_step_statement(found)
    assert "[noise]" in statements.next_step_statement(_diagnosis("unexplained", None, None, source="difference"))
    found = _diagnosis("unexplained", FreeCurve("contact_age", 0.01, "friction level"), ("viscous", 0.5))
    assert statements.rivals_text(found) == "the best named effect, viscous, explains 50 % of the misfit"
    found = _diagnosis("unexplained", FreeCurve("position", 0.53), ("sensor_nonlinearity", 0.52))
    assert "free curve" not in statements.rivals_text(found) and "custom" not in statements.next_step_statement(found)
    nothing = _diagnosis("unexplained", FreeCurve("contact_age", 0.01, "friction level"), None)
    assert statements.rivals_text(nothing) == "" and "a reason" in statements.diagnosis_statement(nothing)
    assert statements.next_step_statement(nothing) == ""


def test_the_statement_begins_with_the_effect_that_is_possible() -> None:
    found: Any = _diagnosis("unexplained", None, ("sensor_nonlinearity", 0.5))
    refused, possible = (
        SimpleNamespace(
            name=name, state=state, reason="half of its gain would not be significant", is_another_law=False
        )
        for name, state in (("run_in", "refused"), ("constant_bias", "possible"))
    )
    other = SimpleNamespace(name="cable_spring", state="possible", reason="its law is another", is_another_law=True)
    found.ledger.entries = (other, possible, refused)
    assert statements.diagnosis_statement(found).startswith(
        "No effect is certain: constant_bias is possible, but half of its gain would not be significant; the best named"
    )
    assert "'stagecad add rig constant_bias'" in statements.next_step_statement(found)
    found.ledger.entries = (other, refused)
    assert statements.diagnosis_statement(found).startswith("No effect of the library explains the residual: the best")


@pytest.mark.parametrize(
    ("fit", "held_out", "words"),
    [(1.0, 1.1, ""), (1.7, 1.8, " The error is 1.80 ×"), (1.03, 1.67, "and 1.03 × on those of the fit: they differ")],
)
def test_an_adequate_model_states_an_error_above_the_noise(fit: float, held_out: float, words: str) -> None:
    found: Any = _diagnosis("adequate", None, None)
    found.before_fit, found.before_validate = ({"force": SimpleNamespace(over_noise=x)} for x in (fit, held_out))
    statement = statements.diagnosis_statement(found)
    assert statement.startswith("Nothing is missing: a reason.") and words in statement
    assert ("The error is" in statement) == bool(words)


def test_the_next_command_adds_the_named_effect_first_and_quotes_its_folder() -> None:
    text = statements.next_step_statement(
        _diagnosis("missing-effect", FreeCurve("position", 0.99), ("cable_spring", 0.6), 0.4)
    )
    assert "'stagecad add rig cable_spring', then 'stagecad diagnose rig'" in text
    assert statements.next_step_statement(_diagnosis("missing-effect", None, None, 0.01)) == ""
    assert statements.next_step_statement(_diagnosis("adequate", None, None, 0.0)) == ""
    assert f"stagecad add {statements.in_command(Path('my rig'))} viscous" == 'stagecad add "my rig" viscous'
    assert statements.in_command(Path("rig")) == "rig"
    row = {"effect": "viscous", "expected_reduction": 0.0, "reduction": -0.0004, "p_value": 0.9, "over_noise": 3.0}
    shares = {f"presliding.share_{k}": {"value": float(k > 1), "unit": "1", "at_bound": k < 2} for k in (1, 2)}
    _, _, reached, *_, values = tables.ranking_table([row | {"parameters": shares}], 1).rows[0]
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
    table = tables.parameter_table({"coulomb.force": quantity})
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
    assert tables.revision_text({"rung": number, "added": added, "removed": removed}, "the beginning") == text


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
    ranking = tables.ranking_table([row | {"effect": name, "parameters": values} for name in names], 3)
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
    show(cast(Run, shown), [tables.ladder_table(rungs)])
    assert all(f" {name} " in stream.getvalue() for name in VARIANTS[1:])
    long = "clearance_of_the_" * 6 + "guide"
    for table in (
        plain_table("", "parameter|value|meaning", [(long, "12 mm", "gap")]),
        tables.parameter_table({long: SETTLED}),
    ):
        stream.truncate(0)
        show(cast(Run, shown), [table])
        assert long in stream.getvalue().splitlines() or f"{long}  12 mm  gap" in stream.getvalue()


def test_a_simulation_that_diverged_is_shown_as_failed() -> None:
    lost = {"fit": {"position": {"rms": {"value": None, "unit": "m"}, "over_noise": None}}}
    found = tables.simulation_table({"form": "force balance", "free_run": lost, "horizon": {"1 s": lost}})
    assert [list(row) for row in found.as_json()["rows"]] == [["fit", "position", "failed", "", "failed", ""]]
