"""What tools/tradeoff tries: for each scene its medium, its hands and the points of its grid."""

import pathlib
import tomllib

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
LEVELS = ("fast", "balanced", "accurate")
MEDIA = ("fluid", "elastic", "rigid", "changing", "mixed")
ALL = {"fluid": "tray_fluid", "elastic": "tray_elastic", "rigid": "tray_rigid", "changing": "butter", "mixed": "mixed"}
DURATIONS = {"tray_fluid": 3.5, "tray_elastic": 2.6, "tray_rigid": 2.1, "butter": 5.0, "mixed": 4.8}
HANDS = pathlib.Path(__file__).resolve().parent / "hands"

SUPPORT, ALPHA = "numerics.support_over_spacing", "numerics.artificial_viscosity"
METHOD = "scene.method"
SKIN, ROUNDS = "numerics.skin_over_spacing", "numerics.elastic_rounds"
BASE = {"scene.accuracy": "accurate"}  # what a point does not set is as at this level


def flowing(support, alpha):
    return {SUPPORT: support, ALPHA: alpha}


# By medium: rows of settings, each tried at every spacing; single changes, tried at one spacing beside the first row. All
# values are texts, as on the command line. Spacings are shares of the scene's at level balanced.
GRIDS = {
    "fluid": {
        "spacings": (2, 1.75, 1.5, 1.25, 1, 0.8),
        "rows": (flowing("2.7", "0"), flowing("2.7", "0.02"), flowing("2", "0"), flowing("2", "0.02"), flowing("2", "0.1")),
        "singles": ({SUPPORT: "3.5"}, {"numerics.density_diffusion": "0"}, {"numerics.density_diffusion": "0.3"},
                    {"numerics.safety": "0.25"}, {"numerics.safety": "0.9"}, {"scene.rate_hz": "500"},
                    {"scene.rate_hz": "2000"}, {"scene.accuracy": "fast"}, {"numerics.viscosity": "explicit"},
                    {SKIN: "0.05"}, {SKIN: "0.5"}, {METHOD: "paper"}),
        "single_at": 1.25},
    "elastic": {
        "spacings": (2, 1.75, 1.5, 1.25, 1, 0.8),
        "rows": ({"numerics.elastic_solver": "auto"}, {"numerics.elastic_solver": "explicit"},
                 {"numerics.elastic_solver": "explicit", SUPPORT: "3"}),
        "singles": ({"numerics.safety": "0.25"}, {"numerics.safety": "0.9"}, {"numerics.elastic_solver": "implicit"},
                    {"numerics.elastic_solver": "implicit", "numerics.safety": "0.25"},
                    {"numerics.elastic_solver": "implicit", ROUNDS: "5"}, {"numerics.elastic_solver": "implicit", ROUNDS: "40"},
                    {"scene.rate_hz": "500"},
                    {"scene.rate_hz": "2000"}, {METHOD: "paper"}),
        "single_at": 1.25},
    "rigid": {
        "spacings": (1, 0.8, 0.6, 0.4, 0.2),
        "rows": ({"numerics.safety": "0.5"}, {"numerics.safety": "0.9"}, {"numerics.safety": "0.25"}),
        "singles": ({"numerics.safety": "0.1"}, {"scene.rate_hz": "500"}, {"scene.rate_hz": "2000"},
                    {"scene.rate_hz": "4000"}, {"scene.rate_hz": "500", "numerics.safety": "0.9"},
                    {METHOD: "paper"}),
        "single_at": 1},
    "changing": {
        "spacings": (1.6, 1.33, 1.15, 1, 0.8),
        "rows": (flowing("2.7", "0.02"), flowing("2", "0.02"), flowing("2", "0.1")),
        "singles": ({"heat.rate_hz": "20"}, {"heat.rate_hz": "50"}, {"heat.rate_hz": "200"}, {"numerics.safety": "0.25"},
                    {"numerics.safety": "0.9"}, {"scene.rate_hz": "500"}, {ALPHA: "0"}, {"scene.accuracy": "fast"},
                    {METHOD: "paper"}),
        "single_at": 1.15},
}
GRIDS["mixed"] = GRIDS["changing"] | {"spacings": (2, 1.75, 1.5, 1.25, 1), "single_at": 1.25}
# What a reference is refined with, and by how much at a time. A fluid by itself has no artificial viscosity, which would
# have to vanish with the spacing, too: the force of tray_fluid at 8.2 mm is then 3.9 % from that at 6.6 mm, which is 5.2 %
# from what runs with alpha 0.02 down to 5.2 mm are extrapolated to.
REFERENCE = {"fluid": flowing("3", "0"), "elastic": {"numerics.elastic_solver": "explicit"},
             "rigid": {"numerics.safety": "0.25"}, "changing": flowing("3", "0.02"), "mixed": flowing("3", "0.02")}
REFINEMENT = 0.8
CPU_SPACINGS, GPU_SPACINGS = (2.5,), (0.64, 0.5, 0.4)  # more of them, where they can be felt in real time
COARSEST_REFERENCE = {"fluid": 1.25, "elastic": 1.25, "rigid": 1, "changing": 1.33, "mixed": 1.6}


