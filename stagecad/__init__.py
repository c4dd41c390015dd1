"""Design a piezo friction-drive stage from one parameter file, and find out why the real one does not behave like it.

>>> import stagecad
>>> stagecad.load_design().si("stage.thickness")
0.012
"""

from importlib import import_module

__version__ = "0.1.0"

_MODULES = {
    "Design": "workbench.api.design",
    "load_design": "workbench.api.design",
    "Effect": "sim.library.effect",
    "Parameter": "sim.library.effect",
    "Scan": "sim.library.effect",
    "Model": "workbench.api.statement",
    "Record": "workbench.api.statement",
    "Rig": "workbench.api.statement",
    "RigKind": "workbench.api.statement",
    "Experiment": "workbench.api.experiment",
    "Comparison": "workbench.api.comparison",
    "compare": "workbench.api.comparison",
    "Diagnosis": "workbench.api.diagnosis",
    "diagnose": "workbench.api.diagnosis",
    "Addition": "workbench.api.growth",
    "Ladder": "workbench.api.growth",
    "add": "workbench.api.growth",
    "ladder": "workbench.api.growth",
    "Undone": "workbench.api.growth",
    "undo": "workbench.api.growth",
    "Differences": "workbench.api.differences",
    "diff": "workbench.api.differences",
    "Suggestion": "workbench.api.suggestion",
    "suggest": "workbench.api.suggestion",
    "Checks": "workbench.api.machine",
    "Drawings": "workbench.api.machine",
    "Parts": "workbench.api.machine",
    "checks": "workbench.api.machine",
    "drawings": "workbench.api.machine",
    "parts": "workbench.api.machine",
    "SimulatedRecords": "workbench.api.simulation",
    "Simulation": "workbench.api.simulation",
    "simulate": "workbench.api.simulation",
    "InputError": "stagecad.parameters.errors",
}
"""Module of each public name, loaded when the name is first used. `__init__.pyi` declares their types."""

__all__ = sorted(_MODULES)  # pyright: ignore[reportUnsupportedDunderAll]


def __getattr__(name: str) -> object:
    if name not in _MODULES:
        raise AttributeError(f"module 'stagecad' has no attribute '{name}'")
    found = getattr(import_module(_MODULES[name]), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
