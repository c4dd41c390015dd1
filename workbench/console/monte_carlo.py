"""The spread of drawn machines as text for a person."""

from __future__ import annotations

import numpy as np

from workbench.console.feature_text import feature_text
from workbench.options import Run
from workbench.simulation.monte_carlo import Study, followed

MOST_NAMED = 8


def say_study(run: Run, study: Study) -> None:
    """What was drawn, and each feature's value at the design, its deviation and 95 % band over the draws."""
    from rich.table import Table

    named = "; ".join(one.words for one in study.opened[:MOST_NAMED])
    more = len(study.opened) - MOST_NAMED
    run.say(f"drawn: {named}" + (f"; and {more} more" if more > 0 else ""))
    for experiment in dict.fromkeys(way[0] for way in study.spreads):
        table = Table(title=experiment, title_justify="left", box=None, header_style="bold")
        for title in ("", "design", "deviation", "2.5 %", "97.5 %", "follows most"):
            table.add_column(title, justify="left" if title in ("", "follows most") else "right")
        for way, spread in study.spreads.items():
            if way[0] != experiment or not spread.moves:
                continue
            found = spread.found
            low, high = np.quantile(found, [0.025, 0.975])
            cells = [spread.nominal, found.std(ddof=1), low, high]
            table.add_row(
                "  ".join(word.replace("_", " ") for word in way[1:]),
                *[feature_text(None if x is None else {"value": float(x), "unit": spread.unit}) for x in cells],
                followed(spread) or "-",
            )
        if table.row_count:
            run.console.print(table)
        still = [way for way, spread in study.spreads.items() if way[0] == experiment and not spread.moves]
        if still:
            run.say(f"{experiment}: {len(still)} features do not move")
    refused = study.refused
    if refused:
        run.note(f"{len(refused)} of {len(study.draws)} draws do not stand, the first: {refused[0][1]}")
