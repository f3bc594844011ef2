#!/usr/bin/python3
"""Plots what palp's programs write, as a PNG: the log of a haptic bridge (force, torque, sample age, lateness over time)
or the time series of a scene's probes (first column time_s). The columns tell which of the two a file is.

examples:
  tools/plot.py out/demo/bridge.csv
  tools/plot.py out/run/probe_wall.csv -o wall.png --from 1 --to 3"""

import argparse
import csv
import math
import pathlib
import re
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (the back end must be chosen first)
import numpy as np  # noqa: E402

# Okabe and Ito's palette: told apart by colour-blind readers and in grey.
BLUE, ORANGE, GREEN, PINK, SKY, YELLOW, INK = "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#222222"
SERIES = [BLUE, ORANGE, GREEN, PINK, SKY, YELLOW]
# States of the bridge in which the hand does not feel the simulation as it is: (background, name).
STATES = {"degraded": ("#F6E8C8", "degraded"), "stale": ("#F3D3C4", "stale"), "fault": ("#E8B0B0", "fault")}
UNITS = {"pa": "Pa", "kpa": "kPa", "m": "m", "mm": "mm", "m_s": "m/s", "n": "N", "nm": "N m", "j": "J", "k": "K",
         "kg_m3": "kg/m³", "rad": "rad", "rad_s": "rad/s", "kg": "kg", "w": "W", "us": "µs", "ms": "ms", "s": "s"}


class BadInput(Exception):
    pass


def style():
    plt.rcParams.update({
        "font.family": "DejaVu Sans", "font.size": 10, "axes.titlesize": 12, "axes.titlelocation": "left",
        "axes.spines.top": False, "axes.spines.right": False, "axes.edgecolor": "#888888", "axes.labelcolor": INK,
        "axes.grid": True, "grid.color": "#E4E4E4", "grid.linewidth": 0.8, "axes.axisbelow": True,
        "xtick.color": "#555555", "ytick.color": "#555555", "legend.frameon": False, "legend.fontsize": 9,
        "lines.linewidth": 1.2, "lines.solid_joinstyle": "round", "figure.dpi": 130,
        "agg.path.chunksize": 20000})


def read_table(path):
    """Columns by name; a column is an array of numbers (empty cells: nan), or of text when a cell is no number."""
    try:
        with open(path, newline="", encoding="utf-8") as file:
            rows = list(csv.reader(line for line in file if not line.startswith("#")))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise BadInput(f"{path}: cannot be read: {error}") from error
    if len(rows) < 3:
        raise BadInput(f"{path}: a line of column names and at least two lines of values were expected")
    names = [name.strip() for name in rows[0]]
    for number, row in enumerate(rows[1:], 2):
        if len(row) != len(names):
            raise BadInput(f"{path}:{number}: {len(row)} values where the first line names {len(names)} columns")
    table = {}
    for i, name in enumerate(names):
        cells = [row[i].strip() for row in rows[1:]]
        try:
            table[name] = np.array([float(cell) if cell else math.nan for cell in cells])
        except ValueError:
            table[name] = np.array(cells, dtype=object)
    return table


def cut(table, time, start, end):
    keep = np.ones(len(time), bool)
    if start is not None:
        keep &= time >= start
    if end is not None:
        keep &= time <= end
    if keep.sum() < 2:
        raise BadInput(f"no values between {start} s and {end} s: the file covers {time[0]:.3f} s to {time[-1]:.3f} s")
    return {name: values[keep] for name, values in table.items()}, time[keep]


def percentile(values, q):
    values = values[np.isfinite(values)]
    return float(np.percentile(values, q)) if len(values) else math.nan


def shade_states(axes, time, states):
    """Colours the background where the bridge is not in its ordinary state; returns the names met."""
    met = []
    edges = [0] + [i for i in range(1, len(states)) if states[i] != states[i - 1]] + [len(states)]
    for begin, end in zip(edges, edges[1:]):
        if states[begin] in STATES:
            color, name = STATES[states[begin]]
            for ax in axes:
                ax.axvspan(time[begin], time[min(end, len(time) - 1)], color=color, lw=0, zorder=0,
                           label=name if ax is axes[0] and name not in met else None)
            met.append(name)
    return met


def vector_panel(ax, time, table, name, label):
    parts = [table[f"{name}_{axis}"] for axis in "xyz"]
    norm = np.sqrt(sum(part**2 for part in parts))
    ax.plot(time, norm, color=INK, lw=1.8, label="norm", zorder=4)
    for part, color, axis in zip(parts, (BLUE, ORANGE, GREEN), "xyz"):
        ax.plot(time, part, color=color, lw=1.0, label=axis, zorder=3)
    ax.axhline(0, color="#999999", lw=0.8, zorder=2)
    ax.set_ylabel(label)
    return norm


def legend(ax):
    handles, labels = ax.get_legend_handles_labels()
    if handles:
        ax.legend(handles, labels, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncol=len(labels), columnspacing=1.2,
                  handlelength=1.4, borderaxespad=0.1)


