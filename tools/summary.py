#!/usr/bin/python3
"""Sums a run of tools/demo up from what its processes wrote, and checks that all were healthy.

usage: tools/summary.py DIR [--no-picture]"""

import argparse
import json
import math
import pathlib
import sys

PROCESSES = ["palp-sim-server", "palp-haptic-bridge", "palp-viewer", "palp-record"]


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


def number(values, key, digits=0, unit=""):
    value = values.get(key)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        return "unknown"
    return f"{value:.{digits}f}{unit and ' ' + unit}"


def report(server, bridge, viewer, recorder):
    rate = bridge.get("rate_hz")
    lateness = (f"{number(bridge, 'rate_hz', 1, 'Hz')}, late by {number(bridge, 'lateness_p50_us')} us (median), "
                f"{number(bridge, 'lateness_p99_us')} us (99 %), {number(bridge, 'lateness_max_us')} us (worst)")
    step = (f"{number(server, 'step_p50_us')} us (median), {number(server, 'step_p99_us')} us (99 %) for "
            f"{number(server, 'steps')} steps")
    frames = f"{number(viewer, 'complete_frames')} complete of {number(viewer, 'frames')}, {number(viewer, 'lost_frames')} lost"
    recording = f"{number(recorder, 'messages')} messages, {number(recorder, 'drops')} dropped"
    return [("haptic loop", lateness if rate is not None or bridge else "unknown"), ("server step", step),
            ("real-time factor", number(server, "real_time_factor", 3)),
            ("publishing", f"{number(server, 'publish_p50_us' if 'publish_p50_us' in server else 'handover_p50_us')} us a "
             "step of the haptic thread (median)"),
            ("sample age", f"{number(bridge, 'sample_age_p50_ms', 2, 'ms')} at the bridge (median)"),
            ("peak force", number(bridge, "peak_force_n", 2, "N")),
            ("lost samples", f"{number(bridge, 'lost_samples')} at the bridge"), ("frames", frames),
            ("recording", recording)]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("dir", type=pathlib.Path)
    parser.add_argument("--no-picture", action="store_true", help="a window showed the scene: a missing scene.png is no fault")
    options = parser.parse_args()
    values, faults = {}, []
    for process in PROCESSES:
        values[process], fault = load(options.dir / "logs" / f"{process}.json")
        if fault:
            faults.append(f"{process} {fault}")
    for label, text in report(*(values[process] for process in PROCESSES)):
        print(f"  {label:18}{text}")
    if values["palp-record"].get("messages") == 0:
        faults.append("palp-record heard no message")
    left = ["force.png", "recording.mcap"]
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
