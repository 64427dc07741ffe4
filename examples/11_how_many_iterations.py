"""
How many iterations?
====================

Quality saturates while the distance from the original goes on growing. Instead of a number of iterations
one can say what may change: a bound for every point (``max_deviation_fraction``), or a rule that ends the
run (``stop_gain``, ``stop_normal_deviation``, ``stop_volume_percent`` ...). The filter says why it stopped.
"""

import numpy as np
import pyvista as pv
from pyvista import examples

from vtksmooth import SurfaceComparison, TrapeziumDrawing

ant = pv.read(examples.antfile)

# %%
# Mean k and the point farthest from the original surface, by iteration; free, and with every point held to
# 0.2 % of the diagonal.

counts = np.arange(0, 21)
curves = {}
for name, bound in (("free", None), ("held to 0.2 %", 0.002)):
    rows = []
    for iterations in counts:
        better = pv.wrap(TrapeziumDrawing(iterations=int(iterations), max_deviation_fraction=bound)(ant))
        comparison = SurfaceComparison()
        comparison(better, ant)
        far = np.abs(better.compute_implicit_distance(ant)["implicit_distance"]).max() / ant.length
        rows.append((comparison.summary["aspect_ratio"]["mean"], 100 * far))
    curves[name] = np.array(rows)

plotter = pv.Plotter(shape=(1, 2), window_size=(1300, 480))
colours = {"free": "#d95f02", "held to 0.2 %": "#1b9e77"}
for column, label in enumerate(("mean aspect ratio k", "farthest point, % of the diagonal")):
    plotter.subplot(0, column)
    chart = pv.Chart2D(x_label="iterations", y_label=label)
    for name, curve in curves.items():
        chart.line(counts, curve[:, column], color=colours[name], width=3.0, label=name)
    plotter.add_chart(chart)
plotter.show()

# %%
# Stop rules, with at most 100 iterations. The iteration that would break a bound is undone.

rules = (
    {"stop_gain": 0.001},
    {"stop_normal_deviation": 5.0, "stop_statistic": "mean"},
    {"stop_deviation_fraction": 0.01},
    {"stop_volume_percent": 1.0},
)
for rule in rules:
    smoothing = TrapeziumDrawing(iterations=100, **rule)
    smoothing(ant)
    print(rule)
    print(f"    {smoothing.report}")
    assert smoothing.report.iterations < 100
    assert smoothing.report.stop_reason != "iterations"

assert curves["held to 0.2 %"][:, 1].max() <= 0.2001
assert curves["free"][-1, 0] > curves["free"][0, 0]
