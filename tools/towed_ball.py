#!/usr/bin/python3
"""Tows a ball through a liquid at rest and compares its drag with the standard curve (Schiller & Naumann 1933).

  tools/towed_ball.py                              radius 3 spacings at Re 10 to 1000, on the CPU
  tools/towed_ball.py --backend cuda --radii 2 3 5 --jobs 5

The ball goes 10 radii, or --way, in a periodic box of 8 x 8 radii, or --across, that is 4 radii longer than its way, at
0.2 m/s after a start of 0.2 radii. A narrow box adds to the drag, by its blockage. Prints the drag over the standard one in
the last three fifths of the way, and the force's noise (what a mean of 26 ms leaves) over the drag."""
import argparse
import concurrent.futures
import math
import os
import pathlib
import tempfile

import cases
import numpy as np

SPACING, SPEED, DENSITY = 0.02, 0.2, 1000.0

SCENE = """
[scene]
name = "tow"
gravity = [0.0, 0.0, 0.0]
rate_hz = 1000
duration = {duration}
[domain]
min = [{low}, {low}, 0.0]
max = [{high}, {high}, {length}]
periodic = [true, true, true]
[numerics]
spacing = {spacing}
support_over_spacing = {support}
artificial_viscosity = {alpha}
tension = true
max_speed = {fastest}
[[material]]
name = "liquid"
density = {density}
viscosity = {viscosity}
[[body]]
name = "ball"
type = "rigid"
material = "liquid"
position = [{x}, {y}, {start}]
[[body.shape]]
type = "sphere"
radius = {radius}
[[body]]
name = "fluid"
type = "fluid"
material = "liquid"
position = [0.0, 0.0, {middle}]
[[body.shape]]
type = "box"
size = [{width}, {width}, {length}]
[[body.shape]]
type = "sphere"
radius = {radius}
position = [{x}, {y}, {hole}]
subtract = true
[[proxy]]
device = 0
body = "ball"
handle = [0.0, 0.0, 0.0]
[proxy.coupling_limit]
stiffness = 2000
damping = 40
angular_stiffness = 20
angular_damping = 0.4
"""


def write_scene(folder, radius, reynolds, options):
    width, length = (round(sides * radius / SPACING) * SPACING for sides in (options.across, options.way + 4))
    start, viscosity = 2 * radius, DENSITY * SPEED * 2 * radius / reynolds
    (folder / "tow.toml").write_text(SCENE.format(
        duration=options.way * radius / SPEED, low=-width / 2, high=width / 2, width=width, length=length, middle=length / 2,
        spacing=SPACING, support=options.support, alpha=options.alpha, fastest=2 * SPEED, density=DENSITY,
        viscosity=viscosity, x=options.place[0], y=options.place[1], start=start, radius=radius, hole=start - length / 2))
    ramp = 0.2 * radius / SPEED
    with open(folder / "path.csv", "w") as out:
        print("time,x,y,z,qx,qy,qz,qw", file=out)
        for t in np.linspace(0, options.way * radius / SPEED, 401):
            way = SPEED * t * t / (2 * ramp) if t < ramp else SPEED * (t - ramp / 2)
            print(f"{t:.6f},{options.place[0]},{options.place[1]},{start + way:.8f},0,0,0,1", file=out)


def tow(spacings, reynolds, options):
    radius = spacings * SPACING
    drag = (24 / reynolds * (1 + 0.15 * reynolds**0.687) * 0.5 * DENSITY * SPEED**2 * math.pi * radius**2)
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        write_scene(folder, radius, reynolds, options)
        failure = cases.run(options, folder / "tow.toml", folder / "out", "--path", f"0={folder / 'path.csv'}")
        if failure:
            return f"R = {spacings:g} dx, Re {reynolds:g}: {failure}"
        proxy = cases.columns(folder / "out/proxy.csv")
    time, force = np.array(proxy["time_s"]), -np.array(proxy["fz_N"])
    end = options.way * radius / SPEED
    parts = [force[(time > end * low) & (time <= end * (low + 0.2))].mean() / drag for low in (0.4, 0.6, 0.8)]
    smooth = np.convolve(np.pad(force, 13, "edge"), np.ones(26) / 26, "valid")[:len(force)]
    noise = (force - smooth)[time > 0.4 * end].std() / drag
    return (f"R = {spacings:g} dx, Re {reynolds:g}: {np.mean(parts):.2f} of the standard drag ("
            + ", ".join(f"{p:.2f}" for p in parts) + f"), noise {noise:.3f}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--radii", type=float, nargs="+", default=[3], metavar="SPACINGS")
    parser.add_argument("--reynolds", type=float, nargs="+", default=[10, 30, 100, 300, 1000])
    parser.add_argument("--way", type=float, default=10, help="in radii")
    parser.add_argument("--across", type=float, default=8, help="in radii")
    parser.add_argument("--place", type=float, nargs=2, default=[0.003, 0.002], metavar=("X", "Y"),
                        help="of the ball's centre on the lattice, m")
    parser.add_argument("--support", type=float, default=2.7, help="over the spacing; default that of the levels")
    parser.add_argument("--alpha", type=float, default=0.0, help="artificial viscosity; default that of the levels")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="runs at a time")
    cases.add_options(parser)
    options = parser.parse_args()
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        balls = [(r, re) for r in options.radii for re in options.reynolds]
        for line in pool.map(lambda ball: tow(*ball, options), balls):
            print(line, flush=True)


if __name__ == "__main__":
    main()
