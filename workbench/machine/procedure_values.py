"""The calculated numbers of the assembly procedure, from the same calculators as the checks."""

from __future__ import annotations

import json
import math
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from designcalc.checks.inputs import Reading, Weighed
    from drawings.procedure.figures import ProcedureValues
    from stagecad.parameters.design import Design
    from stagecad.parameters.mass_properties import MassProperties
    from stagecad.solids.artefacts.store import Store

VALUES = "procedure_values.json"


def procedure_values(design: Design, weighed: Weighed | None = None) -> ProcedureValues:
    """What `drawings.procedure.procedure` wants to be told, SI.

    Args:
        design: the design.
        weighed: what the solids weigh; without it the stage counts as a plain plate.
    """
    from designcalc.bearing.sliding import crown_wear_depth, crown_wear_distance
    from designcalc.checks.inputs import Reading
    from designcalc.checks.machine import heaviest_pad, teeth, usable_ellipse
    from designcalc.checks.teeth import CIRCUITS
    from designcalc.drive.height_adjustment import clamp_shift, wedge_drive
    from drawings.procedure.figures import ProcedureValues

    r = Reading(design, weighed, "assembly procedure")
    wedge = wedge_drive(r("set_screw.pitch"), r("height_pin_1.slope"), r("height_pin_1.stroke"))
    force = _preload(r, "clamp_long")
    shift = clamp_shift(
        screw_force=force,
        wrap=r("base.clamp_neck_angle_1") - math.acos(2 * r("base.clamp_slot_1") / r("base.pocket_diameter")),
        holder_diameter=r("holder.diameter"),
        holder_height=r("holder.height"),
        play=r("base.pocket_diameter") - r("holder.diameter"),
        apex_height=r("holder.floor") + r("piezo.length") + r("actuator.tip_height"),
        modulus=r.material("holder", "youngs_modulus"),
        poisson=r.material("holder", "poisson_ratio"),
    )
    distance = 2 * r("stage.travel") * r("bearing.run_in_cycles")
    crown, rate, load = r("pads.crown_radius"), r("bearing.run_in_wear_rate"), heaviest_pad(r)
    half_worn = float(crown_wear_distance(r("bearing.film_thickness") / 2, crown, rate, load))
    return ProcedureValues(
        way_preload=_preload(r, "way"),
        bar_preload=_preload(r, "bar"),
        clamp_force=force,
        magnet_pull=CIRCUITS * float(teeth(r).point.attraction) if design.teeth.fitted else None,
        lift_per_turn=float(wedge.lift_per_turn),
        lift_per_degree=float(wedge.lift_per_degree),
        adjustment=float(wedge.range) / 2,
        ellipse_height=usable_ellipse(r)[1],
        clamp_squeeze=float(shift.squeeze),
        clamp_drop=float(shift.drop),
        clamp_sideways=float(shift.sideways),
        run_in_distance=distance,
        run_in_time=distance / r("requirements.speed"),
        run_in_wear=float(crown_wear_depth(distance, crown, rate, load)),
        film_strokes=half_worn / (2 * r("stage.travel")),
    )


def stored_values(store: Store, design: Design, moving: MassProperties, tip: MassProperties) -> ProcedureValues:
    """The same from the cache, without a calculator loaded; the field between the teeth takes a second to work out.

    Args:
        moving, tip: what the solids weigh.
    """
    from drawings.procedure.figures import ProcedureValues

    def make(reading: Any, folder: Path) -> None:
        from designcalc.checks import Weighed

        values = procedure_values(reading, Weighed(moving, tip))
        (folder / VALUES).write_text(json.dumps(asdict(values)), "utf-8")

    entry = store.make("procedure values", design, (__name__,), make, (repr((moving, tip)),))
    return ProcedureValues(**entry.document(VALUES))


def _preload(r: Reading, screw: str) -> float:
    from designcalc.bearing.fastener import preload_of_torque

    return float(preload_of_torque(*(r(f"screws.{screw}.{name}") for name in ("torque", "diameter", "nut_factor"))))
