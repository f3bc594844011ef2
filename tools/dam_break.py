#!/usr/bin/python3
"""Breaks a dam, and compares how far the water has come, and how hard it strikes, with what was measured.

  tools/dam_break.py                               both cases at level accurate, on the CPU
  tools/dam_break.py --backend cuda --accuracy fast balanced accurate --spacing 0.018 0.02 0.022

The front is that of Martin & Moyce's own column (1952; Z = x / a over T = t sqrt(2 g / a)): water 28.6 mm wide and twice as
high, of twelve spacings, on a tray without end across. At that size surface tension holds the front back, so the water has
its own, and meets the dry floor at a right angle, which is assumed. The gauge is the lowest in the face of the box of
dam_break_box (the dam break on a box of MARIN: Kleefsman et al. 2005), where the water arrives, with 2.5 kPa, after
0.405 s, and bears 10.9 kPa in the mean of 11 ms at the peak. --spacing, in metres, is the gauge's, at level accurate."""
import argparse
import math
import pathlib
import tempfile

import cases
import numpy as np

WIDTH, GRAVITY = 0.028575, 9.81
MARTIN_MOYCE = ((0.832, 1.217), (1.219, 1.474), (1.997, 2.292), (2.547, 2.995), (3.345, 4.134), (4.034, 4.944),
                (4.418, 5.881), (5.091, 6.980))
ARRIVAL, ARRIVED, PEAK, MEAN_OVER = 0.405, 2.5e3, 10.9e3, 0.011

SCENE = f"""
[scene]
name = "column"
gravity = [0.0, 0.0, -{GRAVITY}]
rate_hz = 2000
duration = {5.2 * math.sqrt(WIDTH / (2 * GRAVITY))}
[domain]
min = [{-0.4 * WIDTH}, 0.0, {-0.4 * WIDTH}]
max = [{10 * WIDTH}, {WIDTH}, {3.3 * WIDTH}]
periodic = [false, true, false]
[numerics]
spacing = {WIDTH / 12}
[[material]]
name = "water"
density = 1000
viscosity = 0.001
surface_tension = 0.072
adhesion = 0.036
[[body]]
name = "tray"
type = "static"
material = "water"
position = [{4.8 * WIDTH}, {0.5 * WIDTH}, {1.05 * WIDTH}]
[[body.shape]]
type = "box"
size = [{10.4 * WIDTH}, {WIDTH}, {2.9 * WIDTH}]
[[body.shape]]
type = "box"
size = [{10 * WIDTH}, {2 * WIDTH}, {2.9 * WIDTH}]
position = [{0.2 * WIDTH}, 0.0, {0.4 * WIDTH}]
subtract = true
[[body]]
name = "water"
type = "fluid"
material = "water"
position = [{0.5 * WIDTH}, {0.5 * WIDTH}, {WIDTH}]
[[body.shape]]
type = "box"
size = [{WIDTH}, {WIDTH}, {2 * WIDTH}]
[[probe]]
name = "front"
quantity = "front"
body = "water"
axis = "x"
side = "max"
rate_hz = 1000
"""


def front(folder, accuracy, options):
    (folder / "column.toml").write_text(SCENE)
    failure = cases.run(options, folder / "column.toml", folder / "front", "--accuracy", accuracy)
    if failure:
        return failure
    found = cases.columns(folder / "front/front.csv")
    way = [np.interp(T * math.sqrt(WIDTH / (2 * GRAVITY)), found["time_s"], found["front_x_m"]) for T, _ in MARTIN_MOYCE]
    return "front over the measured one " + ", ".join(
        f"{x / WIDTH / Z - 1:+.1%} (T {T:.2f})" for x, (T, Z) in zip(way, MARTIN_MOYCE))


def gauge(folder, words, options):
    failure = cases.run(options, "dam_break_box", folder / "gauge", *words, "--duration", "0.7")
    if failure:
        return failure
    found = {name: np.array(column) for name, column in cases.columns(folder / "gauge/front_of_box.csv").items()}
    lowest = found["z_m"] == found["z_m"].min()
    time, pressure = found["time_s"][lowest], found["pressure_Pa"][lowest]
    if not np.any(pressure > ARRIVED):
        return "no water arrives"
    arrived = time[np.argmax(pressure > ARRIVED)]
    sample = time[1] - time[0]
    several = max(1, round(MEAN_OVER / sample))
    peak = np.convolve(pressure, np.ones(several) / several, "valid").max()
    return (f"water arrives after {arrived:.3f} s ({arrived / ARRIVAL - 1:+.1%}), "
            f"{1000 * several * sample:.0f} ms at the peak {peak / 1000:.1f} kPa ({peak / PEAK:.2f} times the measured)")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--accuracy", nargs="+", default=["accurate"], choices=("fast", "balanced", "accurate"))
    parser.add_argument("--spacing", type=float, nargs="*", default=[], metavar="METRES")
    cases.add_options(parser)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for accuracy in options.accuracy:
            print(f"{accuracy}: {front(folder, accuracy, options)}", flush=True)
        levels = [(accuracy, ["--accuracy", accuracy]) for accuracy in options.accuracy]
        spacings = [(f"{1e3 * dx:g} mm", ["--accuracy", "accurate", "--spacing", str(dx)]) for dx in options.spacing]
        for label, words in levels + spacings:
            print(f"{label}: {gauge(folder, words, options)}", flush=True)


if __name__ == "__main__":
    main()
