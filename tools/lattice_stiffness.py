#!/usr/bin/python3
"""Tells how stiff a lattice of particles under pressure is against shear, by kernel and support radius.

  tools/lattice_stiffness.py
  tools/lattice_stiffness.py --support 2.6 2.8 3

Pairs that push each other with (p_i + p_j) V^2 grad W have, where the pressure p is the same everywhere, the energy
p V sum W a particle. Its second derivatives by strains that keep the volume are moduli of the cubic lattice: of
stretch along one axis of the lattice and shrink along another, and of shear along both. A liquid has none. Where one is
below zero pressure makes the lattice collapse; where one is large it resists like a solid with a yield stress. Prints
both over p, and sum F r^2 / 3 and sum W, which are one in the continuum; the latter also of the body-centred and the
face-centred lattice of as many particles: where these are lower, the cubic one turns into them as it rests. Last, the
least and the largest stiffness that a wave of any length and direction meets along the displacement that meets least
(smallest eigenvalue of the pairs' dynamical matrix over p k^2, k^2 as the lattice has it): below zero that wave grows."""
import argparse

import numpy as np

REACH = 5  # spacings that the lattice reaches to each side


def spline(order):
    """The B-spline of that order with its knots at odd multiples of h / 2, or even ones, over r / H."""
    knots = (order + 1) / 2

    def w(q):
        total, weight = np.zeros_like(q), 1.0
        for k in range(int(np.ceil(knots))):
            total = total + weight * np.maximum(knots * (1 - q) - k, 0) ** order
            weight *= -(order + 1 - k) / (k + 1)
        return total
    return w


KERNELS = {"Wendland C2": lambda q: np.maximum(1 - q, 0) ** 4 * (4 * q + 1), "cubic": spline(3), "quartic": spline(4),
           "quintic": spline(5)}


def lattice(*centres):
    """Places around one particle, one a unit of volume: a cubic lattice, or one with further particles in each of its cells."""
    side = np.arange(-REACH, REACH + 1.0)
    cubic = np.stack(np.meshgrid(side, side, side), -1).reshape(-1, 3)
    return np.concatenate([cubic + c for c in [(0, 0, 0), *centres]]) * (1 + len(centres)) ** (1 / 3)


PACKINGS = {"cubic": lattice(), "body-centred": lattice((.5, .5, .5)),
            "face-centred": lattice((.5, .5, 0), (.5, 0, .5), (0, .5, .5))}


def waves():
    """Wave vectors [1/dx] that differ by more than a symmetry of the cubic lattice, to the shortest waves it has."""
    steps = np.linspace(0, np.pi, 7)
    return np.array([(a, b, c) for a in steps for b in steps for c in steps if a >= b >= c and a > 0])


def softest_wave(w, support):
    """The least and the largest of what the softest displacement of each wave meets. w: of the distance."""
    places = PACKINGS["cubic"]
    r = np.linalg.norm(places, axis=1)
    places, r = places[(r > 0) & (r < support)], r[(r > 0) & (r < support)]
    step = 1e-4
    slope, bend = (w(r + step) - w(r - step)) / (2 * step), (w(r + step) - 2 * w(r) + w(r - step)) / step ** 2
    along = places[:, :, None] * places[:, None, :] / r[:, None, None] ** 2
    pairs = (bend - slope / r)[:, None, None] * along + (slope / r)[:, None, None] * np.eye(3)
    k = waves()
    matrices = np.einsum("kp,pij->kij", 1 - np.cos(k @ places.T), pairs)
    least = np.linalg.eigvalsh(matrices)[:, 0] / (2 - 2 * np.cos(k)).sum(axis=1)
    return least.min(), least.max()


def second_derivative(f, step=2e-3):
    return (f(step) - 2 * f(0) + f(-step)) / step ** 2


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--support", type=float, nargs="+", default=[2, 2.2, 2.4, 2.5, 2.6, 2.7, 2.8, 3], metavar="SPACINGS")
    options = parser.parse_args()
    q = np.linspace(0, 1, 100001)
    for name, shape in KERNELS.items():
        unit = 1 / (4 * np.pi * np.sum(q ** 2 * shape(q)) * (q[1] - q[0]))
        for support in options.support:
            def sum_w(strain, packing="cubic"):
                r = np.linalg.norm(PACKINGS[packing] @ strain.T, axis=1) / support
                return unit * shape(r).sum() / support ** 3
            stretch = second_derivative(lambda e: sum_w(np.diag([np.exp(e), np.exp(-e), 1]))) / 4
            shear = second_derivative(lambda e: sum_w(np.eye(3) + e * np.outer([1, 0, 0], [0, 1, 0])))
            swell = -(sum_w(np.eye(3) * (1 + 1e-4)) - sum_w(np.eye(3) * (1 - 1e-4))) / 2e-4 / 3
            soft, stiff = softest_wave(lambda r: unit * shape(r / support) / support ** 3, support)
            sums = ", ".join(f"{sum_w(np.eye(3), packing):.4f} {packing}" for packing in PACKINGS)
            print(f"{name}, H = {support:g} dx: {stretch:+.4f} by stretch, {shear:+.4f} by shear; sum F r^2 / 3 {swell:.4f}; "
                  f"sum W {sums}; softest waves {soft:+.4f} to {stiff:+.4f}")


if __name__ == "__main__":
    main()
