"""`stagecad new experiment`: an `experiment.toml` with comments and questions, from the files of a measurement."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from pathlib import Path

from stagecad.parameters.errors import InputError
from sysid.experiment.columns.proposal import ExperimentProposal, Proposal, propose, read_numbers
from sysid.experiment.readers.base import shown_path
from sysid.experiment.readers.open import RecordFile, open_record_file
from sysid.experiment.rig_kinds.declaration import find_rig
from sysid.experiment.rigs import ALWAYS_ALLOWED

QUESTION = "QUESTION:"
"""Mark of a line that the user should look at."""


def inspect(files: Sequence[Path], kind: str | None) -> tuple[list[RecordFile], ExperimentProposal]:
    """The files, and the experiment proposed from the first of them.

    Raises:
        InputError: a file that cannot be read, files with different columns, or an unknown kind of rig.
    """
    if kind is not None:
        find_rig(kind, "--kind")
    opened = [open_record_file(file, shown_path(str(file))) for file in files]
    for other in opened[1:]:
        if other.header.labels != opened[0].header.labels:
            raise InputError(
                f"{other.name}: has other columns than {opened[0].name}; make an experiment of each, or give the "
                "columns of one under [[record]] by hand"
            )
    numbers = read_numbers(opened[0])
    if not any(values.size for values in numbers.columns.values()):
        reason = next(iter(numbers.reasons.values()), "has a header and no rows of numbers")
        raise InputError(f"{opened[0].name}: {reason}")
    return opened, propose(opened[0], numbers, kind)


def free_experiment(folder: Path) -> Path:
    """The file `experiment.toml` to be written into `folder`, which is made if it is missing.

    It is to be written last: that it exists says that the folder is complete.

    Raises:
        InputError: there is one already.
    """
    target = folder / "experiment.toml"
    if target.exists():
        raise InputError(f"{target}: exists already; remove it first, or name another folder")
    if folder.exists() and not folder.is_dir():
        raise InputError(f"{folder}: is a file; a folder is required")
    folder.mkdir(parents=True, exist_ok=True)
    return target


def questions(proposal: ExperimentProposal) -> list[str]:
    """Questions that the user should decide, one line each."""
    asked = [f"rig.kind = '{proposal.kind}': {proposal.question}"] if proposal.question else []
    for column in proposal.columns:
        if column.question and column.channel is not None:
            asked.append(f"column {column.number} '{column.label}': {column.question}")
    return [*asked, *(f"no column is taken for {name}" for name in missing_channels(proposal))]


def experiment_text(folder: Path, opened: Sequence[RecordFile], proposal: ExperimentProposal) -> str:
    """The text of `experiment.toml`."""
    rig = find_rig(proposal.kind, "--kind")
    lines = [
        f"# Lines with {QUESTION} are guesses. Answer them, and remove the mark.",
        "schema = 1",
        "",
        "[rig]",
        f'kind = "{proposal.kind}"' + (f"    # {QUESTION} {proposal.question}" if proposal.question else ""),
        "",
        "[rig.known]    # what you know of the rig; what is not here is fitted where that is possible",
    ]
    for name, known in rig.known.items():
        if name != ("mass" if proposal.rotary else "inertia"):
            unit = known.rotary_unit if proposal.rotary else known.unit
            lines.append(f'# {name} = "1 {unit}"' if unit else f'# {name} = "1"')
    lines += ["", "[model]", f"effects = {json.dumps(usual_effects(proposal.kind))}", ""]
    remarks = opened[0].header.remarks
    lines += [f"# The files are read as: {', '.join(remarks)}. [format] says otherwise.", ""] if remarks else []
    if proposal.missing:
        lines += [
            "[format]",
            f"missing = {json.dumps(list(proposal.missing))}    # {QUESTION} do these cells mark gaps?",
            "",
        ]
    lines.append("[channels]    # for all records")
    lines += [_channel_line(column, opened[0].header.numbered) for column in proposal.columns if column.channel]
    pulses = any(column.increments for column in proposal.columns)
    for name, unit in missing_channels(proposal).items():
        if pulses and name == "position or velocity":
            lines.append(f"# {QUESTION} how far is it from pulse to pulse? position = {{pulses_per_turn = 1}}")
            lines.append('# or: position = {pitch = "20 um"}')
            continue
        first, _, other = name.partition(" or ")
        also = f"    # or {other}" if other else ""
        lines.append(f'# {QUESTION} which column is it? {first} = {{column = 1, unit = "{unit}"}}{also}')
    left = [f"#   {c.number} '{c.label}'" + f": {c.reason}" * bool(c.reason) for c in proposal.columns if not c.channel]
    lines += ["# columns without a channel:", *left[:30]] if left else []
    for k, file in enumerate(opened):
        role = "validate" if len(opened) > 1 and k == len(opened) - 1 else "fit"
        relative = Path(os.path.relpath(Path(str(file.path)).resolve(), folder.resolve())).as_posix()
        lines += ["", "[[record]]", f'file = "{relative}"', f'role = "{role}"']
        if role == "validate":
            lines[-1] += f"    # {QUESTION} is this the record to hold out from the fit?"
        if k == 0:
            lines += ['# from = "+2 s"    # from two seconds after the first row', '# to = "+20 s"']
    lines += ["", "# [noise]    # standard deviation of the noise of a channel, if you know it"]
    for column in proposal.columns:
        if column.channel in rig.measured_channels:
            lines.append(f'# {column.channel} = "1e-3 {rig.declared(column.channel).si_unit(proposal.rotary)}"')
    return "\n".join(lines) + "\n"


def _channel_line(column: Proposal, numbered: bool) -> str:
    name = str(column.number) if numbered else '"' + column.label.replace("\\", "\\\\").replace('"', '\\"') + '"'
    entries = [f"column = {name}"]
    entries += [f'unit = "{column.unit}"'] if column.unit else []
    entries += [f'scale = "? {column.scale}"'] if column.scale else []
    entries += ["increments = true"] if column.increments else []
    value = name if len(entries) == 1 else "{" + ", ".join(entries) + "}"
    # A load or temperature of unknown unit is left out until the question is answered; no fit needs it.
    optional = column.channel in ALWAYS_ALLOWED and column.channel != "time"
    left = "# " if optional and (column.unit == "?" or column.scale) else ""
    return f"{left}{column.channel} = {value}" + (f"    # {QUESTION} {column.question}" if column.question else "")


def missing_channels(proposal: ExperimentProposal) -> dict[str, str]:
    """Channels that the kind of rig needs and no column is taken for, with their units."""
    rig = find_rig(proposal.kind, "--kind")
    found = {column.channel for column in proposal.columns}
    groups = (("time",), *rig.inputs, *rig.measured)
    return {
        " or ".join(group): rig.declared(group[0]).si_unit(proposal.rotary)
        for group in groups
        if not found & set(group)
    }


def usual_effects(kind: str) -> list[str]:
    """Effects of a first model of a kind of rig."""
    rig = find_rig(kind, "--kind")
    return [] if "actuator-tip" in (rig.name, rig.base) else ["coulomb", "viscous"]
