"""The ladder of an experiment: `add` writes a rung, which is a file, and `undo` takes the last one off.

`experiment.toml` has the model of the last rung. `ladder/NNN.json` contains the complete `[model]`, the added effect,
the fit, the errors, and the hashes of the records; rung 000 is the model before any effect was added. No rung is
deleted: an undone one is moved to `ladder/undone/`.

A change is made in this order: write a note of the intended change (`ladder/pending.json`), write the rung, write
`experiment.toml`, delete the note. Each file is written atomically. If a run is interrupted, the note remains: when
`experiment.toml` contains the model of the rung before, the rung is moved to `ladder/undone/`; when it contains the new
model, or was edited by hand since, the rung is kept. Reading functions apply the same rule without writing.
"""

import errno
import fcntl
import hashlib
import json
import os
import re
import stat
import time
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from stagecad.parameters.atomic import atomic_write_bytes, atomic_write_text
from stagecad.parameters.errors import InputError, require
from stagecad.parameters.input_file import read_input, read_named
from sysid.experiment.experiment import Experiment, Place, Revision
from sysid.experiment.known import Prior
from sysid.experiment.model_table import grown_model, json_data, model_hash, model_of, with_model

_held: dict[Path, int] = {}
POLL_SECONDS = 0.05
LONGEST = 16
"""Bytes of a lock file that are read: a process number, padded."""


@contextmanager
def file_lock(path: Path, timeout: float, busy: str) -> Iterator[None]:
    """Hold the lock on `path`; reentrant within a process."""
    key = path.absolute()
    if _held.get(key, 0):
        _held[key] += 1
        try:
            yield
        finally:
            _held[key] -= 1
        return
    handle = _locked(path, time.monotonic() + timeout, busy)
    try:
        _held[key] = 1
        _write_holder(handle)
        yield
    finally:
        _held.pop(key, None)
        # Removed while it is held: whoever waits for it notices that its file has lost its name.
        with suppress(OSError):
            path.unlink()
        fcntl.flock(handle, fcntl.LOCK_UN)
        os.close(handle)


def _locked(path: Path, end: float, busy: str) -> int:
    while True:
        handle = _open(path)
        try:
            while not _try(handle):
                if time.monotonic() >= end:
                    found = re.fullmatch(rb"(\d+)\s*", _text(handle))
                    holder = found[1].decode() if found else "unknown"
                    raise InputError(
                        f"{busy}: another run is at work on it (process {holder}); try again when it is done"
                    )
                time.sleep(POLL_SECONDS)
            if _has_name(handle, path):
                return handle
        except BaseException:
            os.close(handle)
            raise
        os.close(handle)


def _open(path: Path) -> int:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle = os.open(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_CLOEXEC | os.O_NONBLOCK, 0o666)
    except OSError as error:
        if error.errno == errno.ELOOP:
            raise InputError(f"{path}: is a link; a lock file is required, so remove it") from None
        folder = next((one for one in path.parents if one.is_dir()), path.parent)
        raise InputError(f"{folder}: this folder cannot be written to: {error.strerror}") from None
    if not stat.S_ISREG(os.fstat(handle).st_mode):
        os.close(handle)
        raise InputError(f"{path}: is not a regular file; a lock file is required, so remove it")
    return handle


def _has_name(handle: int, path: Path) -> bool:
    """Whether the open file still has its name; the holder before may have removed it."""
    try:
        return os.path.samestat(os.fstat(handle), path.lstat())
    except FileNotFoundError:
        return False


def _text(handle: int) -> bytes:
    os.lseek(handle, 0, os.SEEK_SET)
    return os.read(handle, LONGEST)


def _write_holder(handle: int) -> None:
    """Write this process's number, unless the file has other content or another name (a hard link)."""
    if os.fstat(handle).st_nlink == 1 and re.fullmatch(rb"\d*\s*", _text(handle)):
        os.lseek(handle, 0, os.SEEK_SET)
        os.write(handle, str(os.getpid()).ljust(LONGEST).encode())


def _try(handle: int) -> bool:
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    return True


SCHEMA = 1
LOCK_SECONDS = 10.0
_RUNG = re.compile(r"(\d{3,})\.json")

Placed = Experiment | Place


