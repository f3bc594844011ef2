"""What the tools share that run a case of their own and compare it with theory: running palp-run, reading its tables."""
import csv
import pathlib
import subprocess

ROOT = pathlib.Path(__file__).resolve().parent.parent


def add_options(parser):
    parser.add_argument("--set", action="append", default=[], metavar="TABLE.KEY=VALUE", help="as of palp-run")
    parser.add_argument("--backend", choices=("cpu", "cuda"), default="cpu")
    parser.add_argument("--bin", type=pathlib.Path, default=ROOT / "build/release/bin")


def run(options, scene, out, *words):
    """Runs a scene with results in the folder `out`. Returns "", or in one sentence why it failed."""
    done = subprocess.run([options.bin / "palp-run", scene, "--out", out, "--backend", options.backend, *words,
                           *(word for pair in options.set for word in ("--set", pair))], capture_output=True, text=True)
    return done.stderr.strip().splitlines()[-1] if done.returncode != 0 else ""


def columns(path):
    """The columns of a CSV table by name, each a list; what is missing is not a number."""
    with open(path) as table:
        rows = list(csv.DictReader(table))
    return {name: [float(row[name] or "nan") for row in rows] for name in rows[0]}
