"""Cuts beside VTK: the same tetrahedra, the same scalar, one run, one thread each.

    python -m venv venv && venv/bin/pip install pyvista numpy
    cargo build --release --example growth
    venv/bin/python tools/compare_cut.py target/release/examples/growth 1000000

The growth tool fills and cuts the model and leaves its tetrahedra and the scalars at their vertices (distance
to the plane, height over the stroke on the screen). VTK then contours and clips these tetrahedra at 0. Prints a
Markdown table of medians, each of Lapis beside what does the same in VTK: the surface alone (`cut::section`,
`contour`), the tetrahedra of both sides (`cut::clip`, `clip_scalar`), and the pieces (`cut::cut`, `clip_scalar` and
then `connectivity`, which numbers what hangs together). `clip_scalar` makes wedges too; the last column is its time
with everything divided into tetrahedra, as Lapis does.
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
          f"Lapis on one thread; medians in milliseconds; in brackets VTK's over Lapis's\n")
    print("| tetrahedra | along | section | `contour` | clip | `clip_scalar` | cut, bare | and `connectivity` "
          "| cut, filled | `clip_scalar`, triangulated |")
    print("| --: | --- | --: | --: | --: | --: | --: | --: | --: | --: |")
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
            both = lambda: grid.clip_scalar(scalars="s", value=0.0, both=True)
            clip, sides = median(both)
            # These take seconds, and are not near: once is enough.
            pieces, _ = median(lambda: [side.connectivity() for side in both()], 1)
            whole, _ = median(lambda: [side.triangulate() for side in both()], 1)
            assert surface.n_cells > 0 and all(side.n_cells > 0 for side in sides)
            own = lambda what: f"{cut[what] * 1e3:.1f}"
            against = lambda seconds, what: f"{seconds * 1e3:.1f} ({seconds / cut[what]:.2f})"
            print(f"| {ours['tetrahedra']:,} | {name} | {own('section_seconds')} | {against(contour, 'section_seconds')} "
                  f"| {own('clip_seconds')} | {against(clip, 'clip_seconds')} | {own('bare_seconds')} "
                  f"| {against(pieces, 'bare_seconds')} | {own('seconds')} | {against(whole, 'seconds')} |", flush=True)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:] or ["100000"])
