#!/usr/bin/env python3
"""Rolls, slides, places, drops and pushes rigid bodies and compares them with what rigid bodies with Coulomb friction do.

  tools/rigid_cases.py                              every case, as a table
  tools/rigid_cases.py --only roll --jobs 2         those whose name begins so
  tools/rigid_cases.py --out after.json --before before.json      with a column of what was kept before

A slope is gravity that leans along x over a level floor. Friction is 0.7, while slipping 0.5, restitution 0.2, the spacing
20 mm, a sub-step 1 ms, unless the case says otherwise; with tools, whose coupling asks for shorter ones, what is chosen."""
import argparse
import concurrent.futures
import csv
import json
import math
import os
import pathlib
import subprocess
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
G = 9.81
PROBE_HZ = 1000

HEAD = """
[scene]
name = "case"
gravity = [{gx}, 0.0, {gz}]
rate_hz = 1000
duration = {duration}
[domain]
min = [-2.0, -2.0, -2.0]
max = [14.0, 2.0, 2.0]
[numerics]
spacing = {{fast = 0.04, balanced = 0.02, accurate = 0.01}}
{numerics}
[[material]]
name = "m"
density = {density}
friction = {friction}
kinetic_friction = {kinetic}
restitution = {restitution}
"""


def shape(kind, cut=False, position=(0, 0, 0), upright=False, **sizes):
    """One shape; a cylinder lies along y unless it is upright."""
    lines = ["[[body.shape]]", f'type = "{kind}"', f"position = {list(map(float, position))}"]
    lines += [f"{key} = {value}" for key, value in sizes.items()]
    lines += ["subtract = true"] if cut else []
    if kind == "cylinder" and not upright:
        lines.append("rotation_deg = {axis = [1.0, 0.0, 0.0], angle = 90.0}")
    return "\n".join(lines)


def body(name, shapes, at=(0, 0, 0), velocity=(0, 0, 0), spin=(0, 0, 0), static=False, turned=None):
    lines = ["[[body]]", f'name = "{name}"', f'type = "{"static" if static else "rigid"}"', 'material = "m"',
             f"position = {list(map(float, at))}"]
    if any(velocity):
        lines.append(f"velocity = {list(map(float, velocity))}")
    if any(spin):
        lines.append(f"angular_velocity = {list(map(float, spin))}")
    if turned:
        lines.append(f"rotation_deg = {{axis = {list(map(float, turned[0]))}, angle = {turned[1]}}}")
    probe = "" if static else f'\n[[probe]]\nname = "{name}"\nquantity = "body"\nbody = "{name}"\nrate_hz = {PROBE_HZ}\n'
    return "\n".join(lines + shapes) + "\n" + probe


FLOOR = body("floor", [shape("box", size=[13.0, 1.0, 0.2])], at=(5.5, 0, -0.1), static=True)

ROUND = {  # shapes, radius, inertia over mass times radius squared
    "cylinder": ([shape("cylinder", radius=0.05, height=0.1)], 0.05, 0.5),
    "disc": ([shape("cylinder", radius=0.05, height=0.01)], 0.05, 0.5),
    "rod": ([shape("cylinder", radius=0.01, height=0.2)], 0.01, 0.5),
    "drum": ([shape("cylinder", radius=0.2, height=0.1)], 0.2, 0.5),
    "tube": ([shape("cylinder", radius=0.05, height=0.1), shape("cylinder", True, radius=0.04, height=0.12)], 0.05,
             (1 + 0.8**2) / 2),
    "ball": ([shape("sphere", radius=0.05)], 0.05, 0.4),
    "shell": ([shape("sphere", radius=0.05), shape("sphere", True, radius=0.03)], 0.05, 0.4 * (1 - 0.6**5) / (1 - 0.6**3)),
}


class Case:
    """bodies: text; slope [deg]; measure(tables, case) returns (reference, result) as texts."""

    def __init__(self, name, bodies, measure, duration, slope=0.0, args=(), path=None, **material):
        self.name, self.bodies, self.measure, self.duration, self.slope = name, bodies, measure, duration, slope
        self.args, self.path = list(args), path
        self.material = {"density": 625.0, "friction": 0.7, "kinetic": 0.5, "restitution": 0.2} | material


