"""Nothing runs into anything that is not meant to meet it, at the ends and the middle of travel and height."""

import math
from dataclasses import replace

import pytest

from stagecad.parameters.design import Design
from stagecad.solids.artefacts.store import ArtefactStore
from stagecad.solids.assembly import interference
from stagecad.solids.assembly.built_machine import BuiltMachine
from stagecad.solids.assembly.interference import Interference, build_interferences, clashes, find_interferences
from stagecad.solids.modelling.registry import construction


@pytest.fixture(scope="module")
def found(machine: BuiltMachine, design: Design, store: ArtefactStore) -> list[Interference]:
    return build_interferences(store, machine.parts, design)


def at_rest(found: list[Interference], first: str, second: str) -> Interference:
    (meeting,) = [m for m in found if {m.first, m.second} == {first, second} and m.travel == m.height == 0.0]
    return meeting


def test_no_clash_anywhere(found: list[Interference]) -> None:
    assert [(m.first, m.second, m.travel, m.height, m.common_volume) for m in clashes(found)] == []
    assert {(m.travel, m.height) for m in found} == {(t, h) for t in (-1.0, 0.0, 1.0) for h in (-1.0, 0.0, 1.0)}


def test_contacts_touch(found: list[Interference]) -> None:
    touching = [m for m in found if m.kind in ("contact", "sliding contact", "drive contact")]
    measured = [m for m in touching if m.clearance is not None and m.travel == m.height == 0.0]
    assert len(measured) >= 12
    for meeting in measured:
        assert meeting.clearance == pytest.approx(0.0, abs=1e-6), meeting


def test_fits_have_the_clearance_of_their_diameters(found: list[Interference], design: Design) -> None:
    holder = (design.base.pocket_diameter - design.holder.diameter) / 2.0
    assert at_rest(found, "base", "holder_1").clearance == pytest.approx(holder, abs=1e-5)
    pin = (design.base.pin_2_bore - design.height_pin_2.diameter) / 2.0
    assert at_rest(found, "base", "height_pin_2_1").clearance == pytest.approx(pin, abs=1e-5)


def test_threads_overlap_by_their_ring(found: list[Interference], design: Design) -> None:
    screw, drill = design.screws.way, design.threads.unc_3_8_tap_drill
    ring = math.pi / 4.0 * (screw.diameter**2 - drill**2) * design.derived.way_screw_engagement
    overlap = at_rest(found, "base", "way_screw_left_1").common_volume
    # The screw's chamfered end and the hole's chamfered mouth take a little of it.
    assert overlap == pytest.approx(ring, rel=0.15)
    assert overlap < ring


def test_tooth_gap_is_the_designs(found: list[Interference], design: Design) -> None:
    gaps = [m.clearance for m in found if m.kind == "gap" and "tooth_iron" in m.second and m.clearance is not None]
    assert gaps
    assert gaps[0] == pytest.approx(design.teeth.gap, abs=1e-6)


def test_the_tip_is_clear_below_and_pressed_above(found: list[Interference], design: Design) -> None:
    drive = {m.height: m for m in found if m.kind == "drive contact" and m.travel == 0.0}
    assert drive[1.0].common_volume > 1.0
    assert drive[0.0].common_volume < interference.TOUCH


def test_a_part_put_wrong_is_found(machine: BuiltMachine, design: Design, monkeypatch: pytest.MonkeyPatch) -> None:
    made = construction(design)

    def sunk(*arguments: object, **named: object) -> tuple:
        """The stage half a millimetre too low."""
        return tuple(
            replace(instance, frame=instance.frame.shifted((0.0, 0.0, -0.5))) if instance.part == "stage" else instance
            for instance in made.assemble(*arguments, **named)  # type: ignore[arg-type]
            if instance.part in ("stage", "bearing_way", "base")
        )

    monkeypatch.setattr(interference, "construction", lambda _: replace(made, assemble=sunk))
    wrong = clashes(find_interferences(machine.parts, design, [(0.0, 0.0)]))
    pressed = {frozenset((m.first, m.second)): m.common_volume for m in wrong}
    assert set(pressed) == {frozenset(("bearing_way_left", "stage")), frozenset(("bearing_way_right", "stage"))}
    # Half a millimetre of the crowned pads: less than of flat ones, and a good part of it.
    pads = {"left": 2, "right": 1}
    for side, number in pads.items():
        flat = number * 0.5 * design.pads.length * design.pads.width
        assert 0.85 * flat < pressed[frozenset((f"bearing_way_{side}", "stage"))] < flat
