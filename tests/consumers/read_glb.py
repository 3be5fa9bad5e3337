"""trimesh loads an exported GLB with its texture, and a PLY with its colours, and both are closed.

Usage: python read_glb.py FILE.glb FILE.ply
"""
import sys

import numpy as np
import trimesh

glb, ply = sys.argv[1:]

scene = trimesh.load(glb)
assert len(scene.geometry) == 1, f"{glb}: {len(scene.geometry)} meshes where one is expected"
mesh = next(iter(scene.geometry.values()))
assert mesh.visual.kind == "texture", f"{glb}: its mesh is not textured"
uv = mesh.visual.uv
assert uv.shape == (len(mesh.vertices), 2), f"{glb}: {uv.shape} texture coordinates"
assert np.isfinite(uv).all() and uv.min() >= 0 and uv.max() <= 1, f"{glb}: texture coordinates outside 0…1"
image = mesh.visual.material.baseColorTexture
width, height = image.size
for side in (width, height):
    assert side & (side - 1) == 0, f"{glb}: its atlas has {width}×{height} texels: no power of two"
# The texture shows something: not one flat colour.
assert np.asarray(image.convert("RGB")).reshape(-1, 3).std(axis=0).max() > 5, f"{glb}: its atlas is flat"
normals = mesh.vertex_normals
assert np.allclose(np.linalg.norm(normals, axis=1), 1, atol=1e-3), f"{glb}: normals are not unit vectors"

solid = trimesh.load(ply)
assert solid.visual.kind == "vertex", f"{ply}: it has no vertex colours"
volumes = []
for name, m in ((glb, mesh), (ply, solid)):
    welded = trimesh.Trimesh(m.vertices, m.faces, process=False)
    welded.merge_vertices(merge_tex=True, merge_norm=True)
    assert welded.is_watertight, f"{name}: its surface is not closed"
    volumes.append(welded.volume)
assert volumes[0] > 0 and abs(volumes[0] / volumes[1] - 1) < 1e-4, f"volumes differ: {volumes}"
print(f"{glb}: {len(mesh.faces)} faces, atlas {width}×{height}, volume {volumes[0]:.6g}")
