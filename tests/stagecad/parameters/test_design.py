"""The design: what the packaged file holds, how overrides, partial files and computed values work."""

import math
import pickle
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stagecad.friction_stage.parameters.derived import COMPUTED
from stagecad.parameters.design import Design
from stagecad.parameters.errors import InputError
from stagecad.parameters.file import packaged_text, read_parameter_file
from stagecad.parameters.iso286 import is_class
from stagecad.parameters.load import design_from_text, diff, further_override, load_design, write_values
from stagecad.parameters.machine import packaged_machine
from tests.refusals import refused


@pytest.fixture(scope="module")
def thesis() -> Design:
    return load_design()


def test_facts_and_heights_of_the_thesis(thesis: Design) -> None:
    """Numbers that the thesis states, and their units as the tables keep them."""
    assert thesis.actuator.piezo_spacing == 46.0 and thesis.actuator.tip_height == 20.0
    way = thesis.bearing_way
    assert (way.length, way.width, way.height) == (280.0, 80.0, 25.4)
    assert (way.bolt_edge, way.width - way.bolt_edge) == (10.0, 70.0)
    assert thesis.screws.way.diameter == 9.525 and thesis.screws.way.length == 25.4
    assert thesis.set_screw.pitch == 3.175 and (thesis.shim.thinnest, thesis.shim.thickest) == (0.0127, 0.762)
    assert thesis.friction.bristle_damping == math.sqrt(1e5) and thesis.requirements.speed == 0.2
    assert thesis.si("requirements.acceleration") == pytest.approx(thesis.environment.gravity)
    assert [thesis.plus_minus(key) for key in ("stage.length", "stage.thickness", "pads.height")] == [0.1, 0.1, 0.01]
    # The stack of section 8: base 0, way 25.4, drive surface and apex 27.4, piezo plane 7.4, holder bottom -34.6.
    derived = thesis.derived
    assert derived.drive_surface_height == pytest.approx(27.4)
    assert derived.tip_apex == pytest.approx(27.4) and derived.piezo_plane == pytest.approx(7.4)
    assert derived.holder_bottom == pytest.approx(-34.6) and 2 * derived.height_adjustment == pytest.approx(1.0)
    assert thesis.piezo.length + thesis.holder.floor - thesis.holder.height == pytest.approx(5.4)
    assert derived.piezo_circle == pytest.approx(26.56, abs=0.005)
    assert derived.actuator_places[1] == pytest.approx((-86.6, 50.0), abs=0.01)
    assert derived.way_screw_end_margin == pytest.approx(25.7)
    assert derived.way_screw_engagement == pytest.approx(11.1) and len(derived.way_screw_places) == 14
    assert thesis.piezo.stiffness == pytest.approx(47e6, rel=2e-3)
    one, two, three = load_design(None, ["actuator.piezo_spacing=50 mm"]).derived.piezo_places
    for a, b in ((one, two), (two, three), (three, one)):
        assert math.dist(a, b) == pytest.approx(50.0)
    assert [sum(axis) for axis in zip(one, two, three)] == pytest.approx([0.0, 0.0], abs=1e-12)


def test_every_entry_has_an_origin_of_its_own(thesis: Design) -> None:
    """What is made from a drawing has a tolerance class; every origin is of a known kind."""
    for entry in thesis.entries:
        kind = entry.origin.split()[0]
        assert kind in ("thesis", "catalogue", "assumed:", "computed:"), entry
        assert (kind == "computed:") == (entry.key in COMPUTED)
    made = {"stage", "pads", "bearing_way", "base", "tip", "holder", "height_pin_1", "height_pin_2", "tooth_iron"}
    # A stroke, a margin or a coating is no dimension of a part.
    no_dimension = {f"height_pin_1.{name}" for name in ("stroke", "coating_thickness")}
    no_dimension |= {"stage.travel", "bearing_way.bolt_end", "tip.coating_thickness", "tip.relief_cover"}
    no_dimension |= {"height_pin_2.sag_tolerance", "pads.sag_tolerance", "bearing_way.pair_tolerance"}
    for entry in thesis.entries:
        if entry.unit == "mm" and entry.key.split(".")[0] in made and entry.key not in no_dimension:
            assert entry.tolerance in ("X", "X.X", "X.XX") or is_class(entry.tolerance or ""), entry


