"""Particles from a photograph that Pillow writes; pynrrd reads their volume and its labels, and trimesh opens the particles as GLB and
as OBJ: as many as asked for, each closed, of one shape and one colour in both.

Usage: python read_shapes.py LAPIS FOLDER
    leaves FOLDER/shapes.glb
"""
import json
import pathlib
import subprocess
import sys

import nrrd
import numpy as np
import trimesh
from PIL import Image, ImageDraw

lapis, folder = sys.argv[1], pathlib.Path(sys.argv[2])
random = np.random.default_rng(5)
most = 12

# Stones in rows, each somewhat aside and as large as it likes.
photo = Image.new("RGB", (96, 96), (40, 36, 30))
draw = ImageDraw.Draw(photo)
for x in range(8, 96, 16):
    for y in range(8, 96, 16):
        (cx, cy), (rx, ry) = (x, y) + random.uniform(-1, 1, 2), random.uniform(4, 6.5, 2)
        colour = random.integers(120, 240)
        draw.ellipse((cx - rx, cy - ry, cx + rx, cy + ry), fill=(int(colour), int(colour) - 40, int(colour) - 80))
photo.save(folder / "stones.png")


def run(*more):
    command = [lapis, "particles", str(folder / "stones.png"), "--size", "48", "--photo-size", "96", *map(str, more)]
    return json.loads(subprocess.run([*command, "--force", "--json"], check=True, capture_output=True).stdout)


counts = run("-o", folder / "stones.nrrd", "--shapes", folder / "shapes.glb", "--shapes-most", most)["counts"]
assert counts["shapes"] == most, counts
run("-o", folder / "stones.nrrd", "--shapes", folder / "shapes.obj", "--shapes-most", most)
_, header = nrrd.read(str(folder / "stones.nrrd"))
labels, _ = nrrd.read(str(folder / header["lapis_labels"]))
assert (np.unique(labels) == np.arange(counts["particles"] + 1)).all(), "labels leave numbers out"

names = {f"particle-{n + 1}" for n in range(most)}
glb = trimesh.load(folder / "shapes.glb", force="scene")
obj = trimesh.load(folder / "shapes.obj", force="scene", split_objects=True, group_material=False)
assert set(glb.geometry) == names, f"the GLB has {sorted(glb.geometry)}"
assert set(obj.geometry) == names, f"the OBJ has {sorted(obj.geometry)}"
volumes = []
for name in sorted(names):
    transform, geometry = glb.graph[name]
    one, other = glb.geometry[geometry].copy().apply_transform(transform), obj.geometry[name]
    for kind, mesh in (("GLB", one), ("OBJ", other)):
        assert mesh.is_watertight and mesh.volume > 0, f"{name} of the {kind} is not closed"
    assert np.allclose(one.bounds, other.bounds, atol=1e-3), f"{name}: {one.bounds} {other.bounds}"
    assert abs(one.volume / other.volume - 1) < 1e-3, f"{name}: {one.volume} {other.volume}"
    # glTF's colours are in linear light, an OBJ's in sRGB.
    # A copy loses them, since the mesh has a material, too.
    linear = glb.geometry[geometry].visual.vertex_attributes["color"][:, :3].mean(axis=0) / 255
    srgb = other.visual.vertex_colors[:, :3] / 255
    expected = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4).mean(axis=0)
    assert np.abs(linear - expected).max() < 0.02, f"{name}: {linear} {expected}"
    volumes.append(one.volume)
boxes = [glb.geometry[glb.graph[n][1]].bounds + glb.graph[n][0][:3, 3] for n in sorted(names)]
for n, a in enumerate(boxes):
    for b in boxes[:n]:
        assert (a[0] > b[1]).any() or (b[0] > a[1]).any(), "two particles lie in each other"
print(f"{most} particles of {min(volumes):.0f} to {max(volumes):.0f} voxels, and {counts['particles']} in a volume")