def at_time(table, t):
    return table[min(len(table) - 1, max(0, round(t * PROBE_HZ) - 1))]


def slope_of(table, key, start, end):
    a, b = at_time(table, start), at_time(table, end)
    return (b[key] - a[key]) / (b["time"] - a["time"])


def acceleration(name, expected, start=0.1):
    def measure(tables, case):
        table = tables[name]
        found = slope_of(table, "vx", start, case.duration)
        end = table[-1]
        return (f"{expected:.4g} m/s^2", f"{found:.4g} ({100 * (found / expected - 1):+.2f} %), aside {1e3 * end['y']:.2g} mm")
    return measure


def rolling_cases():
    for name, (shapes, r, k) in ROUND.items():
        for slope in (0.5, 5, 15, 30):
            a = G * math.sin(math.radians(slope)) / (1 + k)
            yield Case(f"roll {name} {slope:g} deg", FLOOR + body("b", shapes, (0, 0, r)), acceleration("b", a), 0.6, slope)
        lean = math.radians(30)
        a = G * (math.sin(lean) - 0.1 * math.cos(lean))
        yield Case(f"slip {name} 30 deg, mu 0.1", FLOOR + body("b", shapes, (0, 0, r)), acceleration("b", a), 0.6, 30,
                   friction=0.1, kinetic=0.1)

        def begins(tables, case, r=r, k=k):
            end = tables["b"][-1]
            return f"{1 / (1 + k):.4f} m/s", f"{end['vx']:.4f}, rim {end['wy'] * r:.4f}, aside {1e3 * end['y']:.2g} mm"
        yield Case(f"thrown {name} 1 m/s", FLOOR + body("b", shapes, (0, 0, r), (1, 0, 0)), begins, 1.5, friction=0.3, kinetic=0.3)


def level(start):
    def measure(tables, case):
        rows = [row for row in tables["b"] if row["time"] > start]
        v = rows[0]["vx"]
        heights, loads = [row["z"] for row in rows], [row["fz"] for row in rows]
        mean = sum(loads) / len(loads)
        noise = math.sqrt(sum((f - mean)**2 for f in loads) / len(loads)) / mean
        return ("0", f"speed {100 * (rows[-1]['vx'] / v - 1):+.3f} %, aside {1e3 * (rows[-1]['y'] - rows[0]['y']):.2g} mm, "
                f"height {1e6 * (max(heights) - min(heights)):.3g} um, force {100 * noise:.2g} % rms")
    return measure


def level_cases():
    for name in ("cylinder", "rod", "drum", "tube", "ball", "shell"):
        shapes, r, _ = ROUND[name]
        for v in (0.01, 0.1, 1, 3):
            yield Case(f"level {name} {v:g} m/s", FLOOR + body("b", shapes, (0, 0, r), (v, 0, 0), (0, v / r, 0)), level(0.5), 3)
    shapes, r, _ = ROUND["cylinder"]
    for args in (["--accuracy", "fast"], ["--accuracy", "accurate"], *(["--set", f"numerics.sub_steps={n}"] for n in (2, 4, 10))):
        yield Case(f"level cylinder 0.1 m/s {args[-1]}", FLOOR + body("b", shapes, (0, 0, r), (0.1, 0, 0), (0, 0.1 / r, 0)),
                   level(0.5), 3, args=args)

    def swing(k, gap=0.2):
        def measure(tables, case):
            xs = [row["x"] for row in tables["b"]]
            ups = [row["time"] for row, last in zip(tables["b"][1:], tables["b"]) if last["x"] < 0 <= row["x"]]
            period = (ups[-1] - ups[0]) / (len(ups) - 1) if len(ups) > 1 else math.nan
            late = max(abs(x) for x in xs[-1000:])
            expected = 2 * math.pi * math.sqrt((1 + k) * gap / G) * (1 + 0.3**2 / 16)
            return f"{expected:.4f} s, all of the swing", f"{period:.4f} s ({100 * (period / expected - 1):+.2f} %), swing {late / (gap * math.sin(0.3)):.3f}"
        return measure
    bore = body("bore", [shape("box", size=[0.6, 0.3, 0.4]), shape("cylinder", True, (0, 0, 0.2), radius=0.25, height=0.4)],
                static=True)
    place = (0.2 * math.sin(0.3), 0, 0.2 - 0.2 * math.cos(0.3))
    yield Case("swing cylinder in a bore", bore + body("b", ROUND["cylinder"][0], place), swing(0.5), 6)
    yield Case("swing ball in a bore", bore + body("b", ROUND["ball"][0], place), swing(0.4), 6)
    rails = "".join(body(f"rail {k}", [shape("box", size=[6.0, 0.01, 0.2])], at=(2.5, y, -0.1), static=True)
                    for k, y in enumerate((-0.04, 0.04)))
    yield Case("level cylinder 0.1 m/s on rails between its rings", rails + body("b", ROUND["cylinder"][0], (0, 0, 0.05), (0.1, 0, 0), (0, 2, 0)),
               level(0.5), 3)
    notch = [shape("cylinder", radius=0.05, height=0.1), shape("box", True, (0, 0, 0.045), size=[0.02, 0.2, 0.02])]
    yield Case("level cylinder with a groove along it 1 m/s", FLOOR + body("b", notch, (0, 0, 0.05), (1, 0, 0), (0, 20, 0)), level(0.5), 2)


