"""The rule by which accuracy levels are chosen from a measured front. ARCHITECTURE.md says it in words."""

import math

from tradeoff_lib.measures import JND

FAST_STEP_S = 5e-4  # half a haptic step, so that what else runs keeps up, too
WORTH = 0.8  # twice the time must leave at most this share of the error


def error_at(front, step):
    """The error of a front at a step time, by power laws between its points; None below the cheapest."""
    if step < front[0][0]:
        return None
    for (t0, e0), (t1, e1) in zip(front, front[1:]):
        if t0 <= step <= t1:
            share = math.log(step / t0) / math.log(t1 / t0) if t1 > t0 else 1.0
            return math.exp((1 - share) * math.log(e0) + share * math.log(e1))
    return front[-1][1]


def by_rule(front):
    """Of a front, (step time [s], error) with the cheapest first and errors that fall, the index of each level."""
    front = [(step, max(error, 1e-9)) for step, error in front]
    quick = [k for k, (step, _) in enumerate(front) if step <= FAST_STEP_S]
    fast = quick[-1] if quick else 0
    unnoticed = [k for k, (_, error) in enumerate(front) if error <= JND]
    worth = [k for k, (step, error) in enumerate(front)
             if (before := error_at(front, step / 2)) is not None and error <= WORTH * before]
    accurate = max(fast, unnoticed[0] if unnoticed else worth[-1] if worth else 0)
    return {"fast": fast, "balanced": knee(front, fast, accurate), "accurate": accurate}


def knee(front, first, last):
    """The index between two of a front's that lies furthest below the line through both, in logarithms; `last` if none does."""
    (t0, e0), (t1, e1) = front[first], front[last]

    def below(k):
        share = math.log(front[k][0] / t0) / math.log(t1 / t0)
        return (1 - share) * math.log(e0) + share * math.log(e1) - math.log(front[k][1])

    inside = [k for k in range(first + 1, last) if below(k) > 0]
    return max(inside, key=below, default=last)
