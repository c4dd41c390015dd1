"""Compression of a clamped part against axisymmetric finite elements of it on a rigid bed that holds nothing down."""

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.linalg import spsolve

from designcalc.bearing.bolted_rail import joint_stiffness
from designcalc.bearing.fastener import cone_compliance
from designcalc.checks.check import DesignInputs
from designcalc.friction_stage.physics.pads import rail

HEAD, HOLE, THICKNESS = 14.2875e-3, 10.5e-3, 14.3e-3
SILICON_CARBIDE = 410e9, 0.14


def compliance(hole: float, outer: float, divisions: int) -> float:
    """Mean displacement under a uniform pressure of unit force on the head, by elements of four nodes, m/N."""
    under = np.linspace(hole / 2, HEAD / 2, divisions // 2 + 1)
    beyond = np.linspace(HEAD / 2, outer / 2, round(divisions * (outer - HEAD) / (2 * THICKNESS)) + 7)
    r, z = np.append(under, beyond[1:]), np.linspace(0.0, THICKNESS, 2 * divisions + 1)
    first = (np.arange(z.size - 1)[:, None] * r.size + np.arange(r.size - 1)).ravel()
    nodes = first[:, None] + [0, 1, r.size + 1, r.size]
    unknowns = (2 * nodes[:, :, None] + [0, 1]).reshape(-1, 8)
    stiffness = np.zeros((first.size, 8, 8))
    E, nu = SILICON_CARBIDE
    law = np.full((3, 3), nu) + (1 - 2 * nu) * np.eye(3)
    law = E / ((1 + nu) * (1 - 2 * nu)) * np.block([[law, np.zeros((3, 1))], [np.zeros((1, 3)), 0.5 - nu]])
    (a, b), inner = (one.ravel() for one in np.meshgrid(np.diff(r), np.diff(z))), np.tile(r[:-1], z.size - 1)
    for s, t in np.array([(-1, -1), (-1, 1), (1, -1), (1, 1)]) / np.sqrt(3):
        x, y = np.array([-1, 1, 1, -1]), np.array([-1, -1, 1, 1])
        shape, along, up = (1 + x * s) * (1 + y * t) / 4, x * (1 + y * t) / 4, y * (1 + x * s) / 4
        radius = inner + (1 + s) * a / 2
        strain = np.zeros((first.size, 4, 8))
        strain[:, 0, ::2] = strain[:, 3, 1::2] = 2 * along / a[:, None]
        strain[:, 1, 1::2] = strain[:, 3, ::2] = 2 * up / b[:, None]
        strain[:, 2, ::2] = shape / radius[:, None]
        weight = 2 * np.pi * radius * a * b / 4
        stiffness += np.einsum("n,nij,ik,nkl->njl", weight, strain, law, strain, optimize=True)
    rows, columns = np.repeat(unknowns, 8, axis=1), np.tile(unknowns, (1, 8))
    size = 2 * r.size * z.size
    matrix = coo_array((stiffness.ravel(), (rows.ravel(), columns.ravel())), shape=(size, size)).tocsr()
    force, top = np.zeros(size), 2 * (z.size - 1) * r.size + 1
    width, pressure = np.diff(under), 4 / (np.pi * (HEAD**2 - hole**2))
    for one, other in ((0, 1), (1, 0)):
        share = np.pi * pressure * width * (2 * under[one : under.size - other] + under[other : under.size - one]) / 3
        np.add.at(force, top + 2 * (np.arange(width.size) + one), -share)
    held = np.ones(r.size, bool)
    while True:
        fixed = np.flatnonzero(held) * 2 + 1
        free = np.setdiff1d(np.arange(size), fixed)
        moved = np.zeros(size)
        moved[free] = spsolve(matrix[free][:, free].tocsc(), force[free])
        pulled = held & ((matrix @ moved - force)[1 : 2 * r.size : 2] < 0.0)
        sunk = ~held & (moved[1 : 2 * r.size : 2] < 0.0)
        if not (pulled | sunk).any():
            return float(force @ moved)
        held = (held & ~pulled) | sunk


def test_a_flange_with_the_hole_of_its_screw(design):
    """5.45 kN/um, with the hole as wide as the screw and cones of 45 degrees 10.6: twice what a part without edge has.
    A disc as wide as the ledge, 20 mm, gives more: the part lies between."""
    wide, disc = (compliance(HOLE, outer, 24) for outer in (80e-3, 20e-3))
    assert wide == pytest.approx(compliance(HOLE, 80e-3, 12), rel=0.02)
    assert (1 / wide, 1 / disc) == pytest.approx((5.34e9, 4.24e9), rel=0.005)
    cone = float(cone_compliance(HEAD, HOLE, THICKNESS, 20e-3, SILICON_CARBIDE[0]))
    assert cone == pytest.approx(wide, rel=0.03)
    way = rail(DesignInputs(design))
    sheet = float(joint_stiffness(way, THICKNESS / way.bolt_diameter).flange_compression) * way.bolt_diameter
    assert sheet == pytest.approx(10.6e9, rel=2e-3)
    assert sheet * compliance(way.bolt_diameter, 80e-3, 24) > 1.8
