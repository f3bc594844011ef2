#!/usr/bin/python3
"""Lets water slosh in a tank, and tells how much of its energy a wave keeps and how long its period is.

  tools/sloshing.py                                20 spacings deep, without artificial viscosity, on the CPU
  tools/sloshing.py --backend cuda --deep 20 40 --alpha 0 0.005 0.02

The tank is 1 m long, 0.5 m deep and periodic across. The water begins level, with the velocities of the first standing
wave of potential flow, at most 0.1 m/s: omega^2 = g k tanh(k h). Prints the kinetic energy at its peaks after halves of a
period, over that at the start, and the times of the second and the fourth peak over the exact ones."""
import argparse
import math
import pathlib
import tempfile

import cases
import numpy as np

LENGTH, DEPTH, WALL, ACROSS, SPEED = 1.0, 0.5, 0.1, 10, 0.1
WAVE_NUMBER = math.pi / LENGTH
PERIOD = 2 * math.pi / math.sqrt(9.81 * WAVE_NUMBER * math.tanh(WAVE_NUMBER * DEPTH))

SCENE = """
[scene]
name = "sloshing"
gravity = [0.0, 0.0, -9.81]
rate_hz = 1000
duration = {duration}
[domain]
min = [-0.2, 0.0, -0.2]
max = [1.2, {across}, 0.8]
periodic = [false, true, false]
[numerics]
spacing = {spacing}
support_over_spacing = {support}
artificial_viscosity = {alpha}
max_speed = 2.2
[[material]]
name = "water"
density = 1000
viscosity = 0.001
[[body]]
name = "tank"
type = "static"
material = "water"
position = [0.5, {middle}, 0.25]
[[body.shape]]
type = "box"
size = [1.2, {across}, 0.7]
[[body.shape]]
type = "box"
size = [1.0, {wider}, 0.6]
position = [0.0, 0.0, 0.05]
subtract = true
[[body]]
name = "water"
type = "fluid"
material = "water"
[[body.shape]]
type = "particles"
file = "water.csv"
[[probe]]
name = "energy"
quantity = "energy"
rate_hz = 500
"""


def write_scene(folder, deep, alpha, support):
    dx = DEPTH / deep
    across = ACROSS * dx
    (folder / "sloshing.toml").write_text(SCENE.format(
        duration=2.2 * PERIOD, across=across, middle=across / 2, wider=across + 0.1, spacing=dx, support=support,
        alpha=alpha))
    with open(folder / "water.csv", "w") as out:
        print("x,y,z,vx,vy,vz", file=out)
        for x, y, z in ((dx * (i + 0.5), dx * (j + 0.5), dx * (k + 0.5))
                        for k in range(deep) for j in range(ACROSS) for i in range(round(LENGTH / dx))):
            scale = SPEED / math.cosh(WAVE_NUMBER * DEPTH)
            u = -scale * math.sin(WAVE_NUMBER * x) * math.cosh(WAVE_NUMBER * z)
            w = scale * math.cos(WAVE_NUMBER * x) * math.sinh(WAVE_NUMBER * z)
            print(f"{x:.7g},{y:.7g},{z:.7g},{u:.7g},0,{w:.7g}", file=out)


def peak(time, energy, near):
    """The time and height of the parabola through an energy near its peak."""
    part = np.abs(time - near) < 0.12 * PERIOD
    a, b, c = np.polyfit(time[part] - near, energy[part], 2)
    return near - b / (2 * a), c - b * b / (4 * a)


def slosh(deep, alpha, options):
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        write_scene(folder, deep, alpha, options.support)
        failure = cases.run(options, folder / "sloshing.toml", folder / "out")
        if failure:
            return f"{deep} deep, alpha {alpha:g}: {failure}"
        energy = cases.columns(folder / "out/energy.csv")
    time, kinetic = np.array(energy["time_s"]), np.array(energy["kinetic_J"])
    peaks = [peak(time, kinetic, half * PERIOD / 2) for half in (1, 2, 3, 4)]
    return (f"{deep} spacings deep, alpha {alpha:g}: energy left "
            + ", ".join(f"{height / kinetic[0]:.3f}" for _, height in peaks)
            + f"; period over the exact one {peaks[1][0] / PERIOD:.4f}, {peaks[3][0] / (2 * PERIOD):.4f}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--deep", type=int, nargs="+", default=[20], metavar="SPACINGS")
    parser.add_argument("--alpha", type=float, nargs="+", default=[0.0], help="artificial viscosity")
    parser.add_argument("--support", type=float, default=2.7, help="over the spacing; default that of the levels")
    cases.add_options(parser)
    options = parser.parse_args()
    for deep in options.deep:
        for alpha in options.alpha:
            print(slosh(deep, alpha, options), flush=True)


if __name__ == "__main__":
    main()
