"""All tables of the parameter file together, and the keys they declare."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, fields
from functools import cache
from typing import get_type_hints

from stagecad.friction_stage.parameters import alternatives, hardware, parts, physics
from stagecad.friction_stage.parameters.ranges import with_range
from stagecad.parameters.errors import nearest
from stagecad.parameters.schema import Declaration, declarations

MATERIALS = "materials"
"""The table that has one sub-table for each material; its names are free."""


@dataclass(frozen=True)
class Tables:
    """One attribute for each table of the parameter file except `materials`."""

    stage: parts.Stage
    pads: parts.Pads
    sea: parts.DriveSurface
    bearing_way: parts.BearingWay
    base: parts.Base
    actuator: physics.Actuator
    tip: parts.Tip
    holder: parts.Holder
    height_pin_1: parts.HeightPin1
    height_pin_2: parts.HeightPin2
    teeth: parts.Teeth
    tooth_bar: parts.ToothBar
    tooth_iron: parts.ToothIron
    stop_bar: parts.StopBar
    sensor_bracket: parts.SensorBracket
    magnet: parts.Magnet
    preload: physics.Preload
    payload: physics.Payload
    end_stop: physics.EndStop
    leads: physics.Leads
    piezo: hardware.Piezo
    buffer: hardware.Buffer
    lead_clip: hardware.LeadClip
    interferometer: hardware.Interferometer
    mirror: hardware.Mirror
    amplifier: physics.Amplifier
    screws: hardware.Screws
    set_screw: hardware.SetScrew
    spring: hardware.Spring
    shim: hardware.Shim
    threads: hardware.Threads
    making: parts.Making
    drive: physics.Drive
    bearing: physics.Bearing
    friction: physics.Friction
    sensors: physics.Sensors
    requirements: physics.Requirements
    environment: physics.Environment
    loop: physics.Loop
    candidates: alternatives.Candidates
    drawing: physics.Drawing


@cache
def _tables() -> dict[str, type]:
    """Every table by its dotted name (`stage`, `screws.way`), without materials."""
    found: dict[str, type] = {}

    def add(prefix: str, table: type) -> None:
        if declarations(table):
            found[prefix] = table
            return
        hints = get_type_hints(table)
        for item in fields(table):
            add(f"{prefix}.{item.name}", hints[item.name])

    hints = get_type_hints(Tables)
    for item in fields(Tables):
        add(item.name, hints[item.name])
    return found


@cache
def schema(materials: tuple[str, ...] = ("NAME",)) -> dict[str, Declaration]:
    """Every key that a parameter file with these materials may contain, with its declaration."""
    tables = {**_tables(), **{f"{MATERIALS}.{name}": physics.Material for name in materials}}
    return {
        f"{prefix}.{name}": with_range(f"{prefix}.{name}", declaration)
        for prefix, table in tables.items()
        for name, declaration in declarations(table).items()
    }


def nearest_key(key: str, known: Iterable[str]) -> str:
    """End of a message about an unknown key: the nearest known key, or the keys of its table."""
    keys = sorted(known)
    hint = nearest(key, keys)
    if key in {item.split(".")[0] for item in keys}:
        return f"; [{key}] is a table: name a key in it, like '{next(item for item in keys if item.startswith(key))}'"
    table, _, name = key.rpartition(".")
    if table.startswith(f"{MATERIALS}."):
        materials = {item.split(".")[1] for item in keys if item.startswith(f"{MATERIALS}.")}
        if table.split(".")[1] not in materials:
            return nearest(table.split(".")[1], materials).replace("did you mean", "did you mean material")
    if "did you mean" in hint:
        return hint
    table, _, name = key.rpartition(".")
    siblings = [item for item in keys if item.rpartition(".")[0] == table]
    if siblings:
        return f"; keys of [{table}]: {', '.join(item.rpartition('.')[2] for item in siblings)}"
    same = [item for item in keys if item.rpartition(".")[2] == name]
    if same:
        return f"; did you mean '{same[0]}'?"
    return nearest(key.split(".")[0], {item.split(".")[0] for item in keys})
