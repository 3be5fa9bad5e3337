"""A textured GLB as a modeller writes one, for `lapis fill --keep-look`; then the check that what Lapis exports still wears
that texture outside.

Usage: python write_look.py write FILE.glb        a ball of two materials: a picture on its upper half, blue below
       python write_look.py check FILE.glb [cut]  an export of the filled ball, whole or cut
"""
import sys

import numpy as np
import trimesh
from PIL import Image

# Quarters of the picture: red, green above; yellow, white below.
QUARTERS = np.array([[[210, 30, 30], [30, 180, 40]], [[230, 210, 40], [250, 250, 250]]], dtype=np.uint8)
# Factors of glTF are linear light; pictures are sRGB.
FACTOR = [30, 40, 200]
BLUE = [round(255 * (1.055 * (x / 255) ** (1 / 2.4) - 0.055)) for x in FACTOR]


def picture_at(points):
    """Texture coordinates: the ball seen from above, u to the right, v up."""
    return 0.5 + 0.5 * points[:, :2]


def write(path):
    ball = trimesh.creation.icosphere(subdivisions=3)
    above = ball.triangles_center[:, 2] > 0
    picture = Image.fromarray(QUARTERS.repeat(64, axis=0).repeat(64, axis=1))
    scene = trimesh.Scene()
    for name, part in (("painted", above), ("plain", ~above)):
        mesh = ball.submesh([np.flatnonzero(part)], append=True, repair=False)
        if name == "painted":
            material = trimesh.visual.material.PBRMaterial(name=name, baseColorTexture=picture, metallicFactor=0)
            mesh.visual = trimesh.visual.TextureVisuals(uv=picture_at(mesh.vertices), material=material)
        else:
            material = trimesh.visual.material.PBRMaterial(name=name, baseColorFactor=[*FACTOR, 255])
            mesh.visual = trimesh.visual.TextureVisuals(uv=np.zeros((len(mesh.vertices), 2)), material=material)
        scene.add_geometry(mesh, node_name=name, geom_name=name)
    scene.export(path)


def check(path, cut):
    scene = trimesh.load(path, force="scene")
    meshes = list(scene.geometry.values())
    materials = {id(mesh.visual.material) for mesh in meshes}
    assert len(meshes) == 1 and len(materials) == 1, f"{path}: {len(meshes)} meshes, {len(materials)} materials"
    mesh = meshes[0]
    image = mesh.visual.material.baseColorTexture
    assert image is not None, f"{path}: its texture was not found"
    atlas = np.asarray(image.convert("RGB")).astype(int)
    uv = mesh.visual.uv[mesh.faces].mean(axis=1)
    x = np.clip((uv[:, 0] * image.width).astype(int), 0, image.width - 1)
    y = np.clip(((1 - uv[:, 1]) * image.height).astype(int), 0, image.height - 1)
    found = atlas[y, x]
    middles = mesh.triangles_center
    # A cut's faces at the rim lie as far out, but face another way.
    outside = (np.linalg.norm(middles, axis=1) > 0.97) & ((mesh.face_normals * middles).sum(axis=1) > 0.9)
    # The picture stands upright: v runs up in it, rows run down.
    u, v = picture_at(middles).T
    wanted = QUARTERS[(v < 0.5).astype(int), (u >= 0.5).astype(int)].astype(int)
    wanted[middles[:, 2] < 0] = BLUE
    # Near the borders of colours, faces show two.
    plain = outside & (np.abs(middles).min(axis=1) > 0.12)
    right = np.abs(found - wanted).max(axis=1)[plain] < 12
    assert plain.sum() > 100 and right.mean() > 0.99, f"{path}: {right.mean():.1%} of {plain.sum()} faces wear the look"
    inside = ~outside & (np.abs(middles[:, 2]) < 0.9)
    assert cut == (inside.sum() > 20), f"{path}: {inside.sum()} faces inside"
    if cut:
        same = np.abs(found[:, None] - np.vstack([QUARTERS.reshape(-1, 3), [BLUE]])).max(axis=2).min(axis=1) < 12
        assert same[inside].mean() < 0.2, f"{path}: {same[inside].mean():.1%} of the cut faces wear the look too"
    print(f"{path}: its outside wears the look ({plain.sum()} faces, 1 material)")


if sys.argv[1] == "write":
    write(sys.argv[2])
else:
    check(sys.argv[2], sys.argv[3:] == ["cut"])
