"""The kernel is loaded without the modules of VTK that nothing here calls, and all of VTK can be loaded afterwards."""

from tests.process_state import python

PROGRAM = """
import sys
from stagecad.solids.modelling.kernel import load_kernel
load_kernel()
assert "cadquery" in sys.modules and "vtk" not in sys.modules
assert "vtkmodules.vtkRenderingOpenGL2" not in sys.modules
import cadquery as cq
box = cq.Workplane().box(1, 2, 3).val()
assert abs(box.Volume() - 6.0) < 1e-9 and box.toVtkPolyData(0.1, 0.1).GetNumberOfPoints() > 0
import vtk
assert vtk.vtkSphereSource().GetRadius() == 0.5
load_kernel()
assert sys.modules["vtk"] is vtk
"""


def test_vtk_is_left_out_and_can_be_loaded_afterwards() -> None:
    python("-c", PROGRAM)
