"""`stagecad calc` and `stagecad check` as a user or a script runs them."""

import json

import numpy as np
import pytest

from tests.reference.tables import cases


def test_calc_hertz_of_a_point_and_of_a_line(command):
    words = ("--load", "9.7 N", "--radius-1", "2.5 mm", "--modulus-1", "207 GPa", "--poisson-1", "0.3")
    found = command.json("calc", "hertz", *words, "--modulus-2=69 GPa", "--poisson-2=0.33")
    assert found["inputs"]["load"] == {"value": 9.7, "unit": "N"}
    assert found["inputs"]["radius_2"]["value"] is None  # infinite: JSON has no such number
    assert found["results"]["peak_pressure"]["value"] == pytest.approx(1e9, rel=2e-3)
    assert found["results"]["semi_axis_major"] == found["results"]["semi_axis_minor"]
    of_hertz = {"semi_axis_major", "semi_axis_minor", "peak_pressure", "approach", "stiffness", "secant_stiffness"}
    of_strength = {"peak_shear", "peak_shear_depth", "first_yield_pressure", "yield_margin", "edge_tension"}
    assert set(found["results"]) == of_hertz | of_strength
    # F ~ delta^1.5, and a sphere with nu = 0.3 yields first at 1.61 times its yield strength (Johnson, section 6.1)
    results = found["results"]
    assert results["secant_stiffness"]["value"] == pytest.approx(results["stiffness"]["value"] / 1.5)
    assert results["first_yield_pressure"]["value"] == pytest.approx(1.61 * 276e6, rel=5e-3)
    assert results["edge_tension"]["value"] == pytest.approx((1 - 2 * 0.3) / 3 * results["peak_pressure"]["value"])
    found = command.json("calc", "hertz", "--load", "10 N", "--radius-1", "5 mm", "--length", "10 mm")
    assert found["results"]["approach"] is None
    half_width = found["results"]["semi_axis_minor"]["value"]
    assert found["results"]["peak_shear_depth"]["value"] == pytest.approx(0.78615 * half_width, rel=1e-4)
    found = command.json("calc", "hertz", "--radius-1", "7 mm", "--radius-2", "-9 mm")
    assert found["inputs"]["radius_1_minor"]["value"] == 7e-3 and found["inputs"]["radius_2_minor"]["value"] == -9e-3


def test_calc_rail_and_teeth_give_the_sheets_table_and_the_magnets_share(command):
    words = [f"--{part}-modulus=207 GPa" for part in ("rail", "bed", "bolt")]
    found = command.json("calc", "rail", *words, "--poisson", "0.3", "--flange-ratio", "2")
    results = found["results"]
    assert float(f"{results['joint_stiffness_per_diameter']['value']:.2e}") == 4.78e10
    rows = {(row["spacing_ratio"], row["flange_ratio"]): row["stiffness"]["value"] for row in results["table"]}
    assert len(rows) == 27 and round(rows[4, 1.5] / 1e6) == 190
    assert results["total_stiffness"]["value"] == pytest.approx(rows[4, 2.0])
    plain = command.json("calc", "teeth")
    driven = command.json("calc", "teeth", "--magnet", "design")
    assert plain["results"]["lateral_over_normal"]["value"] == pytest.approx(0.075, abs=0.001)
    assert driven["results"]["attraction"]["unit"] == "N"
    # The magnet's reluctance softens the normal direction and leaves the lateral one its share.
    assert driven["results"]["lateral_over_normal"]["value"] > plain["results"]["lateral_over_normal"]["value"]
    found = command.json("calc", "rail", "--set", "bearing_way.bolt_spacing=40 mm")
    assert found["inputs"]["spacing_ratio"]["value"] == pytest.approx(40 / 9.525)


@pytest.mark.parametrize(
    "name, result, value",
    [
        ("drive", "travel_along", 12.3e-6),
        ("drive", "preload_ratio_for_1g", 2.333),
        # a film of next to nothing leaves Hertz's spot: (3 F R/(4 E*))^(1/3)
        ("pads --load 10N --film-thickness 1nm", "contact_radius", (3 * 10 * 2 / (4 * 65.2e9)) ** (1 / 3)),
        ("wedge", "lift_per_turn", 158.75e-6),
        ("screw", "stress_area", 50e-6),
        ("probe", "noise", 1.732e-9),
        ("stack --side-force 10N", "pull_by_drive", 10 * 20 / 46),
        ("stack", "peak_current", np.pi * 5e3 * 1.4e-6 * 150),
        # s/(s + x) with a half-span of 12.5 mm on the tip's line, and the rest of the load rubbing on the pads
        ("tip-over", "share_of_load", 12.5 / 112.5),
        ("tip-over --position 0mm --preload-ratio 0.1", "acceleration", 0.3 * 1.1 * 9.80665),
        ("clamp --torque 0N*m", "drop", 62e-3 * (1 - np.cos(0.03 / 36.6))),
        ("wear --load 16N --crown-radius 2m", "distance", np.pi * 2 * 1e-12 / 1e-13 / 16),
        # the mean over Hertz's pressure on a circle: sigma sqrt(pi) l/sqrt(8 pi a^2/9)
        (
            "smoothness --waviness 0m --pads 1 --contact-length 1.5mm",
            "roughness_by_formula",
            20e-9 * np.pi / np.sqrt(2) * 20e-6 / (0.75e-3 * np.sqrt(8 * np.pi / 9)),
        ),
        ("air-bearing", "load", 90.0),
        ("levitation", "stiffest", 24 * 1e-7 / 0.03**5),
        ("bow --expansion-1 1.3ppm/K", "bow", 0.0),
        ("vibration --stiffness 12MN/m --mass 3kg", "resonance", 2000 / (2 * np.pi)),
        ("alignment", "cosine_error", 0.2 * 0.5e-8),
    ],
)
def test_calc_runs_the_small_calculators(command, name, result, value):
    found = command.json("calc", *name.split())
    assert found["results"][result]["value"] == pytest.approx(value, rel=5e-3, abs=1e-15)


