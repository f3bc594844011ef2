"""How fast waves run in a scene's matter: a small scene of one wave, computed with a point's numerics, against theory.
A fluid sloshes in a trough, endless across, that gravity begins to tilt; an elastic bar swings along its axis, one end clamped, once gravity
begins to pull. Lengths follow from the scene's own spacing, and are whole multiples of the point's."""

import json
import math

GRAVITY = 9.81  # [m/s^2]
TILT = 0.02  # of gravity along the trough
STRETCH = 2e-3  # of the bar where it is clamped
PERIODS = 2.2  # watched: four zeros of the momentum
FAINT = 0.1  # of the first swing: what is less is no wave any more
ROWS = 60  # of the totals in a period
MOST_DAMPING = 0.1  # share of critical damping from which on there is no wave to speak of
LENGTH, DEPTH = 24, 8  # of the trough, in spacings of the scene at level balanced
ACROSS = 14  # of the point's spacings, after which the trough repeats itself: three support radii of up to 4 of them
BAR, THICKNESS = 32, 6


def whole(length, spacing, least=2):
    return spacing * max(least, round(length / spacing))


def first(toml, kind):
    """The material of the first body of a type, or None."""
    names = [body.get("material") for body in toml.get("body", []) if body.get("type") == kind]
    return next((m for m in toml.get("material", []) if names and m.get("name") == names[0]), None)


def written(value):
    """A value of TOML, a table inline."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key} = {written(one)}" for key, one in value.items()) + "}"
    return json.dumps(value)


def scene_text(toml, name, gravity, size, material, bodies, periodic=False):
    """A scene in a domain of this size around the origin, periodic along y if asked for, with the numerics of another."""
    kept = {key: value for key, value in toml.get("numerics", {}).items() if key != "spacing"}
    lines = ["[scene]", f'name = "{name}"', f"gravity = {json.dumps(gravity)}", "", "[domain]",
             f"min = {json.dumps([-v / 2 for v in size])}", f"max = {json.dumps([v / 2 for v in size])}",
             f"periodic = {json.dumps([False, periodic, False])}", "", "[numerics]", "spacing = 1.0",
             *(f"{key} = {written(value)}" for key, value in kept.items()),
             "", "[[material]]", 'name = "matter"', *(f"{key} = {json.dumps(value)}" for key, value in material.items()),
             "", "[[material]]", 'name = "wall"', "density = 7800", f"viscosity = {material.get('viscosity', 0.0)!r}", ""]
    for kind, matter, center, extent, hole, more in bodies:
        lines += ["[[body]]", f'name = "{kind}"', f'type = "{kind}"', f'material = "{matter}"', *more,
                  "[[body.shape]]", 'type = "box"', f"size = {json.dumps(extent)}", f"position = {json.dumps(center)}"]
        if hole:
            lines += ["[[body.shape]]", 'type = "box"', f"size = {json.dumps(hole[1])}", f"position = {json.dumps(hole[0])}",
                      "subtract = true"]
    return "\n".join(lines) + "\n"


def trough(toml, middle, spacing):
    """(scene, period [s]) of the lowest mode of a trough of the scene's fluid; None without a fluid that sloshes."""
    fluid = first(toml, "fluid")
    if fluid is None:
        return None
    length, depth, across = whole(LENGTH * middle, spacing), whole(DEPTH * middle, spacing), ACROSS * spacing
    k = math.pi / length
    rate = math.sqrt(GRAVITY * k * math.tanh(k * depth))
    if 2 * fluid.get("viscosity", 0.0) / fluid["density"] * k * k > MOST_DAMPING * rate:
        return None
    wall, height = 4 * spacing, 1.5 * depth
    outer = [length + 2 * wall, across, height + wall]
    material = {key: fluid[key] for key in ("density", "viscosity") if key in fluid}
    hole = [0.0, 0.0, height], [length, across, 2 * height]
    bodies = [("static", "wall", [0.0, 0.0, (height - wall) / 2], outer, hole, []),
              ("fluid", "matter", [0.0, 0.0, depth / 2], [length, across, depth], None, [])]
    gravity = [TILT * GRAVITY, 0.0, -math.sqrt(1 - TILT ** 2) * GRAVITY]
    size = [2 * length, across, 4 * height]
    return scene_text(toml, "trough", gravity, size, material, bodies, periodic=True), 2 * math.pi / rate


def bar(toml, middle, spacing):
    """(scene, period [s]) of the lowest longitudinal mode of a clamped bar of the scene's elastic matter; None without
    any, or where it is damped too much. With Rayleigh's correction for its lateral inertia."""
    elastic = first(toml, "elastic")
    if elastic is None or "young_modulus" not in elastic:
        return None
    length, thickness = whole(BAR * middle, spacing), whole(THICKNESS * middle, spacing)
    speed = math.sqrt(elastic["young_modulus"] / elastic["density"])
    k = math.pi / (2 * length)
    aside = elastic.get("poisson_ratio", 0.0) * k * thickness
    rate = speed * k / math.sqrt(1 + aside ** 2 / 6)
    if elastic.get("damping", 0.0) * rate / (2 * elastic["young_modulus"]) > MOST_DAMPING:
        return None
    clamp = 4 * spacing
    material = {key: elastic[key] for key in ("density", "young_modulus", "poisson_ratio", "damping") if key in elastic}
    bodies = [("static", "wall", [-clamp / 2, 0.0, 0.0], [clamp, thickness, thickness], None, []),
              ("elastic", "matter", [length / 2, 0.0, 0.0], [length, thickness, thickness], None, ['bonded_to = "static"'])]
    gravity = [STRETCH * speed ** 2 / length, 0.0, 0.0]
    return scene_text(toml, "bar", gravity, [4 * length] * 3, material, bodies), 2 * math.pi / rate


def waves_of(toml, middle, spacing):
    """By name, (scene, period by theory [s]) of the waves that the scene's matter has. middle, spacing: of the scene at
    level balanced, and of the point [m]."""
    found = {"trough": trough(toml, middle, spacing), "bar": bar(toml, middle, spacing)}
    return {name: wave for name, wave in found.items() if wave}


def period_of(times, values):
    """The period of an oscillation that dies out, from the first to the last of its zeros after the start, as long as it
    swings; None with fewer than three."""
    zeros, swing, swings = [], 0.0, []
    for t, u, v, w in zip(times, times[1:], values, values[1:]):
        swing = max(swing, abs(v))
        if v * w >= 0:
            continue
        swings.append(swing)
        if swing < FAINT * swings[0]:
            break
        zeros.append(t - v * (u - t) / (w - v))
        swing = 0.0
    return 2 * (zeros[-1] - zeros[0]) / (len(zeros) - 1) if len(zeros) > 2 else None
