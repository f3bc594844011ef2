#!/usr/bin/env python3
"""Potential-flow reference for the 2-D dam break of a water column a x 2a
(Martin & Moyce 1952, n^2 = 2): mixed Eulerian-Lagrangian boundary elements.

Units a = 1, g = 1/2, rho = 1: t is T = t* sqrt(2 g*/a*), Z = x_front.  phi is even in
x and z (walls x = 0, z = 0): with three images in the Green function only the free
surface is discretised, from the wall contact at x = 0 to the foot at z = 0.  On it
    Dx/Dt = grad phi,  Dphi/Dt = |grad phi|^2/2 - g z   (p = 0),
and each stage solves  sum_j D_ij (phi_j - phi_i) = sum_j S_ij q_j  for q = dphi/dn
(linear elements, exact integrals, collocation at nodes; the rigid mode gives the free
term).  RK4; every step ends with a 6th-order filter and a spline regridding.
Foot: an angle beta < 90 deg with p = 0 and w = 0 obeys q cos(beta) = dphi/ds sin(beta);
this is blended with the collocation equation, which is what is left at beta = 90.
The exact column has a log-singular acceleration at its foot at t = 0+, regularised by a
toe x = 1 + eps exp(-z/(2.5 eps)); the free corner (1, 2), which falls freely and near
T = 1.4 opens into a feature below any mesh size, by a fillet of radius rc; eps, rc -> 0.
Run: OMP_NUM_THREADS=1 /usr/bin/python3 dam_break_potential.py   (--fine: mesh 0.25 too)
"""
import os
os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"
import sys
import time
import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

G = 0.5
T_OUT = (0.832, 1.219, 1.997, 2.547, 3.345, 4.034)
Z_EXP = (1.217, 1.474, 2.292, 2.995, 4.134, 4.944)
R_LOG = 20.0          # kernel ln(r/R): keeps the first-kind equation well posed

def influence(x, z):
    """Double- and single-layer matrices: D[i, j], and S1/S2[i, e] for the first
    and the last node of element e, images in x = 0 and z = 0 included."""
    n = len(x)
    L = np.hypot(np.diff(x), np.diff(z))
    tx, tz = np.diff(x) / L, np.diff(z) / L
    D = np.zeros((n, n))
    S1, S2 = np.zeros((n, n - 1)), np.zeros((n, n - 1))
    for sx, sz in ((1, 1), (-1, 1), (1, -1), (-1, -1)):
        px, pz = (sx * x)[:, None], (sz * z)[:, None]
        dx, dz = px - x[None, :], pz - z[None, :]
        r = np.hypot(dx, dz)
        hit = r < 1e-13
        lr = np.log(np.where(hit, 1e-300, r))
        u = dx[:, :-1] * tx + dz[:, :-1] * tz        # along the element
        b = -dx[:, :-1] * tz + dz[:, :-1] * tx       # along its outward normal
        on = hit[:, :-1] | hit[:, 1:]
        b[on] = 0.0
        th = np.arctan2(b * L, b * b - u * (L - u))
        th[on] = 0.0
        l1, l2, q1, q2 = lr[:, :-1], lr[:, 1:], r[:, :-1] ** 2, r[:, 1:] ** 2
        d2 = -(u * th + b * (l2 - l1)) / L
        D[:, :-1] += -th - d2
        D[:, 1:] += d2
        s0 = (L - u) * l2 + u * l1 - L + b * th
        s2 = (u * s0 + 0.5 * (q2 * l2 - q1 * l1) - 0.25 * (q2 - q1)) / L
        S1 += s0 - s2 - 0.5 * L * np.log(R_LOG)
        S2 += s2 - 0.5 * L * np.log(R_LOG)
    return D, S1, S2

def splines(y):
    """Chord length s and cubic splines of x, z, phi; symmetric at the wall x = 0."""
    s = np.r_[0.0, np.cumsum(np.hypot(np.diff(y[:, 0]), np.diff(y[:, 1])))]
    return s, [CubicSpline(s, y[:, k], bc_type=((2, 0.0) if k == 0 else (1, 0.0),
                                                "not-a-knot")) for k in range(3)]

