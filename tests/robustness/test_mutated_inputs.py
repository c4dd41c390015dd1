"""Mutated parameter files, overrides, experiments and records: read, or refused in one printable line, in time."""

import gzip
import json
import os
import re
import select
import signal
import subprocess
import sys
import time
import warnings
from collections import Counter
from collections.abc import Callable
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import h5py
import numpy as np
import pyarrow
import pytest
from nptdms import ChannelObject, TdmsWriter
from pyarrow import parquet
from scipy.io import savemat

from stagecad.parameters.errors import LONGEST, InputError
from stagecad.parameters.file import packaged_text
from stagecad.parameters.formula import SIGN
from stagecad.parameters.load import load_design
from stagecad.parameters.machine import packaged_machine
from sysid.experiment.experiment import load_experiment
from sysid.experiment.readers import isolated
from sysid.experiment.record import load_records
from tests.robustness.mutation import HOSTILE, count, mutated, mutated_bytes

SLOW = 20.0
"""Processor time for one input that is taken for a hang, s."""

EXPERIMENT = """schema = 1
[rig]
kind = "spring-pull"
[rig.known]
mass = "1.79 +- 0.01 kg"
pull_stiffness = "5752 N/m"
[model]
effects = ["coulomb", "viscous", "stribeck"]
[model.parameters]
"coulomb.force" = {start = "1.2 N", low = "0.1 N", high = inf}
"stribeck.velocity" = {start = "2 mm/s", fixed = true}
[[record]]
file = "fit.SUFFIX"
role = "fit"
from = "0 s"
to = "20 s"
columns = {spring_force = "force"}
units = {spring_force = "N", time = "s", position = "m", pull_position = "m"}
sign = {spring_force = 1}
[[record]]
file = "fit.SUFFIX"
role = "validate"
name = "other"
columns = {spring_force = "force"}
units = {spring_force = "N", time = "s", position = "m", pull_position = "m"}
[noise]
position = "2e-07 m"
"""
FORMAT = """[format]
delimiter = "comma"
decimal = "."
thousands = "none"
header = 1
first_row = 2
encoding = "utf-8"
missing = ["n/a"]
time_format = "%H:%M:%S.%f"
repeated_time = "mean"
sample_rate = "100 Hz"
"""
TIME = np.arange(60) * 0.01
COLUMNS = {"time": TIME, "pull_position": 0.1 * TIME, "position": 0.1 * TIME**2, "force": np.sin(TIME)}
PARTS = 10
"""Runs, each with a seed of its own, into which the long ones are divided."""


def outcome(read: Callable[[], object]) -> str:
    """`accepted` or `refused`; anything else raises."""
    began = time.process_time()
    try:
        read()
        found = "accepted"
    except InputError as error:
        line = str(error)
        assert line.isprintable() and len(line) <= LONGEST, repr(line[:300])
        found = "refused"
    assert time.process_time() - began < SLOW
    return found


def parameter_files(folder: Path, number: int, seed: int) -> Counter[str]:
    random, text, found = np.random.default_rng(seed), packaged_text(), Counter[str]()
    short = 'extends = "thesis"\n' + "\n".join(text.splitlines()[:60])
    keys = list(packaged_machine().schema())
    file = folder / "stage.toml"
    for _ in range(number):
        kind = random.random()
        if kind < 0.5:
            file.write_bytes(mutated(short if kind < 0.4 else text, random))
            found[outcome(lambda: load_design(file))] += 1
        else:
            value = str(random.choice([*HOSTILE, f"{10.0 ** random.uniform(-320, 308):.3g} mm", "12 mm"])).strip('"')
            key = str(random.choice(keys))
            found[outcome(partial(load_design, None, [f"{key}={value}"]))] += 1
    return found


