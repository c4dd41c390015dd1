"""Design a piezo friction-drive stage from one parameter file, and find out why the real one does not behave like it.

>>> import stagecad
>>> stagecad.load_design().si("stage.thickness")
0.012
"""

from importlib import import_module

from stagecad.companions import use_companions

use_companions()

__version__ = "0.2.0"

_PUBLIC = {
    "sim.effects.effect": "Effect Parameter Scan",
    "stagecad.parameters.errors": "InputError",
    "workbench.operations.checks": "Checks checks",
    "workbench.operations.design": "Design load_design",
    "workbench.operations.diff": "Differences diff",
    "workbench.operations.drawings": "Drawings drawings",
    "workbench.operations.measurement.add": "Addition Ladder Restoration add ladder undo",
    "workbench.operations.measurement.compare": "Comparison compare",
    "workbench.operations.measurement.diagnose": "Diagnosis diagnose",
    "workbench.operations.measurement.experiment": "Experiment Model Record Rig RigKind",
    "workbench.operations.measurement.export": "Export export",
    "workbench.operations.measurement.look": "Look look",
    "workbench.operations.measurement.suggest": "Suggestion suggest",
    "workbench.operations.optimise": "Optimisation optimize",
    "workbench.operations.parts": "Parts parts",
    "workbench.operations.simulation.simulate": "SimulatedRecords Simulation simulate",
}
_MODULES = {name: module for module, names in _PUBLIC.items() for name in names.split()}
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