class Unknown(Exception):
    """What a person asked for is not there; one sentence."""


class Definition:
    """A scene, and what is tried with it."""

    def __init__(self, name):
        self.file = next((p for p in (pathlib.Path(name), ROOT / "config/scenes" / f"{name}.toml") if p.is_file()), None)
        if self.file is None:
            raise Unknown(f"{name}: no such scene; a file or the name of one in config/scenes was expected")
        try:
            self.toml = tomllib.loads(self.file.read_text(encoding="utf-8"))
        except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
            raise Unknown(f"{self.file}: {error}") from error
        self.name = self.file.stem
        self.medium = next((m for m, scene in ALL.items() if scene == self.name), None) or self._medium()
        self.duration = DURATIONS.get(self.name, self.toml.get("scene", {}).get("duration", 10.0))
        if not self.toml.get("proxy"):
            raise Unknown(f"{self.file}: the scene has no [[proxy]], expected one: a trade is judged by what a hand feels")

    def _medium(self):
        kinds = {body.get("type") for body in self.toml.get("body", [])}
        if any("temperature" in body for body in self.toml.get("body", [])):
            return "changing"
        if {"fluid", "elastic"} <= kinds:
            return "mixed"
        return "fluid" if "fluid" in kinds else "elastic" if "elastic" in kinds else "rigid"

    def spacing(self, level):
        """The scene's spacing at a level [m]; None where it has none."""
        given = self.toml.get("numerics", {}).get("spacing")
        return given.get(level) if isinstance(given, dict) else given

    def of_reference(self):
        """The scene without what the runs of its reference choose: other levels leave the reference what it is."""
        chosen = {"spacing", *(key.removeprefix("numerics.") for key in REFERENCE[self.medium])}
        return self.toml | {"numerics": {k: v for k, v in self.toml.get("numerics", {}).items() if k not in chosen}}

    def hand_files(self):
        """By device, the script that moves it: the one made for this comparison, else the hand that the scene names."""
        files = {}
        for proxy in self.toml["proxy"]:
            name = proxy.get("hand", "still")
            own = [HANDS / f"{self.name}.toml"] if len(self.toml["proxy"]) == 1 else []
            near = [self.file.parent / name, self.file.parent.parent / "hands" / f"{name}.toml"]
            found = [p for p in (*own, *near, ROOT / "config/hands" / f"{name}.toml") if p.is_file()]
            if not found:
                raise Unknown(f"{self.file}: there is no hand '{name}'")
            files[proxy.get("device", 0)] = found[0]
        return files

    def reference_spacings(self):
        """The spacings of the reference from the coarsest on, without end."""
        spacing = COARSEST_REFERENCE[self.medium] * self.middle()
        while True:
            yield float(f"{spacing:.4g}")
            spacing *= REFINEMENT

    def middle(self):
        spacing = self.spacing("balanced") or self.spacing("accurate") or self.spacing("fast")
        if not spacing:
            raise Unknown(f"{self.file}: numerics.spacing is missing")
        return spacing

    def points(self, size, double, gpu=False):
        """The points of the grid: dicts with spacing [m], set, level (or None) and precision."""
        grid, middle = GRIDS[self.medium], self.middle()
        quick = size == "quick"
        more = () if self.medium == "rigid" else GPU_SPACINGS if gpu else CPU_SPACINGS
        spacings = grid["spacings"][:3] if quick else more + grid["spacings"]
        rows = grid["rows"][:1] + grid["rows"][-1:] if quick else grid["rows"]
        singles = grid["singles"][-1:] if quick else grid["singles"]
        found = [point(spacing, {"scene.accuracy": level}, level)
                 for level in LEVELS if (spacing := self.spacing(level))]
        found += [point(share * middle, BASE | row) for row in rows for share in spacings]
        at = grid["single_at"] * middle
        found += [point(at, BASE | rows[0] | single) for single in singles]
        if double:
            found.append(point(at, BASE | rows[0]) | {"precision": "double"})
        return found


def point(spacing, settings, level=None):
    return {"spacing_m": float(f"{spacing:.4g}"), "set": settings, "level": level, "precision": "float"}


def label(p):
    """A point in a few words."""
    if p["level"]:
        return f"level {p['level']}"
    short = {SUPPORT: "H {} dx", ALPHA: "alpha {}", "numerics.density_diffusion": "delta {}", "numerics.safety": "safety {}",
             SKIN: "skin {} dx", ROUNDS: "{} rounds", "scene.rate_hz": "{} Hz", "numerics.elastic_solver": "{}", "heat.rate_hz": "heat at {} Hz",
             METHOD: "method {}", "numerics.viscosity": "viscosity {}", "scene.accuracy": "otherwise as {}"}
    words = [short.get(key, key + " {}").format(value) for key, value in p["set"].items()
             if (key, value) != ("scene.accuracy", "accurate")]
    if p["precision"] == "double":
        words.append("in double")
    return f"{1e3 * p['spacing_m']:.4g} mm" + "".join(f", {w}" for w in words)
