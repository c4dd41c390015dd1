"""Experiments in memory: the content of an `experiment.toml` as plain data, records as columns, revisions as values."""

import hashlib
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from sim.effects.effect import Effect
from stagecad.deferred import tomlkit
from sysid.experiment.experiment import Experiment, read_experiment
from sysid.experiment.known import DesignValues, Prior
from sysid.experiment.ladder import Revision
from sysid.experiment.model_table import grown_model, json_data, model_of
from sysid.experiment.readers.memory import MemoryTable
from sysid.experiment.toml_table import TomlTable


def experiment_in_memory(
    document: Mapping[str, Any],
    records: Mapping[str, MemoryTable],
    own: Sequence[Effect] = (),
    design: DesignValues | None = None,
    name: str = "experiment",
) -> Experiment:
    """An experiment from the content that its `experiment.toml` would have, its records in memory."""
    text = tomlkit.dumps(document)
    found = read_experiment(TomlTable(name, "", tomllib.loads(text)), Path(name), design, records, own)
    sha256 = hashlib.sha256(text.encode()).hexdigest()
    return replace(found, folder=Path(name), text=text, sha256=sha256, revisions=())


def with_revision(
    experiment: Experiment,
    effects: Sequence[str],
    starts: Mapping[str, tuple[float, str]],
    document: Mapping[str, Any],
    base_document: Mapping[str, Any],
    known: Mapping[str, Prior],
    design: DesignValues | None = None,
) -> Experiment:
    """An experiment in memory with its next revision; arguments as of `ladder.append_revision`."""
    model = model_of(experiment.text)
    revisions = list(experiment.revisions or ())
    if not revisions:
        revisions.append(_revision(0, model, {**base_document, "added": [], "removed": []}))
    grown = grown_model(model, effects, starts, known)
    added = [name for name in effects if name not in model.get("effects", ())]
    removed = [name for name in model.get("effects", ()) if name not in effects]
    revisions.append(_revision(len(revisions), grown, {**document, "added": added, "removed": removed}))
    content = {**tomllib.loads(experiment.text), "model": grown}
    tables = {spec.file: spec.path for spec in experiment.records if isinstance(spec.path, MemoryTable)}
    own = [effect for effect in experiment.custom if isinstance(effect, Effect)]
    after = experiment_in_memory(content, tables, own, design, str(experiment.path))
    return replace(after, revisions=tuple(revisions))


def _revision(number: int, model: Mapping[str, Any], document: Mapping[str, Any]) -> Revision:
    effects = list(model.get("effects", ()))
    return Revision(number, Path(), dict(model), json_data({"rung": number, "effects": effects, **document}))
