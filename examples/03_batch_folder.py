"""
A folder of meshes
==================

Smooth all meshes of a folder; a broken file is reported and does not stop the rest.

    python examples/03_batch_folder.py FOLDER [--output FOLDER] [--iterations N]
    python examples/03_batch_folder.py             makes a folder of samples, one of them broken

Results are written beside each other into the output folder; the table tells what became of each file.
The exit status is 1 when a file of yours failed. On the command line, the recipe that is written into the
output folder does the same: vtksmooth run smooth.json FOLDER --output FOLDER
"""
# sphinx_gallery_thumbnail_path = "pictures/demo_airplane.png"

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

from pyvista import examples

from vtksmooth import Recipe, Step, batch


def smooth_folder(folder: Path, output: Path, iterations: int) -> list[batch.Outcome]:
    """Smooth every mesh file of `folder` into `output`."""
    recipe = Recipe([Step("trapezium-drawing", {"iterations": iterations})])
    jobs = batch.plan([folder], output, ".vtp")
    output.mkdir(parents=True, exist_ok=True)
    recipe.save(output / "smooth.json")
    outcomes = [batch.attempt(recipe, job) for job in jobs]
    print("\n".join(batch.table(outcomes)))
    return outcomes


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
    done = smooth_folder(options.folder, options.output or options.folder / "smooth", options.iterations)
    sys.exit(any(outcome.error for outcome in done))

with tempfile.TemporaryDirectory() as temporary:
    samples = Path(temporary)
    results = options.output or samples / "smooth"
    make_samples(samples)
    done = smooth_folder(samples, results, options.iterations)
    # The checks: the broken file, and only it, failed; the others have their results.
    assert [outcome.job.source.name for outcome in done if outcome.error] == ["broken.ply"]
    assert {path.name for path in results.iterdir()} >= {"airplane.vtp", "ant.vtp"}
    assert not (results / "broken.vtp").exists()
    for outcome in done:
        if outcome.measured:
            before, after = (summary["aspect_ratio"] for summary in outcome.measured.summaries)
            assert after["min"] >= before["min"], "the smallest k of a mesh never falls"
