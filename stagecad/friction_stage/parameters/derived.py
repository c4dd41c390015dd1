"""Dimensions that follow from others.

Two kinds: values of keys that a parameter file may leave out (`COMPUTED`), and positions and envelopes in the assembly
without a key (`Derived`). Millimetres; x along the travel, y across it, z up; the origin is at actuator 1 on
the top of the base.
"""

import math
import tomllib
from dataclasses import dataclass
from pathlib import Path

from stagecad.friction_stage.parameters import parts, physics
from stagecad.parameters.design import Design
from stagecad.parameters.machine import Computed
from stagecad.parameters.threads import BOTTOMING_TAP

Place = tuple[float, float]


COMPUTED: dict[str, Computed] = {
    key: Computed(*stated)
    for key, stated in tomllib.loads(Path(__file__).with_suffix(".toml").read_text("utf-8")).items()
}
"""Formulas of the keys that a parameter file may leave out, with the tolerance class of the resulting dimension."""


def corners(along: float, across: float) -> list[Place]:
    """The four corners (x, y) of a rectangle about the origin, by rising x, then y."""
    return [(sx * along / 2, sy * across / 2) for sx in (-1, 1) for sy in (-1, 1)]


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
    piezo: parts.Piezo
    buffer: parts.Buffer
    lead_clip: parts.LeadClip
    interferometer: parts.Interferometer
    mirror: parts.Mirror
    amplifier: physics.Amplifier
    screws: parts.Screws
    set_screw: parts.SetScrew
    spring: parts.Spring
    shim: parts.Shim
    threads: parts.Threads
    making: parts.Making
    drive: physics.Drive
    bearing: physics.Bearing
    friction: physics.Friction
    sensors: physics.Sensors
    requirements: physics.Requirements
    environment: physics.Environment
    loop: physics.Loop
    heat: physics.Heat
    candidates: physics.Candidates
    drawing: physics.Drawing


