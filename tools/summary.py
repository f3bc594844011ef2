#!/usr/bin/python3
"""Sums a run of tools/demo up from what its processes wrote, and checks that all were healthy.

usage: tools/summary.py DIR [--no-picture] [--bridges NAME...] [--fault TEXT]..."""

import argparse
import json
import math
import pathlib
import sys

SERVER, BRIDGE, VIEWER, RECORDER = "palp-sim-server", "palp-haptic-bridge", "palp-viewer", "palp-record"


def load(path):
    """(values, fault): a missing or broken file is a fault, never an exception."""
    try:
        values = json.loads(path.read_text(encoding="utf-8"))
    except OSError:
        return {}, f"wrote no summary ({path.name})"
    except ValueError as error:
        return {}, f"wrote a broken summary ({path.name}: {error})"
    if not isinstance(values, dict):
        return {}, f"wrote a broken summary ({path.name}: an object was expected)"
    if isinstance(values.get("metrics"), dict):  # numbers may stand in a table of their own
        values = {**values["metrics"], **values}
    if values.get("healthy") is not True:
        return values, f"was not healthy: {values.get('cause') or values.get('trouble') or 'see its log'}"
    return values, None


def number_of(values, key, digits=0, unit=""):
    value = values.get(key)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        return "unknown"
    return f"{value:.{digits}f}{unit and ' ' + unit}"


def bridge_rows(bridge, number):
    """What one bridge felt; its number stands in the labels where there are several."""
    of = f" {number}" if number else ""
    lateness = (f"{number_of(bridge, 'rate_hz', 1, 'Hz')}, late by {number_of(bridge, 'lateness_p50_us')} us (median), "
                f"{number_of(bridge, 'lateness_p99_us')} us (99 %), {number_of(bridge, 'lateness_max_us')} us (worst)")
    return [("haptic loop" + of, lateness if bridge else "unknown"),
            ("sample age" + of, f"{number_of(bridge, 'sample_age_p50_ms', 2, 'ms')} at the bridge (median)"),
            ("peak force" + of, number_of(bridge, "peak_force_n", 2, "N")),
            ("lost samples" + of, f"{number_of(bridge, 'lost_samples')} at the bridge")]


def report(server, bridges, viewer, recorder):
    step = (f"{number_of(server, 'step_p50_us')} us (median), {number_of(server, 'step_p99_us')} us (99 %) for "
            f"{number_of(server, 'steps')} steps")
    publishing = "publish_p50_us" if "publish_p50_us" in server else "handover_p50_us"
    frames = (f"{number_of(viewer, 'complete_frames')} complete of {number_of(viewer, 'frames')}, "
              f"{number_of(viewer, 'lost_frames')} lost")
    recording = f"{number_of(recorder, 'messages')} messages, {number_of(recorder, 'drops')} dropped"
    rows = [row for number, bridge in bridges for row in bridge_rows(bridge, number)]
    return [*rows, ("server step", step), ("real-time factor", number_of(server, "real_time_factor", 3)),
            ("checked", str(server.get("checked") or "unknown")),
            ("publishing", f"{number_of(server, publishing)} us a step of the haptic thread (median)"),
            ("frames", frames), ("recording", recording)]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("dir", type=pathlib.Path)
    parser.add_argument("--no-picture", action="store_true", help="a window showed the scene: a missing scene.png is no fault")
    parser.add_argument("--bridges", nargs="*", default=[BRIDGE], metavar="NAME", help="the bridges that ran")
    parser.add_argument("--fault", action="append", default=[], metavar="TEXT", help="what else was not healthy")
    options = parser.parse_args()
    values, faults = {}, list(options.fault)
    for process in [SERVER, *options.bridges, VIEWER, RECORDER]:
        values[process], fault = load(options.dir / "logs" / f"{process}.json")
        if fault:
            faults.append(f"{process} {fault}")
    bridges = [(name.removeprefix(BRIDGE).lstrip("-"), values[name]) for name in options.bridges]
    for label, text in report(values[SERVER], bridges, values[VIEWER], values[RECORDER]):
        print(f"  {label:18}{text}")
    if values[RECORDER].get("messages") == 0:
        faults.append(f"{RECORDER} heard no message")
    left = ["recording.mcap", *(f"force_{number}.png" if number else "force.png" for number, _ in bridges)]
    if not options.no_picture or (options.dir / "scene.png").exists():
        left.append("scene.png")
    for name in left:
        path = options.dir / name
        if not path.is_file() or path.stat().st_size == 0:
            faults.append(f"{path} is missing")
    for fault in faults:
        print(f"  NOT HEALTHY: {fault}")
    if not faults:
        print(f"  all healthy; see {options.dir}/ for {', '.join(sorted(left))}")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
