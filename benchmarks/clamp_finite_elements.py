"""Clamp of pocket 1 by three-dimensional finite elements: reference of the flexure model in `designcalc.drive.clamp`.

The plan of the base around one finger (pocket, gap slot, relief slot, relief hole, as the part has them) is meshed by
gmsh, extruded through the depth of the base, and solved with quadratic tetrahedra by scikit-fem. The outer faces are
held, everything else is free. Two load cases, both on the free finger: the screw's force on the lug around the screw's
axis, and a radial force on the pocket's wall beside the gap slot, over the holder's height; and from both the force and
the stress of a finger that has closed a gap.

    python -m benchmarks.clamp_finite_elements [--write] [CASE...]

prints the results, and with `--write` replaces `tests/reference/clamp.toml`. Needs gmsh and scikit-fem (extra `fem`).
"""

import argparse
import math
from pathlib import Path
from typing import Any

import numpy as np

from stagecad.friction_stage.parts.base_clamp import Clamp, clamps
from stagecad.parameters.atomic import atomic_write_text
from stagecad.parameters.load import load_design

REFERENCE = Path(__file__).parents[1] / "tests" / "reference" / "clamp.toml"
BOX = ((-55.0, 70.0), (10.0, 98.0))
"""Of the block about the pocket's axis, u and v, mm."""
PRESSED = 10.0
"""Angle of the wall beside the slot on which the holder presses, degrees."""
GRIP_FORCE, GRIP_GAP = 5000.0, 20e-6
"""Of the screw, N, and between wall and holder, m, in the case of a gripped holder."""
NECK_SIZE, LARGEST_SIZE, LAYERS = 1.6, 14.0, 12
"""Of the elements at the neck and far from it, mm; layers through the depth."""
KEYS = ("clamp_screw_offset", "clamp_reach", "clamp_neck", "clamp_relief_hole", "clamp_neck_angle_1", "pocket_diameter")
CASES: dict[str, tuple[str, ...]] = {
    name: tuple(f"base.{key}={value}" for key, value in zip(KEYS, values, strict=True))
    for name, values in {
        "short lever, neck of 6 mm": ("48 mm", "58.5 mm", "6 mm", "6 mm", "85 deg", "76.05 mm"),
        "screw at 57 mm, neck of 5 mm": ("57 mm", "67.5 mm", "5 mm", "6 mm", "85 deg", "76.03 mm"),
        "screw at 59 mm, neck of 4 mm": ("59 mm", "69.5 mm", "4 mm", "6 mm", "85 deg", "76.03 mm"),
        "screw at 59 mm, neck of 4 mm at 100 degrees": ("59 mm", "69.5 mm", "4 mm", "10 mm", "100 deg", "76.03 mm"),
    }.items()
}
"""Overrides of the packaged design."""


