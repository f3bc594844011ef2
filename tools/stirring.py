#!/usr/bin/env python3
"""Stirs oil with the ladle of tray_fluid and tells the force against its motion, which is what a hand feels of it.

  tools/stirring.py                                    as each level has it, on the CPU
  tools/stirring.py --backend cuda --spacing 0.04 0.02 0.0125

The ladle goes along the path of the trade's measurements (tools/tradeoff_lib/hands/tray_fluid.toml), a circle of 20 cm a
second. Prints the mean over one circle, from 1.6 to 2.6 s, and the noise of the force above 30 Hz. The limit of fine
spacings is about 2.0 N."""
import argparse
import csv
import pathlib
import subprocess
import tempfile
import tomllib

import numpy as np
from tradeoff_lib import hand, measures

ROOT = pathlib.Path(__file__).resolve().parent.parent
SCENE, SCRIPT = ROOT / "config/scenes/tray_fluid.toml", ROOT / "tools/tradeoff_lib/hands/tray_fluid.toml"
BEGIN, END, RATE_HZ = 1.6, 2.6, 1000


def stir(name, settings, options):
    with tempfile.TemporaryDirectory() as made:
        folder = pathlib.Path(made)
        scene = tomllib.loads(SCENE.read_text(encoding="utf-8"))
        hand.write_path(scene, scene["proxy"][0], SCRIPT, END + 0.1, folder / "path.csv")
        run = subprocess.run(
            [options.bin / "palp-run", SCENE, "--path", f"0={folder / 'path.csv'}", "--duration", str(END + 0.1), "--out",
             folder / "out", "--backend", options.backend, *settings,
             *(word for pair in options.set for word in ("--set", pair))], capture_output=True, text=True)
        if run.returncode != 0:
            return f"{name}: {run.stderr.strip().splitlines()[-1]}"
        with open(folder / "out/proxy.csv") as table:
            rows = [row for row in csv.DictReader(table) if row["fx_N"]]
    place, force = (np.array([[float(row[column.format(axis)]) for axis in "xyz"] for row in rows])
                    for column in ("{}_m", "f{}_N"))
    time = np.array([float(row["time_s"]) for row in rows])
    circle = (time > BEGIN) & (time <= END)
    velocity = np.gradient(place, time, axis=0)[circle]
    noise = measures.rms((force - measures.lowpass(force, RATE_HZ))[circle])
    against = -(force[circle] * velocity).sum(axis=1) / measures.length(velocity)
    return f"{name}: {against.mean():.2f} N against the motion, noise {noise:.3f} N"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--spacing", type=float, nargs="+", default=[], metavar="METRES",
                        help="at level accurate, in place of the levels")
    parser.add_argument("--set", action="append", default=[], metavar="TABLE.KEY=VALUE", help="as of palp-run")
    parser.add_argument("--backend", choices=("cpu", "cuda"), default="cpu")
    parser.add_argument("--bin", type=pathlib.Path, default=ROOT / "build/release/bin")
    options = parser.parse_args()
    cases = [(f"{1e3 * s:g} mm", ["--accuracy", "accurate", "--spacing", str(s)]) for s in options.spacing]
    for name, settings in cases or [(level, ["--accuracy", level]) for level in ("fast", "balanced", "accurate")]:
        print(stir(name, settings, options), flush=True)


if __name__ == "__main__":
    main()
