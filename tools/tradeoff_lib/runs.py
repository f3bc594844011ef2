"""Runs of palp-run for tools/tradeoff: each once for the same program, scene, path and settings, kept in a folder."""

import csv
import hashlib
import json
import os
import pathlib
import shutil
import subprocess
import threading
import time

import numpy as np

from tradeoff_lib import hand, waves
from tradeoff_lib.scenes import ROOT, SUPPORT, Unknown

QUIET_CORES = 0.3  # processors that others may use beside a run whose times count


def busy_cores(seconds=0.3):
    """How many of the processors that runs may use are at work now, on the mean of a moment."""
    mine = {f"cpu{k}" for k in os.sched_getaffinity(0)}

    def ticks():
        rows = [line.split() for line in pathlib.Path("/proc/stat").read_text().splitlines()]
        counts = [[int(v) for v in row[1:9]] for row in rows if row and row[0] in mine]
        return sum(sum(values) - values[3] - values[4] for values in counts)
    begin = ticks()
    time.sleep(seconds)
    return (ticks() - begin) / os.sysconf("SC_CLK_TCK") / seconds


def revision():
    """The checkout that measures, as git names it."""
    try:
        result = subprocess.run(["git", "describe", "--always", "--dirty"], cwd=ROOT, capture_output=True, text=True, check=False)
    except OSError:
        return "unknown"
    return result.stdout.strip() or "unknown"


def portable(text):
    """What a program said, without this machine's path: results are kept where other checkouts read them."""
    return text.replace(f"{ROOT}/", "")


def program_in(folder, name="palp-run"):
    for file in (folder / name, folder / name.replace("-", "_")):
        if file.is_file():
            return file
    target = name.replace("-", "_")
    raise Unknown(f"{folder} has no {name}; build it with cmake --preset release && ninja -C build/release {target}")


def expected_cost(point):
    """What a run of a point costs, in units of its own: particles times neighbours times sub-steps."""
    support = float(point["set"].get(SUPPORT, 2.5))
    rate = max(1.0, float(point["set"].get("scene.rate_hz", 1000)) / 1000) if point["level"] is None else 1.0
    return point["spacing_m"] ** -4 * support ** 3 * rate


def digest(toml, files):
    """Of what a scene says, however it is written, and of files."""
    said = json.dumps(toml, sort_keys=True, default=str).encode()
    return hashlib.sha1(said + b"".join(p.read_bytes() for p in files)).hexdigest()


REST_S = 2.0  # how long what is at rest settles, and how long it is watched, as in tests/cases/rest_test.cpp