def plan(design: Any, clamp: Clamp, size: float) -> tuple[np.ndarray, np.ndarray]:
    """Triangles of the plan: nodes (2, n), mm, and cells (3, m)."""
    import gmsh

    base, occ = design.base, gmsh.model.occ
    (left, right), (near, far) = BOX
    radius, half = base.pocket_diameter / 2, base.clamp_slot_width / 2
    hole = clamp.relief_hole(design)
    corner = (clamp.slot - base.clamp_lug, base.clamp_reach)
    gmsh.initialize()
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        block = occ.addRectangle(left, near, 0, right - left, far - near)
        run, angle = (
            math.hypot(hole[0] - corner[0], hole[1] - corner[1]),
            math.atan2(hole[1] - corner[1], hole[0] - corner[0]),
        )
        slope = occ.addRectangle(corner[0], corner[1] - half, 0, run, 2 * half)
        occ.rotate([(2, slope)], *corner, 0, 0, 0, 1, angle)
        cutters = [
            occ.addDisk(0, 0, 0, radius, radius),
            occ.addRectangle(clamp.slot - half, 0, 0, 2 * half, base.clamp_reach + half),
            occ.addRectangle(corner[0], corner[1] - half, 0, base.clamp_lug, 2 * half),
            occ.addDisk(*corner, 0, half, half),
            slope,
            occ.addDisk(*hole, 0, base.clamp_relief_hole / 2, base.clamp_relief_hole / 2),
        ]
        occ.cut([(2, block)], [(2, one) for one in cutters])
        occ.synchronize()
        reach, turn = radius + base.clamp_neck / 2, math.radians(clamp.neck)
        x, y = reach * math.cos(turn), reach * math.sin(turn)
        field = gmsh.model.mesh.field
        tip = (clamp.slot, math.sqrt(radius**2 - clamp.slot**2))
        for number, (at, finest, free) in enumerate((((x, y), size, 5.0), (tip, 2 * size, 3.0)), start=1):
            field.add("MathEval", number)
            away = f"sqrt((x-({at[0]}))^2 + (y-({at[1]}))^2)"
            field.setString(number, "F", f"{finest} + 0.3*max({away} - {free}, 0)")
        field.add("Min", 3)
        field.setNumbers(3, "FieldsList", [1, 2])
        field.setAsBackgroundMesh(3)
        for name in ("MeshSizeExtendFromBoundary", "MeshSizeFromPoints", "MeshSizeFromCurvature"):
            gmsh.option.setNumber(f"Mesh.{name}", 0)
        gmsh.option.setNumber("Mesh.MeshSizeMax", LARGEST_SIZE)
        gmsh.model.mesh.generate(2)
        tags, places, _ = gmsh.model.mesh.getNodes()
        _, corners = gmsh.model.mesh.getElementsByType(2)
    finally:
        gmsh.finalize()
    number = np.zeros(int(tags.max()) + 1, int)
    number[tags.astype(int)] = np.arange(tags.size)
    used, cells = np.unique(number[corners.astype(int)], return_inverse=True)
    return places.reshape(-1, 3)[used, :2].T, cells.reshape(-1, 3).T


def extruded(places: np.ndarray, cells: np.ndarray, depth: float) -> tuple[np.ndarray, np.ndarray]:
    """Tetrahedra between z = 0 and -depth: nodes (3, n) and cells (4, m); each prism makes three."""
    count = places.shape[1]
    z = -np.linspace(0.0, depth, LAYERS + 1)
    nodes = np.vstack([np.tile(places, LAYERS + 1), np.repeat(z, count)])
    a, b, c = np.sort(cells, axis=0)  # by number, so that neighbours cut their common side alike
    found = []
    for layer in range(LAYERS):
        lower, upper = layer * count, (layer + 1) * count
        found += [
            (a + lower, b + lower, c + lower, a + upper),
            (b + lower, c + lower, a + upper, b + upper),
            (c + lower, a + upper, b + upper, c + upper),
        ]
    return nodes, np.concatenate([np.stack(one) for one in found], axis=1)


