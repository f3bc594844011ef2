#!/usr/bin/python3
"""Tests the arithmetic of tools/tradeoff against closed forms."""

import pathlib
import sys
import tomllib
import unittest

import numpy as np

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent.parent / "tools"))

from tradeoff_lib import hand, judge, levels, measures, runs, scenes, waves  # noqa: E402

RATE = 1000.0
TIME = np.arange(4000) / RATE


def tone(hertz, amplitude=1.0):
    return amplitude * np.sin(2 * np.pi * hertz * TIME + 0.3)[:, None]


class Lowpass(unittest.TestCase):
    def test_gain_of_tones(self):
        for hertz, gain in ((1, 1 / (1 + 30.0 ** -4)), (30, 0.5), (60, 1 / 17), (300, 1 / 10001)):
            smooth = measures.lowpass(tone(hertz), RATE, 30)
            middle = slice(1000, 3000)
            self.assertLess(measures.rms(smooth[middle] - gain * tone(hertz)[middle]), 2e-4, hertz)

    def test_lines_and_constants_pass(self):
        line = np.column_stack([2 + 3 * TIME, np.full_like(TIME, 7.0)])
        self.assertLess(np.abs(measures.lowpass(line, RATE) - line).max(), 1e-6)

    def test_short_series(self):
        self.assertEqual(measures.lowpass(np.ones((3, 2)), RATE).shape, (3, 2))


class Differences(unittest.TestCase):
    def test_a_tenth_too_strong(self):
        found = measures.difference(1.1 * tone(2), tone(2))
        for key, value in (("rms", 0.1), ("peak", 0.1), ("rms_jnd", 0.1 / 0.07), ("peak_jnd", 0.1 / 0.07)):
            self.assertAlmostEqual(found[key], value, 9)

    def test_nothing_to_measure_against(self):
        self.assertIsNone(measures.difference(tone(2), 0 * tone(2))["rms_jnd"])

    def test_vectors_count_by_their_length(self):
        self.assertAlmostEqual(measures.rms([[3, 4], [0, 0]]), 5 / np.sqrt(2))


class Refinement(unittest.TestCase):
    def series(self, spacings, order, limit=None):
        limit = tone(1) if limit is None else limit
        return [limit + h ** order * tone(3, 20.0) for h in spacings]

    def test_order_and_limit_are_found(self):
        for order in (0.7, 1.0, 1.6, 2.0):
            for spacings in ([0.04, 0.032, 0.0256], [0.05, 0.03, 0.02, 0.01]):
                limit, found, uncertainty, _ = measures.limit_of(spacings, self.series(spacings, order))
                self.assertAlmostEqual(found, order, 4)
                self.assertLess(measures.rms(limit - tone(1)), 1e-5)
                if len(spacings) == 4:
                    self.assertLess(uncertainty, 1e-5)

    def test_a_run_that_strays_moves_the_fit_less(self):
        spacings = [0.08, 0.064, 0.0512, 0.041]
        series = self.series(spacings, 1.0)
        series[-1] = series[-1] + 0.05 * tone(5)
        richardson, _ = measures.extrapolated(spacings[-3:], series[-3:])
        fit, _ = measures.extrapolated(spacings, series)
        self.assertLess(measures.rms(fit - tone(1)), 0.8 * measures.rms(richardson - tone(1)))

    def test_three_spacings_give_the_grid_convergence_index(self):
        spacings = [0.4, 0.2, 0.1]
        _, _, uncertainty, _ = measures.limit_of(spacings, self.series(spacings, 1.0))
        self.assertAlmostEqual(uncertainty, 1.25 * 0.1 * 20 * measures.rms(tone(3)) / measures.rms(tone(1)), 6)

    def test_differences_that_grow_show_no_order(self):
        series = [tone(1), tone(1) + 0.1 * tone(2), tone(1) - 0.3 * tone(2)]
        limit, order, uncertainty, _ = measures.limit_of([0.4, 0.2, 0.1], series)
        self.assertIsNone(order)
        self.assertTrue((limit == series[-1]).all())
        self.assertAlmostEqual(uncertainty, 0.4 * measures.rms(tone(2)) / measures.rms(series[-1]), 9)

    def test_what_moves_on_as_before_is_not_extrapolated(self):
        spacings = [0.0512, 0.041, 0.0328, 0.0262, 0.021]
        series = [tone(1) + 0.1 * np.log(h) * tone(3) for h in spacings]
        limit, order, uncertainty, _ = measures.limit_of(spacings, series)
        self.assertIsNone(order)
        self.assertTrue((limit == series[-1]).all())
        self.assertAlmostEqual(uncertainty, 0.1 * np.log(0.0262 / 0.021) * measures.rms(tone(3)) / measures.rms(limit), 9)

    def test_what_does_not_change_is_certain(self):
        _, _, uncertainty, _ = measures.limit_of([0.4, 0.2, 0.1], [tone(1)] * 3)
        self.assertEqual(uncertainty, 0)