def velocity(y):
    """Velocity of the nodes (n, 2) and normal velocity q (n,)."""
    n = len(y)
    s, cs = splines(y)
    d = np.stack([c(s, 1) for c in cs], axis=1)
    m = np.hypot(d[:, 0], d[:, 1])
    tau, phis = d[:, :2] / m[:, None], d[:, 2] / m
    tau[0], phis[0] = (1.0, 0.0), 0.0
    D, S1, S2 = influence(y[:, 0], y[:, 1])
    rhs = D @ y[:, 2] - D.sum(axis=1) * y[:, 2]
    S = np.zeros((n, n))
    S[:, :-1] += S1
    S[:, 1:] += S2
    cb, sb, snn = tau[-1, 0], -tau[-1, 1], S[-1, -1]      # cos, sin of the tip angle
    S[-1] *= sb ** 2 / snn
    rhs[-1] *= sb ** 2 / snn
    S[-1, -1] += cb ** 2
    rhs[-1] += cb * sb * phis[-1]
    q = np.linalg.solve(S, rhs)
    v = phis[:, None] * tau + q[:, None] * np.stack([-tau[:, 1], tau[:, 0]], axis=1)
    v[0, 0] = v[-1, 1] = 0.0
    return v, q

def rate(y, g):
    v, _ = velocity(y)
    return np.c_[v, 0.5 * (v ** 2).sum(axis=1) - g * y[:, 1]]

def integrals(y, g):
    """Volume, kinetic and potential energy, net flux (exact for the linear elements)."""
    (x, z, p), (_, q) = y.T, velocity(y)
    dx, za, zb = np.diff(x), z[:-1], z[1:]
    L = np.hypot(dx, np.diff(z))
    vol = (0.5 * dx * (za + zb)).sum()
    pot = g * (dx * (za ** 2 + za * zb + zb ** 2) / 6).sum()
    pa, pb, qa, qb = p[:-1], p[1:], q[:-1], q[1:]
    kin = 0.5 * (L * (2 * pa * qa + 2 * pb * qb + pa * qb + pb * qa) / 6).sum()
    return vol, kin, pot, (0.5 * L * (qa + qb)).sum()

def smooth(y):
    """Sixth-order filter in the node index, y - E'E y / 64 with E the third difference:
    it removes the two-node wave and keeps quadratics (also at the one-sided foot)."""
    p = np.vstack([y[3:0:-1] * np.array([-1.0, 1.0, 1.0]), y])
    e = np.diff(p, 3, axis=0) / 64
    for w, i in zip((-1, 3, -3, 1), range(4)):
        p[i:len(p) - 3 + i] -= w * e
    p[3, 0] = p[-1, 1] = 0.0
    return p[3:]

def regrid(y, mark, m, t=0.0):
    """Nodes redistributed with spacing ~ min(hmax, hc + k d_mark, hf + k d_foot), where
    d are arc lengths to the material node mark (the free corner) and to the foot;
    m = (hmax, hc, hf, k, r); at time t hf is hf + r t.  Nodes 0, mark and the foot are kept."""
    hmax, hc, hf, k, r = m
    hf += r * t
    (s, cs), sn = splines(y), [np.zeros(1)]
    for s0, s1 in ((0.0, s[mark]), (s[mark], s[-1])):
        f = np.linspace(s0, s1, 4001)
        h = (hmax ** -2 + (hc ** 2 + (k * (f - s[mark])) ** 2) ** -1
             + (hf + k * (s[-1] - f)) ** -2) ** -0.5
        c = np.r_[0.0, np.cumsum(0.5 * (1 / h[1:] + 1 / h[:-1]) * np.diff(f))]
        ne = int(np.ceil(c[-1]))
        sn.append(np.interp(np.linspace(0.0, c[-1], ne + 1), c, f)[1:])
    mark_new = len(sn[1])
    out = np.stack([c(np.concatenate(sn)) for c in cs], axis=1)
    out[0], out[mark_new], out[-1] = y[0], y[mark], y[-1]
    return out, mark_new

