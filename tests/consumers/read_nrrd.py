"""pynrrd reads a volume that Lapis wrote, and both see the same block.

Usage: python read_nrrd.py VOLUME.nrrd LAPIS
"""
import json
import subprocess
import sys

import nrrd
import numpy as np

path, lapis = sys.argv[1:]
data, header = nrrd.read(path)
report = json.loads(subprocess.run([lapis, "info", path, "--json"], check=True, capture_output=True).stdout)
assert data.dtype == np.uint8 and data.shape[0] == 4, (data.dtype, data.shape)
assert list(data.shape[1:]) == report["measures"]["size"], (data.shape, report)
assert header["kinds"] == ["RGBA-color", "space", "space", "space"], header["kinds"]
assert header["lapis_tiles"] == report["measures"]["tiles"], header
mean = np.round(data.reshape(4, -1).mean(axis=1))
assert np.abs(mean - report["measures"]["mean_colour"]).max() <= 1, mean
print(f"{path}: {data.shape[1:]} voxels, tiles along {header['lapis_tiles']!r}")
