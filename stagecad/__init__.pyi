from sim.effects.effect import Effect as Effect
from sim.effects.effect import Parameter as Parameter
from sim.effects.effect import Scan as Scan
from stagecad.parameters.errors import InputError as InputError
from workbench.api.machine.design_results import (
    Checks as Checks,
)
from workbench.api.machine.design_results import (
    Drawings as Drawings,
)
from workbench.api.machine.design_results import (
    Parts as Parts,
)
from workbench.api.machine.design_results import (
    checks as checks,
)
from workbench.api.machine.design_results import (
    drawings as drawings,
)
from workbench.api.machine.design_results import (
    parts as parts,
)
from workbench.api.machine.differences import Differences as Differences
from workbench.api.machine.differences import diff as diff
from workbench.api.machine.optimisation import Optimisation as Optimisation
from workbench.api.machine.optimisation import optimize as optimize
from workbench.api.measurement.comparison import Comparison as Comparison
from workbench.api.measurement.comparison import compare as compare
from workbench.api.measurement.diagnosis import Diagnosis as Diagnosis
from workbench.api.measurement.diagnosis import diagnose as diagnose
from workbench.api.measurement.experiment import Experiment as Experiment
from workbench.api.measurement.growth import Addition as Addition
from workbench.api.measurement.growth import Ladder as Ladder
from workbench.api.measurement.growth import Undone as Undone
from workbench.api.measurement.growth import add as add
from workbench.api.measurement.growth import ladder as ladder
from workbench.api.measurement.growth import undo as undo
from workbench.api.measurement.statement import Model as Model
from workbench.api.measurement.statement import Record as Record
from workbench.api.measurement.statement import Rig as Rig
from workbench.api.measurement.statement import RigKind as RigKind
from workbench.api.measurement.suggestion import Suggestion as Suggestion
from workbench.api.measurement.suggestion import suggest as suggest
from workbench.api.simulation import (
    SimulatedRecords as SimulatedRecords,
)
from workbench.api.simulation import (
    Simulation as Simulation,
)
from workbench.api.simulation import (
    simulate as simulate,
)
from workbench.operations.design import Design as Design
from workbench.operations.design import load_design as load_design

__version__: str
__all__ = [
    "Addition",
    "Checks",
    "Comparison",
    "Design",
    "Diagnosis",
    "Differences",
    "Drawings",
    "Effect",
    "Experiment",
    "InputError",
    "Ladder",
    "Model",
    "Optimisation",
    "Parameter",
    "Parts",
    "Record",
    "Rig",
    "RigKind",
    "Scan",
    "SimulatedRecords",
    "Simulation",
    "Suggestion",
    "Undone",
    "add",
    "checks",
    "compare",
    "diagnose",
    "diff",
    "drawings",
    "ladder",
    "load_design",
    "optimize",
    "parts",
    "simulate",
    "suggest",
    "undo",
]