@contextmanager
def history_lock(experiment: Placed, timeout: float = LOCK_SECONDS) -> Iterator[None]:
    """Lock the experiment against writes of other runs; reentrant within a process."""
    folder = experiment.folder / "ladder"
    try:
        with file_lock(folder / ".lock", timeout, str(experiment.path)):
            yield
    finally:
        # Where nothing was written, no empty folder is left.
        with suppress(OSError):
            folder.rmdir()


def read_history(experiment: Placed) -> list[Revision]:
    """The rungs in order of their number; empty if no effect was added yet. Writes nothing."""
    in_memory = getattr(experiment, "revisions", None)
    if in_memory is not None:
        return list(in_memory)
    rungs = _read_rungs(experiment.folder / "ladder")
    return rungs[:-1] if _was_reverted(experiment, rungs) else rungs


def edited_by_hand(experiment: Placed, rungs: Sequence[Revision]) -> bool:
    """Whether `[model]` differs from the last revision."""
    if getattr(experiment, "revisions", None) is not None:
        return False
    return bool(rungs) and model_hash(model_of(_current_text(experiment))) != model_hash(rungs[-1].model)


def append_revision(
    experiment: Experiment,
    effects: Sequence[str],
    starts: Mapping[str, tuple[float, str]],
    document: Mapping[str, Any],
    base_document: Mapping[str, Any],
    record_hashes: Mapping[str, str],
    timeout: float = LOCK_SECONDS,
    known: Mapping[str, Prior] | None = None,
) -> Revision:
    """Write the next rung, then `experiment.toml`."""
    with history_lock(experiment, timeout), _readable_errors():
        _recover(experiment)
        text = _current_text(experiment)
        if hashlib.sha256(read_named(experiment.path)).hexdigest() != experiment.sha256:
            raise InputError(f"{experiment.path}: changed while the fit ran; nothing was added, run again")
        rungs = _read_rungs(experiment.folder / "ladder")
        model = model_of(text)
        if not rungs or model_hash(model) != model_hash(rungs[-1].model):
            added = {"added": [], "edited_by_hand": True} if rungs else {"added": []}
            _write_rung(experiment, len(rungs), model, {**base_document, **added}, record_hashes, None, text)
            rungs = _read_rungs(experiment.folder / "ladder")
        grown = grown_model(model, effects, starts, known)
        after = with_model(text, grown, str(experiment.path))
        added = [name for name in effects if name not in model.get("effects", ())]
        removed = [name for name in model.get("effects", ()) if name not in effects]
        number = len(rungs)
        _note_pending(experiment, "add", number)
        rung = _write_rung(
            experiment, number, grown, {**document, "added": added, "removed": removed}, record_hashes, text, after
        )
        atomic_write_text(experiment.path, after)
        _pending_path(experiment.folder).unlink(missing_ok=True)
        return rung


def undo(experiment: Placed, timeout: float = LOCK_SECONDS) -> tuple[Revision, Path]:
    """Go back to the rung before the last; the last one is kept in `ladder/undone/`."""
    require((experiment.folder / "ladder").is_dir(), f"{experiment.path}: nothing to undo; no effect was added yet")
    with history_lock(experiment, timeout), _readable_errors():
        _recover(experiment)
        rungs = _read_rungs(experiment.folder / "ladder")
        if len(rungs) < 2:
            raise InputError(f"{experiment.path}: nothing to undo; no effect was added yet")
        last, before = rungs[-1], rungs[-2]
        text = _current_text(experiment)
        if edited_by_hand(experiment, rungs):
            raise InputError(
                f"{experiment.path}: [model] was edited by hand since rung {last.number:03d}, so nothing is undone; "
                f"restore the model of {last.path} in [model], or edit [model] by hand to the model you want"
            )
        restored = last.document.get("experiment_before")
        if not isinstance(restored, str) or _sha(text) != last.document.get("experiment_sha256"):
            restored = with_model(text, before.model, str(experiment.path))
        _note_pending(experiment, "undo", last.number)
        atomic_write_text(experiment.path, restored)
        kept = _set_aside(last.path)
        _pending_path(experiment.folder).unlink(missing_ok=True)
        return before, kept


