from sim.effects.effect import Effect as Effect
from sim.effects.effect import Parameter as Parameter
from sim.effects.effect import Scan as Scan
from stagecad.parameters.errors import InputError as InputError
from workbench.operations.checks import Checks as Checks
from workbench.operations.checks import checks as checks
from workbench.operations.design import Design as Design
from workbench.operations.design import load_design as load_design
from workbench.operations.diff import Differences as Differences
from workbench.operations.diff import diff as diff
from workbench.operations.drawings import Drawings as Drawings
from workbench.operations.drawings import drawings as drawings
from workbench.operations.measurement.add import Addition as Addition
from workbench.operations.measurement.add import Ladder as Ladder
from workbench.operations.measurement.add import Restoration as Restoration
from workbench.operations.measurement.add import add as add
from workbench.operations.measurement.add import ladder as ladder
from workbench.operations.measurement.add import undo as undo
from workbench.operations.measurement.compare import Comparison as Comparison
from workbench.operations.measurement.compare import compare as compare
from workbench.operations.measurement.diagnose import Diagnosis as Diagnosis
from workbench.operations.measurement.diagnose import diagnose as diagnose
from workbench.operations.measurement.experiment import Experiment as Experiment
from workbench.operations.measurement.experiment import Model as Model
from workbench.operations.measurement.experiment import Record as Record
from workbench.operations.measurement.experiment import Rig as Rig
from workbench.operations.measurement.experiment import RigKind as RigKind
from workbench.operations.measurement.export import Export as Export
from workbench.operations.measurement.export import export as export
from workbench.operations.measurement.look import Look as Look
from workbench.operations.measurement.look import look as look
from workbench.operations.measurement.suggest import Suggestion as Suggestion
from workbench.operations.measurement.suggest import suggest as suggest
from workbench.operations.optimise import Optimisation as Optimisation
from workbench.operations.optimise import optimize as optimize
from workbench.operations.parts import Parts as Parts
from workbench.operations.parts import parts as parts
from workbench.operations.simulation.simulate import (
    SimulatedRecords as SimulatedRecords,
)
from workbench.operations.simulation.simulate import (
    Simulation as Simulation,
)
from workbench.operations.simulation.simulate import (
    simulate as simulate,
)

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
    "Export",
    "InputError",
    "Ladder",
    "Look",
    "Model",
    "Optimisation",
    "Parameter",
    "Parts",
    "Record",
    "Restoration",
    "Rig",
    "RigKind",
    "Scan",
    "SimulatedRecords",
    "Simulation",
    "Suggestion",
    "add",
    "checks",
    "compare",
    "diagnose",
    "diff",
    "drawings",
    "export",
    "ladder",
    "load_design",
    "look",
    "optimize",
    "parts",
    "simulate",
    "suggest",
    "undo",
]
