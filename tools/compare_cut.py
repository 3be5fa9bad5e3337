"""Cuts beside VTK: the same tetrahedra, the same scalar, one run, one thread each.

    python -m venv venv && venv/bin/pip install pyvista numpy
    cargo build --release --example growth
    venv/bin/python tools/compare_cut.py target/release/examples/growth 1000000

The growth tool fills and cuts the model and leaves its tetrahedra and the scalars at their vertices (distance
to the plane, height over the stroke on the screen). VTK then contours and clips these tetrahedra at 0. Prints a
Markdown table of medians: the surface alone beside `contour`, the pieces beside `clip_scalar`.
"""
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import pyvista as pv
from vtkmodules.vtkCommonCore import vtkSMPTools, vtkVersion

TIMES = 7


def median(work, times=TIMES):
    """Median seconds of some runs, and the last result."""
    seconds = []
    for _ in range(times):
        start = time.perf_counter()
        result = work()
        seconds.append(time.perf_counter() - start)
    return sorted(seconds)[times // 2], result


def main(growth, sizes):
    vtkSMPTools.Initialize(1)
    print(f"VTK {vtkVersion.GetVTKVersion()}, {vtkSMPTools.GetEstimatedNumberOfThreads()} thread; "
          f"Lapis on one thread; medians in milliseconds; in brackets VTK's over Lapis's: of `contour` over the "
          f"section, of the others over the cut of the bare tetrahedra\n")
    print("| tetrahedra | along | section | `contour` | cut, filled | cut, bare | `clip_scalar(both=True)` | triangulated |")
    print("| --: | --- | --: | --: | --: | --: | --: | --: |")
    for size in sizes:
        with tempfile.TemporaryDirectory() as folder:
            run = subprocess.run([growth, "--one", size, "--save", folder], check=True, capture_output=True)
            ours = json.loads(run.stdout)
            load = lambda name: np.load(Path(folder) / f"{name}.npy")
            grid = pv.UnstructuredGrid({pv.CellType.TETRA: load("tets").astype(np.int64)}, load("points"))
            scalars = {name: load(name) for name in ours["cuts"]}
        for name, cut in ours["cuts"].items():
            grid.clear_data()
            grid["s"] = scalars[name]
            grid.set_active_scalars("s")
            contour, surface = median(lambda: grid.contour([0.0], scalars="s"))
            clip, pieces = median(lambda: grid.clip_scalar(scalars="s", value=0.0, both=True))
            # Takes seconds, and is not near: once is enough.
            whole, _ = median(lambda: [p.triangulate() for p in grid.clip_scalar(scalars="s", value=0.0, both=True)], 1)
            assert surface.n_cells > 0 and all(p.n_cells > 0 for p in pieces)
            against = lambda seconds, own: f"{seconds * 1e3:.1f} ({seconds / own:.2f})"
            bare = cut["bare_seconds"]
            print(f"| {ours['tetrahedra']:,} | {name} | {cut['section_seconds'] * 1e3:.1f} "
                  f"| {against(contour, cut['section_seconds'])} | {cut['seconds'] * 1e3:.1f} | {bare * 1e3:.1f} "
                  f"| {against(clip, bare)} | {against(whole, bare)} |", flush=True)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:] or ["100000"])
