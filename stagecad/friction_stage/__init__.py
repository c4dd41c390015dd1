"""The friction stage of the thesis: what it states of itself for the tool."""

from pathlib import Path

from stagecad.friction_stage.design import Design
from stagecad.friction_stage.parameters.derived import COMPUTED, Tables
from stagecad.friction_stage.parameters.physics import Material
from stagecad.friction_stage.parameters.ranges import kinds, with_range
from stagecad.parameters.machine import Machine

_RULES = ("sliding", "height", "holes", "making", "stops", "teeth", "values")
_OWNERS = {
    "stage": ("stage",),
    "pads": ("stage",),
    "sea": ("stage",),
    "bearing_way": ("bearing_way",),
    "base": ("base",),
    "actuator": ("tip", "holder"),
    "tip": ("tip",),
    "holder": ("holder",),
    "height_pin_1": ("height_pin_1",),
    "height_pin_2": ("height_pin_2",),
    "teeth": ("stage", "tooth_bar", "tooth_iron"),
    "tooth_bar": ("tooth_bar",),
    "tooth_iron": ("tooth_iron",),
    "stop_bar": ("stop_bar",),
    "sensor_bracket": ("sensor_bracket",),
    "magnet": ("magnet",),
    "end_stop": ("stop_bar",),
    "piezo": ("piezo",),
    "buffer": ("buffer",),
    "lead_clip": ("lead_clip",),
    "interferometer": ("interferometer",),
    "mirror": ("mirror",),
    "screws.way": ("way_screw",),
    "screws.clamp_long": ("clamp_screw_long",),
    "screws.clamp_short": ("clamp_screw_short",),
    "screws.bar": ("bar_screw",),
    "screws.stop": ("stop_screw",),
    "set_screw": ("set_screw",),
    "spring": ("spring",),
}

MACHINE = Machine(
    name="friction_stage",
    tables=Tables,
    material=Material,
    design=Design,
    computed=COMPUTED,
    bounded=with_range,
    kinds=kinds,
    rules=tuple(f"{__name__}.rules.{module}" for module in _RULES),
    owners=_OWNERS,
    file=Path(__file__).parent / "parameters" / "thesis.toml",
)