class Dominance(unittest.TestCase):
    def test_by_cost_and_error(self):
        points = [(1, 10), (2, 5), (2, 7), (3, 5), (4, 1), (None, None), (5, 0.5), (9, 2)]
        self.assertEqual(measures.dominators(points), [None, None, 1, 1, None, None, None, 6])

    def test_equals_do_not_dominate_each_other(self):
        self.assertEqual(measures.dominators([(1, 1), (1, 1)]), [None, None])


class Levels(unittest.TestCase):
    def test_by_the_rule(self):
        # (0.001, 0.06): the cheapest below 7 %; between it and the quick one (0.0008, 0.08) lies furthest below the line
        front = [(1e-4, 0.9), (4e-4, 0.5), (6e-4, 0.4), (8e-4, 0.08), (1e-3, 0.06), (4e-3, 0.01)]
        self.assertEqual(levels.by_rule(front), {"fast": 1, "balanced": 3, "accurate": 4})

    def test_where_no_error_is_small_time_must_be_worth_it(self):
        front = [(1e-3, 0.9), (2e-3, 0.5), (4e-3, 0.3), (8e-3, 0.29)]
        self.assertEqual(levels.by_rule(front), {"fast": 0, "balanced": 1, "accurate": 2})

    def test_one_point_is_all_levels(self):
        self.assertEqual(levels.by_rule([(1e-4, 0.01)]), {"fast": 0, "balanced": 0, "accurate": 0})


class Errors(unittest.TestCase):
    def run_of(self, force, noise=0.0, at_start=5.0):
        totals = np.linspace(0, 2, 200)[:, None]
        return {"force": (RATE, TIME, force + tone(200, noise)), "torque": (RATE, TIME, force), "place": (RATE, TIME, 0 * force),
                "energy": (50.0, None, at_start + totals), "momentum": (50.0, None, totals), "volume": (50.0, None, 2 - 0.1 * totals),
                "penetration": (50.0, None, 1e-3 * totals)}

    def test_are_those_that_were_put_in(self):
        reference = judge.on_grid(self.run_of(tone(2)), TIME)
        found = judge.errors(self.run_of(1.2 * tone(2), noise=0.5, at_start=6.0), reference, TIME)
        self.assertAlmostEqual(found["force"]["rms"], 0.2, 2)
        self.assertAlmostEqual(found["noise_N"], 0.5 / np.sqrt(2), 2)
        self.assertAlmostEqual(found["volume"], 0.1, 6)
        self.assertAlmostEqual(found["penetration_mm"], 2, 6)
        self.assertAlmostEqual(found["energy"], 0, 9)
        self.assertAlmostEqual(found["momentum"], 0, 9)
        self.assertIsNone(found["temperature_K"])
        self.assertIsNone(found["wave_speed"])

    def test_of_two_waves_the_worse_counts(self):
        reference = judge.on_grid(self.run_of(tone(2)), TIME)
        for speeds, worst in (({"trough": -0.03, "bar": 0.01}, 0.03), ({"trough": None, "bar": 0.02}, 0.02), ({"bar": None}, None)):
            self.assertEqual(judge.errors(self.run_of(tone(2)), reference, TIME, speeds)["wave_speed"], worst)

    def test_another_rate_is_the_same_motion(self):
        reference = judge.on_grid(self.run_of(tone(2)), TIME[:3900])
        half = {name: (RATE / 2, TIME[::2], tone(2)[::2]) for name in ("force", "torque", "place")}
        reference["place"] = tone(2)[:3900]
        found = judge.errors(half, reference, TIME[:3900])
        self.assertLess(found["force"]["rms"], 1e-3)
        self.assertLess(found["place_mm"], 0.1)


