"""NumPy, pynrrd and Pillow read what `lapis bake` writes, and all three see the same voxels in the same places.

Usage: python read_bake.py LAPIS MODEL.lapis FOLDER
"""
import json
import pathlib
import subprocess
import sys

import nrrd
import numpy as np
from PIL import Image

lapis, model, folder = sys.argv[1], sys.argv[2], pathlib.Path(sys.argv[3])


def bake(output, *options):
    command = [lapis, "bake", model, "-o", str(output), "--json", "--quiet", *options]
    return json.loads(subprocess.run(command, check=True, capture_output=True).stdout)


def slices(name):
    pictures = [np.asarray(Image.open(path)) for path in sorted((folder / name).glob("slice-*.png"))]
    return np.stack(pictures), json.loads((folder / name / "volume.json").read_text())


size = ["--resolution", "40", "--padding", "1"]
report = bake(folder / "baked.nrrd", *size)
bake(folder / "baked.npy", *size)
bake(folder / "baked", *size)
measures = report["measures"]

data, header = nrrd.read(str(folder / "baked.nrrd"))  # [rgba, x, y, z]
assert list(data.shape[1:]) == measures["size"] and data.dtype == np.uint8, (data.shape, measures)
assert np.allclose(header["space directions"][1:], np.diag(measures["voxel_size"])), header
assert np.allclose(header["space origin"], measures["origin"]), header
array = np.load(folder / "baked.npy", mmap_mode="r")  # [z, y, x, rgba]
assert np.array_equal(array, data.transpose(3, 2, 1, 0))
pictures, sidecar = slices("baked")
assert np.array_equal(array, pictures)
assert sidecar == json.loads((folder / "baked.volume.json").read_text())
assert sidecar["voxel_size"] == measures["voxel_size"] and sidecar["origin"] == measures["origin"], sidecar
assert (array[..., 3] > 0).sum() == report["counts"]["inside"]
assert abs(measures["volume_ratio"] - 1) < 0.05, measures

palette = ["#f6efd2", "#a4c84a", "#20170f"]
report = bake(folder / "print", "--dpi-x", "30", "--dpi-y", "20", "--layer-height", "2", "--palette", ",".join(palette))
pictures, sidecar = slices("print")
assert sidecar["print"] == {"dpi": [30, 20], "layer_mm": 2, "unit_mm": 1}, sidecar
printed = pictures[pictures[..., 3] > 0]
names, counts = np.unique(printed, axis=0, return_counts=True)
counted = {"#%02x%02x%02x" % tuple(name[:3]): int(n) for name, n in zip(names, counts)}
assert counted == {name: n for name, n in report["counts"]["materials"].items() if n}, (counted, report)
dpi = Image.open(folder / "print" / "slice-0000.png").info["dpi"]
assert np.allclose(dpi, [30, 20], atol=0.1), dpi
print(f"{model}: baked to {measures['size']} voxels, printed with {counted}")
