#!/usr/bin/python3
"""Plots what a spoon felt in trays of stone, jelly and oil, as the paper's figure 4 does.

example:
  build/release/bin/palp-haptic-bench --metric figure4 --rate 1000 --link local --series out
  tools/figure4.py out -o figure4.png"""

import argparse
import pathlib
import sys

import plot
from plot import plt

TRAYS = [("rigid", "stone"), ("elastic", "jelly"), ("fluid", "oil")]
METHODS = [("accurate", 1.4, 1.0), ("paper", 0.9, 0.45)]
AXES = [("x", plot.ORANGE, "along the way aside"), ("z", plot.BLUE, "up"), ("y", plot.GREEN, "across")]


def draw(series, out):
    plot.style()
    figure, rows = plt.subplots(2, 3, figsize=(13, 6.4), sharex="col", sharey="row", constrained_layout=True)
    for column, (tray, title) in enumerate(TRAYS):
        for method, width, alpha in METHODS:
            table = plot.read_table(series / f"tray_{tray}_{method}.csv")
            for axes, quantity, unit in zip(rows[:, column], ("force", "torque"), ("n", "nm")):
                for name, colour, meaning in AXES:
                    axes.plot(table["time_s"], table[f"{quantity}_{name}_{unit}"], color=colour, linewidth=width,
                              alpha=alpha, label=f"{meaning}, {method}")
        rows[0, column].set_title(title)
        rows[1, column].set_xlim(left=-0.5)
        rows[1, column].set_xlabel("time since touch [s]")
    rows[0, 0].set_ylabel("force of the tray on the hand [N]")
    rows[1, 0].set_ylabel("torque about the handle [N m]")
    rows[0, 2].legend(loc="upper left")
    figure.savefig(out)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("series", type=pathlib.Path, help="folder that palp-haptic-bench --series wrote into")
    parser.add_argument("-o", "--out", type=pathlib.Path, default=pathlib.Path("figure4.png"))
    options = parser.parse_args()
    try:
        draw(options.series, options.out)
    except plot.BadInput as error:
        sys.exit(f"figure4.py: {error}")


if __name__ == "__main__":
    main()