def formulas(number: int, seed: int) -> Counter[str]:
    """Counts of random formulas in place of a parameter's value, half of them mutated."""
    random, found = np.random.default_rng(seed), Counter[str]()
    lengths = [key for key, entry in packaged_machine().schema().items() if entry.unit == "mm"]
    for _ in range(number):
        text = _formula(lengths, random, int(random.integers(0, 6)))
        if random.random() < 0.5:
            text = mutated(text, random).decode("utf-8", "replace")
        found[outcome(partial(load_design, None, [f"{random.choice(lengths)}={SIGN}{text}"]))] += 1
    return found


def _formula(keys: list[str], random: np.random.Generator, depth: int, length: bool = True) -> str:
    """A length, or a number, of the elements of formulas; one part in thirty has the wrong unit."""
    if random.random() < 0.03:
        length = not length
    if not depth or random.random() < 0.1:
        number = f"{10.0 ** (random.normal() if random.random() < 0.95 else random.uniform(-320, 308)):.3g}"
        return str(random.choice([str(random.choice(keys)), f"{number} mm"] if length else [number, "0", "2", "pi"]))
    form = str(random.choice(_LENGTHS if length else _NUMBERS))
    return re.sub("[LN]", lambda kind: _formula(keys, random, depth - 1, kind[0] == "L"), form)


_LENGTHS = ("(L + L)", "L - L", "L*N", "L/N", "sqrt(L*L + L^2)", "L^3/(L*L)", "-abs(L)", "(L^0.5)^2") + tuple(
    f"{name}(L, L)" for name in ("min", "max", "floor", "ceil", "round")
)
_NUMBERS = ("(N - N)", "L/L", "N^N", "+N", "round(N)") + tuple(
    f"{name}(N)" for name in ("sin", "cos", "tan", "sqrt", "asin", "acos", "atan")
)
"""Expressions that are a length, and that are a number, of lengths L and numbers N."""


def experiments(folder: Path, number: int, seed: int, binary: float) -> Counter[str]:
    """Counts of mutated experiments and records; `binary` is the share of formats that another process reads."""
    random, found, whole = np.random.default_rng(seed), Counter[str](), _binary_records(folder)
    for _ in range(number):
        suffix = str(random.choice([*whole, "json"] if random.random() < binary else ["csv", "csv.gz"]))
        stated = EXPERIMENT.replace("SUFFIX", suffix) + FORMAT * bool(random.integers(2))
        record, changed = whole.get(suffix) or _TEXTS[suffix].encode(), random.random()
        if changed < (0.5 if suffix in _TEXTS else 0.05):
            experiment = mutated(stated, random)
        else:
            experiment = stated.encode()
            record = mutated(_TEXTS[suffix], random) if suffix in _TEXTS else mutated_bytes(record, random)
        if suffix == "csv.gz":
            record = gzip.compress(record, 1)
            record = mutated_bytes(record, random) if changed > 0.9 else record
        (folder / "experiment.toml").write_bytes(experiment)
        (folder / f"fit.{suffix}").write_bytes(record)
        found[outcome(lambda: _sound(folder))] += 1
    return found


def _sound(folder: Path) -> None:
    for record in load_records(load_experiment(folder)):
        assert np.all(np.diff(record.time) > 0.0)
        assert not any(np.isinf(values).any() for values in record.channels.values())


def _csv() -> str:
    rows = "\n".join(",".join(f"{value:.6g}" for value in row) for row in zip(*COLUMNS.values(), strict=True))
    return "time [s],pull_position [m],position [m],force [N]\n" + rows + "\n"


_TEXTS = {"csv": _csv(), "csv.gz": _csv(), "json": json.dumps({key: one.tolist() for key, one in COLUMNS.items()})}


def _binary_records(folder: Path) -> dict[str, bytes]:
    path = {suffix: folder / f"valid.{suffix}" for suffix in ("parquet", "mat", "npz", "h5", "tdms")}
    parquet.write_table(pyarrow.table(COLUMNS), path["parquet"])
    savemat(path["mat"], COLUMNS)
    np.savez(path["npz"], **COLUMNS)
    with h5py.File(path["h5"], "w") as file:
        for name, values in COLUMNS.items():
            file[name] = values
    with TdmsWriter(path["tdms"]) as writer:
        writer.write_segment([ChannelObject("rig", name, values) for name, values in COLUMNS.items()])
    return {suffix: one.read_bytes() for suffix, one in path.items()}


