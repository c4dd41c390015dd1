"""Design a piezo friction-drive stage from one parameter file, and find out why the real one does not behave like it.

>>> import stagecad
>>> stagecad.load_design().si("stage.thickness")
0.012
"""

from importlib import import_module

from stagecad.companions import use_companions

use_companions()

__version__ = "0.2.0"

_MODULES = {
    "Design": "workbench.operations.design",
    "load_design": "workbench.operations.design",
    "Effect": "sim.effects.effect",
    "Parameter": "sim.effects.effect",
    "Scan": "sim.effects.effect",
    "Model": "workbench.operations.measurement.experiment",
    "Record": "workbench.operations.measurement.experiment",
    "Rig": "workbench.operations.measurement.experiment",
    "RigKind": "workbench.operations.measurement.experiment",
    "Experiment": "workbench.operations.measurement.experiment",
    "Comparison": "workbench.operations.measurement.compare",
    "compare": "workbench.operations.measurement.compare",
    "Diagnosis": "workbench.operations.measurement.diagnose",
    "diagnose": "workbench.operations.measurement.diagnose",
    "Addition": "workbench.operations.measurement.add",
    "Ladder": "workbench.operations.measurement.add",
    "add": "workbench.operations.measurement.add",
    "ladder": "workbench.operations.measurement.add",
    "Restoration": "workbench.operations.measurement.add",
    "undo": "workbench.operations.measurement.add",
    "Differences": "workbench.operations.diff",
    "diff": "workbench.operations.diff",
    "Optimisation": "workbench.operations.optimise",
    "optimize": "workbench.operations.optimise",
    "Suggestion": "workbench.operations.measurement.suggest",
    "suggest": "workbench.operations.measurement.suggest",
    "Checks": "workbench.operations.checks",
    "Drawings": "workbench.operations.drawings",
    "Parts": "workbench.operations.parts",
    "checks": "workbench.operations.checks",
    "drawings": "workbench.operations.drawings",
    "parts": "workbench.operations.parts",
    "SimulatedRecords": "workbench.operations.simulation.simulate",
    "Simulation": "workbench.operations.simulation.simulate",
    "simulate": "workbench.operations.simulation.simulate",
    "Export": "workbench.operations.measurement.export",
    "export": "workbench.operations.measurement.export",
    "Look": "workbench.operations.measurement.look",
    "look": "workbench.operations.measurement.look",
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
