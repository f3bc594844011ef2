"""The arithmetic of tools/tradeoff: filters, errors, the limit of a refinement, dominance. Series are arrays with a row
for each time; those that are compared have the same times."""

import math

import numpy as np

TOLERANCE = 0.03  # uncertainty at which a reference is refined no more, as a share of the force
JND = 0.07  # just-noticeable difference of a force, as a share of it (Jones & Hunter 1992)
CUTOFF_HZ = 30  # below: what the hand follows; above: what it feels as vibration
ORDERS = (0.5, 2.0)  # orders of convergence that are believed: particle methods have two at most


def lowpass(series, rate_hz, cutoff_hz=CUTOFF_HZ):
    """The series without what is faster than cutoff_hz, without delay: the response of a second-order Butterworth filter
    that runs forwards and backwards, 1 / (1 + (f / cutoff)^4). The ends are continued by point reflection."""
    series = np.asarray(series, dtype=float)
    pad = min(len(series) - 1, max(1, int(rate_hz)))
    head = 2 * series[0] - series[pad:0:-1]
    tail = 2 * series[-1] - series[-2:-pad - 2:-1]
    longer = np.concatenate([head, series, tail])
    frequency = np.fft.rfftfreq(len(longer), 1 / rate_hz)
    gain = (1 / (1 + (frequency / cutoff_hz) ** 4)).reshape(-1, *[1] * (series.ndim - 1))
    return np.fft.irfft(np.fft.rfft(longer, axis=0) * gain, n=len(longer), axis=0)[pad:pad + len(series)]


def length(series):
    """The length of the vector in each row."""
    return np.linalg.norm(np.atleast_2d(np.asarray(series, dtype=float).T).T, axis=1)


def rms(series):
    return float(np.sqrt(np.mean(length(series) ** 2)))


def ratio(value, scale):
    """value / scale, or None where the scale is nothing to measure against."""
    return value / scale if scale > 0 and math.isfinite(value) else None


def difference(series, reference):
    """How far a series is from a reference, as shares: rms over rms, largest over largest; in units of the JND."""
    gap = np.asarray(series) - np.asarray(reference)
    share = ratio(rms(gap), rms(reference))
    peak = ratio(float(length(gap).max()), float(length(reference).max()))
    return {"rms": share, "peak": peak, "rms_jnd": None if share is None else share / JND,
            "peak_jnd": None if peak is None else peak / JND}


def observed_order(spacings, coarse_gap, fine_gap):
    """The order p of an error that falls as spacing^p, from three spacings, the finest last, and the distances between
    what the first two and the last two gave; None where the distances do not fall as any believable order would."""
    h1, h2, h3 = spacings
    if fine_gap <= 0:
        return None
    wanted = coarse_gap / fine_gap

    def shrinks(p):
        return (h1 ** p - h2 ** p) / (h2 ** p - h3 ** p)  # grows with p

    low, high = ORDERS
    if wanted < shrinks(low):
        return None
    if wanted >= shrinks(high):
        return high
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if shrinks(middle) < wanted else (low, middle)
    return (low + high) / 2


def fitted(spacings, series, order):
    """The least-squares fit of limit + c * spacing^order to each value of the series, finer ones weighing more: the limit,
    and what share of how the series differ it explains."""
    x, w = np.asarray(spacings) ** order, 1 / np.asarray(spacings)
    values = np.stack(series)
    mean_x, mean = np.average(x, weights=w), np.average(values, axis=0, weights=w)
    slope = np.tensordot(w * (x - mean_x), values - mean, axes=1) / np.sum(w * (x - mean_x) ** 2)
    left = values - mean - np.multiply.outer(x - mean_x, slope)
    per_run = tuple(range(1, values.ndim))
    total = np.sum(w * np.sum((values - mean) ** 2, axis=per_run))
    explained = 1 - np.sum(w * np.sum(left ** 2, axis=per_run)) / total if total > 0 else 0.0
    return mean - slope * mean_x, explained


def best_order(spacings, series):
    """The order whose fit explains most, by golden-section search; None where a lower one than is believed would explain
    more: then the series still move as much as before, and an extrapolation would lead far beyond them."""
    low, high = ORDERS
    share = (math.sqrt(5) - 1) / 2
    for _ in range(40):
        a, b = high - share * (high - low), low + share * (high - low)
        if fitted(spacings, series, a)[1] < fitted(spacings, series, b)[1]:
            low = a
        else:
            high = b
    order = (low + high) / 2
    return order if order - ORDERS[0] > 1e-3 else None


def extrapolated(spacings, series):
    """The estimate of the limit of some series, one a spacing, the finest last, and its order: of three Richardson's, of
    more a least-squares fit of the last five (Eca & Hoekstra 2014), which a run that strays moves less. The finest series
    itself and None where they show no order."""
    spacings, series = list(spacings[-5:]), [np.asarray(one, dtype=float) for one in series[-5:]]
    if len(series) == 3:
        order = observed_order(spacings, rms(series[1] - series[0]), rms(series[2] - series[1]))
    else:
        order = best_order(spacings, series) if len(series) > 3 else None
    if order is None:
        return series[-1], None
    limit, explained = fitted(spacings[-2:], series[-2:], order) if len(series) == 3 else fitted(spacings, series, order)
    return (limit, order) if explained > 0.5 else (series[-1], None)


def limit_of(spacings, series):
    """The limit of a refinement: (series, order or None, uncertainty as a share of its rms, how that was found)."""
    limit, order = extrapolated(spacings, series)
    scale = rms(limit)
    last_gap = rms(np.asarray(series[-1]) - series[-2]) if len(series) > 1 else math.inf
    if order is None:
        return limit, None, ratio(last_gap, scale), "no order is seen: the finest run, and how far the one before it is"
    if len(series) >= 4:
        before, _ = extrapolated(spacings[:-1], series[:-1])
        return limit, order, ratio(rms(limit - before), scale), "how far the limit moved with the last refinement"
    index = 1.25 * rms(limit - np.asarray(series[-1]))
    return limit, order, ratio(index, scale), "1.25 times the way from the finest run (grid convergence index)"


def dominators(points):
    """For each (cost, error) the index of the point that dominates it most: not dearer and not further off, and better in
    one of the two; of several the one with the least error. None on the front, and where a value is missing."""
    found = []
    for cost, error in points:
        better = [k for k, (c, e) in enumerate(points)
                  if None not in (c, e, cost, error) and c <= cost and e <= error and (c < cost or e < error)]
        found.append(min(better, key=lambda k: points[k][1], default=None))
    return found
