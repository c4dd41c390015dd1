"""A design of the friction stage: its tables as typed attributes, and what follows from them."""

from dataclasses import dataclass
from functools import cached_property

from stagecad.friction_stage.parameters import parts, physics
from stagecad.friction_stage.parameters.derived import Derived
from stagecad.parameters import design


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
class Design(design.Design, Tables):
    """Every number of the machine: the tables of the parameter file as attributes, and every entry by its key."""

    @cached_property
    def derived(self) -> Derived:
        """Heights, places and envelopes that follow from the parameters."""
        return Derived(self)
