#!/usr/bin/python3
"""Stirs oil with the ladle of tray_fluid and tells the force against its motion, which is what a hand feels of it.

  tools/stirring.py                                    as each level has it, on the CPU
  tools/stirring.py --backend cuda --spacing 0.04 0.02 0.0125

The ladle goes along the path of the trade's measurements (tools/tradeoff_lib/hands/tray_fluid.toml), a circle of 20 cm a
second. Prints the mean over one circle, from 1.6 to 2.6 s, and the noise of the force above 30 Hz. The limit of fine
spacings is about 2.0 N."""
import argparse
import pathlib
import tempfile
import tomllib

import cases
import numpy as np
from tradeoff_lib import hand, measures

SCENE = cases.ROOT / "config/scenes/tray_fluid.toml"
SCRIPT = cases.ROOT / "tools/tradeoff_lib/hands/tray_fluid.toml"
BEGIN, END, RATE_HZ = 1.6, 2.6, 1000


def stir(name, settings, options):
    with tempfile.TemporaryDirectory() as made:
        folder = pathlib.Path(made)
        scene = tomllib.loads(SCENE.read_text(encoding="utf-8"))
        hand.write_path(scene, scene["proxy"][0], SCRIPT, END + 0.1, folder / "path.csv")
        failure = cases.run(options, SCENE, folder / "out", "--path", f"0={folder / 'path.csv'}", "--duration",
                            str(END + 0.1), *settings)
        if failure:
            return f"{name}: {failure}"
        proxy = cases.columns(folder / "out/proxy.csv")
    felt = np.isfinite(proxy["fx_N"])  # nothing is, before the first step
    place, force = (np.array([proxy[column.format(axis)] for axis in "xyz"]).T[felt] for column in ("{}_m", "f{}_N"))
    time = np.array(proxy["time_s"])[felt]
    circle = (time > BEGIN) & (time <= END)
    velocity = np.gradient(place, time, axis=0)[circle]
    noise = measures.rms((force - measures.lowpass(force, RATE_HZ))[circle])
    against = -(force[circle] * velocity).sum(axis=1) / measures.length(velocity)
    return f"{name}: {against.mean():.2f} N against the motion, noise {noise:.3f} N"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--spacing", type=float, nargs="+", default=[], metavar="METRES",
                        help="at level accurate, in place of the levels")
    cases.add_options(parser)
    options = parser.parse_args()
    runs = [(f"{1e3 * s:g} mm", ["--accuracy", "accurate", "--spacing", str(s)]) for s in options.spacing]
    for name, settings in runs or [(level, ["--accuracy", level]) for level in ("fast", "balanced", "accurate")]:
        print(stir(name, settings, options), flush=True)


if __name__ == "__main__":
    main()
