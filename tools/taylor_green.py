#!/usr/bin/env python3
"""Writes the particles of config/scenes/taylor_green.toml as CSV to standard output; or tells how fast vortices decay.

  tools/taylor_green.py > config/scenes/taylor_green.csv
  tools/taylor_green.py --decay                            50 x 50 x 12 particles, from a lattice and displaced, on the CPU
  tools/taylor_green.py --decay --backend cuda --across 25 50 100

With --decay, prints the rate at which the kinetic energy falls in the first and the second half of a second over the exact
one, 16 pi^2 nu, at Reynolds number 100: from a lattice, and from one of which every particle is displaced by up to a
quarter of the spacing along each axis (the same each time)."""
import argparse
import math
import pathlib
import random
import sys
import tempfile

import cases

SCENE = cases.ROOT / "config/scenes/taylor_green.toml"
CELLS, LAYERS = 20, 10
LAYERS_OF_DECAY, DISPLACED = 12, 0.25
RATE = 16 * math.pi**2 * 0.01


def write_particles(cells, layers, displaced, out):
    draw = random.Random(1)
    spacing = 1 / cells
    print("x,y,z,vx,vy,vz", file=out)
    for k in range(cells):
        for j in range(layers):
            for i in range(cells):
                x, y, z = ((n + 0.5 + (draw.uniform(-displaced, displaced) if displaced else 0)) * spacing
                           for n in (i, j, k))
                u = -math.cos(2 * math.pi * x) * math.sin(2 * math.pi * z)
                w = math.sin(2 * math.pi * x) * math.cos(2 * math.pi * z)
                print(f"{x:.6g},{y:.6g},{z:.6g},{u:.7g},0,{w:.7g}", file=out)


def decay(cells, displaced, options):
    name = f"{cells} across, " + (f"displaced by {displaced:g} dx" if displaced else "from a lattice")
    with tempfile.TemporaryDirectory() as made:
        folder = pathlib.Path(made)
        with open(folder / "taylor_green.csv", "w") as out:
            write_particles(cells, LAYERS_OF_DECAY, displaced, out)
        text = SCENE.read_text(encoding="utf-8")
        for old, new in (("max = [1.0, 0.5, 1.0]", f"max = [1.0, {LAYERS_OF_DECAY / cells}, 1.0]"),
                         ("spacing = 0.05", f"spacing = {1 / cells}")):
            if old not in text:
                raise SystemExit(f"tools/taylor_green.py: {SCENE} has no '{old}' any more, which --decay replaces")
            text = text.replace(old, new)
        (folder / "taylor_green.toml").write_text(text)
        failure = cases.run(options, folder / "taylor_green.toml", folder / "out")
        if failure:
            return f"{name}: {failure}"
        table = cases.columns(folder / "out/energy.csv")
    energy = dict(zip(table["time_s"], table["kinetic_J"]))
    start, half, end = (energy[min(energy, key=lambda t, at=at: abs(t - at))] for at in (0, 0.5, 1))
    return (f"{name}: {math.log(start / half) / (0.5 * RATE):.2f} and {math.log(half / end) / (0.5 * RATE):.2f} of the exact "
            "rate")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--decay", action="store_true", help="run, and compare the decay with the exact one")
    parser.add_argument("--across", type=int, nargs="+", default=[50], metavar="PARTICLES")
    cases.add_options(parser)
    options = parser.parse_args()
    if not options.decay:
        write_particles(CELLS, LAYERS, 0, sys.stdout)
        return
    for cells in options.across:
        for displaced in (0, DISPLACED):
            print(decay(cells, displaced, options), flush=True)


if __name__ == "__main__":
    main()
