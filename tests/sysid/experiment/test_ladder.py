"""The ladder: rungs and experiment file in step, whatever happens between two writes; the lock between processes."""

import json
import multiprocessing
import os
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest

import sysid.experiment.ladder as ladder
from sim.effects.catalogue import library
from sim.effects.effect import Effect
from stagecad.parameters.errors import InputError
from sysid.experiment.experiment import Experiment, find_experiment, load_experiment
from sysid.experiment.ladder import append_revision, edited_by_hand, file_lock, history_lock, read_history, undo
from tests.experiments import write_csv
from tests.reference.tables import cases
from tests.refusals import refused

TEXT = """# my rig, spring no. 3
schema = 1

[rig]
kind = "velocity-drive"   # the slow one

[model]
# what we know so far
effects = [
    "coulomb",  # dry
    "viscous",
]

[model.parameters]
"coulomb.force" = {start = "1.2 N", low = "0.1 N", high = inf}  # from last week

[[record]]
file = "fit.csv"     # Monday
role = "fit"

[noise]
friction_force = "0.01 N"  # data sheet
"""


RECORD = '[[record]]\nfile = "fit.csv"\nrole = "fit"\n'
T = np.arange(50) * 0.01


def _rig(folder: Path, text: str = TEXT) -> Experiment:
    write_csv(folder / "fit.csv", {"time": T, "position": 0.01 * np.sin(T), "friction_force": np.cos(T)})
    (folder / "experiment.toml").write_text(text)
    return load_experiment(folder)


def _add(experiment: Experiment, *new: str, starts: dict[str, tuple[float, str]] | None = None) -> ladder.Revision:
    effects = (*experiment.effects, *new)
    starts = starts or {"coulomb.force": (1.3, "N")}
    after = {"before": {"fit": {"rms": np.float64(0.1), "p": float("nan")}}, "parameters": {}}
    before = {"before": {"fit": {"rms": 0.5}}, "parameters": {}}
    return append_revision(experiment, effects, starts, after, before, {"fit": "abc"})


def test_first_rung_keeps_the_model_before_and_every_comment(tmp_path):
    experiment = _rig(tmp_path)
    _add(experiment, "stribeck", starts={"coulomb.force": (1.3, "N"), "stribeck.velocity": (0.002, "m/s")})
    text = experiment.path.read_text()
    for comment in ("my rig, spring no. 3", "the slow one", "what we know so far", "dry", "Monday", "data sheet"):
        assert f"# {comment}" in text
    after = load_experiment(tmp_path)
    assert after.effects == ("coulomb", "viscous", "stribeck")
    assert after.parameters["stribeck.velocity"].start == pytest.approx(0.002)
    # Bounds that the user gave stay.
    setting = after.parameters["coulomb.force"]
    assert (setting.start, setting.low, setting.high) == (1.3, 0.1, float("inf"))
    rungs = read_history(after)
    assert [rung.effects for rung in rungs] == [("coulomb", "viscous"), ("coulomb", "viscous", "stribeck")]
    assert rungs[0].document["before"]["fit"]["rms"] == 0.5
    assert rungs[1].document["added"] == ["stribeck"] and rungs[1].document["records"] == {"fit": "abc"}
    assert rungs[1].document["before"]["fit"] == {"rms": 0.1, "p": None} and not edited_by_hand(after, rungs)


def test_comments_orders_and_new_tables_are_no_edits(tmp_path):
    plain = "\n".join(line for line in TEXT.splitlines() if "coulomb.force" not in line and "parameters" not in line)
    experiment = _rig(tmp_path, plain)
    _add(experiment, "stribeck")
    assert '"coulomb.force" = {start = "1.3 N"}\n\n[[record]]' in experiment.path.read_text()
    (tmp_path / "other").mkdir()
    experiment = _rig(tmp_path / "other")
    _add(experiment, "stribeck")
    experiment.path.write_text(experiment.path.read_text().replace("# dry", "# Coulomb 1785"))
    rung, _ = undo(load_experiment(tmp_path / "other"))
    assert rung.number == 0 and "stribeck" not in rung.effects
    assert "# Coulomb 1785" in experiment.path.read_text()


def test_undo_restores_the_file_byte_for_byte_and_keeps_what_was_edited(tmp_path):
    experiment = _rig(tmp_path)
    _add(experiment, "stribeck")
    second = experiment.path.read_bytes()
    _add(load_experiment(tmp_path), "constant_bias")
    restored, kept = undo(load_experiment(tmp_path))
    assert restored.number == 1 and experiment.path.read_bytes() == second
    assert json.loads(kept.read_text())["added"] == ["constant_bias"]
    undo(load_experiment(tmp_path))
    assert experiment.path.read_text() == TEXT
    refused("nothing to undo", undo, load_experiment(tmp_path))
    # A second climb reuses the number and loses neither.
    _add(load_experiment(tmp_path), "cable_spring")
    undo(load_experiment(tmp_path))
    undone = tmp_path / "ladder" / "undone"
    assert {path.name for path in undone.iterdir()} == {"001-1.json", "001-2.json", "002-1.json"}
    experiment = _rig(tmp_path)
    _add(experiment, "stribeck")
    experiment.path.write_text(experiment.path.read_text().replace("0.01 N", "0.02 N"))
    undo(load_experiment(tmp_path))
    assert experiment.path.read_text() == TEXT.replace("0.01 N", "0.02 N")