def solve(design: Any, size: float = NECK_SIZE) -> dict[str, Any]:
    """Results of one design.

    Returns:
        closure and give of the wall by screw and holder, m/N; stress of the neck of the free finger, Pa/N; force on the
        holder, N, and stress of the neck, Pa, once a gap is closed; number of unknowns.
    """
    from scipy.sparse.linalg import LinearOperator, cg
    from skfem import Basis, ElementTetP2, ElementVector, FacetBasis, LinearForm, MeshTet, asm, condense
    from skfem.models.elasticity import lame_parameters, linear_elasticity

    base, clamp = design.base, clamps(design)[0]
    places, cells = extruded(*plan(design, clamp, size), base.height)
    mesh = MeshTet(places * 1e-3, cells)
    material = design.materials[base.material]
    lame = lame_parameters(material.youngs_modulus, material.poisson_ratio)
    basis = Basis(mesh, ElementVector(ElementTetP2()), intorder=2)
    stiffness = asm(linear_elasticity(*lame), basis)

    (left, right), (near, far) = BOX
    boundary = mesh.boundary_facets()
    x, y, z = (1e3 * mesh.p[axis, mesh.facets[:, boundary]].mean(axis=0) for axis in range(3))
    cut = (abs(x - left) < 1e-3) | (abs(x - right) < 1e-3) | (abs(y - near) < 1e-3) | (abs(y - far) < 1e-3)
    radius = base.pocket_diameter / 2
    start, turn = math.degrees(clamp.start_angle(radius)), np.degrees(np.arctan2(y, x))
    low = design.derived.holder_bottom
    wall = (abs(np.hypot(x, y) - radius) < 0.2) & (turn < start + PRESSED) & (x < clamp.slot) & (z > low)
    middle = math.radians(start + PRESSED / 2)
    facets = FacetBasis(mesh, basis.elem, facets=boundary[wall], intorder=3)

    @LinearForm
    def pressing(v: Any, w: Any) -> Any:
        return -(math.cos(middle) * v[0] + math.sin(middle) * v[1])

    @LinearForm
    def pulling(v: Any, w: Any) -> Any:
        away = np.hypot(w.x[1] - 1e-3 * base.clamp_screw_offset, w.x[2] + 1e-3 * base.clamp_screw_depth)
        in_lug = (w.x[0] < 1e-3 * clamp.slot) & (w.x[0] > 1e-3 * (clamp.slot - base.clamp_lug))
        return v[0] * in_lug * (away < 0.5e-3 * base.clamp_hole)

    press, screw = asm(pressing, facets) / facets.dx.sum(), asm(pulling, basis)
    # The forces on the degrees of freedom along u add up to the whole.
    screw = screw / screw[basis.get_dofs(elements=True).all("u^1")].sum()
    inner, _, _, free = condense(stiffness, screw, D=basis.get_dofs(boundary[cut]))
    diagonal = inner.diagonal()
    scale = LinearOperator(inner.shape, lambda r: r / diagonal)
    moved = {}
    for name, load in (("screw", screw), ("holder", press)):
        answer, info = cg(inner, load[free], rtol=1e-5, M=scale, maxiter=20000)
        if info:
            raise RuntimeError(f"{name}: no convergence")
        moved[name] = np.zeros(basis.N)
        moved[name][free] = answer
    reach, turned = radius + base.clamp_neck / 2, math.radians(clamp.neck)
    neck = (reach * math.cos(turned), reach * math.sin(turned))
    closure, give = float(press @ moved["screw"]), float(press @ moved["holder"])
    # The holder presses outwards with what is left once the gap is closed.
    force = (closure * GRIP_FORCE - GRIP_GAP) / give
    gripped = GRIP_FORCE * moved["screw"] - force * moved["holder"]
    return {
        "closure": closure,
        "give": give,
        "free_stress": _neck_stress(basis, moved["screw"], lame, neck, base.clamp_neck),
        "grip": force,
        "grip_stress": _neck_stress(basis, gripped, lame, neck, base.clamp_neck),
        "unknowns": int(basis.N),
    }


def _neck_stress(basis: Any, moved: np.ndarray, lame: Any, neck: tuple[float, float], thickness: float) -> float:
    """Largest principal stress at the neck, Pa."""
    gradient = np.asarray(basis.interpolate(moved).grad)
    strain = 0.5 * (gradient + gradient.swapaxes(0, 1))
    stress = 2 * lame[1] * strain + lame[0] * np.einsum("ii...->...", strain) * np.eye(3)[:, :, None, None]
    at = 1e3 * np.asarray(basis.global_coordinates())
    near = np.hypot(at[0] - neck[0], at[1] - neck[1]) < thickness
    return float(np.abs(np.linalg.eigvalsh(stress[:, :, near].transpose(2, 0, 1))).max())


def main() -> None:
    """Print the reference, or write it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--size", type=float, default=NECK_SIZE, help="of the elements at the neck, mm")
    parser.add_argument("case", nargs="*", default=list(CASES))
    given = parser.parse_args()
    lines = [
        f'source = "three-dimensional finite elements, elements of {given.size:g} mm at the neck: {__spec__.name}"'
    ]
    for name in given.case:
        found = solve(load_design(None, CASES[name], rules=False), given.size)
        print(name, found, flush=True)
        lines += ["", "[[case]]", f'name = "{name}"', "overrides = ["]
        lines += [f'    "{one}",' for one in CASES[name]]
        lines += ["]", *(f"{key} = {value:.4g}" for key, value in found.items() if key != "unknowns")]
    if given.write:
        atomic_write_text(REFERENCE, "\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
