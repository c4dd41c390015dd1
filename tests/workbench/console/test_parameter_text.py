"""Fitted values in the terminal and on the page: the same words for what the records leave open."""

from __future__ import annotations

import pytest

from workbench.console.loop_rows import parameter_rows
from workbench.console.loop_text import parameter_table, ranking_table

SETTLED = {"value": 1.2, "unit": "N", "low": 1.1, "high": 1.3}


@pytest.mark.parametrize(
    ("quantity", "interval", "word"),
    [
        (SETTLED, "1.1 N … 1.3 N", ""),
        ({**SETTLED, "low": -0.1}, "-100 mN … 1.3 N", "may as well be zero"),
        ({**SETTLED, "low": None, "high": None}, "", "not told by these records"),
        ({**SETTLED, "high": None}, "", "not told by these records"),
        ({**SETTLED, "low": None, "high": None, "at_bound": True}, "", "at its bound"),
        ({**SETTLED, "at_bound": True}, "1.1 N … 1.3 N", "at its bound"),
    ],
)
def test_a_value_has_its_interval_and_the_doubt_about_it(quantity, interval, word):
    (row,) = parameter_rows({"coulomb.force": quantity})
    assert (row["interval"], row["word"]) == (interval, word)
    columns = [column.header for column in parameter_table({"coulomb.force": quantity}).columns]
    assert columns == ["parameter", "value", "95 % interval", *(["remark"] if word else [])]


def test_an_effect_that_changes_nothing_is_not_below_zero():
    row = {"effect": "viscous", "expected_reduction": 0.0, "reduction": -0.0004, "p_value": 0.9}
    (reached,) = ranking_table([row], 1).columns[2].cells
    assert reached == "0.0 %"
