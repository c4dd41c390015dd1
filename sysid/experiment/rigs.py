"""Kinds of rig: imposed channels, measured channels and known quantities of each."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

from stagecad.parameters.formula import Formula


@dataclass(frozen=True)
class Channel:
    """A quantity that a record may contain, in SI units (temperature in degC) of a linear and of a rotary axis;
    `shows_axis` is whether its unit determines which one it is."""

    name: str
    unit: str
    rotary_unit: str
    shows_axis: bool = False

    def si_unit(self, rotary: bool) -> str:
        """The SI unit of the channel on a linear or a rotary axis."""
        return self.rotary_unit if rotary else self.unit


CHANNELS: dict[str, Channel] = {
    channel.name: channel
    for channel in (
        Channel("time", "s", "s"),
        Channel("position", "m", "rad", shows_axis=True),
        Channel("position_y", "m", "m"),
        Channel("velocity", "m/s", "rad/s", shows_axis=True),
        Channel("pull_position", "m", "rad", shows_axis=True),
        Channel("friction_force", "N", "N*m", shows_axis=True),
        Channel("spring_force", "N", "N*m", shows_axis=True),
        Channel("drive_force", "N", "N*m", shows_axis=True),
        Channel("voltage_1", "V", "V"),
        Channel("voltage_2", "V", "V"),
        Channel("voltage_3", "V", "V"),
        Channel("tip_x", "m", "m"),
        Channel("tip_y", "m", "m"),
        Channel("tip_z", "m", "m"),
        # On a rotary axis a load may be a force or a torque; it is not converted.
        Channel("normal_load", "N", "N"),
        Channel("temperature", "degC", "degC"),
    )
}

ALWAYS_ALLOWED = ("time", "normal_load", "temperature")


@dataclass(frozen=True)
class KnownQuantity:
    """A known quantity of a rig: SI unit on a linear and a rotary axis, whether it must be positive, and NAME of the
    parameter `rig.NAME` that it states, where that is not its key."""

    unit: str
    rotary_unit: str
    positive: bool = True
    parameter: str = ""

    def si_unit(self, rotary: bool) -> str:
        """Its SI unit on a linear or a rotary axis."""
        return self.rotary_unit if rotary else self.unit


MASS = KnownQuantity("kg", "kg*m^2")
_AXIS_KNOWN = {"mass": MASS, "inertia": KnownQuantity("kg", "kg*m^2", parameter="mass")}
_TIP_KNOWN = {
    "piezo_spacing": KnownQuantity("m", "m"),
    "tip_height": KnownQuantity("m", "m"),
    "bias_voltage": KnownQuantity("V", "V", positive=False),
}

LISTED = "; 'stagecad new experiment --help' lists the kinds of rig with their keys"
"""Ending of the refusal of a kind of rig, or of a key of `[rig.known]`."""
_ZERO = re.compile(r"\s*0(\.0*)?\s*\*[^+-]*")
"""A product with the factor 0 in front."""


@dataclass(frozen=True)
class RigKind:
    """A kind of rig; `known` are the permitted keys of `[rig.known]`.

    Of each group of `inputs` and of `measured` channels at least one must be recorded, the optional ones may be. The
    noise of `sensed_inputs` enters the residual. A declared kind has `own` channels, of which those of its `base` are
    made by the formulas of `balance`, and `constants` the base's known quantities; `defaults` are quantities, as
    written, for what is not given; `rotary` is whether the axis is, where units do not tell."""

    name: str
    inputs: tuple[tuple[str, ...], ...]
    measured: tuple[tuple[str, ...], ...]
    known: dict[str, KnownQuantity]
    optional_inputs: tuple[str, ...] = ()
    optional_measured: tuple[str, ...] = ()
    sensed_inputs: tuple[str, ...] = ()
    own: Mapping[str, Channel] = field(default_factory=dict)
    base: str = ""
    balance: Mapping[str, Formula] = field(default_factory=dict)
    constants: Mapping[str, Formula] = field(default_factory=dict)
    defaults: Mapping[str, str] = field(default_factory=dict)
    rotary: bool | None = None

    @property
    def zero_channels(self) -> frozenset[str]:
        """Channels of the base that the balance states as zero, by one term with the factor 0: not measured."""
        return frozenset(name for name, formula in self.balance.items() if _ZERO.fullmatch(formula.text))

    def declared(self, channel: str) -> Channel:
        """The declaration of one of its channels."""
        return self.own[channel] if channel in self.own else CHANNELS[channel]

    def parameter_of(self, key: str) -> str:
        """NAME of the parameter `rig.NAME` that a key of `[rig.known]` states."""
        return self.known[key].parameter or key

    def key_of(self, parameter: str) -> str | None:
        """The key of `[rig.known]` that states the parameter `rig.NAME`; None where it is always fitted."""
        return next((key for key in self.known if self.parameter_of(key) == parameter), None)

    @property
    def summary(self) -> str:
        """Its channels and known keys in one line."""
        parts = [("imposed", self.inputs), ("measured", self.measured)]
        texts = [f"{name}: {', '.join(' or '.join(group) for group in groups)}" for name, groups in parts]
        further = [*self.optional_inputs, *self.optional_measured]
        texts += [f"may be recorded: {', '.join(further)}"] * bool(further)
        keys = {
            one: [key for key in self.known if self.parameter_of(key) == self.parameter_of(one)] for one in self.known
        }
        known = dict.fromkeys(" or ".join(same) for same in keys.values())
        return "; ".join([*texts, f"known: {', '.join(known)}"])

    @property
    def all_channels(self) -> tuple[str, ...]:
        """Names of the channels of all kinds, and its own."""
        return (*CHANNELS, *self.own)

    @property
    def input_channels(self) -> tuple[str, ...]:
        """Channels imposed on the rig."""
        return tuple(name for group in self.inputs for name in group) + self.optional_inputs

    @property
    def measured_channels(self) -> tuple[str, ...]:
        """Channels measured on the rig."""
        return tuple(name for group in self.measured for name in group) + self.optional_measured

    @property
    def channels(self) -> tuple[str, ...]:
        """Channels that a record of this rig may contain, `time` first."""
        return ALWAYS_ALLOWED + self.input_channels + self.measured_channels


_VOLTAGES = (("voltage_1",), ("voltage_2",))
_SPRING = {"pull_stiffness": KnownQuantity("N/m", "N*m/rad")}
_DRIVE_KNOWN = {
    "mass": MASS,
    **_TIP_KNOWN,
    "normal_load": KnownQuantity("N", "N"),
    "preload": KnownQuantity("N", "N"),
    "piezo_gain": KnownQuantity("m/V", "m/V", parameter="gain"),
    "contact_stiffness": KnownQuantity("N/m", "N/m"),
    "contact_damping": KnownQuantity("N*s/m", "N*s/m", positive=False),
    "press": KnownQuantity("m", "m"),
}
_FRICTION, _DRIVE, _MOTION = (("friction_force",),), (("drive_force",),), (("position", "velocity"),)
_SPRING_ENDS = (("pull_position",),), (("position", "spring_force"),)
RIGS: dict[str, RigKind] = {
    rig.name: rig
    for rig in (
        RigKind("velocity-drive", _MOTION, _FRICTION, _AXIS_KNOWN, sensed_inputs=(*_MOTION[0], "normal_load")),
        RigKind("spring-pull", *_SPRING_ENDS, _AXIS_KNOWN | _SPRING, sensed_inputs=("pull_position",)),
        RigKind("force-drive", _DRIVE, _MOTION, _AXIS_KNOWN, sensed_inputs=("drive_force",)),
        RigKind("actuator-tip", _VOLTAGES, (("tip_x",), ("tip_y",)), _TIP_KNOWN, ("voltage_3",), ("tip_z",)),
        RigKind("friction-drive", _VOLTAGES, (("position",),), _DRIVE_KNOWN, ("voltage_3",), ("position_y",)),
    )
}
