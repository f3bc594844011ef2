"""What a run is worth: its errors against a reference that is refined until it no longer moves."""

import json

import numpy as np

from tradeoff_lib import measures
from tradeoff_lib.scenes import BASE, REFERENCE, Unknown, point

FILTERED = ("force", "torque")


def on_grid(series, grid):
    """Series of a run, what the hand follows of force and torque, at the times of the grid (totals: at their own)."""
    found = {}
    for name, (rate, times, values) in series.items():
        if name in FILTERED:
            values = measures.lowpass(values, rate)
        if name in FILTERED or name == "place":
            values = np.column_stack([np.interp(grid, times, column) for column in values.T])
        found[name] = values
    return found


def errors(series, reference, grid, waves=None):
    """All errors of a run by name; None where there is nothing to measure against. waves: by name, how far their speeds
    are from theory, as shares."""
    smooth = on_grid(series, grid)
    _, _, force = series["force"]
    found = {"force": measures.difference(smooth["force"], reference["force"]),
             "torque": measures.difference(smooth["torque"], reference["torque"]),
             "noise_N": measures.rms(force - measures.lowpass(force, series["force"][0])),
             "place_mm": 1e3 * float(measures.length(smooth["place"] - reference["place"]).max())}
    for name in ("momentum", "angular momentum", "energy"):
        mine, theirs = smooth.get(name), reference.get(name)
        if mine is None or theirs is None or len(mine) != len(theirs):
            found[name] = None
        elif name == "energy":  # as a share of how much it changes; from its start, since particles begin elsewhere
            change = theirs - theirs[0]
            found[name] = measures.ratio(measures.rms(mine - mine[0] - change), float(np.abs(change).max()))
        else:
            found[name] = measures.difference(mine, theirs)["rms"]
    volume = smooth.get("volume")
    found["volume"] = float(np.abs(volume / volume[0] - 1).max()) if volume is not None and volume[0] > 0 else None
    depth = smooth.get("penetration")
    found["penetration_mm"] = 1e3 * float(depth.max()) if depth is not None else None
    speeds = [abs(error) for error in (waves or {}).values() if error is not None]
    found["wave_speed"] = max(speeds, default=None)
    for name, result in (("temperature", "temperature_K"), ("liquid", "liquid")):
        mine, theirs = smooth.get(name), reference.get(name)
        known = mine is not None and theirs is not None and len(mine) == len(theirs)
        found[result] = float(np.abs(mine - theirs).max()) if known else None
    return found