def test_undo_refuses_after_an_edit_by_hand_and_add_keeps_that_model(tmp_path):
    experiment = _rig(tmp_path)
    _add(experiment, "stribeck")
    edited = experiment.path.read_text().replace('"viscous",', '"viscous", "cable_spring",')
    experiment.path.write_text(edited)
    refused(r"\[model\] was edited by hand since rung 001", undo, load_experiment(tmp_path))
    assert experiment.path.read_text() == edited
    _add(load_experiment(tmp_path), "constant_bias")
    rungs = read_history(load_experiment(tmp_path))
    assert len(rungs) == 4 and rungs[2].document["edited_by_hand"] and "cable_spring" in rungs[2].effects


def test_undo_says_so_where_the_model_edited_by_hand_is_no_valid_one(tmp_path):
    experiment = _rig(tmp_path)
    _add(experiment, "stribeck", starts={"stribeck.velocity": (0.002, "m/s")})
    edited = "\n".join(line for line in experiment.path.read_text().splitlines() if line.strip(" ,") != '"stribeck"')
    experiment.path.write_text(edited)
    refused(r"stribeck\.velocity", load_experiment, tmp_path)
    refused(r"\[model\] was edited by hand since rung 001", undo, find_experiment(tmp_path))
    assert experiment.path.read_text() == edited
    experiment.path.write_text(edited + "[model\n")
    refused(r"experiment\.toml: ", undo, find_experiment(tmp_path))


def test_add_refuses_a_file_that_changed_during_the_fit_and_leaves_no_folder(tmp_path):
    experiment = _rig(tmp_path)
    experiment.path.write_text(TEXT + "# a thought\n")
    refused("changed while the fit ran", _add, experiment, "stribeck")
    assert read_history(load_experiment(tmp_path)) == []
    assert sorted(path.name for path in tmp_path.iterdir()) == ["experiment.toml", "fit.csv"]


def test_a_core_that_replaces_another_takes_its_settings_along(tmp_path):
    experiment = _rig(tmp_path)
    append_revision(experiment, ("viscous", "presliding"), {}, {}, {}, {})
    after = load_experiment(tmp_path)
    assert after.effects == ("viscous", "presliding") and not after.parameters
    undo(after)
    assert experiment.path.read_text() == TEXT


def test_an_add_stopped_before_its_note_was_removed_keeps_its_rung_although_the_model_is_edited_then(tmp_path):
    experiment = _rig(tmp_path)
    _add(experiment, "stribeck")
    (tmp_path / "ladder" / "pending.json").write_text('{"operation": "add", "rung": 1}')
    experiment.path.write_text(experiment.path.read_text().replace('"stribeck"', '"quadratic_drag"'))
    now = load_experiment(tmp_path)
    assert [rung.number for rung in read_history(now)] == [0, 1]
    refused("edited by hand since rung 001", undo, now)
    assert (tmp_path / "ladder" / "001.json").is_file() and not (tmp_path / "ladder" / "undone").exists()
    _add(load_experiment(tmp_path), "constant_bias")
    added = [rung.effects[2:] for rung in read_history(load_experiment(tmp_path))]
    assert added == [(), ("stribeck",), ("quadratic_drag",), ("quadratic_drag", "constant_bias")]


def test_another_process_waits_and_is_told(tmp_path):
    experiment = _rig(tmp_path)
    code = (
        "import sys; from sysid.experiment.experiment import load_experiment\n"
        "from sysid.experiment.ladder import history_lock\n"
        "with history_lock(load_experiment(sys.argv[1])):\n    print('held', flush=True); sys.stdin.read()"
    )
    root, pipe = Path(ladder.__file__).parents[1], subprocess.PIPE
    words = [sys.executable, "-c", code, str(tmp_path)]
    with subprocess.Popen(words, stdin=pipe, stdout=pipe, text=True, cwd=root) as other:
        assert other.stdout is not None and other.stdout.readline() == "held\n"
        with pytest.raises(InputError, match=f"another run is at work on it .process {other.pid}.; try again"):
            append_revision(experiment, ("coulomb",), {}, {}, {}, {}, timeout=0.2)
        # A process that is killed lets go of the lock.
        other.kill()
        other.wait()
    _add(experiment, "stribeck")


def _climb(folder: str, effect: str) -> None:
    with history_lock(load_experiment(folder), timeout=60.0):
        _add(load_experiment(folder), effect)


