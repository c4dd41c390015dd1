"""Pages that are made of the program, or name its parts: effects, theory, convergence, thesis, glossary."""

import re
from pathlib import Path

import pytest

from benchmarks.convergence import converged_digits, shown
from designcalc.bearing.plate import SupportedPlate
from designcalc.checks.check import DesignInputs
from designcalc.friction_stage.physics.stage_plate import stage_plate
from sim.friction_stage.studies import STUDIES
from stagecad.parameters.load import load_design
from tests.docs.scripts import script
from workbench.cli.dispatch import COMMANDS
from workbench.operations.calculate import CALCULATORS
from workbench.operations.simulation.simulate import EXPERIMENTS, EXTRA

DOCS = Path(__file__).resolve().parents[2] / "docs"


def test_constants_and_tables_are_those_of_the_code() -> None:
    module = script("make_effects")
    written = (DOCS / "effects.md").read_text(encoding="utf-8")
    assert written == module.page(), "declarations have changed: run 'python docs/make_effects.py'"
    module = script("make_thresholds")
    text = (DOCS / "theory.md").read_text(encoding="utf-8")
    assert text.count("| `CERTAIN_Z` |") == 1
    assert module.with_thresholds(text) == text, "constants have changed: run 'python docs/make_thresholds.py'"
    assert [shown(value, 3) for value in (0.0123456, 184.65, 4902.1)] == ["0.0123", "185", "4900"]
    assert converged_digits(37.69, 37.67) == 3 and converged_digits(184.6, 180.6) == 2
    assert converged_digits(1.0, 1.0) == 5 and converged_digits(1.0, 2.0) == 1


PAGE = Path(__file__).parents[2] / "docs" / "convergence.md"
LIMITS = {
    "elements": 1e-3, "modes": 3e-2, "step (us)": 1e-3, "step, high (us)": 5e-3, "tolerance": 1e-6,
    "tolerance of the cycle": 1e-6, "modes on pads": 1e-2, "refinement": 1e-3, "functions": 1e-6,
    "tolerance of a run": 1e-6, "step, held (us)": 1e-2, "step, moving (us)": 3e-2, "parts": 1e-3, "modes held": 1e-3,
    "points": 1e-4, "points of the rule": 1e-6, "points of a pulse": 1e-6,
}  # fmt: skip
"""Largest difference of the rows in use; peaks of impacts and pulses converge slowest."""


@pytest.mark.parametrize("heading", LIMITS)
def test_every_digit_printed_of_the_rows_in_use_has_converged(heading: str) -> None:
    rows = PAGE.read_text(encoding="utf-8").split(f"| {heading} |")[1].split("\n\n")[0].strip().splitlines()
    cells = [[cell.strip() for cell in row.strip("|").split("|")] for row in rows]
    used = [row for row in cells if row[0].startswith("**")]
    assert len(used) == 1 and float(used[0][-1]) < LIMITS[heading]
    assert used[0][1:-1] == cells[-1][1:-1], "digits of the finest row"


def test_every_experiment_study_and_calculator_is_in_the_page() -> None:
    text = PAGE.read_text(encoding="utf-8")
    assert set(re.findall(r"^\| ([a-z][^|]*?) \| .*\| largest difference \|$", text, re.MULTILINE)) == set(LIMITS)
    names = [*({*EXPERIMENTS, *EXTRA} - {"stage"}), *STUDIES]
    calculators = [f"calc {name}" if f"`calc {name}`" in text else name for name in CALCULATORS]
    assert [name for name in (*names, *calculators) if f"`{name}`" not in text] == []


def test_the_page_has_the_modes_of_the_plate() -> None:
    """Of an estimated mass of the stage, three percent below that of the solids: within one percent of the page."""
    printed = re.search(r"\*\*20\*\* \| ([\d.]+) \|", PAGE.read_text(encoding="utf-8"))
    supported = stage_plate(DesignInputs(load_design()))
    fine = SupportedPlate(supported.plate, supported._springs, (), supported.bodies, 30).modes(3).frequency
    assert fine[0] == pytest.approx(float(printed[1]), rel=0.02)
    assert supported.modes(3).frequency == pytest.approx(fine, rel=1e-3)


THESIS_PAGE = (Path(__file__).parents[2] / "docs" / "thesis.md").read_text(encoding="utf-8")


def _numbers(heading: str) -> set[int]:
    """First column of the table of a section; `35 to 37` is three numbers."""
    rows = THESIS_PAGE.split(f"## {heading}\n")[1].split("\n## ")[0].splitlines()[3:]
    found: set[int] = set()
    for row in rows:
        first = row.split("|")[1] if row.startswith("|") else ""
        for low, high in re.findall(r"(\d+)(?: to (\d+))?", first):
            found |= set(range(int(low), int(high or low) + 1))
    return found


def test_figures_commands_and_symbols_are_listed() -> None:
    assert _numbers("Figures") == set(range(1, 43)) and _numbers("Tables") == {1, 2, 3}
    commands = set(re.findall(r"`stagecad ([a-z]+)", THESIS_PAGE))
    assert commands and commands <= set(COMMANDS)
    assert len(ENTRIES) > 50
    missing = [line for entry in ENTRIES for line in _missing(entry)]
    assert not missing, "\n".join(missing)


ROOT = Path(__file__).parents[2]
LINES = (ROOT / "docs" / "glossary.md").read_text(encoding="utf-8").splitlines()
ENTRIES = [line for line in LINES if line.startswith("| ") and not line.startswith(("| term", "| ---"))]


def _missing(entry: str) -> list[str]:
    """Symbols of an entry that do not stand in the file that follows them."""
    names: list[str] = []
    missing: list[str] = []
    for token in re.findall(r"`([^`]+)`", entry.strip("| ").rsplit(" | ", 1)[1]):
        if not token.endswith((".py", ".toml")):
            names.append(token)
            continue
        path = ROOT / token
        text = path.read_text(encoding="utf-8") if path.is_file() else ""
        symbols = (rf"^\s*(?:\[.*\.|def |class )?{name}\b\s*[(:=,\[\]]" for name in names)
        missing += [f"{token}: no {name}" for name, s in zip(names, symbols) if not re.search(s, text, re.MULTILINE)]
        names = []
    return missing
