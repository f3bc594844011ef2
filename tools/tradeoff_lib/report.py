"""What tools/tradeoff writes: a table and a plot for each scene and machine, the page of all media, and the table that
programs choose their numerics from."""

import json
import re

from tradeoff_lib import levels
from tradeoff_lib.judge import number, share
from tradeoff_lib.measures import JND, TOLERANCE, dominators
from tradeoff_lib.scenes import ALPHA, LEVELS, MEDIA, METHOD, Unknown

# Okabe and Ito's palette, as tools/plot.py has it
LABEL_AT = {"fast": (7, 4), "balanced": (-12, 9), "accurate": (7, -12)}  # apart where two levels cost the same [points]
TIMING_NOISE = 0.1
BLUE, ORANGE, GREY, INK = "#0072B2", "#D55E00", "#9AA0A6", "#222222"
COLUMNS = ("point", "particles", "sub-steps", "step: mean", "median", "99 %", "rate", "real-time factor", "memory", "force error",
           "in JND", "peak", "torque error", "noise", "place", "penetration", "wave speed", "volume", "energy",
           "momentum", "angular", "temperature", "dominated by")


def number_of(value, factor=1.0, digits=3):
    return "" if value is None else f"{factor * value:.{digits}g}"


def millimetres(value):
    return "" if value is None else f"{number_of(value, 1, 2)} mm"


def percent(value):
    return "" if value is None else f"{100 * value:.2g} %"


def told_apart(uncertainty):
    """The error below which points are told apart no more: the reference's uncertainty, but no more than what a reference is
    asked for, since neighbouring points share most of what a worse one is off by."""
    return min(uncertainty or 0.0, TOLERANCE)


def mean_step(summary):
    """The mean of a run's haptic steps [s]. It decides whether a server keeps up. Their median does not: it jumps by half
    where every other step lists neighbours."""
    return 1 / summary["reached_rate_hz"]


def cost_and_error(p, least=0.0):
    """What a point costs, in seconds of computing for a second of simulated time, and how far its force is off, `least` at
    least."""
    if not p["errors"]:
        return None, None
    error = p["errors"]["force"]["rms"]
    return mean_step(p["summary"]) * p["summary"]["rate_hz"], None if error is None else max(error, least)


def row_of(p):
    """The cells of a point that was run."""
    s, e = p["summary"], p["errors"]
    return [p["label"], s["particles"], s["sub_steps"], f"{number_of(mean_step(s), 1e3)} ms",
            f"{number_of(s['step_median_s'], 1e3)} ms", f"{number_of(s['step_p99_s'], 1e3)} ms", f"{number_of(s['reached_rate_hz'])} Hz",
            number_of(s["real_time_factor"]), f"{number_of(s['memory_bytes'], 1e-6)} MB", percent(e["force"]["rms"]),
            number_of(e["force"]["rms_jnd"], 1, 2), percent(e["force"]["peak"]), percent(e["torque"]["rms"]),
            f"{number_of(e['noise_N'], 1, 2)} N", millimetres(e["place_mm"]), millimetres(e.get("penetration_mm")),
            percent(e.get("wave_speed")), percent(e["volume"]), percent(e["energy"]), percent(e["momentum"]), percent(e["angular momentum"]),
            "" if e["temperature_K"] is None else f"{number_of(e['temperature_K'], 1, 2)} K",
            p["dominated_by"] or "**front**"]


def heading(one):
    timing = "" if one["quiet"] else "; **timed beside other work, so times are no promise**"
    return (f"{one['scene']} on {one['class']} ({one['hardware']}), {one['duration_s']:g} s, revision {one['commit']}, "
            f"{one['date']}{timing}")


def reference_line(one):
    ref = one["reference"]
    steps = ", ".join(f"{1e3 * s['spacing_m']:.4g} mm: {percent(s['error'])}" for s in ref["spacings"])
    return (f"Reference: force of {number_of(ref['rms_force_N'])} N rms, known within {share(ref['uncertainty'])} ({ref['how']}; "
            f"of it {share(ref['of_time_step'])} by the length of the sub-step; order {number(ref['order'])}, in {ref['precision']}). "
            f"The runs that it was found from, and how far from it: {steps}. It ends there because {ref['note'] or 'no finer spacing was asked for'}.")


def table(one):
    """The lines of the table of one scene on one machine, the cheapest point first."""
    done = [p for p in one["points"] if p["errors"]]
    done.sort(key=lambda p: cost_and_error(p)[0])
    lines = ["| " + " | ".join(COLUMNS) + " |", "|---" * len(COLUMNS) + "|"]
    lines += ["| " + " | ".join(str(cell).replace("|", "/") for cell in row_of(p)) + " |" for p in done]
    failed = [f"- {p['label']}: {p['status']}: {p['said']}" for p in one["points"] if not p["errors"]]
    return lines + (["", "Not run to the end:", "", *failed] if failed else [])


