"""Slow, constant, senseless and long records, chains of formulas, limits of the system: a result, or one line."""

import json
import sys
from itertools import pairwise
from pathlib import Path

import numpy as np
import pyarrow
import pytest
from pyarrow import parquet

from stagecad.parameters.errors import InputError
from stagecad.parameters.load import design_from_text, load_design
from stagecad.solids.artefacts.part import kernel_errors
from tests.experiments import record_text, state, write_rig
from tests.process_state import python
from tests.refusals import refused
from tests.sysid.slide import SIGN, TIME, VELOCITY, slide
from workbench.cli import run


def experiment(folder: Path, step: float, constant: float | None = None) -> None:
    """Friction along a slow sine, sampled every `step`; or a force that never changes."""
    generator, records = np.random.default_rng(3), {}
    for name in ("fit", "validate"):
        phase = np.arange(400) * 0.0628
        x, v = -np.cos(phase), np.sin(phase) * 0.0628 / step
        force = 2.0 * np.sign(v) + 0.01 * generator.normal(size=400)
        force = force if constant is None else np.full(400, constant)
        columns = {"time": np.arange(400) * step, "position": x, "velocity": v}
        records[name] = columns | {"friction_force": force}
    write_rig(folder, "velocity-drive", records, ["coulomb", "viscous"])


@pytest.mark.parametrize("step", [1.0, 5.0, 10.0, 1e3, 1e7])
def test_a_slow_record_has_a_result(tmp_path: Path, capsys, step: float) -> None:
    """Seconds, or milliseconds and nanoseconds that are labelled as seconds."""
    experiment(tmp_path / "rig", step)
    assert run(["compare", str(tmp_path / "rig"), "--no-figures", "--out", str(tmp_path / "out")]) in (0, 1)
    assert "coulomb" in capsys.readouterr().out


@pytest.mark.filterwarnings("ignore")
def test_a_constant_force_has_a_verdict(tmp_path: Path, capsys) -> None:
    experiment(tmp_path / "rig", 0.01, 1.0)
    assert run(["diagnose", str(tmp_path / "rig"), "--no-figures", "--out", str(tmp_path / "out")]) in (0, 1, 2)
    assert "never changes" in capsys.readouterr().err


def chain(count: int, closed: bool) -> str:
    """Keys each of which is the next one; the last is a length, or the first again."""
    lengths = [e.key for e in load_design().entries if e.unit == "mm" and not isinstance(e.value, bool | str)]
    lines = [f'{key} = "={after}"' for key, after in pairwise(lengths[:count])]
    last = f'"={lengths[0]}"' if closed else '{value = "20 mm", origin = "assumed: for a test"}'
    return 'extends = "thesis"\n' + "\n".join([*lines, f"{lengths[count - 1]} = {last}"])


@pytest.mark.parametrize("count", [30, 120, 200])
def test_a_long_chain_of_formulas_is_computed_and_a_ring_is_named(count: int) -> None:
    refused("depends on itself", design_from_text, chain(count, closed=True), "ring.toml", (), rules=False)
    # The value is outside of the bounds of a key on the way.
    with pytest.raises(InputError, match=r"20 mm|0\.02|must lie between"):
        design_from_text(chain(count, closed=False), "chain.toml", (), rules=False)


def test_a_chain_of_formulas_has_its_value() -> None:
    lines = ['"=2 * stage.payload_pitch"', '"=stage.dowel_diameter + 20 mm"', '"6 mm"']
    keys = ("payload.height", "stage.payload_pitch", "stage.dowel_diameter")
    text = "\n".join(['extends = "thesis"', *map("{} = {}".format, keys, lines)])
    design = design_from_text(text, "chain.toml", (), rules=False)
    assert [design.value(key) for key in keys] == pytest.approx([52.0, 26.0, 6.0])