def stand_cases():
    upright = [shape("cylinder", upright=True, radius=0.05, height=0.1)]

    def rest(tables, case):
        a, b = at_time(tables["b"], 0.5), tables["b"][-1]
        lean = math.degrees(2 * math.asin(min(1, math.hypot(b["qx"], b["qy"]))))
        return "0", (f"first half second {1e6 * math.hypot(a['x'], a['y']):.3g} um, then {1e6 * math.hypot(b['x'] - a['x'], b['y'] - a['y']):.3g} um, "
                     f"leans {lean:.2g} deg, turns {b['wz']:.2g} rad/s")
    yield Case("stand cylinder", FLOOR + body("b", upright, (0, 0, 0.05)), rest, 5)
    yield Case("stand cylinder 20 deg", FLOOR + body("b", upright, (0, 0, 0.05)), rest, 5, 20)
    tilt = math.radians(5)
    height = 0.05 * math.cos(tilt) + 0.05 * math.sin(tilt)
    yield Case("stand cylinder let go leaning by 5 deg", FLOOR + body("b", upright, (0, 0, height), turned=((0.6, 0.8, 0), 5.0)), rest, 8)

    def spun(tables, case):
        stop = next((row["time"] for row in tables["b"] if abs(row["wz"]) < 0.05), math.nan)
        return (f"{0.5 * 0.05 * 20 / (0.5 * G):.3f} s with all load on its rim, {0.75 * 0.05 * 20 / (0.5 * G):.3f} s spread evenly",
                f"{stop:.3f} s, aside {1e3 * math.hypot(tables['b'][-1]['x'], tables['b'][-1]['y']):.2g} mm")
    yield Case("stand cylinder spun with 20 rad/s", FLOOR + body("b", upright, (0, 0, 0.05), spin=(0, 0, 20)), spun, 1)


def rests(name):
    def measure(tables, case):
        a, b = at_time(tables[name], 0.5), tables[name][-1]
        return "stays", f"{1e6 * a['x']:.3g} um in half a second, then {1e6 * (b['x'] - a['x']):.3g} um"
    return measure


BLOCKS = {"block": (0.12, 0.08, 0.05), "tall": (0.06, 0.06, 0.08), "flat": (0.2, 0.2, 0.01)}


def block(name, size, gap=0.0, velocity=(0, 0, 0), base=0.0):
    return body(name, [shape("box", size=list(size))], (0, 0, base + size[2] / 2 + gap), velocity)