def bridge_figure(table, title, start, end):
    time = (table["t_ns"] - table["t_ns"][0]) * 1e-9
    table, time = cut(table, time, start, end)
    figure, axes = plt.subplots(4, 1, sharex=True, figsize=(10, 9), layout="constrained",
                                gridspec_kw={"height_ratios": [3, 2, 1.3, 1.3]})
    force = vector_panel(axes[0], time, table, "force", "force on the hand [N]")
    torque = vector_panel(axes[1], time, table, "torque", "torque on the hand [N m]")
    if "state" in table:
        shade_states(axes, time, table["state"])
    age_ms = table["age_us"] * 1e-3
    axes[2].plot(time, age_ms, color=BLUE, lw=0.8)
    axes[2].set_ylabel("sample age [ms]")
    axes[2].set_ylim(bottom=0)
    axes[3].plot(time, np.maximum(table["lateness_us"], 0), color=PINK, lw=0.8)
    axes[3].set_ylabel("lateness [µs]")
    axes[3].set_ylim(bottom=0)
    axes[3].set_xlabel("time [s]")
    axes[3].set_xlim(time[0], time[-1])
    axes[0].set_title(f"{title}: force up to {np.nanmax(force):.2f} N")
    axes[1].set_title(f"torque up to {np.nanmax(torque):.3f} N m", fontsize=10)
    axes[2].set_title(f"age of the simulation's sample: median {percentile(age_ms, 50):.2f} ms, "
                      f"99 % below {percentile(age_ms, 99):.2f} ms", fontsize=10)
    axes[3].set_title(f"loop behind its deadline: median {percentile(table['lateness_us'], 50):.0f} µs, "
                      f"99 % below {percentile(table['lateness_us'], 99):.0f} µs", fontsize=10)
    legend(axes[0])
    figure.align_ylabels(axes)
    return figure


def unit_of(name):
    """Splits 'wall_pressure_pa' into its words and its unit."""
    bracket = re.fullmatch(r"(.*?)\s*\[(.*)\]", name)
    if bracket:
        return bracket.group(1).replace("_", " "), bracket.group(2)
    for suffix in sorted(UNITS, key=len, reverse=True):
        if name.lower().endswith("_" + suffix):
            return name[: -len(suffix) - 1].replace("_", " "), UNITS[suffix]
    return name.replace("_", " "), ""


def probe_groups(names):
    """Columns that differ only in a trailing axis or number share a panel: {(words, unit): [(column, label)]}."""
    groups = {}
    for name in names:
        words, unit = unit_of(name)
        match = re.fullmatch(r"(.*?)[ .]?\b([xyz]|\d+)", words)
        key, label = (match.group(1).strip(), match.group(2)) if match and match.group(1).strip() else (words, words)
        groups.setdefault((key, unit), []).append((name, label))
    return groups


def probe_figure(table, title, start, end):
    time = table.pop("time_s")
    table, time = cut(table, time, start, end)
    numbers = [name for name, values in table.items() if values.dtype != object]
    groups = probe_groups(numbers)
    if not groups:
        raise BadInput("no column of numbers beside time_s")
    figure, axes = plt.subplots(len(groups), 1, sharex=True, squeeze=False, layout="constrained",
                                figsize=(10, 1.2 + 2.2 * len(groups)))
    for ax, ((words, unit), columns) in zip(axes[:, 0], groups.items()):
        shades = matplotlib.colormaps["cividis"](np.linspace(0, 0.85, len(columns))) if len(columns) > len(SERIES) else SERIES
        for (name, label), color in zip(columns, shades):
            ax.plot(time, table[name], color=color, label=label)
        ax.set_ylabel(f"{words} [{unit}]" if unit else words)
        if 1 < len(columns) <= 8:
            legend(ax)
    axes[0, 0].set_title(title)
    axes[-1, 0].set_xlabel("time [s]")
    axes[-1, 0].set_xlim(time[0], time[-1])
    figure.align_ylabels(axes[:, 0])
    return figure


def plot(path, output, title, start, end):
    table = read_table(path)
    if {"t_ns", "force_x", "torque_x", "age_us", "lateness_us"} <= table.keys():
        figure = bridge_figure(table, title or "Haptic bridge", start, end)
    elif "time_s" in table:
        figure = probe_figure(table, title or path.stem, start, end)
    else:
        raise BadInput(f"{path}: neither the log of a bridge (t_ns, force_x, ...) nor probes (time_s, ...)")
    figure.savefig(output)
    plt.close(figure)
    return output


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("csv", type=pathlib.Path, nargs="+")
    parser.add_argument("-o", "--output", type=pathlib.Path, help="the PNG; default: beside the CSV, with its name")
    parser.add_argument("--title")
    parser.add_argument("--from", type=float, dest="start", metavar="S", help="first second shown")
    parser.add_argument("--to", type=float, dest="end", metavar="S", help="last second shown")
    options = parser.parse_args()
    if options.output and len(options.csv) > 1:
        parser.error("--output needs a single CSV")
    style()
    for path in options.csv:
        try:
            print(plot(path, options.output or path.with_suffix(".png"), options.title, options.start, options.end))
        except (BadInput, OSError, KeyError) as error:
            sys.exit(f"plot.py: {error}")


if __name__ == "__main__":
    main()