def test_lack_of_memory_in_the_kernel_is_not_a_fault_of_the_design() -> None:
    class Standard_OutOfMemory(Exception):  # noqa: N801, N818 - a name of the kernel
        pass

    for error in (MemoryError(), Standard_OutOfMemory(), RuntimeError("std::bad_alloc")):
        with pytest.raises(MemoryError), kernel_errors("stage", load_design()):
            raise error


FORCE = 1.5 * SIGN + 20.0 * VELOCITY


SPIKES = FORCE.copy()
SPIKES[np.random.default_rng(1).choice(FORCE.size, FORCE.size // 100, replace=False)] = 1e6

CASES = {
    "saturated": (np.clip(FORCE, -1.55, 1.55), 0.0, None),
    "saturated at the level": (np.clip(FORCE, -1.5, 1.5), 0.0, None),
    "spikes": (SPIKES, 0.01, "rows have values of 'friction_force' more than 100 times as far"),
    "noise a hundred times less than stated": (FORCE, 1e-4, "of the stated noise"),
    "huge": (1e9 + FORCE, 0.01, None),
    "tiny": (1e-12 * FORCE, 1e-14, None),
}


@pytest.mark.parametrize("name", CASES)
def test_a_comparison_ends_in_a_document_with_its_warning(tmp_path, capsys, name: str) -> None:
    force, noise, said = CASES[name]
    slide(tmp_path / "rig", force, "coulomb", "viscous", held_out=True, noise=noise)
    assert run(["compare", str(tmp_path / "rig"), "--no-figures", "--json"]) == 0
    captured = capsys.readouterr()
    warnings = json.loads(captured.out)["warnings"]
    if said is not None:
        assert any(said in line for line in warnings), warnings
        # Above the verdict, which is the last line.
        assert captured.err.index("warning: ") < len(captured.err.rstrip().rpartition("\n")[0])


@pytest.mark.parametrize("level", [0.0, 1.0])
def test_a_sensor_that_shows_one_value_is_named(tmp_path: Path, level: float) -> None:
    dead = np.full(TIME.size, level)
    refused("fit.csv: friction_force never changes", slide, tmp_path / "rig", dead, "coulomb", held_out=True, noise=0.0)


ROWS = 1_000_000
"""Of each of two records."""
MOST = 2 * 1024**2
"""Of memory that all processes of the command take at their largest, kB."""

PROGRAM = """
import resource, sys
from workbench.cli import run
status = run(["diagnose", "rig", "--no-figures", "--json", "found.json"])
largest = max(resource.getrusage(who).ru_maxrss for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
print(largest)
sys.exit(status)
"""


def _record(path: Path, seed: int) -> None:
    """Coulomb friction of 1 N with a Stribeck peak of 0.8 N, noise of 10 mN."""
    time = np.arange(ROWS) * 1e-4
    velocity = 0.02 * np.sin(2.0 * time + seed) + 0.006 * np.sin(7.0 * time)
    force = np.sign(velocity) * (1.0 + 0.8 * np.exp(-((velocity / 0.004) ** 2)))
    force += 0.01 * np.random.default_rng(seed).standard_normal(ROWS)
    parquet.write_table(
        pyarrow.table({"time [s]": time, "velocity [m/s]": velocity, "friction_force [N]": force}), path
    )


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="the largest resident memory is in kB on Linux")
def test_a_diagnosis_of_two_million_rows_is_bounded_in_memory(tmp_path: Path) -> None:
    rig = tmp_path / "rig"
    rig.mkdir()
    records = ""
    for seed, role in ((1, "fit"), (2, "validate")):
        _record(rig / f"{role}.parquet", seed)
        records += record_text(f"{role}.parquet", role=role)
    state(rig, records, effects=["coulomb"])
    assert int(python("-c", PROGRAM, folder=tmp_path).stdout.split()[-1]) < MOST
    assert json.loads((tmp_path / "found.json").read_text("utf-8"))["effect"] == "stribeck"
