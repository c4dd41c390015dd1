"""An experiment in memory, written as a folder that the commands read."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from sim.effects.effect import Effect
from stagecad.parameters.atomic import atomic_write_text
from stagecad.parameters.errors import InputError
from sysid.experiment.readers.memory import MemoryTable

if TYPE_CHECKING:
    from workbench.api.measurement.experiment import Experiment


def save(experiment: Experiment, folder: Path) -> Path:
    """Write records as Parquet and `experiment.toml` into a folder; returns the folder.

    Raises:
        InputError: the folder has an experiment already, the experiment is in a folder, or an effect of its model is
            declared in memory, where a file cannot name it.
    """
    import tomlkit

    from workbench.simulation.tables import write_table

    if experiment.in_files:
        raise InputError(f"{experiment.stated.path}: is in a folder already")
    own = [effect.name for effect in experiment.stated.custom if isinstance(effect, Effect)]
    if own:
        raise InputError(
            f"{folder}: effect '{own[0]}' is declared in memory; put it into a Python file, save without it, and name "
            "the file under [model] custom"
        )
    target = folder / "experiment.toml"
    if target.exists():
        raise InputError(f"{target}: is there already; name a new folder")
    document = experiment.to_json()
    for table, spec in zip(document["record"], experiment.stated.records, strict=True):
        assert isinstance(spec.path, MemoryTable)
        (written,) = write_table(folder / table["file"], spec.path.columns, ("parquet",))
        table["file"] = written.name
    atomic_write_text(target, tomlkit.dumps(document))
    return folder