@pytest.mark.parametrize("text, message", cases("mistakes", "profile"))
def test_calc_says_what_is_wrong_with_a_profile(command, tmp_path, text, message):
    file = tmp_path / "way.csv"
    file.write_text(text, "utf-8")
    line = command.refused("calc", "smoothness", "--profile", file)
    assert message in line and "way.csv" in line


def test_calc_ranks_suspensions_and_rides_a_measured_profile(command, tmp_path):
    assert command.json("calc", "suspensions")["results"]["table"][0]["suspension"] == "sliding pads"
    found = command.json("calc", "budget")
    rows = found["results"]["repeatability"]
    errors = {row["contribution"]: row["error"]["value"] for row in rows}
    # the aluminium stage grows by 23.6 ppm/K over half of its 230 mm
    assert errors["growth of the stage"] == pytest.approx(23.6e-6 * 0.115)
    # break-away of 0.06 (78.7 N + 29.5 N) bends three stacks of 3 E I/L^3 = 0.167 N/um and more
    assert rows[0]["contribution"] == "wind-up by the pads' friction"
    assert errors["wind-up by the pads' friction"] == pytest.approx(0.06 * 108.2 / 0.49e6, rel=0.02)
    place = np.arange(0, 40, 0.05)
    wave = 8 * np.sin(2 * np.pi * place / 10)
    rows = "\n".join(f"{x:.4f},{h:.6f}" for x, h in zip(place, wave))
    file = tmp_path / "way.csv"
    file.write_text("position [mm],height [nm]\n" + rows + "\n", "utf-8")
    found = command.json("calc", "smoothness", "--profile", str(file), "--contact-length", "1 mm")
    half = np.pi * 0.1
    transfer = 3 * (np.sin(half) - half * np.cos(half)) / half**3  # Fourier transform of a parabola
    assert found["results"]["peak_to_valley"]["value"] == pytest.approx(16e-9 * transfer, rel=5e-3)


def test_check_prints_a_list_and_fails_where_the_thesis_does(command, tmp_path):
    checks = command.json("check", "--no-solids", "--out", str(tmp_path), status=1)
    verdicts = {check["name"]: check["verdict"] for check in checks}
    assert verdicts["piezo stroke of the drive"] == "fails" and verdicts["interferometer range"] == "passes"
    assert set(checks[0]["value"]) == {"value", "unit"}
    assert json.loads((tmp_path / "checks" / "checks.json").read_text()) == checks
    assert "## Differences from the thesis" in (tmp_path / "checks" / "checks.md").read_text()


def test_check_without_teeth_sweeps_and_draws_what_there_is(command, tmp_path):
    words = ("check", "--no-solids", "--figures", "--out", str(tmp_path), "--set", "teeth.fitted=false")
    found = command.json(*words, "--sweep", "tip.nose_radius=10 mm:30 mm:3", status=1)
    assert (tmp_path / "checks" / "rail.png").is_file() and not (tmp_path / "checks" / "teeth.png").exists()
    stiffness = found["sweep"]["checks"]["tip contact against piezo stiffness"]["value"]
    assert stiffness[2] / stiffness[0] == pytest.approx(3 ** (1 / 3), rel=1e-6)
    assert (tmp_path / "checks" / "sweep_tip_nose_radius.png").stat().st_size > 10_000


@pytest.mark.slow
def test_check_draws_its_figures_into_one_page(command, tmp_path):
    command("check", "--no-solids", "--figures", "--out", str(tmp_path), status=1)
    page = (tmp_path / "checks" / "checks.html").read_text("utf-8")
    for name in ("rail", "teeth", "speed", "travel", "profile", "budget", "dynamic_budget"):
        assert (tmp_path / "checks" / f"{name}.png").stat().st_size > 10_000
    assert page.count('src="data:image/png;base64,') == 7
    assert "http" not in page  # opens without a network
    assert "Dynamic error budgets at the payload" in page and "refractive index of the air" in page
    spectra = json.loads((tmp_path / "checks" / "dynamic_budget.json").read_text("utf-8"))
    assert set(spectra) == {"along, filtered probe", "along, interferometer", "normal"}
    parts = spectra["along, filtered probe"]
    assert parts[-1]["disturbance"] == "total"
    squares = sum(row["rms"]["value"] ** 2 for row in parts[:-1])
    assert parts[-1]["rms"]["value"] == pytest.approx(squares**0.5, rel=1e-6)
    # each check has its formula, its numbers and the origin of its inputs; what failed has what would pass
    for words in ("2*10 um &lt;= 17 um", "assumed: by its name, at 150 V", "about mid-voltage"):
        assert words in page


def test_help_of_a_calculator_has_its_own_options_with_unit_and_default(command):
    out = command("calc", "wedge", "--help").out
    options = [line.split()[:2] for line in out.splitlines() if line.startswith("  --")]
    assert options == [["--pitch", "m"], ["--slope", "NUMBER"], ["--stroke", "m"]]
    assert "[default: set_screw.pitch]" in out and "--load" not in out