def _current_text(experiment: Placed) -> str:
    return read_named(experiment.path).decode("utf-8-sig")


def _sha(text: str) -> str:
    return hashlib.sha256(text.encode("utf-8")).hexdigest()


@contextmanager
def _readable_errors() -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise InputError(f"{error.filename}: cannot be written: {error.strerror}") from None


def _read_rungs(folder: Path) -> list[Revision]:
    if not folder.is_dir():
        return []
    rungs = [_read_rung(path) for path in sorted(folder.iterdir()) if _RUNG.fullmatch(path.name)]
    rungs.sort(key=lambda rung: rung.number)
    for place, rung in enumerate(rungs):
        if rung.number != place:
            raise InputError(f"{folder}: rung {place:03d}.json is missing, but {rung.path.name} is there")
    return rungs


def _read_rung(path: Path) -> Revision:
    data = read_named(path)
    try:
        document = json.loads(data)
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: is not JSON: {error}") from None
    if not isinstance(document, dict) or document.get("schema") != SCHEMA:
        raise InputError(f"{path}: is not a rung of this program; 'schema': {SCHEMA} is required")
    if not isinstance(document.get("model"), dict):
        raise InputError(f"{path}: 'model' is missing, or no table")
    return Revision(int(path.stem), path, document["model"], document)


def _write_rung(
    experiment: Placed,
    number: int,
    model: Mapping[str, Any],
    document: Mapping[str, Any],
    record_hashes: Mapping[str, str],
    text_before: str | None,
    text_after: str,
) -> Revision:
    path = experiment.folder / "ladder" / f"{number:03d}.json"
    whole = {
        "schema": SCHEMA,
        "rung": number,
        "effects": list(model.get("effects", ())),
        **{key: value for key, value in document.items() if key not in ("schema", "rung", "effects", "model")},
        "model": dict(model),
        "records": dict(record_hashes),
        **_own_rig(experiment.folder, text_after),
        "experiment_sha256": _sha(text_after),
        "experiment_before": text_before,
    }
    whole = json_data(whole)
    atomic_write_text(path, json.dumps(whole, indent=1, ensure_ascii=False, allow_nan=False) + "\n")
    return Revision(number, path, whole["model"], whole)


def _own_rig(folder: Path, text: str) -> dict[str, Any]:
    """Hash of the declaration file of the experiment's own kind of rig, if it has one."""
    kind = tomllib.loads(text).get("rig", {}).get("kind")
    if not isinstance(kind, str) or not kind.endswith(".toml"):
        return {}
    return {"rig": {kind: hashlib.sha256(read_named(folder / kind)).hexdigest()}}


def _pending_path(folder: Path) -> Path:
    return folder / "ladder" / "pending.json"


def _note_pending(experiment: Placed, operation: str, number: int) -> None:
    note = json.dumps({"operation": operation, "rung": number}).encode()
    atomic_write_bytes(_pending_path(experiment.folder), note)


def _pending(folder: Path) -> dict[str, Any] | None:
    try:
        note = json.loads(read_input(_pending_path(folder)))
        return {"rung": int(note["rung"]), "operation": str(note["operation"])}
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _was_reverted(experiment: Placed, rungs: Sequence[Revision]) -> bool:
    """Whether an interrupted run left the last rung without its model in `experiment.toml`. A third model was written
    by hand since: then the rung is kept, since it cannot be known whether it was completed."""
    pending = _pending(experiment.folder)
    if pending is None or len(rungs) < 2 or rungs[-1].number != pending["rung"]:
        return False
    current = model_hash(model_of(_current_text(experiment)))
    return current != model_hash(rungs[-1].model) and current == model_hash(rungs[-2].model)


def _recover(experiment: Placed) -> None:
    """Complete or revert an interrupted change."""
    rungs = _read_rungs(experiment.folder / "ladder")
    if _was_reverted(experiment, rungs):
        _set_aside(rungs[-1].path)
    _pending_path(experiment.folder).unlink(missing_ok=True)


def _set_aside(path: Path) -> Path:
    folder = path.parent / "undone"
    folder.mkdir(exist_ok=True)
    number = 1
    while (kept := folder / f"{path.stem}-{number}.json").exists():
        number += 1
    path.rename(kept)
    return kept