def test_the_packaged_file_gives_no_number_that_follows_from_others() -> None:
    design = design_from_text(packaged_text(), "here")
    for key in COMPUTED:
        assert design.entry(key).origin.startswith("computed:")


def test_si_materials_and_attributes_of_every_key(thesis: Design) -> None:
    assert thesis.si("stage.length") == 0.23 and thesis.si("pads.count") == 3.0
    assert thesis.si("base.clamp_neck_angle_1") == pytest.approx(math.radians(100.0))
    assert thesis.si("bearing.film_thickness") == thesis.bearing.film_thickness == 2e-6
    refused("is not a number", thesis.si, "stage.material")
    refused(r"did you mean 'stage.length'\?", thesis.si, "stage.lenght")
    assert thesis.material("bearing_way.material") is thesis.materials["sic"]
    assert {"al_6061_t6", "invar_36", "sus416", "sic", "ptfe", "steel", "iron", "ndfeb", "pzt"} <= set(thesis.materials)
    assert load_design(None, ["base.material=sus416"]).material("base.material").expansion == pytest.approx(9.9e-6)
    for entry in thesis.entries:
        holder: object = thesis
        for name in entry.key.split("."):
            holder = holder[name] if holder is thesis.materials else getattr(holder, name)  # type: ignore[index]
        assert holder == entry.value
    assert len(packaged_machine().schema()) <= len(thesis.entries)
    given = load_design(None, ["bearing_way.bolt_count=6"])
    assert (given.bearing_way.bolt_count, thesis.bearing_way.bolt_count) == (6, 7)
    assert len(given.derived.way_screw_places) == 12


def test_a_users_own_material(tmp_path: Path) -> None:
    file = tmp_path / "own.toml"
    file.write_text(
        'extends = "thesis"\n[stage]\nmaterial = "beryllium"\n[materials.beryllium]\ndescription = "Be S-200F"\n'
        'density = "1850 kg/m^3"\nyoungs_modulus = "303 GPa"\npoisson_ratio = 0.07\nexpansion = "11.4 um/m/K"\n'
        'strength = "240 MPa"\nstrength_kind = "yield"\nmagnetic = false\n',
        "utf-8",
    )
    design = load_design(file)
    assert design.material("stage.material").density == 1850.0 and design.stage.length == 230.0


def test_tolerance_classes_and_uncertainties_of_values(tmp_path: Path) -> None:
    file = tmp_path / "bare.toml"
    file.write_text('extends = "thesis"\n[stage]\nthickness = "12.50 mm"\nlength = "240 mm"\nwidth = "27 cm"\n')
    design = load_design(file)
    assert [design.tolerance(f"stage.{name}") for name in ("thickness", "length", "width")] == ["X.XX", "X", "X.X"]
    assert design.stage.width == 270.0
    design = load_design(None, ["payload.mass=1.79 +- 0.01 kg", "stage.thickness=12 +- 0.02 mm"])
    assert design.payload.mass == 1.79 and design.entry("payload.mass").std == 0.01
    assert design.entry("stage.thickness").std == pytest.approx(0.02)


def test_an_override_changes_its_value_and_the_digest_of_values_and_crosses_processes(thesis: Design) -> None:
    thicker = load_design(None, ["stage.thickness=13 mm", "stage.thickness=14 mm"])
    changed = {item.key for item in diff(thesis, thicker)}
    holes = {"stage.payload_drill_depth", "stage.payload_thread_depth"}
    assert changed == {"stage.thickness", *holes, "interferometer.beam_height", "mirror.height"}
    assert thicker.stage.thickness == 14.0
    assert thicker.tolerance("stage.thickness") == thesis.tolerance("stage.thickness")
    assert thicker.entry("stage.thickness").origin == "assumed: given by --set" and thicker.digest != thesis.digest
    assert load_design(None, ["screws.way.length=25.4 mm"]).digest == thesis.digest
    assert load_design(None, ["stage.thickness=12.001 mm"]).digest != thesis.digest
    commented = design_from_text("# a remark\n" + packaged_text(), "here")
    assert commented.digest == thesis.digest and pickle.loads(pickle.dumps(thesis)) == thesis