class Waves(unittest.TestCase):
    scene = {"body": [{"type": "fluid", "material": "oil"}, {"type": "elastic", "material": "jelly"}],
             "material": [{"name": "oil", "density": 1000, "viscosity": 0.05},
                          {"name": "jelly", "density": 1000, "young_modulus": 2e4, "poisson_ratio": 0.4}]}

    def test_periods(self):
        for hertz in (0.8, 2.3):
            found = waves.period_of(TIME, np.exp(-0.2 * TIME) * tone(hertz)[:, 0])
            self.assertAlmostEqual(found, 1 / hertz, 5)
        self.assertIsNone(waves.period_of(TIME[:100], tone(1)[:100, 0]))

    def test_by_theory(self):
        found = waves.waves_of(self.scene, 0.02, 0.02)
        self.assertAlmostEqual(found["trough"][1], 0.8875, 4)  # a trough of 0.48 m, 0.16 m deep
        self.assertAlmostEqual(found["bar"][1], 4 * 0.64 / np.sqrt(20), 2)
        thick = {"body": self.scene["body"], "material": [m | {"viscosity": 50, "damping": 1e4} for m in self.scene["material"]]}
        self.assertEqual(waves.waves_of(thick, 0.02, 0.02), {})
        self.assertEqual(waves.waves_of({"body": [{"type": "rigid", "material": "oil"}]}, 0.02, 0.02), {})

    def test_lengths_are_whole_multiples(self):
        self.assertAlmostEqual(waves.whole(0.48, 0.035), 0.49)
        self.assertAlmostEqual(waves.whole(0.01, 0.035), 0.07)

    def test_numerics_are_those_of_the_scene(self):
        kept = scenes.Definition("tray_fluid").toml["numerics"]
        for text, _ in waves.waves_of(scenes.Definition("tray_fluid").toml, 0.02, 0.03).values():
            self.assertEqual(tomllib.loads(text)["numerics"], kept | {"spacing": 1.0})


class Homes(unittest.TestCase):
    def test_handle_of_a_turned_body(self):
        scene = {"body": [{"name": "tool", "position": [1, 2, 3], "rotation_deg": {"axis": [0, 0, 2], "angle": 90}}]}
        place, _ = hand.home_of(scene, {"body": "tool", "handle": [0.5, 0, 0]})
        self.assertLess(np.abs(place - [1, 2.5, 3]).max(), 1e-12)


class Grids(unittest.TestCase):
    def test_each_medium_has_twenty_points_and_each_is_another(self):
        for scene in scenes.ALL.values():
            points = scenes.Definition(scene).points("full", False)
            self.assertGreaterEqual(len(points), 20, scene)
            self.assertEqual(len({scenes.label(p) for p in points}), len(points), scene)
            self.assertEqual(sum(p["level"] is not None for p in points), 3, scene)

    def test_a_reference_serves_as_long_as_only_levels_change(self):
        tray = scenes.Definition("tray_fluid")
        before = runs.digest(tray.of_reference(), [])
        tray.toml["numerics"]["spacing"] = {"fast": 0.05, "balanced": 0.02, "accurate": 0.01}
        tray.toml["numerics"]["support_over_spacing"] = {"fast": 2.2}
        self.assertEqual(runs.digest(tray.of_reference(), []), before)
        tray.toml["numerics"]["max_speed"] = 3.0
        self.assertNotEqual(runs.digest(tray.of_reference(), []), before)


if __name__ == "__main__":
    unittest.main()
