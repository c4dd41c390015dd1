"""A proposed change is printed with what evaluating it on the whole design shows."""

from dataclasses import replace

import pytest

from designcalc.checks.check import Change, change
from designcalc.checks.run import evaluate_proposals, run_checks
from stagecad.parameters.errors import InputError
from stagecad.parameters.load import load_design
from stagecad.parameters.rules import violations

DESIGN = load_design(None, ())


def load(override: str):
    return load_design(None, (override,), rules=False)


@pytest.fixture(scope="module")
def evaluated():
    return evaluate_proposals(run_checks(DESIGN), DESIGN, None, load)


def test_every_change_says_what_a_run_with_it_shows(evaluated):
    """Each change is made again here, by itself, and all checks are run."""
    before = {check.name: check.verdict for check in evaluated}
    changes = [(check, one) for check in evaluated for one in check.changes]
    assert len(changes) > 15
    # Of the packaged machine each is enough for its own check, or cannot be made; most break nothing else.
    assert not [one.override for _, one in changes if "not enough" in one.result]
    assert sum(not one.result for _, one in changes) > 0.7 * len(changes)
    # One of every outcome is enough to run in full.
    outcomes = {one.result.split(" ")[0]: (check, one) for check, one in changes}
    assert {"", "passes,", "cannot"} <= set(outcomes)
    for check, one in outcomes.values():
        if one.result.startswith("is refused"):
            with pytest.raises(InputError):
                load(one.override)
            continue
        design = load(one.override)
        after = {c.name: c.verdict for c in run_checks(design)}
        worse = [name for name, verdict in after.items() if verdict != "passes" and before.get(name) == "passes"]
        if one.result == "":
            assert after[check.name] == "passes" and not worse and not violations(design)
            assert f"{one.key} = {one.text} passes, and no other check then fails" in check.proposal
        elif one.result.startswith("passes"):
            assert after[check.name] == "passes" and worse
            assert repr(worse[0]) in one.result
        else:
            assert one.result.startswith("cannot") and violations(design)


def test_a_usable_change_replaces_one_that_cannot_be_built(evaluated):
    shim = next(c for c in evaluated if c.name == "range of the adjustment against the thickest shim")
    assert [one.key for one in shim.changes] == ["shim.thickest", "height_pin_1.stroke"]
    assert "height_pin_1.stroke" not in shim.proposal and "shim.thickest = 500 um passes" in shim.proposal


def test_a_refused_or_insufficient_change_says_so():
    check = next(c for c in run_checks(DESIGN) if c.name == "piezo stroke of the drive")
    changes = (Change("actuator.stroke_amplitude", "9 um"), Change("actuator.stroke_amplitude", "-1 um"))
    (found,) = [
        c
        for c in evaluate_proposals(
            [replace(c, changes=changes if c.name == check.name else ()) for c in run_checks(DESIGN)],
            DESIGN,
            None,
            load,
        )
        if c.name == check.name
    ]
    assert [one.result.split(":")[0] for one in found.changes] == ["is not enough", "is refused"]
    assert "actuator.stroke_amplitude = 9 um is not enough" in found.proposal


@pytest.mark.parametrize(
    "value, up, text",
    [(0.027468, True, "27.5 mm"), (0.027468, False, "27.4 mm"), (0.02, True, "20 mm"), (1.2e-9, False, "1.2 nm")],
)
def test_a_change_is_rounded_to_the_safe_side(value, up, text):
    (one,) = change("tip.nose_radius", value, "m", up=up)
    assert one.override == f"tip.nose_radius={text}"
    assert change("tip.nose_radius", float("inf"), "m", up=up) == ()