def test_measured_values_are_written_back_with_comments_and_line_ends_kept(tmp_path: Path) -> None:
    file = tmp_path / "stage.toml"
    text = packaged_text().replace("[bearing]\n", "[bearing]\n# the film was run in for 4000 cycles\n")
    file.write_text(text, "utf-8")
    write_values(file, {"bearing.dynamic_friction": (0.043, "measured: run_7")})
    written = file.read_text("utf-8")
    old, new = text.splitlines(), written.splitlines()
    (line,) = [line for line in new if line not in old]
    assert line == 'dynamic_friction = {value = 0.043, origin = "measured: run_7"}'
    assert len(old) == len(new)
    design = load_design(file)
    assert design.bearing.dynamic_friction == 0.043
    assert design.entry("bearing.dynamic_friction").origin == "measured: run_7"
    file.write_bytes(b'extends = "thesis"\r\n[stage] # mine\r\nlength = "240 mm"\r\n')
    values = {"stage.thickness": ("12.05 mm", "measured: cmm_2"), "screws.way.torque": ("12 N*m", "measured: t")}
    write_values(file, values)
    assert b"[stage] # mine\r\n" in file.read_bytes()
    design = load_design(file)
    assert design.stage.thickness == 12.05 and design.screws.way.torque == 12.0


@pytest.mark.parametrize(("key", "value", "origin"), [
    ("stage.thickness", "12 kg", "measured: x"), ("stage.thicknes", "12 mm", "measured: x"),
    ("stage.thickness", "12 mm", "because"), ("stage.length", "205 mm", "measured: x"),
    ("length", "205 mm", "measured: x"),
])  # fmt: skip
def test_a_bad_value_leaves_the_file_as_it_was(tmp_path: Path, key: str, value: str, origin: str) -> None:
    file = tmp_path / "stage.toml"
    file.write_text(packaged_text(), "utf-8")
    with pytest.raises(InputError):
        write_values(file, {key: (value, origin)})
    assert file.read_text("utf-8") == packaged_text() and list(tmp_path.iterdir()) == [file]


@pytest.mark.parametrize("override", [
    "stage.length=232 mm", "actuator.piezo_spacing=60 mm", "holder.diameter==actuator.piezo_spacing + 30 mm",
    "piezo.length=20 mm", "materials.sus416.density=7800 kg/m^3", "stage.material=sus416", "drawing.revision=B",
])  # fmt: skip
def test_a_further_override_gives_the_design_that_is_loaded_with_it(override: str) -> None:
    first = ("stage.thickness=12.5 mm", "actuator.tip_height=20.5 mm")
    changed = further_override(read_parameter_file(), first)(override)
    assert changed == load_design(overrides=(*first, override), rules=False)


@pytest.mark.parametrize(
    "override",
    ["stage.length=1 kg", "stage.lenght=1 mm", "stage.length=-1 mm", "stage.length=", "stage.length==stage.length"],
)
def test_a_further_override_is_refused_as_any_other(override: str) -> None:
    with pytest.raises(InputError) as expected:
        load_design(overrides=(override,), rules=False)
    with pytest.raises(InputError) as found:
        further_override(read_parameter_file())(override)
    assert str(found.value) == str(expected.value)


