"""Each rule: an override that breaks it gets its message; the thesis's design passes all."""

import pytest

from stagecad.parameters.errors import InputError
from stagecad.parameters.load import load_design
from stagecad.parameters.machine import packaged_machine
from stagecad.parameters.rules.registry import all_rules, violations

BREAKS = [
    ("pad_proportion", ["pads.length=30 mm"], "make 2.5 : 1, but pads must be 2 : 1; make pads.width 15 mm"),
    ("pads_under_stage", ["stage.width=240 mm"], "it must be at least 246 mm"),
    ("pads_under_stage", ["pads.spacing_along=230 mm"], "it must be at least 258 mm"),
    ("pads_under_stage", ["pads.spacing_along=20 mm"], "leaves no gap"),
    ("pads_on_way", ["stage.travel=210 mm"], "the travel may be 204 mm"),
    ("pads_on_way", ["bearing_way.length=270 mm"], "need a bearing_way.length of 276 mm"),
    ("pads_on_way", ["pads.spacing_across=300 mm", "stage.width=330 mm"], "running face goes from 96 mm to 154 mm"),
    ("drive_surface_over_tip", ["stage.length=215 mm"], "must be at least 220 mm"),
    ("drive_surface_over_tip", ["sea.width=10 mm"], "it must be at least 12 mm"),
    ("drive_surface_over_tip", ["actuator.fitted=3", "teeth.fitted=false"], "set sea.whole_underside = true"),
    ("drive_surface_clear_of_pads", ["sea.width=220 mm"], "reach the pads"),
    ("crown_of_pads", ["pads.crown_radius=20 mm"], "falls away"),
    ("crown_of_pads", ["pads.crown_radius=31.8 m"], "a pad may be hollow"),
    ("threads_in_metal", ["stage.material=alumina"], "is brittle, and no holes are tapped in it"),
    ("edges", ["magnet.thickness=0.5 mm"], "at both ends leaves nothing of magnet.thickness"),
    ("edges", ["tooth_iron.corner_radius=5.1 mm"], "does not go into an iron of 10 mm"),
    ("edges", ["stage.corner_radius=0.4 mm"], "stage.edge_chamfer = 0.5 mm is not smaller than stage.corner_radius"),
    ("turned_edges", ["height_pin_2.crown_radius=6 mm"], "it must be more than 8 mm"),
    ("turned_edges", ["height_pin_1.end_chamfer=4.5 mm", "height_pin_1.spigot_length=10 mm"], "leaves no shoulder"),
    ("turned_edges", ["holder.index_depth=60 mm"], "cuts through holder.height"),
    ("turned_edges", ["tip.hub_diameter=120 mm"], "reaches the feet of the tip"),
    ("grooves", ["sea.groove_depth=11 mm"], "leaves too little of stage.thickness"),
    ("stage_holes", ["stage.dowel_spacing=226 mm"], "over the edge"),
    ("stage_holes", ["stage.payload_columns=6"], "stage.length = 230 mm; it must be at least 259 mm"),
    ("stage_holes", ["stage.payload_drill_depth=10 mm"], "would break through to the drive surface"),
    ("stage_holes", ["stage.dowel_spacing=150 mm", "stage.dowel_offset=52 mm"], "meets a payload hole"),
    ("ways_on_base", ["bearing_way.length=370 mm"], "is longer than base.length"),
    ("ways_on_base", ["base.width=340 mm"], "need 350 mm"),
    ("way_ledge", ["bearing_way.bolt_edge=7 mm"], "overhang the way's outer edge; at least 8.144 mm"),
    ("way_ledge", ["bearing_way.bolt_count=8"], "leave 6.65 mm of ceramic"),
    ("way_ledge", ["bearing_way.bolt_spacing=15 mm"], "touch; at least 16.288 mm is needed"),
    ("way_ledge", ["bearing_way.flange_thickness=26 mm"], "leaves no ledge"),
    ("way_screws", ["screws.way.length=0.75 in"], "engages 4.75 mm, and 9.525 mm is needed"),
    ("way_screws", ["screws.way.length=1.25 in"], "goes 17.45 mm deep"),
    ("tip_reaches_stage", ["base.pin_1_axis_depth=62 mm"], "2 mm below the drive surface"),
    ("tip_reaches_stage", ["height_pin_1.slope=0.02"], "covers 0.2 mm"),
    (
        "fits",
        ["base.pin_2_bore=16.02 mm", "height_pin_2.diameter=16.1 mm"],
        "does not go into base.pin_2_bore = 16.02 mm",
    ),
    ("fits", ["base.pocket_diameter=76.05 mm", "holder.diameter=75.5 mm"], "is loose in base.pocket_diameter"),
    ("fits", ["holder.bore_diameter=10.05 mm", "piezo.diameter=10.2 mm"], "does not go into holder.bore_diameter"),
    ("key_access", ["stage.width=330 mm"], "it must be at most 315.71"),
    ("key_access", ["stage.length=280 mm", "stage.travel=10 mm"], "it must be at most 266.5 mm"),
    ("tool_reach", ["holder.lead_slot_width=3 mm"], "holder.lead_slot_width would be right at 5.1 mm"),
    ("tool_reach", ["making.bore_depth_ratio=10"], "base.pin_1_bore would be right at 25 mm"),
    ("wedge", ["height_pin_1.length=30 mm"], "leaves the wedge"),
    ("wedge", ["height_pin_1.slope=0.2"], "leaves the pin"),
    ("wedge", ["base.pocket_clearance=6 mm"], "is guided over"),
    ("height_screw", ["spring.free_length=1.5 in"], "goes loose"),
    (
        "height_screw",
        ["height_pin_1.diameter=23 mm", "base.pin_1_bore=23.05 mm"],
        "does not pass the set screw's thread",
    ),
    ("height_screw", ["set_screw.length=1.5 in"], "the set screw leaves its thread"),
    ("holder_bores", ["holder.diameter=76 mm", "actuator.piezo_spacing=60 mm"], "it must be at least 83.332 mm"),
    ("holder_bores", ["holder.lift_radius=36 mm"], "over the edge of holder.diameter"),
    ("tip_body", ["tip.hub_diameter=18.2 mm"], "the hub by fillet and chamfer of 1.8 mm"),
    ("tip_body", ["tip.arm_width=16 mm"], "is wider than tip.foot_diameter"),
    ("tip_over_holder", ["holder.height=45 mm"], "comes within"),
    ("tip_over_holder", ["base.pocket_clearance=0.2 mm"], "at least 0.5 mm"),
    ("tip_over_holder", ["base.pocket_bore=30 mm"], "leave base.pocket_bore out"),
    ("tip_body", ["tip.foot_diameter=12 mm"], "at least 14.2 mm is needed"),
    ("tip_body", ["actuator.tip_height=7 mm", "tip.relief_cover=5 mm"], "leaves no cone"),
    (
        "holes_apart",
        ["base.lift_spacing_across=330 mm", "base.lift_spacing_along=228.6 mm"],
        "a way screw's hole and a lifting hole meet",
    ),
    ("holes_apart", ["bearing_way.bolt_edge=70 mm"], "a way screw's hole and the clamp screw's hole of pocket 2"),
    ("holes_apart", ["base.actuator_spacing=76 mm"], "pocket 1 and pocket 2"),
    ("holes_in_base", ["base.bracket_spacing_along=358 mm"], "a bracket hole comes too close to an edge"),
    ("holes_in_base", ["base.height=70 mm"], "is missing of making.least_wall = 2 mm"),
    ("pockets_between_ways", ["base.way_gap=180 mm"], "pocket 2 reaches under a way"),
    (
        "holes_and_seats",
        ["base.seat_overhang=0.4 mm"],
        "a setting-pin hole meets the edge of a seat of the ways, 95.4 mm",
    ),
    ("holes_and_seats", ["base.lift_spacing_across=195 mm"], "a lifting hole meets the edge of a seat"),
    ("height_bores", ["base.pocket_depth=50 mm"], "of floor between pocket and wedge pin"),
    ("clamp_screws", ["base.length=380 mm"], "screws.clamp_long.length = 6 in is too short"),
    ("clamp_screws", ["screws.clamp_short.length=5 in"], "too long"),
    ("clamp_screws", ["base.clamp_counterbore=12 mm"], "does not go into"),
    ("clamp_fingers", ["base.clamp_reach=54 mm"], "cuts the clamp screw's hole"),
    ("clamp_necks", ["base.clamp_neck_angle_2=123 deg"], "it must be at least 144.8 deg"),
    ("clamp_necks", ["base.clamp_neck_angle_2=168 deg"], "into the bore of height pin 1"),
    ("way_ledge", ["bearing_way.height=16 mm"], "leave 1.7 mm of ledge"),
    ("bars", ["tooth_bar.channel_depth=2 mm"], "is no deeper than teeth.groove_depth"),
    ("bars", ["tooth_bar.channel_depth=11 mm"], "leaves no bar"),
    ("clamp_fingers", ["base.clamp_screw_offset=44 mm"], "between the clamp screw and the pocket"),
    ("thread_depths", ["base.lift_thread_depth=30 mm"], "is deeper than base.lift_drill_depth"),
    ("teeth_for_one_axis", ["actuator.fitted=3"], "set teeth.fitted = false"),
    ("tooth_shape", ["teeth.width=5 mm"], "leaves no groove"),
    ("tooth_shape", ["teeth.groove_depth=7 mm"], "behind the teeth"),
    ("tooth_gap", ["tooth_bar.height=23 mm"], "leaves a gap of 0.4 mm under the irons"),
    (
        "iron_pockets",
        ["stage.iron_pocket_length=40.1 mm", "tooth_iron.length=41 mm"],
        "does not go into stage.iron_pocket_length",
    ),
    ("iron_pockets", ["stage.iron_pocket_width=24 mm"], "two irons and a magnet take 25 mm"),
    ("iron_pockets", ["teeth.bar_spacing=50 mm"], "into the drive surface"),
    ("iron_pockets", ["stage.payload_columns=3"], "breaks into an iron pocket"),
    ("bars", ["tooth_bar.length=260 mm"], "need 240 mm over stage.travel"),
    ("bars", ["tooth_bar.screw_span=250 mm"], "it must lie from 261.5 mm to 270.5 mm"),
    ("bars", ["tooth_bar.screw_spacing=44 mm"], "puts the screws off the feet"),
    ("bars", ["teeth.bar_spacing=80 mm"], "into the tip, whose foot reaches"),
    ("bars", ["screws.bar.length=12 mm"], "engages 2 mm, and 5 mm is needed"),
    ("buffers", ["end_stop.count=3"], "buffers stand in pairs"),
    ("buffers", ["end_stop.height=-2 mm"], "leave 0.2 mm between buffers and stage"),
    ("buffers", ["end_stop.height=-4 mm"], "below the irons, which stand out by 5 mm"),
    ("buffers", ["buffer.width=11 mm"], "wider than a tooth iron of 10 mm"),
    ("stop_bars", ["stop_bar.foot=28 mm"], "stop_bar.foot may be 27 mm"),
    ("stop_bars", ["stop_bar.overhang=13 mm"], "reach over the end of base.length"),
    ("stop_bars", ["stop_bar.relief=14 mm"], "at least 15.5 mm"),
    ("stop_bars", ["stop_bar.relief=24 mm"], "leave a nose of less than 4 mm"),
    ("stop_bars", ["buffer.length=22 mm"], "leave no nose"),
    ("stop_bars", ["stop_bar.counterbore=17 mm"], "breaks through a side"),
    ("stop_bars", ["stop_bar.screw_hole=6 mm"], "do not let"),
    ("stop_bars", ["stop_bar.grip=22 mm"], "do not sink the heads"),
    ("stop_bars", ["screws.stop.length=16 mm"], "engages 4 mm, and 6 mm is needed"),
    ("sensor", ["stop_bar.sensor_depth=5 mm"], "bring thread or bracket over the stop bar"),
    ("sensor", ["sensor_bracket.rise=4 mm"], "leave no wall over the screws"),
    ("sensor", ["interferometer.beam_height=18 mm"], "put the arm on the screws"),
    ("sensor", ["stop_bar.sensor_spacing=44 mm"], "puts the screws off"),
    ("sensor", ["stop_bar.sensor_drill_depth=30 mm"], "goes through the foot"),
    ("sensor", ["sensor_bracket.flange=12 mm"], "engages 4 mm, and 5 mm is needed"),
    ("sensor", ["sensor_bracket.length=150 mm"], "does not carry the interferometer"),
    ("sensor", ["interferometer.beam_height=45 mm"], "beam over the optics"),
    ("sensor", ["interferometer.screw_spacing=55 mm"], "does not fit interferometer.length"),
    ("sensor", ["mirror.width=36 mm"], "do not cover stage.target_spacing"),
    ("sensor", ["mirror.height=15 mm"], "hang 1.5 mm below the stage"),
    ("lead_clips", ["lead_clip.slot_width=5.5 mm"], "leave 0.25 mm of a clip"),
    ("lead_clips", ["lead_clip.length=60 mm"], "is longer than the lead channels"),
    ("ordered", ["shim.thinnest=1 mm"], "is more than shim.thickest"),
    ("screws_in_their_threads", ["screws.bar.thread=M4x0.7"], "which is tapped M5x0.8"),
    ("screws_in_their_threads", ["screws.way.pitch=1.5 mm"], "is not that of its tapped hole"),
    ("purchased_shapes", ["piezo.end_radius=4 mm"], "too small for an end"),
]