def place_cases():
    size = BLOCKS["block"]
    for slope in (0, 10, 20, 30, 34):
        for gap in (0, 1e-4, -1e-4):
            yield Case(f"place block {slope} deg, {1e3 * gap:+.1f} mm", FLOOR + block("b", size, gap), rests("b"), 10, slope)
        for gap in (5e-3, 5e-2):
            yield Case(f"drop block {slope} deg, {1e3 * gap:g} mm", FLOOR + block("b", size, gap), rests("b"), 5, slope)
    lean = math.radians(36)
    for gap in (0, 1e-4):
        yield Case(f"place block 36 deg, {1e3 * gap:+.1f} mm", FLOOR + block("b", size, gap),
                   acceleration("b", G * (math.sin(lean) - 0.5 * math.cos(lean)), 0.3), 0.8, 36)
    for density in (2.08, 104000):
        for gap in (0, 1e-4):
            yield Case(f"place block of {density * 4.8e-4:.2g} kg 30 deg, {1e3 * gap:+.1f} mm", FLOOR + block("b", size, gap), rests("b"), 5, 30,
                       density=density)
    for name in ("tall", "flat"):
        for gap in (0, 1e-4):
            yield Case(f"place {name} 30 deg, {1e3 * gap:+.1f} mm", FLOOR + block("b", BLOCKS[name], gap), rests("b"), 5, 30)
    for count in (2, 3):
        for slope in (20, 30):
            pile = "".join(block("b" if k == count - 1 else f"b{k}", (0.12, 0.12, 0.03), 0, base=0.03 * k) for k in range(count))
            yield Case(f"place stack of {count} {slope} deg", FLOOR + pile, rests("b"), 5, slope)
    for args in (["--accuracy", "fast"], ["--accuracy", "accurate"], *(["--set", f"numerics.sub_steps={n}"] for n in (2, 4, 10))):
        for gap in (0, 1e-4):
            yield Case(f"place block 30 deg, {1e3 * gap:+.1f} mm {args[-1]}", FLOOR + block("b", size, gap), rests("b"), 5, 30, args=args)
    yield Case("place block 30 deg, gravity grows over 1 s", FLOOR + block("b", size), rests("b"), 5, 30, args=["--set", "scene.gravity_ramp=1"])
    for e in (0.0, 0.6):
        yield Case(f"place block 30 deg, +0.1 mm, restitution {e}", FLOOR + block("b", size, 1e-4), rests("b"), 5, 30, restitution=e)


def throw_cases():
    size = BLOCKS["block"]
    for slope in (0, 20):
        for v in (0.05, 0.2, 1):
            def stops(tables, case, v=v):
                lean = math.radians(case.slope)
                way = v * v / (2 * G * (0.5 * math.cos(lean) - math.sin(lean)))
                table = tables["b"]
                then = at_time(table, case.duration - 1)
                return (f"{1e3 * way:.4g} mm, stays", f"{1e3 * then['x']:.4g} mm ({100 * (then['x'] / way - 1):+.1f} %), "
                        f"then {1e6 * (table[-1]['x'] - then['x']):.3g} um")
            yield Case(f"throw block {slope} deg, {v:g} m/s", FLOOR + block("b", size, 0, (v, 0, 0)), stops, 4, slope)


def tool_path(points):
    return "time,x,y,z,qx,qy,qz,qw\n" + "".join(f"{t:.6f},{x:.8f},0,{z:.8f},0,0,0,1\n" for t, x, z in points)


PROXY = '[[proxy]]\ndevice = 0\nbody = "tool"\n[proxy.coupling_limit]\nstiffness = 1000\ndamping = 20\n'