def test_a_value_of_an_own_file_keeps_its_tolerance_class_and_fit(tmp_path: Path) -> None:
    file = tmp_path / "own.toml"
    file.write_text(
        'extends = "thesis"\n[bearing_way]\nheight = "25.4 mm"\n[height_pin_1]\ndiameter = "20 mm"\n'
        '[stage]\nthickness = {value = "13 mm", origin = "assumed: stiffer"}\n'
        'length = {value = "230 mm", tolerance = "X.X", origin = "assumed: closer"}\n',
        "utf-8",
    )
    design = load_design(file)
    kept = ("bearing_way.height", "height_pin_1.diameter", "stage.thickness")
    assert [design.tolerance(key) for key in kept] == ["X.XX", "f7", "X.X"]
    assert design.tolerance("stage.length") == "X.X"


THESIS = load_design()
LENGTHS = [entry.key for entry in THESIS.entries if entry.unit == "mm"]
NUMBERS = [entry for entry in THESIS.entries if isinstance(entry.value, float) and math.isfinite(entry.value)]

slight = st.dictionaries(st.sampled_from(LENGTHS), st.floats(0.98, 1.02), min_size=1, max_size=6)
wild = st.dictionaries(
    st.sampled_from([entry.key for entry in NUMBERS]), st.floats(-10.0, 10.0) | st.floats(1e-6, 1e6), max_size=3
)


def overrides(factors: dict[str, float]) -> list[str]:
    entries = [(THESIS.entry(key), factor) for key, factor in factors.items()]
    return [f"{entry.key}={entry.value * factor:.9g} {entry.unit}" for entry, factor in entries]


def attempt(texts: list[str]) -> Design | str:
    """The design, or the line that refuses it."""
    try:
        return load_design(None, texts)
    except InputError as error:
        return str(error)


@settings(max_examples=60)
@given(slight)
def test_slight_changes_give_a_machine_that_goes_together_or_a_line(factors: dict[str, float]) -> None:
    design = attempt(overrides(factors))
    if isinstance(design, str):
        assert design.isprintable()
        return
    # Each seen from the geometry itself, and not from the rule.
    half, way = design.stage.travel / 2, design.bearing_way
    low, high = design.base.way_gap / 2, design.base.way_gap / 2 + way.width - way.ledge_width
    for x, y in design.derived.pad_places:
        assert abs(x) + half + design.pads.length / 2 <= way.length / 2
        assert low <= abs(y) - design.pads.width / 2 and abs(y) + design.pads.width / 2 <= high
    assert half < design.stage.length / 2
    for x, y in design.derived.way_screw_places:
        assert abs(x) + way.bolt_hole / 2 < way.length / 2 and abs(y) + way.bolt_hole / 2 < design.base.width / 2
        for px, py in design.derived.actuator_places:
            assert math.hypot(x - px, y - py) > way.bolt_hole / 2 + design.base.pocket_diameter / 2
    assert abs(design.derived.tip_apex - design.derived.drive_surface_height) <= design.derived.height_adjustment
    # The pins pass through their bores at the limits of size: the largest pin in the smallest bore.
    for pin, bore in (("height_pin_1.diameter", "base.pin_1_bore"), ("height_pin_2.diameter", "base.pin_2_bore")):
        assert design.si(pin) + 1e-3 * design.deviations(pin)[1] < design.si(bore) + 1e-3 * design.deviations(bore)[0]
    assert design.holder.diameter < design.base.pocket_diameter
    assert 0 < design.derived.way_screw_engagement <= design.base.way_thread_depth


@settings(max_examples=60)
@given(wild)
def test_wild_changes_are_read_or_refused_in_a_line(factors: dict[str, float]) -> None:
    design = attempt(overrides(factors))
    if isinstance(design, str):
        assert design.isprintable()
        return
    for key in factors:
        declaration = packaged_machine().schema().get(key)
        if declaration is not None:
            assert declaration.low <= design.value(key) <= declaration.high


@settings(max_examples=60)
@given(st.text(max_size=40))
def test_any_text_as_an_override_is_read_or_refused_in_a_line(text: str) -> None:
    for override in (text, f"stage.length={text}", f"{text}=3 mm", f"teeth.fitted={text}", f"drawing.title={text}"):
        found = attempt([override])
        assert not isinstance(found, str) or found.isprintable()
