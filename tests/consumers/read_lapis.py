"""Recomputes colours and particle labels from a .lapis file alone, as docs/format.md says, and compares them with `lapis info`.

Usage: python read_lapis.py LAPIS MODEL.lapis
"""
import json
import subprocess
import sys

import numpy as np
from safetensors import safe_open

lapis, path = sys.argv[1:]
with safe_open(path, "numpy") as file:
    a = {name: file.get_tensor(name) for name in file.keys()}
    about = json.loads(file.metadata()["lapis"])
assert about["format"] == 5


def linear(c):
    """sRGB bytes to linear light."""
    s = c / 255.0
    return np.where(s <= 0.04045, s / 12.92, ((s + 0.055) / 1.055) ** 2.4)


def srgb(x):
    """Linear light to sRGB bytes."""
    x = np.clip(x, 0, 1)
    return 255 * np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)


def trilinear(block, uvw, tiles):
    """A block [z, y, x, …] at texture coordinates: wrapped on tiling axes, clamped on the others."""
    taps = []
    for axis, n in zip("xyz", block.shape[2::-1]):
        x = uvw["xyz".index(axis)] * n - 0.5
        if axis in tiles:
            lo = int(np.floor(x))
            taps.append(((lo % n, 1 - (x - lo)), ((lo + 1) % n, x - lo)))
        else:
            x = min(max(x, 0), n - 1)
            lo = int(x)
            taps.append(((lo, 1 - (x - lo)), (min(lo + 1, n - 1), x - lo)))
    return sum(
        block[k, j, i] * (wi * wj * wk) for i, wi in taps[0] for j, wj in taps[1] for k, wk in taps[2]
    )


def shifted(patch, uvw):
    """Where a patch reads its exemplar."""
    return uvw + a["patch_shift"][patch].astype(float) if "patch_shift" in a else uvw


def taken(patch, uvw):
    """How much of the voxels around a point the patch takes, and its colour there without the others."""
    e = a["patch_exemplar"][patch]
    block = a[f"exemplar_{e}"].astype(float)
    block = np.concatenate([linear(block[..., :3]), block[..., 3:] / 255], axis=-1)
    tiles = about["exemplar_tiles"][e]
    choice = a["patch_choice"][patch] if "patch_choice" in a else 2**32 - 1
    if choice == 2**32 - 1:
        return 1.0, trilinear(block, uvw, tiles)
    named = np.isin(
        a.get(f"labels_{e}", np.zeros(block.shape[:3])),
        a["choice_label"][a["choice_start"][choice] : a["choice_start"][choice + 1]],
    )
    takes = (named != bool(a["choice_without"][choice])).astype(float)
    share = trilinear(takes, uvw, tiles)
    return share, trilinear(block * takes[..., None], uvw, tiles) / max(share, 1e-30)


def texture(patch, uvw):
    return taken(patch, shifted(patch, uvw))[1]


def opacity(patch, uvw):
    n = a["patch_mask"][patch]
    if n in about.get("masks_everywhere", []):
        mask = 1.0
    elif (uvw >= 0).all() and (uvw <= 1).all():
        mask = trilinear(a[f"mask_{n}"].astype(float), uvw, "") / 255
    else:
        mask = 0.0
    return mask * taken(patch, shifted(patch, uvw))[0] if mask > 0 else mask


def colour(tet, barycentric):
    x, m = np.zeros(4), 0.0
    layers = range(a["layer_start"][tet], a["layer_start"][tet + 1])
    for layer in layers:
        uvw = barycentric @ a["layer_uvw"][layer].astype(float)
        patch = a["layer_patch"][layer]
        mask = opacity(patch, uvw)
        c = texture(patch, uvw)
        x = x * (1 - mask) + mask * np.append(c[:3] * c[3], c[3])
        m = m * (1 - mask) + mask
    if m < 1 / 255:
        oldest = layers[0]
        c = texture(a["layer_patch"][oldest], barycentric @ a["layer_uvw"][oldest].astype(float))
        return np.append(srgb(c[:3]), 255 * c[3])
    x /= m
    return np.append(srgb(x[:3] / x[3]) if x[3] > 0 else np.zeros(3), 255 * x[3])


def particle(tet, barycentric):
    """Patch and label of the layer that is seen; the label is None where its exemplar has none."""
    shown, clear = [], 1.0
    layers = range(a["layer_start"][tet], a["layer_start"][tet + 1])
    for layer in reversed(layers):
        uvw = barycentric @ a["layer_uvw"][layer].astype(float)
        patch = a["layer_patch"][layer]
        mask = opacity(patch, uvw)
        shown.append((clear * mask, patch, shifted(patch, uvw)))
        clear *= 1 - mask
    if 1 - clear < 1 / 255:
        weight, patch, uvw = shown[-1]
    else:
        weight, patch, uvw = max(shown, key=lambda s: s[0])
    e = a["patch_exemplar"][patch]
    # Where two layers show nearly as much as each other, or two voxels are nearly as far, rounding may decide.
    if sorted((s[0] for s in shown), reverse=True)[1:2] > [weight - 1e-3]:
        return None
    if f"labels_{e}" not in a:
        return int(patch), None
    block = a[f"labels_{e}"]
    at = []
    for axis, n in zip("xyz", block.shape[::-1]):
        x = uvw["xyz".index(axis)] * n
        if abs(x - round(x)) < 1e-3:
            return None
        at.append(int(np.floor(x)) % n if axis in about["exemplar_tiles"][e] else min(max(int(np.floor(x)), 0), n - 1))
    return int(patch), int(block[at[2], at[1], at[0]])


random = np.random.default_rng(1)
tets = random.integers(len(a["tets"]), size=40)
weights = random.dirichlet(np.ones(4) * 2, size=40)
points = [w @ a["vertices"][a["tets"][t]] for t, w in zip(tets, weights)]
command = [lapis, "info", path, "--json"] + [f"--at={p[0]!r},{p[1]!r},{p[2]!r}" for p in map(np.ndarray.tolist, points)]
answers = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)["measures"]["at"]
worst = 0.0
told = 0
for answer, t in zip(answers, tets):
    # A point on a face may be found in the neighbour; colours agree there only where the layers do.
    found, barycentric = answer["tet"], np.array(answer["barycentric"])
    ours = colour(found, barycentric)
    worst = max(worst, np.abs(ours - answer["colour"]).max())
    seen = particle(found, barycentric)
    if seen is not None:
        assert seen == (answer["patch"], answer["label"]), (seen, answer)
        told += 1
    depth = barycentric @ a["depth"][a["tets"][found]]
    assert abs(depth - answer["depth"]) < 1e-9
# The program rounds to whole bytes.
assert worst <= 1.0, f"{path}: colours differ by {worst:.2f}/255"
assert told > 20, told
print(f"{path}: {len(points)} colours recomputed, at most {worst:.2f}/255 apart")