def page_of(one):
    return "\n".join([f"# {heading(one)}", "", reference_line(one), "",
                      "Force and torque: rms over rms of what is slower than 30 Hz; noise: what is faster. JND: 7 % of the force.",
                      "Place: of the tool, largest distance from where the reference has it (it enters a solid so much deeper).",
                      "Penetration: how deep the centre of a particle lay in a solid, at most; empty where it was not measured.",
                      "Wave speed: of a sloshing trough or a swinging bar of the scene's matter (tools/tradeoff_lib/waves.py), "
                      "against theory.",
                      "Volume: largest change since the start. Momentum, energy: against the finest run.", "", *table(one)]) + "\n"


def plot(one, path):
    """Error against cost, the front and the levels marked. Raises ImportError where there is no matplotlib."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg  # here, because it takes long and most calls draw nothing
    from matplotlib.figure import Figure

    done = [p for p in one["points"] if p["errors"] and p["errors"]["force"]["rms"] is not None]
    figure = Figure(figsize=(6.4, 4.4), dpi=130)
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    xy = [(cost, max(1e-3, 100 * error)) for cost, error in map(cost_and_error, done)]
    axes.scatter(*zip(*xy), s=14, color=GREY, label="dominated", zorder=2)
    front = sorted(at for at, p in zip(xy, done) if not p["dominated_by"])
    axes.plot(*zip(*front), "o-", color=BLUE, markersize=4, linewidth=1.3, label="front", zorder=3)
    for p, at in zip(done, xy):
        if p["level"]:
            axes.scatter(*at, s=52, facecolors="none", edgecolors=ORANGE, linewidths=1.6, zorder=4)
            axes.annotate(p["level"], at, textcoords="offset points", xytext=LABEL_AT[p["level"]], color=ORANGE, fontsize=9)
    axes.axhline(100 * JND, color=INK, linewidth=0.8, linestyle=":", label="just noticeable")
    axes.axvline(1, color=INK, linewidth=0.8, linestyle="--", label="real time")
    axes.set(xscale="log", yscale="log", xlabel="computing time over simulated time", ylabel="force error, rms [%]",
             title=f"{one['medium']}: {one['scene']} on {one['class']}")
    bottom, top = axes.get_ylim()
    if one["reference"]["uncertainty"]:
        axes.axhspan(bottom, min(top, max(bottom, 100 * one["reference"]["uncertainty"])), color="#EEF3F8", zorder=0,
                     label="within the reference's uncertainty")
    axes.set_ylim(bottom, top)
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(True, which="major", color="#E4E4E4", linewidth=0.8)
    axes.legend(frameon=False, fontsize=8)
    figure.tight_layout()
    figure.savefig(path)


def promise_line(entry):
    """What --budget or --error was asked for, promised and kept, in a line."""
    asked = " ".join(entry["asked"])
    if "said" in entry:
        return f"{asked}: {entry['said']}"
    return (f"{asked}: {1e3 * entry['spacing_m']:.4g} mm; step {number_of(entry['step_s'], 1e3)} ms, "
            f"{number_of(entry['promised_step_s'], 1e3)} expected; error {percent(entry['error'])}, "
            f"{percent(entry['promised_error'])} expected: {'kept' if entry['kept'] else '**not kept**'}")


def all_page(results, folder):
    """Writes trade.md, its plots and trade.json for the newest result of each scene and machine."""
    newest = {}
    for one in sorted(results, key=lambda one: one["date"]):
        newest[one["scene"], one["class"]] = one
    chosen = sorted(newest.values(), key=lambda one: (MEDIA.index(one["medium"]), one["class"], one["scene"]))
    lines = ["# Speed against accuracy", "",
             "How far the force on the hand is from that of a reference which was refined until it no longer moves, and what a",
             "haptic step costs, for many choices of numerics. `tools/tradeoff --all` writes this page. A point is on the front",
             "if no other costs less for the same simulated time and errs less. JND: just-noticeable differences, 7 % of the force.",
             "Wave speed: against theory, of a sloshing trough or a swinging bar of the scene's matter; empty where not measured.", ""]
    for one in chosen:
        name = f"trade_{one['scene']}_{one['class']}.png"
        plot(one, folder / name)
        marked = [p for p in one["points"] if p["level"] and p["errors"]]
        lines += [f"## {one['medium'].capitalize()}: {heading(one)}", "", f"![Error against cost]({name})", "",
                  reference_line(one), ""]
        lines += [f"- Level {p['level']}: {percent(p['errors']['force']['rms'])} at "
                  f"{number_of(mean_step(p['summary']), 1e3)} ms, "
                  + (f"dominated by {p['dominated_by']}" if p["dominated_by"] else "on the front")
                  for p in sorted(marked, key=lambda p: LEVELS.index(p["level"]))]
        lines += [f"- Asked for {promise_line(entry)}" for entry in one.get("promises", [])]
        lines += ["", *table(one), ""]
    (folder / "trade.md").write_text("\n".join(lines))
    (folder / "trade.json").write_text(json.dumps({"results": chosen}, indent=1) + "\n")


def front_of(one, method="accurate"):
    """The points of a method's measured front, the cheapest first: of those at the scene's own haptic rate and in single
    precision, which is what programs run. A scene keeps its method, so none gives way to one of the other."""
    able = [p for p in one["points"] if p["errors"] and p["errors"]["force"]["rms"] is not None and p["precision"] == "float"
            and "scene.rate_hz" not in p["set"] and p["set"].get(METHOD, "accurate") == method]
    least = told_apart(one["reference"]["uncertainty"])
    front = [p for p, by in zip(able, dominators([cost_and_error(p, least) for p in able])) if by is None]
    front.sort(key=lambda p: mean_step(p["summary"]))
    values = [cost_and_error(p, least) for p in front]
    # a step that is timed twice differs by this much, so a point that is cheaper by less and errs by more is not better
    return [p for p, (cost, error) in zip(front, values)
            if not any(cost < c <= (1 + TIMING_NOISE) * cost and e * (1 + TIMING_NOISE) < error for c, e in values)]


def points_to_store(one):
    """The fronts of both methods, the cheapest first, and the levels where the reference tells whether they are beaten: it
    has to be known as well as a hand feels."""
    front = sorted(front_of(one) + front_of(one, "paper"), key=lambda p: mean_step(p["summary"]))
    known = one["reference"]["uncertainty"] is not None and one["reference"]["uncertainty"] <= JND
    return front, [p for p in one["points"] if p["level"] and p["errors"] and known]


def stored_point(p, least):
    """A point as programs read it. A level's numbers may change, so they are written out."""
    settings = p["set"] | (numbers_of_level(p) if p["level"] else {})
    return {"spacing_m": p["spacing_m"], "set": settings, "particles": p["summary"]["particles"],
            "sub_steps": p["summary"]["sub_steps"], "step_mean_s": mean_step(p["summary"]),
            "step_p99_s": p["summary"]["step_p99_s"], **calm_step(p), "error": cost_and_error(p, least)[1],
            "noise_N": p["errors"]["noise_N"], "memory_bytes": p["summary"]["memory_bytes"],
            **({} if p.get("rest_drift") is None else {"rest_drift_spacings": p["rest_drift"]})}