def test_two_runs_at_once_lose_nothing(tmp_path):
    _rig(tmp_path)
    context = multiprocessing.get_context("spawn")
    runs = [context.Process(target=_climb, args=(str(tmp_path), name)) for name in ("stribeck", "constant_bias")]
    for run in runs:
        run.start()
    for run in runs:
        run.join(60)
    assert [run.exitcode for run in runs] == [0, 0]
    after = load_experiment(tmp_path)
    assert set(after.effects) == {"coulomb", "viscous", "stribeck", "constant_bias"}
    assert len(read_history(after)) == 3 and not edited_by_hand(after, read_history(after))


@pytest.mark.parametrize(("name", "content", "message"), cases("mistakes", "ladder"))
def test_a_damaged_ladder_says_which_rung(tmp_path, name, content, message):
    _add(_rig(tmp_path), "stribeck")
    (tmp_path / "ladder" / name).write_text(content)
    refused(message, read_history, load_experiment(tmp_path))


@pytest.mark.parametrize(
    "layout",
    [
        f'model = {{effects = ["coulomb"]}}\nschema = 1\nrig = {{kind = "velocity-drive"}}\n{RECORD}',
        f'schema = 1\nrig.kind = "velocity-drive"\nmodel.effects = ["coulomb"]\n{RECORD}',
        TEXT.replace("\n", "\r\n"),
        TEXT.replace(
            '[model.parameters]\n"coulomb.force" = {start = "1.2 N", low = "0.1 N", high = inf}',
            '[model.parameters.coulomb.force]\nstart = "1.2 N"',
        ),
    ],
    ids=["inline", "dotted", "crlf", "nested"],
)
def test_other_layouts_of_the_same_file(tmp_path, layout):
    experiment = _rig(tmp_path)
    experiment.path.write_bytes(layout.encode())
    experiment = load_experiment(tmp_path)
    _add(experiment, "stribeck")
    after = load_experiment(tmp_path)
    assert after.effects == (*experiment.effects, "stribeck") and after.parameters["coulomb.force"].start == 1.3
    assert tomllib.loads(after.text)["record"] == tomllib.loads(layout)["record"]
    undo(after)
    assert experiment.path.read_bytes() == layout.encode()


@pytest.mark.parametrize("effect", library().values(), ids=lambda effect: effect.name)
def test_values_at_the_bounds_of_an_effect_are_written_and_read_again(tmp_path: Path, effect: Effect) -> None:
    for law in (effect, *effect.variants):
        core = law.friction_state is not None
        text = TEXT.replace('    "coulomb",  # dry\n', "").replace('"coulomb.force"', '# "coulomb.force"')
        experiment = _rig(tmp_path, text if core else TEXT)
        for end in ("low", "high"):
            starts = {
                f"{law.name}.{p.name}": (getattr(p, end) * (1.0 + 1e-10), p.unit.replace("channel", "N"))
                for p in law.parameters
                if np.isfinite(getattr(p, end))
            }
            if law.name in experiment.effects or not starts:
                continue
            _add(experiment, law.name, starts=starts)
            read = load_experiment(tmp_path)
            values = {key: value for key, (value, _) in starts.items()}
            assert {key: read.parameters[key].start for key in starts} == pytest.approx(values, rel=1e-8)
            undo(read)
            experiment = load_experiment(tmp_path)


def test_a_lock_is_reentrant_holds_the_process_number_and_is_removed(tmp_path: Path) -> None:
    lock = tmp_path / ".lock"
    with file_lock(lock, 0.1, "it"):
        with file_lock(lock, 0.1, "it"):
            pass
        assert lock.read_text().strip() == str(os.getpid())
    assert not lock.exists()


def test_links_and_pipes_in_place_of_a_lock_are_refused(tmp_path: Path) -> None:
    victim = tmp_path / "thesis.txt"
    victim.write_text("years of work")
    (tmp_path / ".lock").symlink_to(victim)
    with pytest.raises(InputError, match=r"\.lock: is a link"), file_lock(tmp_path / ".lock", 0.1, "it"):
        pass
    assert victim.read_text() == "years of work"
    (tmp_path / ".lock").unlink()
    os.mkfifo(tmp_path / ".lock")
    with pytest.raises(InputError, match="is not a regular file"), file_lock(tmp_path / ".lock", 0.1, "it"):
        pass


def test_a_file_with_content_or_another_name_is_not_written_to(tmp_path: Path) -> None:
    victim = tmp_path / "numbers.txt"
    victim.write_text("123")
    os.link(victim, tmp_path / ".lock")
    with file_lock(tmp_path / ".lock", 0.1, "it"):
        assert victim.read_text() == "123"
    victim.write_text("years of work")
    os.link(victim, tmp_path / ".lock")
    with file_lock(tmp_path / ".lock", 0.1, "it"):
        pass
    assert victim.read_text() == "years of work"


def test_a_lock_left_by_a_killed_process_is_taken_over(tmp_path: Path) -> None:
    (tmp_path / ".lock").write_text("999999")
    with file_lock(tmp_path / ".lock", 0.1, "it"):
        assert (tmp_path / ".lock").read_text().strip() == str(os.getpid())