class Reference:
    """The limit that a refinement of the spacing runs to: its series, and how sure it is."""

    def __init__(self, runner, budget_s, tolerance, say):
        self.runner, self.budget_s, self.tolerance, self.say = runner, budget_s, tolerance, say
        self.grid = np.arange(1, int(round(runner.duration * 1000)) + 1) / 1000
        self.spacings, self.runs, self.walls = [], [], []
        self.limit, self.order, self.uncertainty, self.how, self.stopped = None, None, None, "", ""
        self.points, self.time_step = [], None
        self.precision = "double" if "double" in runner.programs else "float"

    def extend(self):
        """Refines until two refinements agree on the limit or the time is spent. Raises RuntimeError without any run."""
        medium = self.runner.definition.medium
        for spacing in self.runner.definition.reference_spacings():
            spent = sum(self.walls)
            expected = self.walls[-1] * (self.spacings[-1] / spacing) ** 4 if self.walls else 0
            at = point(spacing, BASE | REFERENCE[medium]) | {"precision": self.precision}
            if spent + expected > self.budget_s and self.runner.kept(at, timed=False) is None:
                self.stopped = (f"{1e3 * spacing:.4g} mm was not run: it would take about {expected:.0f} s, and "
                                f"{spent:.0f} of the {self.budget_s:.0f} s for the reference are spent")
                break
            result = self.runner.run(at, limit_s=max(60.0, 2 * (self.budget_s - spent)), timed=False)
            if result["status"] == "unhealthy":  # a fault at this spacing, which says nothing of the limit
                self.say(f"reference at {1e3 * spacing:.4g} mm is left out: {result['said']}")
                continue
            if result["status"] != "done":
                self.stopped = f"{1e3 * spacing:.4g} mm could not be run: {result['said']}"
                break
            self._take(spacing, at, result)
            if self.uncertainty is not None and self.uncertainty <= self.tolerance:
                self.stopped = f"two refinements agree within {100 * self.tolerance:g} %"
                break
        if not self.runs:
            raise RuntimeError(self.stopped)
        self._halve_the_time_step()

    def _halve_the_time_step(self):
        """Adds to the uncertainty what the sub-step does, from the finest run that can be repeated in the time left: a force
        that is off in proportion to the sub-step moves by half of that when it is halved."""
        left = self.budget_s - sum(self.walls)
        k = max((k for k, wall in enumerate(self.walls) if 2 * wall <= left), default=0)
        at, sub_steps = self.points[k]
        at = at | {"set": at["set"] | {"numerics.sub_steps": str(2 * sub_steps)}}
        result = self.runner.run(at, limit_s=max(60.0, 4 * self.walls[k]), timed=False)
        if result["status"] != "done":
            self.stopped += f"; what the sub-step does is not known: {result['said']}"
            return
        halved = on_grid(self.runner.series(at), self.grid)
        self.time_step = 2 * (measures.difference(self.runs[k]["force"], halved["force"])["rms"] or 0.0)
        if self.uncertainty is not None:
            self.uncertainty += self.time_step
        self.say(f"reference at {1e3 * self.spacings[k]:.4g} mm and half the sub-step: {result['wall_s']:.0f} s; the "
                 f"sub-step's part of the uncertainty {share(self.time_step)}")

    def _take(self, spacing, at, result):
        self.points.append((at, result["summary"]["sub_steps"]))
        series = self.runner.series(at)
        self.spacings.append(spacing)
        self.runs.append(on_grid(series, self.grid))
        self.walls.append(result["wall_s"])
        self.limit = dict(self.runs[-1])
        if len(self.runs) >= 3:
            for name in ("force", "torque", "place"):
                found = measures.limit_of(self.spacings, [run[name] for run in self.runs])
                self.limit[name] = found[0]
                if name == "force":
                    _, self.order, self.uncertainty, self.how = found
        gap = "" if len(self.runs) < 2 else (
            f", {self.distance(-2):.1%} from the one before; uncertainty {share(self.uncertainty)}, order {number(self.order)}")
        self.say(f"reference at {1e3 * spacing:.4g} mm: {result['wall_s']:.0f} s{gap}")

    def distance(self, index):
        """How far the force of an earlier run is from the last one's, as a share."""
        return measures.difference(self.runs[index]["force"], self.runs[-1]["force"])["rms"] or 0.0

    def summary(self):
        force = self.limit["force"]
        return {"uncertainty": self.uncertainty, "of_time_step": self.time_step, "order": self.order, "how": self.how, "note": self.stopped,
                "precision": self.precision, "rms_force_N": measures.rms(force),
                "peak_force_N": float(measures.length(force).max()),
                "spacings": [{"spacing_m": h, "wall_s": wall,
                              "error": measures.difference(run["force"], force)["rms"]}
                             for h, run, wall in zip(self.spacings, self.runs, self.walls)]}

    def save(self, path):
        """Writes the reference, so that other machines can judge by it."""
        about = {"summary": self.summary(), "digest": self.runner.motion_digest}
        np.savez_compressed(path, about=json.dumps(about), grid=self.grid, **self.limit)


class KeptReference:
    """A reference that another run saved."""

    def __init__(self, path, runner):
        try:
            with np.load(path) as kept:
                about = json.loads(str(kept["about"]))
                self.grid = kept["grid"]
                self.limit = {name: kept[name] for name in kept.files if name not in ("about", "grid")}
        except (OSError, ValueError, KeyError) as error:
            raise Unknown(f"--reference {path}: no reference.npz of tools/tradeoff: {error}") from error
        if about["digest"] != runner.motion_digest:
            raise Unknown(f"--reference {path}: it is of another scene, path or duration; give one of the same")
        self.found, self.stopped = about["summary"], about["summary"]["note"]

    def summary(self):
        return self.found


def share(value):
    return "unknown" if value is None else f"{100 * value:.2g} %"


def number(value):
    return "unknown" if value is None else f"{value:.2g}"