def march(y, mark, m, dtmax, cdef, times, g):
    """RK4 to each of the times; yields (t, y, mark, steps).  The step is limited by
    dtmax and by cdef / (largest strain rate along the surface)."""
    t, steps = 0.0, 0
    for te in times:
        while t < te - 1e-12:
            k1 = rate(y, g)
            dv, dl = np.diff(k1[:, :2], axis=0), np.diff(y[:, :2], axis=0)
            strain = (np.hypot(*dv.T) / np.hypot(*dl.T)).max()
            dt = min(dtmax, cdef / max(strain, 1e-9))
            if dt < 1e-5:
                return
            dt = (te - t) / np.ceil((te - t) / dt - 1e-9)
            k2 = rate(y + 0.5 * dt * k1, g)
            k3 = rate(y + 0.5 * dt * k2, g)
            k4 = rate(y + dt * k3, g)
            y = y + dt / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
            t += dt
            steps += 1
            y, mark = regrid(smooth(y), mark, m, t)
        yield t, y, mark, steps

def column(m, eps, rc):
    """The column with its toe and its fillet, at rest."""
    a = np.linspace(np.pi / 2, 0, 101)[1:-1]
    z = 2 - rc - (2 - rc) * (1 - np.expm1(6 * np.linspace(1, 0, 1201)) / np.expm1(6))
    x = np.r_[np.linspace(0, 1 - rc, 101), 1 - rc + rc * np.cos(a), 1 + 0 * z]
    z = np.r_[np.full(101, 2.0), 2 - rc + rc * np.sin(a), z]
    x = x + eps * np.exp(-z / (2.5 * eps))
    return regrid(np.c_[x, z, 0 * x], 150, m)

def mesh(f, eps, rc):
    return 0.08 * f, 0.3 * rc * f, 0.3 * eps * f, 0.1 * f, 0.01 * f

def dam_break(f=1.0, dtmax=0.03, cdef=0.2, eps=0.01, rc=0.04, times=T_OUT):
    """One run with mesh factor f; prints, returns Z at the times."""
    m, c0 = mesh(f, eps, rc), time.time()
    y, mark = column(m, eps, rc)
    vol0, _, e0, _ = integrals(y, G)
    zs = []
    print(f"\nmesh factor {f}, dtmax {dtmax}, strain limit {cdef}, eps {eps}, rc {rc}")
    print("    T   steps nodes     Z     dZ/dT  tip angle   z_wall  corner x, z    "
          "  dVol/Vol   dE/E0     flux")
    for t, y, mark, steps in march(y, mark, m, dtmax, cdef, times, G):
        vol, kin, pot, flux = integrals(y, G)
        v = velocity(y)[0]
        zs.append(y[:, 0].max())
        b = np.degrees(np.arctan2(y[-2, 1], y[-1, 0] - y[-2, 0]))
        print(f"{t:6.3f} {steps:6d} {len(y):5d}  {zs[-1]:8.5f} {v[-1, 0]:7.4f} {b:8.2f}"
              f"  {y[0, 1]:9.5f} {y[mark, 0]:8.4f} {y[mark, 1]:7.4f} {vol / vol0 - 1:10.2e}"
              f" {(kin + pot) / e0 - 1:10.2e} {flux:9.1e}", flush=True)
    print(f"  {time.time() - c0:.0f} s")
    return np.array(zs)