class Runner:
    """Runs points of a scene. Threads may call run at the same time."""

    def __init__(self, definition, options, folder):
        self.definition, self.options, self.folder = definition, options, folder
        self.programs = {"float": program_in(options.bin)}
        if options.double:
            self.programs["double"] = program_in(options.double)
        self.bench = program_in(options.bin, "palp-bench")
        self.digests = {p: hashlib.sha1(file.read_bytes()).hexdigest() for p, file in self.programs.items()}
        self.duration = options.duration or definition.duration
        (folder / "runs").mkdir(parents=True, exist_ok=True)
        self.paths, self.sources = self._make_paths()
        self.scene_digest = digest(definition.toml, self.paths.values())
        # of the hand's scripts, not of the paths made from them, which other machines round otherwise
        self.motion_digest = digest(definition.of_reference(), self.sources) + f" {self.duration}"
        self.timed = options.jobs == 1 and not options.errors_only
        self.children, self.lock = [], threading.Lock()

    def _make_paths(self):
        """The path of each device, and the files that they come from."""
        given = dict(self.options.path)
        paths, sources, hands = {}, [], None
        for proxy in sorted(self.definition.toml["proxy"], key=lambda proxy: proxy.get("device", 0)):
            device = proxy.get("device", 0)
            if device in given:
                paths[device] = given[device]
                sources.append(given[device])
                continue
            hands = hands or self.definition.hand_files()
            paths[device] = self.folder / f"path_{device}.csv"
            hand.write_path(self.definition.toml, proxy, hands[device], self.duration, paths[device])
            sources.append(hands[device])
        return paths, sources

    def key(self, point):
        what = [self.digests[point["precision"]], self.scene_digest, self.options.backend, self.duration,
                point["spacing_m"], sorted(point["set"].items()), *point.get("asked", [])]
        return hashlib.sha1(json.dumps(what).encode()).hexdigest()[:16]

    def kept(self, point, timed=True):
        """The result of an earlier run, or None. One that was timed beside others is no result on a quiet machine, if
        its times are asked for."""
        try:
            found = json.loads((self.folder / "runs" / self.key(point) / "result.json").read_text())
        except (OSError, ValueError):
            return None
        if timed and self.timed and not found["quiet"] and busy_cores() < QUIET_CORES:
            return None
        return found

    def run(self, point, limit_s=None, timed=True):
        """Runs a point, or finds its run. {status: done, refused, unhealthy or late; said; quiet; summary; wall_s; waves}."""
        out = self.folder / "runs" / self.key(point)
        result = self.kept(point, timed) or self._run_anew(point, out, limit_s)
        wanted = timed and result["status"] == "done" and point["precision"] == "float" and "asked" not in point
        if wanted and "calm_step_s" not in result["summary"]:  # a run of the reference has none
            result["summary"]["calm_step_s"] = self._calm_step(point, out / "calm.json")
            if self.options.grid == "full" and not self.options.no_waves:
                result["waves"] = self._wave_speeds(point, out)
            (out / "result.json").write_text(json.dumps(result))
        return result

    def _run_anew(self, point, out, limit_s):
        shutil.rmtree(out, ignore_errors=True)
        quiet = self.timed and busy_cores() < QUIET_CORES
        command = [str(self.programs[point["precision"]]), str(self.definition.file), *self._numerics(point), "--duration",
                   repr(self.duration), "--totals-hz", "50", "--out", str(out)]
        for device, path in self.paths.items():
            command += ["--path", f"{device}={path}"]
        began = time.monotonic()
        status, said = self._call(command, limit_s or self.options.limit)
        result = {"status": {0: "done", 3: "unhealthy", None: "late"}.get(status, "refused"), "said": said,
                  "quiet": quiet, "wall_s": time.monotonic() - began, "summary": None}
        if result["status"] == "done":
            result["summary"] = json.loads(portable((out / "summary.json").read_text()))
        out.mkdir(parents=True, exist_ok=True)
        for file in out.glob("*.csv"):
            if not file.name.startswith(("proxy", "totals")):
                file.unlink()
        if result["status"] != "late":
            (out / "result.json").write_text(json.dumps(result))
        return result

    def _numerics(self, point):
        """The options of a program for a point, or for what is asked for in place of one."""
        if "asked" in point:
            return ["--backend", self.options.backend, *point["asked"]]
        sets = [word for item in point["set"].items() for word in ("--set", "=".join(item))]
        return ["--backend", self.options.backend, "--spacing", repr(point["spacing_m"]), *sets]

    def _calm_step(self, point, file):
        """The median step while the hand holds still [s], by which --budget compares machines; None where it fails."""
        command = [str(self.bench), "--scene", str(self.definition.file), *self._numerics(point), "--seconds", "0.5",
                   "--out", str(file)]
        if self._call(command, self.options.limit)[0] != 0:
            return None
        return json.loads(file.read_text())["results"][0]["calm_step_s"]

    def _wave_speeds(self, point, folder):
        """By wave, how far the speed of one in the scene's matter is from theory, as a share; None where it has none."""
        found = {}
        choices = waves.waves_of(self.definition.toml, self.definition.middle(), point["spacing_m"])
        for name, (scene, period) in choices.items():
            file, out = folder / f"{name}.toml", folder / name
            file.write_text(scene)
            rows_hz = min(waves.ROWS / period, float(point["set"].get("scene.rate_hz", 1000)))
            command = [str(self.programs[point["precision"]]), str(file), *self._numerics(point), "--duration",
                       repr(waves.PERIODS * period), "--totals-hz", repr(rows_hz), "--out", str(out)]
            measured = None
            if self._call(command, self.options.limit)[0] == 0:
                totals = read_csv(out / "totals.csv")
                measured = waves.period_of(totals["time_s"], totals["px_N_s"])
            found[name] = period / measured - 1 if measured else None
            shutil.rmtree(out, ignore_errors=True)
        return found

    def rest_drift(self, point):
        """How far the particle that goes farthest goes from two to four seconds after the start while no hand moves, in
        spacings; None where it cannot be said."""
        out = self.folder / "runs" / self.key(point)
        file = out / "rest.json"
        if not file.is_file():
            command = [str(self.programs[point["precision"]]), str(self.definition.file), *self._numerics(point), "--duration",
                       repr(2 * REST_S), "--snapshots-hz", repr(1 / REST_S), "--out", str(out / "rest")]
            drift = None
            if self._call(command, self.options.limit)[0] == 0:
                begin, end = (places_in(out / "rest" / f"particles_{k:06d}.csv") for k in (1, 2))
                drift = float(np.linalg.norm(end - begin, axis=1).max() / point["spacing_m"])
            shutil.rmtree(out / "rest", ignore_errors=True)
            file.write_text(json.dumps(drift))
        return json.loads(file.read_text())

    def _call(self, command, limit_s):
        """The exit status (None: it took too long) and the last words of a program."""
        environment = dict(os.environ)
        if self.options.jobs > 1:
            environment["OMP_NUM_THREADS"] = str(max(1, len(os.sched_getaffinity(0)) // self.options.jobs))
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, env=environment)
        with self.lock:
            self.children.append(process)
        try:
            said = process.communicate(timeout=limit_s)[1]
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()
            return None, f"not done after {limit_s:.0f} s"
        finally:
            with self.lock:
                self.children.remove(process)
        return process.returncode, (portable(said).strip().splitlines() or ["no word"])[-1][-400:]

    def stop(self):
        """Ends what runs."""
        with self.lock:
            for process in self.children:
                process.terminate()

    def series(self, point):
        """What a run that is done left: by name, (rate [Hz], times, array). Devices side by side."""
        out = self.folder / "runs" / self.key(point)
        devices = [read_csv(out / ("proxy.csv" if d == 0 else f"proxy_{d}.csv")) for d in sorted(self.paths)]
        time_s = devices[0]["time_s"]
        rate = (len(time_s) - 1) / (time_s[-1] - time_s[0])

        def beside(*names):
            return np.column_stack([table[name] for table in devices for name in names])

        found = {"force": (rate, time_s, beside("fx_N", "fy_N", "fz_N")),
                 "torque": (rate, time_s, beside("tx_N_m", "ty_N_m", "tz_N_m")),
                 "place": (rate, time_s, beside("x_m", "y_m", "z_m"))}
        totals = read_csv(out / "totals.csv")
        for name, columns in TOTALS.items():
            values = np.column_stack([totals[c] for c in columns])
            if np.isfinite(values).all():
                found[name] = (50.0, totals["time_s"], values)
        return found


TOTALS = {"energy": ["total_J"], "momentum": ["px_N_s", "py_N_s", "pz_N_s"],
          "angular momentum": ["Lx_N_m_s", "Ly_N_m_s", "Lz_N_m_s"], "volume": ["volume_m3"],
          "temperature": ["mean_temperature_K"], "liquid": ["liquid_fraction"],
          "penetration": ["penetration_m"]}


def places_in(path):
    """A row of x, y and z a particle [m]."""
    with open(path, newline="", encoding="utf-8") as file:
        return np.array([[float(row[axis]) for axis in "xyz"] for row in csv.DictReader(file)])


def read_csv(path):
    with open(path, newline="", encoding="utf-8") as file:
        rows = list(csv.reader(file))
    values = np.array([[float(cell) if cell else np.nan for cell in row] for row in rows[1:]]).T
    return dict(zip(rows[0], values))