@dataclass(frozen=True)
class Derived:
    """Places, heights and envelopes that follow from a design. mm unless a name says otherwise."""

    design: Tables

    @property
    def drive_surface_height(self) -> float:
        """Height of the drive surface, and of the tip's apex when it just touches: way and pads."""
        return self.design.bearing_way.height + self.design.pads.height

    @property
    def wedge_height(self) -> float:
        """Height of the wedge face at the middle of the adjustment."""
        return self.design.height_pin_1.flat_height - self.design.base.pin_1_axis_depth

    @property
    def holder_bottom(self) -> float:
        """Height of the holder's bottom at the middle of the adjustment."""
        return self.wedge_height + self.design.height_pin_2.length

    @property
    def holder_top(self) -> float:
        """Height of the holder's top at the middle of the adjustment."""
        return self.holder_bottom + self.design.holder.height

    @property
    def piezo_plane(self) -> float:
        """Height of the piezos' ends at the middle of the adjustment."""
        return self.holder_bottom + self.design.holder.floor + self.design.piezo.length

    @property
    def tip_apex(self) -> float:
        """Height of the tip's apex at the middle of the adjustment."""
        return self.piezo_plane + self.design.actuator.tip_height

    @property
    def height_adjustment(self) -> float:
        """Range of the height of the tip to either side of the middle: half the wedge pin's stroke times its slope."""
        return self.design.height_pin_1.stroke / 2 * self.design.height_pin_1.slope

    @property
    def piezo_circle(self) -> float:
        """Radius of the circle through the three piezos: R = D / sqrt(3)."""
        return self.design.actuator.piezo_spacing / math.sqrt(3.0)

    @property
    def piezo_places(self) -> tuple[Place, Place, Place]:
        """Axes (x, y) of piezos 1, 2, 3 about the tip's axis."""
        half, radius = self.design.actuator.piezo_spacing / 2, self.piezo_circle
        return (-half, -radius / 2), (half, -radius / 2), (0.0, radius)

    @property
    def actuator_places(self) -> tuple[Place, Place, Place]:
        """Axes (x, y) of the three actuator pockets: an equilateral triangle, the first at the origin."""
        spacing = self.design.base.actuator_spacing
        back = -spacing * math.sqrt(3.0) / 2
        return (0.0, 0.0), (back, spacing / 2), (back, -spacing / 2)

    @property
    def fitted_places(self) -> tuple[Place, ...]:
        """Axes of the actuators that are fitted."""
        return self.actuator_places[: self.design.actuator.fitted]

    @property
    def pad_places(self) -> tuple[Place, ...]:
        """Centres (x, y) of the pads from the middle of the stage."""
        along, across = self.design.pads.spacing_along / 2, self.design.pads.spacing_across / 2
        far = ((0.0, -across),) if self.design.pads.count == 3 else ((-along, -across), (along, -across))
        return ((-along, across), (along, across), *far)

    @property
    def seat_edge(self) -> float:
        """Inner edge of the seats of the ways, from the middle of the base."""
        return self.design.base.seat_gap / 2

    @property
    def way_screw_places(self) -> tuple[Place, ...]:
        """Axes (x, y) of the way screws: the left way's (y > 0) first, each by rising x."""
        way = self.design.bearing_way
        across = self.design.base.way_gap / 2 + way.width - way.bolt_edge
        along = [(i - (way.bolt_count - 1) / 2) * way.bolt_spacing for i in range(way.bolt_count)]
        return tuple((x, side * across) for side in (1, -1) for x in along)

    @property
    def way_hole_places(self) -> tuple[Place, ...]:
        """Axes (x, y) of the tapped holes under the ways: the left way's (y > 0) first, each by rising x.

        The ways end flush with the side faces of the base, and their rows of screws are dimensioned from there.
        """
        way = self.design.bearing_way
        across = self.design.base.width / 2 - way.bolt_edge
        along = [(i - (way.bolt_count - 1) / 2) * way.bolt_spacing for i in range(way.bolt_count)]
        return tuple((x, side * across) for side in (1, -1) for x in along)

    @property
    def bar_hole_places(self) -> tuple[Place, ...]:
        """Axes (x, y) of the tapped holes for the screws of the tooth bars."""
        along, across = self.design.tooth_bar.screw_span / 2, self.design.teeth.bar_spacing / 2
        half = self.design.tooth_bar.screw_spacing / 2
        return tuple((x, side * across + step) for side in (1, -1) for x in (-along, along) for step in (-half, half))

    @property
    def payload_places(self) -> tuple[Place, ...]:
        """Axes (x, y) of the payload's tapped holes from the middle of the stage."""
        stage = self.design.stage
        columns, rows, pitch = stage.payload_columns, stage.payload_rows, stage.payload_pitch
        along = [(i - (columns - 1) / 2) * pitch for i in range(columns)]
        across = [(j - (rows - 1) / 2) * pitch for j in range(rows)]
        return tuple((x, y) for x in along for y in across)

    @property
    def way_screw_end_margin(self) -> float:
        """Distance of the last screw of a way from the end of the way."""
        way = self.design.bearing_way
        return (way.length - (way.bolt_count - 1) * way.bolt_spacing) / 2

    @property
    def way_screw_engagement(self) -> float:
        """Length of thread that a way screw has in the base."""
        return self.design.screws.way.length - self.design.bearing_way.flange_thickness

    @property
    def drive_surface_width(self) -> float:
        """Width of the drive surface: its strip, or the whole underside for two axes."""
        return self.design.stage.width if self.design.sea.whole_underside else self.design.sea.width

    @property
    def iron_width(self) -> float:
        """Width of one tooth iron: its teeth at their pitch."""
        return self.design.teeth.per_iron * self.design.teeth.pitch

    @property
    def end_stops(self) -> bool:
        """Whether the machine has end stops and the sensor on one of them."""
        return self.design.teeth.fitted and self.design.end_stop.count > 0

    @property
    def buffer_places(self) -> tuple[float, ...]:
        """Places y of the buffers at either end."""
        middle, pole = self.design.teeth.bar_spacing / 2, (self.iron_width + self.design.magnet.thickness) / 2
        # At the inner irons, and for four buffers at the outer ones too.
        offsets = [middle - pole, middle + pole] if self.design.end_stop.count > 2 else [middle - pole]
        return tuple(sorted([-y for y in offsets] + offsets))

    @property
    def interferometer_front(self) -> float:
        """Distance from the back of a stop bar to the front of the interferometer, along the travel."""
        optics = self.design.interferometer
        return self.design.sensor_bracket.optics - (optics.length - optics.screw_spacing) / 2

    @property
    def magnets(self) -> int:
        """Number of magnets: one in each iron pocket."""
        return 2 if self.design.teeth.fitted else 0


def full_clamp_thread(design: Design) -> float:
    """Length of full thread in the lug of a clamp, whose hole is as deep as its thread, mm."""
    return design.base.clamp_thread_depth - BOTTOMING_TAP * design.threads.unc_3_8_pitch


def full_set_screw_thread(design: Design) -> float:
    """Distance from the actuator's axis from which on the thread of the set screw is full, mm."""
    return design.base.set_screw_thread_end + BOTTOMING_TAP * design.threads.unc_1_pitch