def numbers_of_level(p):
    """The alpha that a level expanded to, as the run said. Its H is another one for elastic bodies, and is left to it."""
    alpha = re.search(r"alpha ([0-9.]+)", p["summary"]["numerics"])
    return {ALPHA: alpha.group(1)} if alpha else {}


def levels_by_rule(one):
    """The point of the front that each level should be; none where only method paper was run."""
    front, least = front_of(one), told_apart(one["reference"]["uncertainty"])
    if not front:
        return {}
    chosen = levels.by_rule([(mean_step(p["summary"]), cost_and_error(p, least)[1]) for p in front])
    return {level: front[k] for level, k in chosen.items()}


def calm_step(p):
    time_s = p["summary"].get("calm_step_s")
    return {} if time_s is None else {"calm_step_s": time_s}


def store(one, folder):
    """Puts the front of a scene into the table of its machine class, CLASS.json. Raises Unknown where the reference is too
    short to tell errors by."""
    if one["reference"]["uncertainty"] is None:
        raise Unknown(f"{one['scene']}: nothing was stored, since the reference is of fewer than three spacings")
    path = folder / f"{one['class']}.json"
    try:
        whole = json.loads(path.read_text())
    except FileNotFoundError:
        whole = {"scenes": {}}
    ref = one["reference"]
    least = told_apart(ref["uncertainty"])
    front, of_levels = points_to_store(one)
    whole["scenes"][one["scene"]] = {
        "medium": one["medium"], "date": one["date"], "commit": one["commit"],
        "reference": {"uncertainty": ref["uncertainty"], "note": ref["note"]},
        "rule": "points that no other of the same method beats in both mean step time and force error (rms over rms, below 30 Hz; "
                f"below {share(least)} errors are not told apart), "
                f"measured along the path of {one['duration_s']:g} s",
        "points": [stored_point(p, least) for p in front],
        "levels": {p["level"]: stored_point(p, least) for p in of_levels},
        "levels_by_rule": {level: p["label"] for level, p in levels_by_rule(one).items()}}
    table_of_class = {"class": one["class"], "hardware": one["hardware"], "date": one["date"], "commit": one["commit"],
                      "scenes": dict(sorted(whole["scenes"].items()))}
    folder.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(table_of_class, indent=1) + "\n")
    return path
