"""Kinds of the project's tables of hardware: their columns, and the parts that choose a row."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

from stagecad.friction_stage.parameters import hardware, physics
from stagecad.parameters.project_tables import ROW, Kind
from stagecad.parameters.schema import declarations, mm


@dataclass
class _Thread:
    tap_drill: float = mm("of the thread")
    pitch: float = mm("of the thread")


@cache
def kinds() -> dict[str, Kind]:
    """The kinds of table by name."""

    def of(table: type, slots: tuple[str, ...], optional: tuple[str, ...] = ()) -> Kind:
        columns = {name: one for name, one in declarations(table).items() if name != ROW}
        free = (name for name, one in columns.items() if one.computed or one.default is not None)
        return Kind(columns, slots, (*optional, *free))

    threads = tuple(name.removesuffix("_pitch") for name in declarations(hardware.Threads) if name.endswith("_pitch"))
    screws = tuple(f"screws.{name}" for name in ("way", "clamp_long", "clamp_short", "bar"))
    ceramic = ("hysteresis", "strain_limit", "creep", "damping_ratio")
    return {
        "piezos": of(hardware.Piezo, ("piezo",), ceramic),
        "screws": of(hardware.Screw, screws, ("torque", "nut_factor")),
        "set_screws": of(hardware.SetScrew, ("set_screw",)),
        "springs": of(hardware.Spring, ("spring",)),
        "threads": Kind(declarations(_Thread), names=threads),
        "materials": of(physics.Material, ()),
    }
