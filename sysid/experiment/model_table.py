"""Editing of the `[model]` table of an experiment file; all other content of the file is kept."""

import copy
import hashlib
import json
import math
import tomllib
from collections.abc import Mapping, Sequence
from typing import Any

from stagecad.deferred import tomlkit
from stagecad.parameters.errors import InputError
from sysid.experiment.known import Prior


def model_of(text: str) -> dict[str, Any]:
    """The `[model]` of an experiment file as plain data."""
    return tomllib.loads(text).get("model", {})


def model_hash(model: Mapping[str, Any]) -> str:
    """Hash of the content of a `[model]`, independent of comments, order of keys and layout."""
    return hashlib.sha256(json.dumps(json_data(model), sort_keys=True, default=str).encode()).hexdigest()


def json_data(value: Any) -> Any:
    """JSON data of `value`: numpy numbers and arrays as Python numbers and lists, NaN as null, infinity as text."""
    if isinstance(value, Mapping):
        return {str(key): json_data(item) for key, item in value.items()}
    if isinstance(value, list | tuple | set | frozenset):
        return [json_data(item) for item in value]
    if hasattr(value, "tolist"):
        return json_data(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None if math.isnan(value) else ("inf" if value > 0 else "-inf")
    return value


def grown_model(
    model: Mapping[str, Any],
    effects: Sequence[str],
    starts: Mapping[str, tuple[float, str]],
    known: Mapping[str, Prior] | None = None,
) -> dict[str, Any]:
    """`model` with other effects, and with fitted values as starts."""
    grown = copy.deepcopy(dict(model))
    grown["effects"] = list(effects)
    settings = flat_settings(grown.get("parameters", {}))
    settings = {key: value for key, value in settings.items() if key.rpartition(".")[0] in effects}
    for key, (value, unit) in starts.items():
        before = settings.get(key, {})
        setting = dict(before) if isinstance(before, Mapping) else {}
        if key.rpartition(".")[0] not in effects or _is_prior(before) or setting.get("fixed"):
            continue
        unit = "" if unit == "1" else unit
        prior = (known or {}).get(key)
        if prior is not None:
            setting["start"] = f"{prior.value:.6g} +- {prior.std:.2g} {unit}".strip()
        else:
            setting["start"] = f"{value:.9g} {unit}" if unit else float(f"{value:.9g}")
        settings[key] = setting
    grown.pop("parameters", None)
    return {**grown, "parameters": settings} if settings else grown


def _is_prior(setting: Any) -> bool:
    start = setting.get("start") if isinstance(setting, Mapping) else setting
    return isinstance(start, str) and (start == "design" or any(mark in start for mark in ("+-", "+/-", "±")))


def flat_settings(parameters: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """Settings by dotted key, whether written as `"coulomb.force" = {...}` or as `coulomb.force = {...}`."""
    flat: dict[str, Any] = {}
    for key, value in parameters.items():
        nested = isinstance(value, Mapping) and not {"start", "low", "high", "fixed"} & set(value)
        if nested and any(isinstance(item, Mapping | str) for item in value.values()):
            flat.update(flat_settings(value, f"{prefix}{key}."))
        else:
            flat[f"{prefix}{key}"] = value
    return flat


def with_model(text: str, model: Mapping[str, Any], file: str) -> str:
    """The experiment file's text with `[model]` replaced by `model`; comments and all other content are kept."""
    # Imported here: tomlkit takes 0.04 s to load, and only functions that write an experiment need it.
    from tomlkit.exceptions import TOMLKitError

    try:
        document = tomlkit.parse(text)
        table: Any = document["model"]
        for key in [key for key in table if key not in model]:
            del table[key]
        for key, value in model.items():
            _set(table, key, value)
        edited = tomlkit.dumps(document)
        if model_hash(model_of(edited)) != model_hash(model):
            # A layout that cannot be edited key by key (dotted keys across tables) is rewritten.
            document["model"] = tomlkit.item(dict(model))
            edited = tomlkit.dumps(document)
    except (TOMLKitError, KeyError, TypeError) as error:
        raise InputError(f"{file}: [model] cannot be edited: {error}") from None
    rest = {key: value for key, value in tomllib.loads(text).items() if key != "model"}
    after = {key: value for key, value in tomllib.loads(edited).items() if key != "model"}
    if model_hash(model_of(edited)) != model_hash(model) or rest != after:
        raise InputError(f"{file}: [model] cannot be edited in its present layout; write it as one table [model]")
    return edited


def _set(table: Any, key: str, value: Any) -> None:
    from tomlkit.items import InlineTable

    if key not in table:
        if isinstance(value, Mapping) and key == "parameters" and not isinstance(table, InlineTable):
            inner = tomlkit.table()
            for name, setting in value.items():
                inner[name] = inline(setting)
            inner.add(tomlkit.nl())
            table[key] = inner
        else:
            table[key] = inline(value)
        return
    present = table[key]
    plain = present.unwrap() if hasattr(present, "unwrap") else present
    # An infinite bound is stored as text in a rung, but may be a TOML number in the file.
    if json_data(plain) == json_data(value):
        return
    if isinstance(value, list) and isinstance(plain, list):
        _set_list(present, value)
    elif isinstance(value, Mapping) and isinstance(plain, Mapping):
        for name in [name for name in present if name not in value]:
            del present[name]
        for name, setting in value.items():
            _set(present, name, setting)
    else:
        table[key] = inline(value)


def _set_list(present: Any, wanted: list[Any]) -> None:
    for place in range(len(present) - 1, -1, -1):
        if present[place] not in wanted:
            del present[place]
    for place, item in enumerate(wanted):
        if place >= len(present):
            present.append(item)
        elif present[place] != item:
            present.insert(place, item)
    while len(present) > len(wanted):
        del present[len(present) - 1]


def inline(value: Any) -> Any:
    """A value of a TOML file whose tables, also those of a list, stand in its line."""
    if isinstance(value, Mapping):
        table = tomlkit.inline_table()
        table.update({key: inline(item) for key, item in value.items()})
        return table
    if isinstance(value, list):
        array = tomlkit.array()
        array.extend(map(inline, value))
        return array
    return tomlkit.item(value)
