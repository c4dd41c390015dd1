"""Parameters of the simulated machine: bodies, places, stiffnesses and limits, SI.

Axes: x along the travel, y across it, z up. Places are given from the middle of the stage (`Stage`) or of the base
(`Actuator`); heights from the drive surface, the face of the stage on which the tip acts, with the stage resting on its
pads.
"""

import math
from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True)
class Bending:
    """Bending modes of the free stage with its payload, orthogonal to the motion of the rigid body."""

    frequencies: np.ndarray  # Hz, shape (modes,)
    damping: float  # ratio
    # deflection at the nodes of a regular grid over the plate, of modes of mass 1 kg, kg^-1/2, shape (nodes along y,
    # nodes along x, modes)
    shapes: np.ndarray
    # of the grid, (x, y) from the middle of the stage, m, shape (2,); the opposite corner is at its negative
    corner: np.ndarray

    @property
    def spacing(self) -> np.ndarray:
        """Spacing of the nodes along x and y, m, shape (2,)."""
        return -2.0 * self.corner / (np.array(self.shapes.shape[1::-1]) - 1.0)

    def at(self, places: np.ndarray) -> np.ndarray:
        """Deflection and slopes along x and y at places (x, y) on the stage, kg^-1/2, shape (places, 3, modes)."""
        from sim.stage.state import shapes_at

        out = np.zeros((len(places), 3, len(self.frequencies)))
        for (x, y), shapes in zip(np.asarray(places, dtype=float).tolist(), out, strict=True):
            shapes_at(self.shapes, self.corner, self.spacing, (x, y), shapes)
        return out


RIGID = Bending(np.empty(0), 0.0, np.empty((2, 2, 0)), np.array([-1.0, -1.0]))


@dataclass(frozen=True)
class Stage:
    """The body that moves, payload and ballast included."""

    mass: float  # kg
    centre: np.ndarray  # of mass, from the middle of the stage at the height of the drive surface, m, shape (3,)
    inertia: np.ndarray  # about the centre of mass, kg m^2, shape (3, 3)
    preload: float = 0.0  # of the magnets, N, downwards at the middle of the stage; it moves with the stage
    guide_stiffness: float = 0.0  # of one tooth iron across the travel, N/m
    # middles of the tooth irons (x, y), m, shape (n, 2); empty without teeth
    guide_places: np.ndarray = field(default_factory=lambda: np.empty((0, 2)))
    guide_length: float = 0.0  # of an iron along the travel, m
    bending: Bending = RIGID  # modes; none for a rigid stage


@dataclass(frozen=True)
class Pads:
    """The sliding bearing."""

    places: np.ndarray  # centres (x, y), m, shape (n, 2)
    height: float  # of the drive surface over their faces, m
    contact_rate: float  # K of the normal force K delta^1.5 of one pad, N/m^1.5
    damping: float  # s/m, the normal force is K delta^1.5 (1 + damping ddelta/dt)
    static_friction: float  # coefficients
    dynamic_friction: float  # coefficients
    stribeck_velocity: float  # m/s; mu = mu_d + (mu_s - mu_d) exp(-(v/vs)^2)
    presliding: float  # distance from rest to full slip, m
    tangential_lag: float  # of the film's shear force behind its shear, s; damps while it sticks


@dataclass(frozen=True)
class Tip:
    """The rigid tip on its three piezos: it rises, tilts about the plane of their ends, and sways with that plane."""

    mass: float  # with the part of the stacks that moves with it, kg
    inertia: float  # about an axis in the piezos' plane, kg m^2
    height: float  # of the apex over the piezos' plane, m
    piezo_places: np.ndarray  # axes (x, y) of the piezos about the tip's axis, m, shape (3, 2)
    stiffness: float  # of one piezo, N/m
    damping: float  # of one piezo, N s/m
    moment: float = 0.0  # mass times height of the centre of mass over the piezos' plane, kg m
    # of the three stacks together against a force across them, N/m; infinite where they only stretch
    sway_stiffness: float = math.inf
    sway_damping: float = 0.0  # of the same, N s/m
    sway_play: float = math.inf  # sway at which the stacks touch the mouths of their bores, m
    sway_stop: float = 0.0  # stiffness that the bores add beyond it, N/m

    @property
    def sways(self) -> bool:
        return math.isfinite(self.sway_stiffness)


@dataclass(frozen=True)
class Contact:
    """Between tip and drive surface."""

    rate: float  # K of Hertz's K delta^1.5, N/m^1.5
    damping: float  # s/m, as of a pad: the coefficient of restitution is 1 - (2/3) damping v for slow impacts
    friction: float  # coefficient
    tangential_ratio: float  # of the tangential to the normal stiffness, 2 (1 - nu)/(2 - nu) by Mindlin


@dataclass(frozen=True)
class Piezo:
    """One stack with its amplifier."""

    stroke: float  # of the whole sweep from 0 to the highest voltage, m
    highest_voltage: float  # V
    bias: float  # voltage of mid-stroke, V
    hysteresis: float  # width of the loop of the whole sweep over its stroke
    creep: float  # extension gained per decade of time
    capacitance: float  # F
    current: float  # that the amplifier can give, A
    slew_rate: float  # of the amplifier itself, V/s
    bandwidth: float  # of the amplifier, Hz
    bits: int  # of the converter over the whole voltage
    loss: float = 0.0  # capacitance at full stroke times loss factor, F
    tension: float = math.inf  # that a stack without preload bears, N

    @property
    def voltage_rate(self) -> float:
        """Largest rate of the voltage, V/s: the amplifier's own, or that of its current into the capacitance."""
        return min(self.slew_rate, self.current / self.capacitance)

    def unclipped_frequency(self, amplitude: float) -> float:
        """Highest frequency of a sine of that amplitude, m, that the amplifier follows, Hz: rate/(2 pi volts)."""
        volts = amplitude * self.highest_voltage / self.stroke
        return self.voltage_rate / (2.0 * math.pi * volts)


@dataclass(frozen=True)
class Sensors:
    """Sensors of the control loop."""

    interferometer_count: float  # m
    probe_noise: float  # m rms within probe_bandwidth, Hz
    probe_bandwidth: float
    filter_frequency: float  # corner of the RC filter behind the probe, Hz
    filtered_range: float  # of the converter behind filter and gain, m
    filtered_count: float  # of the same, m
    lvdt_count: float  # m
    lvdt_linearity_error: float  # m


@dataclass(frozen=True)
class Surroundings:
    """Disturbances of a held position."""

    floor_velocity: float  # rms in each band, m/s
    floor_bands: tuple[tuple[float, float], ...]  # Hz
    held_resonance: float  # of the stage that tip and sticking pads hold, Hz
    held_damping: float  # its ratio
    amplifier_noise: float  # of each voltage, V rms within the amplifier's bandwidth
    air_error: float  # rms of the interferometer's error by the air's index, m
    air_time: float  # its time constant, s


@dataclass(frozen=True)
class StageMachine:
    """All parameters of the simulated stage."""

    stage: Stage  # see there
    pads: Pads  # see there
    tip: Tip  # see there
    contact: Contact  # see there
    piezo: Piezo  # see there
    sensors: Sensors  # see there
    actuators: np.ndarray  # places (x, y) of the tips from the middle of the base, m, shape (n, 2), n = 1 or 3
    travel: float  # of the stage, end to end, m
    gravity: float  # m/s^2
    surroundings: Surroundings | None = None  # disturbances of the position loop; None without any

    @property
    def load(self) -> float:
        """Weight and preload, N."""
        return self.stage.mass * self.gravity + self.stage.preload
