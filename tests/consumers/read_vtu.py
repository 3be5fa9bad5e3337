"""meshio opens our VTU files: tetrahedra of a mesh, and a filled model with its fields.

Usage: python read_vtu.py LAPIS TETRAHEDRA.vtu MODEL.lapis MODEL.vtu
"""
import json
import subprocess
import sys

import meshio
import numpy as np
from safetensors import safe_open

lapis, plain, model, filled = sys.argv[1:]


def tetrahedra(path):
    """The file, its positions and its tetrahedra, which all are positive."""
    mesh = meshio.read(path)
    assert [c.type for c in mesh.cells] == ["tetra"], f"{path}: {mesh.cells}"
    points, tets = mesh.points, mesh.cells[0].data
    assert points.dtype == np.float64 and points.shape[1] == 3 and tets.shape[1] == 4
    a, b, c, d = (points[tets[:, k]] for k in range(4))
    volumes = np.einsum("ij,ij->i", b - a, np.cross(c - a, d - a)) / 6
    assert (volumes > 0).all(), f"{path}: {(volumes <= 0).sum()} tetrahedra are inside out"
    info = json.loads(subprocess.run([lapis, "info", path, "--json"], check=True, capture_output=True).stdout)
    assert info["counts"]["tetrahedra"] == len(tets), info
    assert abs(info["measures"]["volume"] / volumes.sum() - 1) < 1e-12, info
    return mesh, points, tets


tetrahedra(plain)
mesh, points, tets = tetrahedra(filled)
with safe_open(model, "numpy") as file:
    ours = {name: file.get_tensor(name) for name in file.keys()}
starts = ours["layer_start"].astype(int)
counts = np.diff(starts)
newest = np.full(len(counts), -1)
newest[counts > 0] = ours["layer_patch"][starts[1:][counts > 0] - 1]
for name, found, expected in [
    ("positions", points, ours["vertices"]),
    ("tetrahedra", tets, ours["tets"]),
    ("depth", mesh.point_data["depth"], ours["depth"]),
    ("R", mesh.point_data["R"], ours["frame"][:, 0]),
    ("S", mesh.point_data["S"], ours["frame"][:, 1]),
    ("T", mesh.point_data["T"], ours["frame"][:, 2]),
    ("layers", mesh.cell_data["layers"][0], counts),
    ("newest_patch", mesh.cell_data["newest_patch"][0], newest),
    ("tet_origin", mesh.cell_data["tet_origin"][0], ours["tet_origin"]),
]:
    assert found.shape == expected.shape, f"{name}: {found.shape} where {expected.shape} belongs"
    assert np.array_equal(found, expected), f"{name} differs from the model's"
assert set(mesh.point_data) == {"depth", "R", "S", "T"}, mesh.point_data.keys()
print(f"{filled}: {len(tets)} tetrahedra, all fields as in {model}")
