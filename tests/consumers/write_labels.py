"""Volumes with particle labels of other programs: pynrrd's and NumPy's. Lapis counts the same particles in both, and the
labels that its models hold are these.

Usage: python write_labels.py LAPIS FOLDER
    leaves FOLDER/labels.lapis, a model with labels
"""
import json
import pathlib
import subprocess
import sys

import nrrd
import numpy as np
from safetensors import safe_open

lapis, folder = sys.argv[1], pathlib.Path(sys.argv[2])
random = np.random.default_rng(3)

# Each voxel belongs to the nearest of 40 centres, or to the matrix where two are about as near.
side = np.array([24, 20, 16])
centres = random.uniform(size=(40, 3))
z, y, x = np.meshgrid(*((np.arange(n) + 0.5) / n for n in side[::-1]), indexing="ij")
offset = np.stack([x, y, z], axis=-1)[..., None, :] - centres
distance = np.sort(np.linalg.norm(offset - np.round(offset), axis=-1), axis=-1)
nearest = np.argmin(np.linalg.norm(offset - np.round(offset), axis=-1), axis=-1)
labels = np.where(distance[..., 1] - distance[..., 0] < 0.05, 0, nearest + 1).astype("<u4")
palette = np.concatenate([[[30, 30, 30]], random.integers(80, 256, size=(40, 3))])
colours = np.concatenate([palette[labels], np.full(labels.shape + (1,), 255)], axis=-1).astype(np.uint8)

nrrd.write(str(folder / "pynrrd-labels.nrrd"), labels.transpose(2, 1, 0), {"endian": "little"})
header = {"kinds": ["RGBA-color", "space", "space", "space"], "lapis_tiles": "xyz", "lapis_labels": "pynrrd-labels.nrrd"}
custom = {"lapis_tiles": "string", "lapis_labels": "string"}
nrrd.write(str(folder / "pynrrd.nrrd"), colours.transpose(3, 2, 1, 0), header, custom_field_map=custom)
np.save(folder / "numpy.npy", colours)
np.save(folder / "numpy-labels.npy", labels)
(folder / "numpy.volume.json").write_text(json.dumps({"tiles": "xyz", "labels": "numpy-labels.npy"}))


def run(*arguments):
    done = subprocess.run([lapis, *map(str, arguments), "--json"], check=True, capture_output=True)
    return json.loads(done.stdout)


for name in ["pynrrd.nrrd", "numpy.npy"]:
    about = run("info", folder / name)
    assert about["counts"]["particles"] == len(np.unique(labels[labels > 0])), about
    assert abs(about["measures"]["particle_share"] - (labels > 0).mean()) < 1e-9, about
    assert about["measures"]["size"] == side.tolist() and about["measures"]["tiles"] == "xyz", about
model = folder / "labels.lapis"
run("fill", "meshes/kiwi.obj", "--tets", 2000, "--texture", folder / "pynrrd.nrrd", "--type", 0, "--scale", 15, "-o", model)
with safe_open(model, "numpy") as file:
    assert (file.get_tensor("labels_0") == labels).all() and (file.get_tensor("exemplar_0") == colours).all()
print(f"{model}: the labels of {about['counts']['particles']} particles")