def tool_cases():
    size, floor = BLOCKS["block"], FLOOR
    for speed in (0.02, 0.1):
        def pushes(tables, case, speed=speed):
            rows = [row for row in tables["tool"] if row["time"] > 0.6 * case.duration]
            force = [-row["fx"] for row in rows]
            mean = sum(force) / len(force)
            weight = case.material["density"] * 4.8e-4 * G
            peak = max(-row["fx"] for row in tables["tool"])
            return (f"{0.5 * weight:.4g} N once it slides, {0.7 * weight:.4g} N at most",
                    f"{mean:.4g} N ({100 * (mean / (0.5 * weight) - 1):+.1f} %), {min(force):.3g} to {max(force):.3g}, peak {peak:.4g} N")
        tool = body("tool", [shape("box", size=[0.03, 0.03, 0.03])], (-0.08, 0, 0.03))
        ways = [(0, -0.08, 0.03), (0.5, -0.08, 0.03), (0.5 + 0.2 / speed, -0.08 + 0.2, 0.03)]
        yield Case(f"push block at {speed:g} m/s", floor + block("b", size) + tool + PROXY, pushes, 0.5 + 0.2 / speed, path=tool_path(ways))

        def draws(tables, case):
            rows = [row for row in tables["tool"] if row["time"] > 0.6 * case.duration]
            ratio = [-row["fx"] / row["fz"] for row in rows if row["fz"] > 0.5]
            low, high, mean = min(ratio), max(ratio), sum(ratio) / len(ratio)
            return "0.5 of the pressure", f"{mean:.4f}, {low:.3f} to {high:.3f}"
        ways = [(0, 0, 0.0155), (0.3, 0, 0.0155), (0.5, 0, 0.005), (0.8, 0, 0.005), (0.8 + 0.2 / speed, 0.2, 0.005)]
        tool = body("tool", [shape("box", size=[0.03, 0.03, 0.03])], (0, 0, 0.0155))
        yield Case(f"draw tool over the floor at {speed:g} m/s", floor + tool + PROXY, draws, 0.8 + 0.2 / speed, path=tool_path(ways))
        ways = [(t, x, z + 0.05) for t, x, z in ways]
        tool = body("tool", [shape("box", size=[0.03, 0.03, 0.03])], (0, 0, 0.0655))
        yield Case(f"draw tool over a heavy block at {speed:g} m/s",
                   floor + body("b", [shape("box", size=[0.6, 0.3, 0.05])], (0.1, 0, 0.025)) + tool + PROXY, draws, 0.8 + 0.2 / speed,
                   path=tool_path(ways), density=5000.0)


def run(case, options):
    lean = math.radians(case.slope)
    numerics = "" if case.path or any("sub_steps" in word for word in case.args) else "sub_steps = 1"
    text = HEAD.format(gx=G * math.sin(lean), gz=-G * math.cos(lean), duration=case.duration, numerics=numerics, **case.material) + case.bodies
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        (folder / "case.toml").write_text(text)
        if case.path:
            (folder / "path.csv").write_text(case.path)
        words = [str(options.bin / "palp-run"), str(folder / "case.toml"), "--out", str(folder / "out"), "--backend", options.backend]
        words += ["--path", f"0={folder / 'path.csv'}"] if case.path else []
        done = subprocess.run(words + case.args, capture_output=True, text=True)
        if done.returncode != 0:
            return "", (done.stderr.strip() or done.stdout.strip()).splitlines()[-1]
        tables = {}
        for file in (folder / "out").glob("*.csv"):
            with open(file) as rows:
                tables[file.stem] = [{key.split("_")[0]: float(value or "nan") for key, value in row.items()} for row in csv.DictReader(rows)]
        if not tables:
            return "", "no tables"
        return case.measure(tables, case)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default="", metavar="TEXT", help="beginning of the names of cases to run")
    parser.add_argument("--before", type=pathlib.Path, help="results to print beside")
    parser.add_argument("--out", type=pathlib.Path, help="results, as JSON")
    parser.add_argument("--backend", choices=("cpu", "cuda"), default="cpu")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="runs at a time")
    parser.add_argument("--bin", type=pathlib.Path, default=ROOT / "build/release/bin")
    options = parser.parse_args()
    before = json.loads(options.before.read_text()) if options.before else {}
    cases = [case for make in (rolling_cases, level_cases, stand_cases, place_cases, throw_cases, tool_cases) for case in make()
             if case.name.startswith(options.only)]
    print("| case | exact |" + (" before |" if before else "") + " found |\n|---|---|---|" + ("---|" if before else ""))
    found = {}
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        for case, (reference, result) in zip(cases, pool.map(lambda one: run(one, options), cases)):
            found[case.name] = result
            print(f"| {case.name} | {reference} |" + (f" {before.get(case.name, '')} |" if before else "") + f" {result} |", flush=True)
    if options.out:
        options.out.write_text(json.dumps(found, indent=1) + "\n")


if __name__ == "__main__":
    main()
