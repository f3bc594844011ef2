"""The path of a hand script (config/hands/README.md) as palp-run takes it. Restates
haptic_bridge/device/trajectory.cpp; a test compares the two."""

import tomllib

import numpy as np


def times(a, b):
    """The product of two quaternions x y z w: first b, then a."""
    (ax, ay, az, aw), (bx, by, bz, bw) = a, b
    return np.array([aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx,
                     aw * bz + ax * by - ay * bx + az * bw, aw * bw - ax * bx - ay * by - az * bz])


def conjugate(q):
    return np.array([-q[0], -q[1], -q[2], q[3]])


def rotation_by(vector):
    """The quaternion of a rotation vector [rad]."""
    angle = np.linalg.norm(vector)
    if angle < 1e-12:
        return np.array([0.0, 0.0, 0.0, 1.0])
    return np.append(np.sin(angle / 2) * np.asarray(vector) / angle, np.cos(angle / 2))


def rotation_between(start, end):
    """The rotation vector that turns start into end."""
    turn = times(end, conjugate(start))
    turn = -turn if turn[3] < 0 else turn
    sine = np.linalg.norm(turn[:3])
    return 2 * turn[:3] if sine < 1e-6 else 2 * np.arctan2(sine, turn[3]) / sine * turn[:3]


def rotate(q, vector):
    return times(times(q, np.append(vector, 0.0)), conjugate(q))[:3]


def rotation_rate(r, w):
    """The rate of the rotation vector r that gives the angular velocity w."""
    angle = np.linalg.norm(r)
    c = 1 / 12 + angle ** 2 / 720 if angle < 1e-4 else (1 - 0.5 * angle * np.sin(angle) / (1 - np.cos(angle))) / angle ** 2
    return w - 0.5 * np.cross(r, w) + c * np.cross(r, np.cross(r, w))


class Trajectory:
    def __init__(self, script):
        frames = script["keyframe"]
        self.time = np.array([float(k["time"]) for k in frames]) - frames[0]["time"]
        self.x = [np.array(k.get("position", [0.0, 0.0, 0.0]), dtype=float) for k in frames]
        self.q = [rotation_by(np.radians(k.get("rotation_deg", [0.0, 0.0, 0.0]))) for k in frames]
        self.loop = script.get("loop", False)
        self.smooth = script.get("interpolation", "minimum_jerk") == "catmull_rom"
        self.tangents = [self._tangent(k) for k in range(len(frames))]

    def _tangent(self, k):
        last = len(self.time) - 1
        before, after, span = k - 1, k + 1, None
        if k in (0, last):
            if not self.loop or last < 2:
                return np.zeros(3), np.zeros(3)
            before, after = last - 1, 1
            span = self.time[1] - self.time[0] + self.time[last] - self.time[last - 1]
        span = span or self.time[after] - self.time[before]
        return (self.x[after] - self.x[before]) / span, rotation_between(self.q[before], self.q[after]) / span

    def at(self, t):
        """The offset from the home pose at a time: position, quaternion."""
        if self.loop and t > 0:
            t = np.fmod(t, self.time[-1])
        if t <= 0 or t >= self.time[-1]:
            k = 0 if t <= 0 else -1
            return self.x[k], self.q[k]
        k = int(np.searchsorted(self.time, t, side="right")) - 1
        span = self.time[k + 1] - self.time[k]
        s = (t - self.time[k]) / span
        way, turn = self.x[k + 1] - self.x[k], rotation_between(self.q[k], self.q[k + 1])
        if self.smooth:
            (va, wa), (vb, wb) = self.tangents[k], self.tangents[k + 1]
            h1, h2, h3 = s * s * (3 - 2 * s), s * (1 - s) ** 2, s * s * (s - 1)
            x = h1 * way + span * (h2 * va + h3 * vb)
            r = h1 * turn + h2 * wa * span + h3 * rotation_rate(turn, wb) * span
        else:
            m = s ** 3 * (10 + s * (6 * s - 15))
            x, r = m * way, m * turn
        return self.x[k] + x, times(rotation_by(r), self.q[k])


def orientation_of(table):
    """The orientation of a body's table in a scene file."""
    if "rotation_deg" in table:
        axis = np.array(table["rotation_deg"]["axis"], dtype=float)
        return rotation_by(np.radians(table["rotation_deg"]["angle"]) * axis / np.linalg.norm(axis))
    q = np.array(table.get("orientation", [0.0, 0.0, 0.0, 1.0]), dtype=float)
    return q / np.linalg.norm(q)


def home_of(scene, proxy):
    """Where the handle of a [[proxy]] starts: position, quaternion."""
    body = next(b for b in scene["body"] if b["name"] == proxy["body"])
    q = orientation_of(body)
    return np.array(body.get("position", [0.0, 0.0, 0.0])) + rotate(q, np.array(proxy.get("handle", [0.0, 0.0, 0.0]))), q


def write_path(scene, proxy, script_file, duration, path, rate_hz=1000):
    """Writes the path of a hand script that moves the tool of a [[proxy]] from where it starts."""
    curve = Trajectory(tomllib.loads(script_file.read_text(encoding="utf-8")))
    home, upright = home_of(scene, proxy)
    rows = ["time,x,y,z,qx,qy,qz,qw"]
    for k in range(int(round(duration * rate_hz)) + 1):
        x, q = curve.at(k / rate_hz)
        rows.append(",".join(f"{v:.9g}" for v in [k / rate_hz, *(home + x), *times(q, upright)]))
    path.write_text("\n".join(rows) + "\n")
