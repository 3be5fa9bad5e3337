"""What meshio writes, Lapis reads: tetrahedra as VTU, MSH and TetGen files, in all their encodings.

Usage: python write_tets.py LAPIS TETRAHEDRA.vtu FOLDER
"""
import json
import os
import subprocess
import sys

import meshio
import numpy as np

lapis, source, folder = sys.argv[1:]
given = meshio.read(source)
tets = given.cells[0].data
# A file as other programs write it: with a surface, a field, and a node that nothing uses.
a, b, c, d = tets.T
faces = np.concatenate([np.stack(f, 1) for f in ((b, c, d), (a, d, c), (a, b, d), (a, c, b))])
_, first, times = np.unique(np.sort(faces, 1), axis=0, return_index=True, return_counts=True)
surface = faces[first[times == 1]]
points = np.vstack([given.points, [[1e3, 1e3, 1e3]]])
mesh = meshio.Mesh(
    points,
    [("triangle", surface), ("tetra", tets)],
    point_data={"height": points[:, 2]},
    cell_data={
        "gmsh:physical": [np.full(len(surface), 1), np.full(len(tets), 2)],
        "gmsh:geometrical": [np.full(len(surface), 1), np.full(len(tets), 1)],
    },
)
bare = meshio.Mesh(points, [("tetra", tets)])
expected = json.loads(subprocess.run([lapis, "info", source, "--json"], check=True, capture_output=True).stdout)

ways = [
    ("ascii.vtu", mesh, {"file_format": "vtu", "binary": False}),
    ("binary.vtu", mesh, {"file_format": "vtu", "binary": True, "compression": None}),
    ("zlib.vtu", mesh, {"file_format": "vtu", "binary": True, "compression": "zlib"}),
    ("single.vtu", meshio.Mesh(points.astype(np.float32), mesh.cells), {"file_format": "vtu"}),
    ("ascii22.msh", mesh, {"file_format": "gmsh22", "binary": False}),
    ("binary22.msh", mesh, {"file_format": "gmsh22", "binary": True}),
    ("ascii41.msh", bare, {"file_format": "gmsh", "binary": False}),
    ("binary41.msh", bare, {"file_format": "gmsh", "binary": True}),
    ("tetgen.node", bare, {"file_format": "tetgen"}),
]
for name, what, how in ways:
    path = os.path.join(folder, name)
    meshio.write(path, what, **how)
    info = json.loads(subprocess.run([lapis, "info", path, "--json"], check=True, capture_output=True).stdout)
    assert info["counts"] == expected["counts"], (name, info["counts"], expected["counts"])
    apart = abs(info["measures"]["volume"] / expected["measures"]["volume"] - 1)
    # meshio writes text with 16 digits.
    assert apart < (1e-6 if name == "single.vtu" else 1e-12), (name, apart)
lzma = os.path.join(folder, "lzma.vtu")
meshio.write(lzma, bare, file_format="vtu", binary=True, compression="lzma")
refused = subprocess.run([lapis, "info", lzma], capture_output=True, text=True)
assert refused.returncode == 1 and "LZMA" in refused.stderr, refused
print(f"{len(ways)} files of {len(tets)} tetrahedra, written by meshio, were read")