@pytest.mark.parametrize(("rule", "overrides", "words"), BREAKS)
def test_what_breaks_a_rule_is_told_in_the_users_words(rule: str, overrides: list[str], words: str) -> None:
    found = violations(load_design(None, overrides, rules=False))
    messages = [item.message for item in found if item.rule == rule]
    assert any(words in message for message in messages), found
    with pytest.raises(InputError) as caught:
        load_design(None, overrides)
    assert str(caught.value).isprintable()


def test_every_rule_can_be_broken_and_the_thesis_breaks_none() -> None:
    assert {rule for rule, _, _ in BREAKS} == set(all_rules(packaged_machine()))
    assert violations(load_design(rules=False)) == []


@pytest.mark.parametrize(
    "overrides",
    [
        ["actuator.tip_height=15 mm"],
        ["actuator.tip_height=25 mm"],
        ["actuator.piezo_spacing=40 mm"],
        ["bearing_way.height=30 mm"],
        ["bearing_way.length=340 mm"],
        ["bearing_way.width=70 mm"],
        ["bearing_way.bolt_spacing=19.05 mm"],
        ["bearing_way.bolt_spacing=95.25 mm"],
        ["stage.thickness=8 mm"],
        ["stage.thickness=20 mm"],
        ["stage.length=280 mm"],
        ["stage.width=290 mm"],
        ["stage.travel=100 mm"],
        ["teeth.gap=0.5 mm"],
        ["teeth.pitch=4 mm"],
        ["teeth.width=3 mm"],
        ["pads.length=20 mm", "pads.width=10 mm"],
        ["teeth.fitted=false"],
        ["base.material=sus416"],
    ],
)
def test_the_keys_that_scripts_change_can_be_changed_alone(overrides: list[str]) -> None:
    design = load_design(None, overrides)
    assert design.derived.tip_apex == pytest.approx(design.derived.drive_surface_height, abs=1e-9)


def test_two_axes_with_a_smaller_travel_can_be_built() -> None:
    two = ["actuator.fitted=3", "teeth.fitted=false", "sea.whole_underside=true", "pads.count=4"]
    assert len(load_design(None, [*two, "stage.travel=24 mm"]).derived.fitted_places) == 3
    with pytest.raises(InputError, match="second axis"):
        load_design(None, [*two, "stage.travel=40 mm"])
