"""Records simulated from the model of an experiment, written with the `experiment.toml` that compares them with it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stagecad.parameters.atomic import atomic_write_bytes, atomic_write_text
from stagecad.parameters.errors import InputError
from stagecad.parameters.units import as_json
from workbench.cli.options import Run
from workbench.identification.design_values import design_values
from workbench.simulation.tables import write_table

if TYPE_CHECKING:
    from sysid.simulate_experiment import SimulatedExperiment


def write_simulated_records(
    run: Run, experiment: Path, motion: Path | None, seed: int | None, formats: tuple[str, ...]
) -> dict[str, Any]:
    """Simulate an experiment into OUT/simulate/NAME; returns the document of the command.

    Args:
        run: of the command.
        experiment: folder or `experiment.toml`.
        motion: file with other inputs than its own.
        seed: of the noise; without noise for None.
        formats: of the records: csv, parquet or both.

    Raises:
        InputError: a fault in a file, or a model that cannot be simulated.
    """
    from sysid.experiment.experiment import find_experiment
    from sysid.simulate_experiment import simulate_experiment

    if not formats:
        raise InputError("--format none: the records of an EXPERIMENT are its only result; allowed: csv, parquet, both")
    place = find_experiment(experiment)
    folder = run.out / "simulate" / place.folder.resolve().name
    if folder.resolve() == place.folder.resolve():
        raise InputError(f"--out {run.out}: the records would replace those of {experiment}; choose another folder")
    with run.progress() as progress:
        task = progress.add_task("fitting the model where it has no values", total=None)
        simulated = simulate_experiment(
            place.path,
            design_values(run.design),
            motion,
            lambda name: progress.update(task, description=f"{name} done"),
        )
    for note in simulated.problem.notes:
        run.note(f"note: {note}")
    files = []
    for record, table in zip(simulated.records, simulated.logged(seed), strict=True):
        files += write_table(folder / record.file, table, formats)
    import tomlkit

    for name, path in simulated.custom.items():
        atomic_write_bytes(folder / name, path.read_bytes())
        files.append(folder / name)
    target = folder / "experiment.toml"
    added = "without noise" if seed is None else f"with noise of seed {seed}"
    inputs = "its own inputs" if motion is None else motion.name
    head = f"# Simulated from the model of {place.folder.resolve().name} on {inputs}, {added}.\n"
    atomic_write_text(target, head + tomlkit.dumps(simulated.document(formats[0])))
    return simulated_json(simulated, seed, [str(file) for file in (*files, target)])


def simulated_json(simulated: SimulatedExperiment, seed: int | None, files: Sequence[str]) -> dict[str, Any]:
    """The document of `simulate EXPERIMENT`."""
    return {
        "schema": 1,
        "effects": [effect.name for effect in simulated.model.effects],
        "parameters": {
            key: {**as_json(value, unit), "from": origin} for key, value, unit, origin in simulated.parameters()
        },
        "noise": {name: found.to_json() for name, found in simulated.noise.items()} if seed is not None else {},
        "seed": seed,
        "records": [{"name": r.name, "role": r.role, "rows": int(r.time.size)} for r in simulated.records],
        "files": list(files),
    }
