"""The calculated values of the assembly procedure, kept in the store of artefacts."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from drawings.procedure.figures import ProcedureValues
    from stagecad.parameters.design import Design
    from stagecad.parameters.mass_properties import BodyMasses
    from stagecad.solids.artefacts.store import ArtefactStore

VALUES = "procedure_values.json"


def procedure_values(store: ArtefactStore, design: Design) -> ProcedureValues:
    """The values of a design from the masses of its own solids, for `drawings.artefacts.tasks.make_sheets`."""
    from stagecad.solids.assembly.machine import body_masses

    return stored_values(store, design, body_masses(design))


def stored_values(store: ArtefactStore, design: Design, masses: BodyMasses) -> ProcedureValues:
    """The values from the store, or calculated now; the field between the teeth takes a second to compute."""
    from drawings.procedure.figures import ProcedureValues

    def calculate(tracked: Any, folder: Path) -> None:
        from designcalc.machine.assembly_values import assembly_values
        from designcalc.machine.inputs import DesignInputs

        (folder / VALUES).write_text(json.dumps(assembly_values(DesignInputs(tracked, masses))), "utf-8")

    entry = store.make("procedure values", design, (__name__,), calculate, (repr((masses.moving, masses.tip)),))
    return ProcedureValues(**entry.document(VALUES))
