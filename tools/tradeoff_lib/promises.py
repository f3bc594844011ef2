"""Whether --budget and --error keep their word: what palp-run was asked for, what it promised and what came out."""

from tradeoff_lib import judge
from tradeoff_lib.report import cost_and_error, front_of, mean_step, promise_line, told_apart

WITHIN = 0.2  # what is asked for may be exceeded by this share
BUDGETS = (0.7, 1.4, 3.0)  # of the front's middle step
ERRORS = (0.8, 1.3, 2.0)  # of the front's middle error
MOST = 0.99  # that --error takes


def questions(one):
    """What to ask for, as an option with its value in seconds or as a share: budgets and errors around the middle of a
    measured front, within it."""
    least = told_apart(one["reference"]["uncertainty"])
    front = [(mean_step(p["summary"]), cost_and_error(p, least)[1]) for p in front_of(one)]
    if not front:
        return []
    step, error = front[len(front) // 2]
    slowest, worst = front[-1][0], front[0][1]
    return ([("--budget", share * step) for share in BUDGETS if share * step < slowest]
            + [("--error", share * error) for share in ERRORS if share * error < min(worst, MOST)])


def keep(runner, one, reference, say):
    """Asks each question; a list of what was asked, promised and measured."""
    found = []
    for option, value in questions(one):
        asked = [option, f"{1e6 * value:.4g}us" if option == "--budget" else f"{100 * value:.4g}%"]
        point = {"spacing_m": 0.0, "set": {}, "level": None, "precision": "float", "asked": asked}
        result = runner.run(point)
        entry = {"asked": asked, "said": result["said"]}
        if result["status"] == "done":
            summary, chosen = result["summary"], result["summary"]["chosen"]
            error = judge.errors(runner.series(point), reference.limit, reference.grid)["force"]["rms"]
            measured = mean_step(summary) if option == "--budget" else error
            entry = {"asked": asked, "spacing_m": chosen["spacing_m"], "set": chosen["set"],
                     "promised_step_s": chosen["expected_step_s"], "step_s": mean_step(summary),
                     "promised_error": chosen["expected_error"], "error": error, "quiet": result["quiet"],
                     "kept": measured <= (1 + WITHIN) * value}
        found.append(entry)
        say(promise_line(entry))
    return found
