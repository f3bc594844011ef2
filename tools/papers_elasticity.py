#!/usr/bin/python3
"""How fast vibrations of a clamped block grow with the paper's elasticity (sim_server/physics/elastic.h), and how much damping
ends that: eigenvalues of the linear problem about rest. Lengths in spacings, times in spacings over sqrt(E / rho), damping in
rho sqrt(E / rho) dx. The block is periodic along y, and held by its first four layers along x."""

import argparse

import numpy as np

CLAMPED = 4


class Block:
    def __init__(self, shape, support):
        grid = np.meshgrid(*(np.arange(n, dtype=float) for n in shape), indexing="ij")
        self.place = np.stack([axis.ravel() for axis in grid], axis=1)
        between = self.place[None] - self.place[:, None]
        between[..., 1] -= shape[1] * np.round(between[..., 1] / shape[1])
        distance = np.linalg.norm(between, axis=2)
        self.i, self.j = np.nonzero((distance < support) & (distance > 0))
        self.rest = between[self.i, self.j]
        q = distance[self.i, self.j] / support
        wendland = 21 / (2 * np.pi * support**3)
        self.W = wendland * (1 - q) ** 4 * (1 + 4 * q)
        self.F = wendland * 20 * (1 - q) ** 3 / support**2
        self.at_rest = self.summed(self.F[:, None, None] * self.rest[:, :, None] * self.rest[:, None, :])
        free = np.nonzero(self.place[:, 0] >= CLAMPED)[0]
        self.free = (3 * free[:, None] + np.arange(3)).ravel()

    def summed(self, terms):
        total = np.zeros((len(self.place),) + terms.shape[1:])
        np.add.at(total, self.i, terms)
        return total

    def force(self, u, poisson):
        """On each particle of mass 1, at displacements u, E = 1."""
        now = self.rest + u[self.j] - u[self.i]
        dyads = now[:, :, None] * self.rest[:, None, :]
        U, _, V = np.linalg.svd(self.summed(self.W[:, None, None] * dyads))
        R = U @ V
        G = R.transpose(0, 2, 1) @ self.summed(self.F[:, None, None] * dyads) - self.at_rest
        strain = (G + G.transpose(0, 2, 1)) / 2
        shear, lame = 1 / (2 + 2 * poisson), poisson / ((1 + poisson) * (1 - 2 * poisson))
        trace = np.trace(strain, axis1=1, axis2=2)[:, None, None]
        stress = R @ (np.eye(3) + G) @ (2 * shear * strain + lame * trace * np.eye(3))
        return self.summed(self.F[:, None] * np.einsum("nab,nb->na", stress[self.i] + stress[self.j], self.rest))

    def stiffness(self, poisson, step=1e-6):
        columns = []
        for k in self.free:
            u = np.zeros(self.place.size)
            u[k] = step
            change = self.force(u.reshape(-1, 3), poisson) - self.force(-u.reshape(-1, 3), poisson)
            columns.append(-change.ravel()[self.free] / (2 * step))
        return np.stack(columns, axis=1)

    def damping(self):
        n = len(self.place)
        along = self.rest / np.linalg.norm(self.rest, axis=1)[:, None]
        pairs = 10 * self.F[:, None, None] * along[:, :, None] * along[:, None, :]
        total = np.zeros((n, n, 3, 3))
        np.add.at(total, (self.i, self.i), pairs)
        np.add.at(total, (self.i, self.j), -pairs)
        return total.transpose(0, 2, 1, 3).reshape(3 * n, 3 * n)[np.ix_(self.free, self.free)]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--shape", type=int, nargs=3, default=(12, 8, 4), metavar="N", help="particles; default 12 8 4")
    parser.add_argument("--support", type=float, default=2.5, help="support radius in spacings; default 2.5")
    parser.add_argument("--poisson", type=float, default=0.3975)
    parser.add_argument("--damping", type=float, nargs="+", default=[0, 0.001, 0.003, 0.01])
    options = parser.parse_args()
    block = Block(options.shape, options.support)
    K, C = block.stiffness(options.poisson), block.damping()
    print(f"{options.shape} particles, H = {options.support} dx, nu = {options.poisson}: K differs from its transpose by "
          f"{np.abs(K - K.T).max() / np.abs(K).max():.2g}")
    for eta in options.damping:
        first_order = np.block([[np.zeros_like(K), np.eye(len(K))], [-K, -eta * C]])
        print(f"  damping {eta:g}: growth {np.linalg.eigvals(first_order).real.max():.2g}", flush=True)


if __name__ == "__main__":
    main()
