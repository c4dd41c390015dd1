"""Figures of results: one function a figure, which returns a matplotlib `Figure`; modules load when first used."""

from typing import TYPE_CHECKING, Any

from stagecad.deferred import DeferredModule

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from workbench.figures import checks, design, identification, plot, simulation
    from workbench.figures.plot import Plot
else:
    Figure = Plot = Any
    checks, design, identification, plot, simulation = (
        DeferredModule(f"{__name__}.{name}") for name in ("checks", "design", "identification", "plot", "simulation")
    )