@pytest.mark.parametrize("kind", ["parameter files", "formulas", "experiments and records"])
def test_some_inputs_are_read_and_some_refused(tmp_path: Path, kind: str) -> None:
    found = {
        "parameter files": lambda: parameter_files(tmp_path, 80, 1),
        "formulas": lambda: formulas(60, 3),
        "experiments and records": lambda: experiments(tmp_path, 160, 2, 0.0),
    }[kind]()
    assert found["refused"] > 20 and found["accepted"] > 0


LONG = {
    "formula": "stage.length + " * 5_000,
    "units": " in mm " * 5_000,
    "digits": "9" * 400_000,
    "blanks": " " * 100_000,
    "letters": "a" * 100_000,
}


@pytest.mark.parametrize("kind", LONG)
@pytest.mark.parametrize("place", ["force [N]", "time [s]", "0.01,"])
def test_long_texts_take_no_time_that_grows_with_the_square_of_their_length(tmp_path, kind: str, place: str) -> None:
    (tmp_path / "experiment.toml").write_text(EXPERIMENT.replace("SUFFIX", "csv"))
    (tmp_path / "fit.csv").write_text(_csv().replace(place, f"{LONG[kind]},", 1))
    began = time.process_time()
    assert outcome(lambda: _sound(tmp_path)) == "refused"
    assert time.process_time() - began < 0.1 * SLOW


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(11, 11 + PARTS))
def test_many_parameter_files(tmp_path: Path, capsys: pytest.CaptureFixture[str], seed: int) -> None:
    found = parameter_files(tmp_path, count(100_000 // PARTS), seed)
    with capsys.disabled():
        print(f"\nparameter files and overrides, seed {seed}: {sum(found.values())}: {dict(found)}")  # noqa: T201


@pytest.mark.slow
def test_many_formulas(capsys: pytest.CaptureFixture[str]) -> None:
    found = formulas(count(6_000), 4)
    with capsys.disabled():
        print(f"\nformulas: {sum(found.values())}: {dict(found)}")  # noqa: T201


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(21, 21 + PARTS))
def test_many_experiments_and_records(tmp_path, capsys, monkeypatch, seed: int) -> None:
    monkeypatch.setattr(isolated, "subprocess", SimpleNamespace(run=_forked_reader, DEVNULL=None))
    found = experiments(tmp_path, count(50_000 // PARTS), seed, 0.1)
    with capsys.disabled():
        print(f"\nexperiments and records, seed {seed}: {sum(found.values())}: {dict(found)}")  # noqa: T201


def _forked_reader(command: list[str], stdin: int, **_: Any) -> subprocess.CompletedProcess[bytes]:
    """The process of a binary reader as a fork of this one, which does not load the libraries again."""
    ours, its = os.pipe()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        child = os.fork()
    if not child:
        os.dup2(stdin, 0)
        os.dup2(its, 1)
        os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
        sys.stdin, sys.stdout, sys.argv = os.fdopen(0), os.fdopen(1, "w"), ["reader", command[-1]]
        try:
            isolated.answer()
            sys.stdout.flush()
        except BaseException:
            os._exit(1)
        os._exit(0)
    os.close(its)
    found = bytearray()
    while select.select([ours], [], [], 2.0 * isolated.SECONDS)[0]:
        data = os.read(ours, 1 << 20)
        if not data:
            break
        found += data
    else:
        os.kill(child, signal.SIGKILL)
    os.close(ours)
    code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    assert code != -signal.SIGKILL, "a reader hangs"
    return subprocess.CompletedProcess(command, code, bytes(found))
