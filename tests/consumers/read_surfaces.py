"""trimesh loads an exported GLB and OBJ with their textures, a PLY with its colours and an STL; all show one closed
surface.

Usage: python read_surfaces.py FILE [parts]
    where FILE.glb, FILE.obj, FILE.ply and FILE.stl are exports of one model; `parts`: of several parts, whose walls lie
    against each other
"""
import os
import sys

import numpy as np
import trimesh

stem = sys.argv[1]
parts = sys.argv[2:] == ["parts"]
names = {kind: f"{stem}.{kind}" for kind in ("glb", "obj", "ply", "stl")}


def textured(name):
    """A mesh with an atlas: the mesh and its picture."""
    scene = trimesh.load(name, force="scene")
    assert len(scene.geometry) == 1, f"{name}: {len(scene.geometry)} meshes where one is expected"
    mesh = next(iter(scene.geometry.values()))
    assert mesh.visual.kind == "texture", f"{name}: its mesh is not textured"
    uv = mesh.visual.uv
    assert uv.shape == (len(mesh.vertices), 2), f"{name}: {uv.shape} texture coordinates"
    assert np.isfinite(uv).all() and uv.min() >= 0 and uv.max() <= 1, f"{name}: texture coordinates outside 0…1"
    material = mesh.visual.material
    image = material.baseColorTexture if hasattr(material, "baseColorTexture") else material.image
    assert image is not None, f"{name}: its texture was not found"
    for side in image.size:
        assert side & (side - 1) == 0, f"{name}: its atlas has {image.size} texels: no powers of two"
    # The texture shows something: not one flat colour.
    assert np.asarray(image.convert("RGB")).reshape(-1, 3).std(axis=0).max() > 5, f"{name}: its atlas is flat"
    normals = mesh.vertex_normals
    assert np.allclose(np.linalg.norm(normals, axis=1), 1, atol=1e-3), f"{name}: normals are not unit vectors"
    return mesh, image


def colours(mesh, image):
    """The atlas's colours in the middle of each face, sorted by the middles' places: the same for GLB and OBJ."""
    middles = mesh.triangles_center
    uv = mesh.visual.uv[mesh.faces].mean(axis=1)
    picture = np.asarray(image.convert("RGB")).astype(int)
    # trimesh turns both formats so that v runs up.
    x = np.clip((uv[:, 0] * image.width).astype(int), 0, image.width - 1)
    y = np.clip(((1 - uv[:, 1]) * image.height).astype(int), 0, image.height - 1)
    order = np.lexsort(np.round(middles / np.ptp(mesh.vertices), 5).T)
    return picture[y, x][order]


glb, atlas = textured(names["glb"])
obj, same = textured(names["obj"])
assert np.array_equal(np.asarray(atlas), np.asarray(same)), "GLB and OBJ have different atlases"
apart = np.abs(colours(glb, atlas) - colours(obj, same)).max(axis=1)
assert (apart > 0).mean() < 0.01, f"GLB and OBJ show different colours on {(apart > 0).mean():.1%} of the faces"
with open(names["obj"]) as file:
    library = next(line.split(maxsplit=1)[1].strip() for line in file if line.startswith("mtllib"))
assert os.path.basename(library) == library, f"the OBJ names its material by the path {library}"

ply = trimesh.load(names["ply"])
assert ply.visual.kind == "vertex", f"{names['ply']}: it has no vertex colours"
stl = trimesh.load(names["stl"])
volumes = []
for name, mesh in zip(names.values(), (glb, obj, ply, stl)):
    assert len(mesh.faces) == len(glb.faces), f"{name}: {len(mesh.faces)} faces"
    welded = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    welded.merge_vertices(merge_tex=True, merge_norm=True)
    if parts:
        _, faces = np.unique(welded.edges_sorted, axis=0, return_counts=True)
        assert (faces % 2 == 0).all(), f"{name}: {(faces % 2).sum()} edges of its surface are open"
    else:
        assert welded.is_watertight, f"{name}: its surface is not closed"
    volumes.append(welded.volume)
assert volumes[0] > 0 and np.ptp(volumes) / volumes[0] < 1e-4, f"volumes differ: {volumes}"
print(f"{stem}: {len(glb.faces)} faces, atlas {atlas.width}×{atlas.height}, volume {volumes[0]:.6g}")