def check_start():
    """Accelerations at t = 0+ against the Fourier series of the initial pressure,
    p = sum A_n cos(k_n x) sinh(k_n (2 - z)), k_n = (n + 1/2) pi (cf. Pohle)."""
    n = np.arange(100)
    k, e = (n + 0.5) * np.pi, np.exp(-2 * (n + 0.5) * np.pi)
    top = G * ((2 * (-1.0) ** n / k * 2 * e / (1 + e ** 2)).sum() - 1)
    print("\ncheck 1: initial accelerations / g, series against BEM (eps 1e-3, rc 0.01)")
    y, _ = column(mesh(0.5, 1e-3, 0.01), 1e-3, 0.01)
    y[:, 2] = -G * y[:, 1]                       # phi_t on the surface
    v, _ = velocity(y)
    print(f"  top at the wall   w_t {top / G:9.5f} {v[0, 1] / G:9.5f}")
    i0 = int(np.argmax(y[:, 0] > 0.99999))       # the front face
    for z in (1.5, 1.0, 0.5, 0.2, 0.1, 0.05):
        ser = (2 / k * np.exp(-k * z) * (1 - np.exp(-2 * k * (2 - z))) / (1 + e ** 2)).sum()
        bem = CubicSpline(y[i0:, 1][::-1], v[i0:, 0][::-1])(z) / G
        print(f"  face at z = {z:4.2f}  u_t {ser:9.5f} {bem:9.5f}")
    return top

def check_ellipse(f=1.0, dtmax=0.03):
    """Dirichlet's ellipse, g = 0: a circle with phi = (x^2 - z^2)/2 at t = 0 stays an
    ellipse, a a'' (a^4 + 1) = 2 a'^2: a free-surface flow with an exact solution."""
    th = np.linspace(np.pi / 2, 0, 801)
    y = np.stack([np.cos(th), np.sin(th), 0.5 * np.cos(2 * th)], axis=1)
    m = (0.08 * f, 0.08 * f, 0.01 * f, 0.1 * f, 0.0)
    y, mark = regrid(y, 400, m)
    ref = solve_ivp(lambda t, a: (a[1], 2 * a[1] ** 2 / (a[0] * (a[0] ** 4 + 1))), (0, 2),
                    (1.0, 1.0), rtol=1e-11, atol=1e-12, dense_output=True).sol
    print(f"\ncheck 2: Dirichlet's ellipse, mesh factor {f}: t, x_tip exact, BEM, rel. error"
          ", z_top rel. error")
    for t, y, mark, _ in march(y, mark, m, dtmax, 0.2, (0.5, 1.0, 1.5, 2.0), 0.0):
        a = ref(t)[0]
        print(f"  {t:4.1f} {a:9.6f} {y[-1, 0]:9.6f} {y[-1, 0] / a - 1:9.1e}"
              f" {y[0, 1] * a - 1:9.1e}", flush=True)

def main():
    c0 = time.time()
    top = check_start()
    check_ellipse(1.0)
    check_ellipse(0.5, 0.015)
    print(f"\ncheck 3: series z_wall(T = 0.2) = {2 + top * 0.02:.5f} + O(T^4)")
    dam_break(1.0, times=(0.1, 0.2, 0.4))
    z2, z1, z0 = dam_break(2.0), dam_break(1.0), dam_break(0.5)
    zt = dam_break(1.0, dtmax=0.015, cdef=0.1)
    zr = dam_break(1.0, rc=0.08)
    ze2, ze = dam_break(1.0, eps=0.02), dam_break(0.5, eps=0.005)
    if "--fine" in sys.argv:
        dam_break(0.25, dtmax=0.015, eps=0.005)
    unc = abs(z1 - z0) + abs(zt - z1) + abs(ze - z0) + abs(zr - z1)
    print("\nZ(T): the finest run (mesh 0.5, eps 0.005); differences in 1e-4:\n"
          "    T     Z_pot     +-    mesh 2-1  mesh 1-.5  dt-dt/2  eps .02-.01"
          "  eps .01-.005  rc .08-.04  Ritter   Z_exp")
    for i, t in enumerate(T_OUT):
        d = 1e4 * np.array([z2[i] - z1[i], z1[i] - z0[i], z1[i] - zt[i], ze2[i] - z1[i],
                            z0[i] - ze[i], zr[i] - z1[i]])
        print(f"  {t:.3f}  {ze[i]:.4f}  {unc[i]:.4f}" + "".join(f"{v:11.1f}" for v in d)
              + f"    {1 + 2 * t:.3f}   {Z_EXP[i]:.3f}")
    print(f"total {time.time() - c0:.0f} s")

if __name__ == "__main__":
    main()
