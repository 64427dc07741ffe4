"""Smooth all meshes of a folder; a broken file is reported and does not stop the rest.

    python examples/03_batch_folder.py FOLDER [--output FOLDER] [--iterations N]
    python examples/03_batch_folder.py             makes a folder of samples, one of them broken

Results are written beside each other into the output folder; the table tells what became of each file.
The exit status is 1 when a file of yours failed.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

from pyvista import examples

from vtksmooth import TrapeziumDrawing, VtksmoothError
from vtksmooth.files import READABLE, read_surface, write_surface


def smooth_folder(folder: Path, output: Path, iterations: int) -> dict[str, str]:
    """Smooth every mesh file of `folder` into `output`; return what went wrong, by file name."""
    output.mkdir(parents=True, exist_ok=True)
    failed: dict[str, str] = {}
    print(f"{'file':24} {'points':>8} {'mean k':>16} {'smallest k':>16} {'inverted':>10}")
    for path in sorted(folder.iterdir()):
        if path.suffix.lower() not in READABLE:
            continue
        smoothing = TrapeziumDrawing(iterations=iterations)
        try:
            mesh, notes = read_surface(path)
            notes += write_surface(smoothing(mesh), output / f"{path.stem}_smooth.vtp")
        except VtksmoothError as error:
            failed[path.name] = str(error)
            print(f"{path.name:24} {error}")
            continue
        report = smoothing.report
        mean, least, inverted = report.mean_aspect_ratio, report.min_aspect_ratio, report.inverted
        print(
            f"{path.name:24} {mesh.n_points:8} {mean[0]:7.3f} -> {mean[1]:.3f} "
            f"{least[0]:7.3f} -> {least[1]:.3f} {inverted[0]:4} -> {inverted[1]}"
        )
        for note in notes:
            print(f"{'':24} {note}")
        assert least[1] >= least[0], "the smallest k of a mesh never falls"
    return failed


def make_samples(folder: Path) -> None:
    """Copy two meshes that PyVista brings along, and one with its end cut off."""
    for source in (examples.antfile, examples.planefile):
        data = Path(source).read_bytes()
        (folder / Path(source).name).write_bytes(data)
    (folder / "broken.ply").write_bytes(data[: len(data) // 2])


parser = argparse.ArgumentParser(description="Smooth all meshes of a folder.")
parser.add_argument("folder", type=Path, nargs="?", help="folder with mesh files")
parser.add_argument("--output", type=Path, help="where results go (default: FOLDER/smooth)")
parser.add_argument("--iterations", type=int, default=5)
options = parser.parse_args()

if options.folder:
    problems = smooth_folder(options.folder, options.output or options.folder / "smooth", options.iterations)
    sys.exit(1 if problems else 0)

with tempfile.TemporaryDirectory() as temporary:
    samples = Path(temporary)
    results = options.output or samples / "smooth"
    make_samples(samples)
    problems = smooth_folder(samples, results, options.iterations)
    # The checks: the broken file, and only it, failed; the others have their results.
    assert list(problems) == ["broken.ply"]
    assert {path.name for path in results.iterdir()} >= {"airplane_smooth.vtp", "ant_smooth.vtp"}
    assert not (results / "broken_smooth.vtp").exists()
