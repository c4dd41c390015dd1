from sim.library.effect import Effect as Effect
from sim.library.effect import Parameter as Parameter
from sim.library.effect import Scan as Scan
from stagecad.parameters.errors import InputError as InputError
from workbench.api.comparison import Comparison as Comparison
from workbench.api.comparison import compare as compare
from workbench.api.design import Design as Design
from workbench.api.design import load_design as load_design
from workbench.api.diagnosis import Diagnosis as Diagnosis
from workbench.api.diagnosis import diagnose as diagnose
from workbench.api.differences import Differences as Differences
from workbench.api.differences import diff as diff
from workbench.api.experiment import Experiment as Experiment
from workbench.api.growth import Addition as Addition
from workbench.api.growth import Ladder as Ladder
from workbench.api.growth import Undone as Undone
from workbench.api.growth import add as add
from workbench.api.growth import ladder as ladder
from workbench.api.growth import undo as undo
from workbench.api.machine import (
    Checks as Checks,
)
from workbench.api.machine import (
    Drawings as Drawings,
)
from workbench.api.machine import (
    Parts as Parts,
)
from workbench.api.machine import (
    checks as checks,
)
from workbench.api.machine import (
    drawings as drawings,
)
from workbench.api.machine import (
    parts as parts,
)
from workbench.api.simulation import (
    SimulatedRecords as SimulatedRecords,
)
from workbench.api.simulation import (
    Simulation as Simulation,
)
from workbench.api.simulation import (
    simulate as simulate,
)
from workbench.api.statement import Model as Model
from workbench.api.statement import Record as Record
from workbench.api.statement import Rig as Rig
from workbench.api.statement import RigKind as RigKind
from workbench.api.suggestion import Suggestion as Suggestion
from workbench.api.suggestion import suggest as suggest

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
    "parts",
    "simulate",
    "suggest",
    "undo",
]
