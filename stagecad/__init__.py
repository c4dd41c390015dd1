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
    "Model": "workbench.operations.experiment",
    "Record": "workbench.operations.experiment",
    "Rig": "workbench.operations.experiment",
    "RigKind": "workbench.operations.experiment",
    "Experiment": "workbench.operations.experiment",
    "Comparison": "workbench.operations.compare",
    "compare": "workbench.operations.compare",
    "Diagnosis": "workbench.operations.diagnose",
    "diagnose": "workbench.operations.diagnose",
    "Addition": "workbench.operations.add",
    "Ladder": "workbench.operations.add",
    "add": "workbench.operations.add",
    "ladder": "workbench.operations.add",
    "Restoration": "workbench.operations.add",
    "undo": "workbench.operations.add",
    "Differences": "workbench.operations.diff",
    "diff": "workbench.operations.diff",
    "Optimisation": "workbench.operations.optimise",
    "optimize": "workbench.operations.optimise",
    "Suggestion": "workbench.operations.suggest",
    "suggest": "workbench.operations.suggest",
    "Checks": "workbench.operations.checks",
    "Drawings": "workbench.operations.drawings",
    "Parts": "workbench.operations.parts",
    "checks": "workbench.operations.checks",
    "drawings": "workbench.operations.drawings",
    "parts": "workbench.operations.parts",
    "SimulatedRecords": "workbench.operations.simulate",
    "Simulation": "workbench.operations.simulate",
    "simulate": "workbench.operations.simulate",
    "Export": "workbench.operations.export",
    "export": "workbench.operations.export",
    "Look": "workbench.operations.look",
    "look": "workbench.operations.look",
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
