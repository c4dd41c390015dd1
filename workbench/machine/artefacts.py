"""The machine's solids and the calculated values of its assembly procedure, from the cache or made now."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from workbench.cli.options import Run

if TYPE_CHECKING:
    from drawings.friction_stage.procedure.figures import ProcedureValues
    from stagecad.friction_stage.assembly.machine import Machine
    from stagecad.parameters.design import Design
    from stagecad.parameters.mass_properties import BodyMasses
    from stagecad.solids.artefacts.store import ArtefactStore

VALUES = "procedure_values.json"
Result = TypeVar("Result")


def with_repair(run: Run, store: ArtefactStore, write: Callable[[], Result]) -> Result:
    """`write()`, begun again after each damaged artefact that it meets, which the store then makes again.

    Raises:
        OSError: an artefact made again is damaged too.
    """
    from stagecad.solids.artefacts.outputs import DamagedError

    dropped: set[str] = set()
    while True:
        try:
            return write()
        except DamagedError as damage:
            if damage.entry.key in dropped:
                raise OSError(f"the cache in {store.folder} does not keep what is written to it") from None
            dropped.add(damage.entry.key)
            store.drop(damage.entry)
            run.note("a stored result was damaged; it is made again")


def built_machine(run: Run, store: Any = None) -> Machine:
    """The machine of the run's design, from the cache or built now; `store` is the cache, by default the user's own.

    The CAD kernel cannot be interrupted within a step: a note on a terminal states so before the kernel begins.
    """
    from stagecad.friction_stage.assembly.machine import build_machine, find_machine
    from stagecad.solids.modelling.registry import part_names

    machine = find_machine(run.design.values, store)
    if machine is not None:
        return machine
    with run.progress() as progress:
        if not progress.disable:
            run.note("making the parts; Ctrl-C ends it after the CAD kernel's step, which may take some seconds")
        task = progress.add_task("parts", total=len(part_names(run.design.values)) + 1)
        return build_machine(run.design.values, store, lambda name: progress.update(task, advance=1, description=name))


def procedure_values(store: ArtefactStore, design: Design) -> ProcedureValues:
    """The values of a design from the masses of its own solids, for `drawings.artefacts.tasks.build_all_sheets`."""
    from stagecad.friction_stage.assembly.machine import body_masses

    return stored_values(store, design, body_masses(design))


def stored_values(store: ArtefactStore, design: Design, masses: BodyMasses) -> ProcedureValues:
    """The values from the store, or computed if they are not there; the field between the teeth takes a second."""
    from drawings.friction_stage.procedure.figures import ProcedureValues

    def calculate(tracked: Any, folder: Path) -> None:
        from designcalc.checks.inputs import DesignInputs
        from designcalc.friction_stage.physics.assembly_values import assembly_values

        (folder / VALUES).write_text(json.dumps(assembly_values(DesignInputs(tracked, masses))), "utf-8")

    entry = store.make("procedure values", design, (__name__,), calculate, (repr((masses.moving, masses.tip)),))
    return ProcedureValues(**entry.document(VALUES))
