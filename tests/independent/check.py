#!/usr/bin/env python3
"""Tests of the generator and the judge, with values worked out by hand."""
import json
import pathlib
import tempfile
import unittest

import numpy as np

import cases
import judge
import motion
import pixels
import ranges
import skin


def numbers_of(seed, **given):
    return ranges.draw(np.random.default_rng(seed), given)


class TheSkin(unittest.TestCase):
    def test_the_depth_around_a_contact_is_that_of_hertz(self):
        self.assertEqual(skin.hertz(np.array(0.0)), 1)
        self.assertAlmostEqual(float(skin.hertz(np.array(1.0))), 0.5)
        self.assertAlmostEqual(float(skin.hertz(np.array(1.0 + 1e-9))), 0.5, 6)
        self.assertAlmostEqual(float(skin.hertz(np.array(50.0)) * 50), 4 / (3 * np.pi), 3)  # a point load from afar

    def test_what_sticks_moves_as_a_whole_by_the_shear(self):
        surface = skin.Skin(numbers_of(1, relief_mm=0.0), np.random.default_rng(1))
        surface.border[:] = 1
        n = surface.numbers
        still = np.array(surface.fields(n["depth_mm"], 0.0, 1.0, 0, 0)[:2])
        pulled = np.array(surface.fields(n["depth_mm"], 0.36, 1.0, 0, 0)[:2]) - still
        sticks = surface.radius < 0.8 * n["patch_mm"]  # sqrt(1 - 0.36) of the contact's radius
        wanted = 0.36 * n["px_per_mm"] * surface.lift_direction
        np.testing.assert_allclose(pulled[0][sticks], wanted[0], atol=1e-4)
        np.testing.assert_allclose(pulled[1][sticks], wanted[1], atol=1e-4)
        self.assertLess(np.hypot(*pulled)[surface.radius > n["patch_mm"]].max(), 0.36 * n["px_per_mm"])

    def test_friction_has_the_drawn_mean_from_the_first_contact_on(self):
        n = numbers_of(3, friction_spread=0.0, shear_mm=0.5, depth_mm=1.0)
        base = np.linspace(0, 3, 4000)
        shear, limit, gross, _ = motion.sheared(base, np.ones(4000), n, np.random.default_rng(1), None)
        np.testing.assert_allclose(limit, 0.5)
        np.testing.assert_allclose(shear[base < 0.499], base[base < 0.499], atol=1e-9)
        self.assertEqual(gross[base < 0.499].max(), 0)
        self.assertEqual(gross[base > 0.51].min(), 1)
        self.assertLess(shear.max(), 0.51)


class TheArm(unittest.TestCase):
    def test_a_move_takes_its_duration_and_ends_at_its_travel(self):
        t = np.arange(0, 3, motion.STEP)
        travel = motion.ramp(t, 1.0, -30, 50, 500)
        self.assertAlmostEqual(motion.duration(-30, 50, 500), 0.7)  # 0.1 s faster, 0.5 s even, 0.1 s slower
        self.assertEqual(np.abs(travel[t <= 1.0]).max(), 0)
        np.testing.assert_allclose(travel[t >= 1.7], -30)

    def test_play_swallows_the_start_of_each_move(self):
        np.testing.assert_allclose(motion.backlash(np.array([0, 0.05, 0.2, 0.3, 0.25, 0.05]), 0.1), [0, 0, 0.1, 0.2, 0.2, 0.05])

    def test_truths_begin_with_the_motion(self):
        for name in ("ordinary", "second-press", "two-lifts", "uneven-press"):
            rng = np.random.default_rng(5)
            scene = cases.CASES[name](numbers_of(5), rng)
            m = scene.motion
            touched = m.t[np.flatnonzero(m.depth > 0)[0]]
            self.assertAlmostEqual(m.truths[0]["start"], touched, delta=2 * motion.STEP)
            slip = next(x for x in m.truths if x["what"] == "slip")
            before = (m.t > m.lift_start) & (m.t < slip["start"])
            self.assertLess(np.abs(np.diff(m.shear[before], prepend=m.shear[before][:1])).max(initial=0), 2e-6)
            self.assertGreater(slip["gross"], slip["start"])


class ThePixels(unittest.TestCase):
    def see(self, pictures, background=None):
        numbers = numbers_of(1, threshold_on=0.25, threshold_off=0.25, threshold_spread=0.0, photoreceptor_s=1e-9)
        camera = pixels.Pixels(numbers, np.random.default_rng(1), background)
        camera.dither[:] = 0.5  # as far from ON as from OFF
        for t, value in pictures:
            camera.see(t, np.full((ranges.HEIGHT, ranges.WIDTH), value, np.float32))
        return camera.events()

    def test_events_lie_where_the_logarithm_crosses_its_thresholds(self):
        t, pixel, on = self.see([(0, 0.0), (1, 0.0), (2, 1.1)])
        np.testing.assert_allclose(np.sort(t[pixel == 7]), 1 + np.array([0.25, 0.5, 0.75, 1.0]) / 1.1, atol=1e-6)
        self.assertTrue(on.all())

    def test_a_pixel_begins_between_its_thresholds(self):
        camera = pixels.Pixels(numbers_of(1), np.random.default_rng(1))
        camera.dither[:] = camera.dither.max()
        for t in range(3):
            camera.see(t, np.zeros((ranges.HEIGHT, ranges.WIDTH), np.float32))
        self.assertEqual(len(camera.events()[0]), 0)
        self.assertLess(camera.dither.max(), 1 - 1e-4)

    def test_a_small_swing_makes_no_events(self):
        self.assertEqual(len(self.see([(0, 0.0), (1, 0.2), (2, -0.2), (3, 0.2)])[0]), 0)

    def test_noise_resets_its_pixel(self):
        _, pixel, _ = self.see([(0, 0.0), (1, 0.2), (2, 0.3)], (np.array([1.5]), np.array([7]), np.array([True])))
        self.assertEqual(np.count_nonzero(pixel == 7), 0)  # 0.1 since the noise
        self.assertEqual(np.count_nonzero(pixel == 8), 1)

    def test_a_pixel_is_blind_after_each_event(self):
        keep = pixels.rest_between(np.array([1, 1, 1, 1, 2]), np.array([0, 0.4, 0.9, 1.3, 1.4]), 0.5)
        np.testing.assert_array_equal(keep, [0, 2, 4])

    def test_stamps_tell_the_read_out_and_the_column(self):
        n, rng = numbers_of(1, readout_us=195.163, noise_hz_per_px=0.3), np.random.default_rng(1)
        background, _ = pixels.noise(n, rng, 1.0)
        table = pixels.read_out(n, rng, (np.zeros(0), np.zeros(0, int), np.zeros(0, bool)), background, 10**15)
        phase = (table["t_us"] - 10**15 - (ranges.WIDTH - 1 - table["x"]) * ranges.COLUMN_US) / 195.163
        self.assertGreater(abs(np.exp(2j * np.pi * phase).mean()), 0.999)
        self.assertTrue((np.diff(table["t_us"]) >= 0).all())


class TheJudge(unittest.TestCase):
    def run_of(self, truths, labels, flags=(), robot=None, remarks=()):
        """`robot`: the error [us] of its clock in the middle of its log and the half-width that the labels state."""
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder) / "cup" / "01"
            folder.mkdir(parents=True)
            full = [{"what": c, "class": c, "labelled": True, "start_us": s, "end_us": e, "first_event_us": s, "gross_us": None}
                    for c, s, e in truths]
            parameters = {"case": "ordinary", "press_speeds_mm_s": [5.0], "visible_us": [s for _, s, _ in truths]}
            clock = lambda offset, half: {"offset_us": offset, "offset_low_us": offset - half, "offset_high_us": offset + half, "drift_ppm": 100.0,
                                          "reference_us": 1_000_000, "method": "first shear (1)"}
            (folder / "robot.csv").write_text("timestamp x\n1.0 0\n2.0 0\n3.0 0\n")
            clocks = {"robot": robot and clock(7_000_000 + robot[0], robot[1]), "video": None}
            true = {"robot": robot and {"offset_us": 7_000_000, "drift_ppm": 100.0, "reference_us": 1_000_000}, "video": None}
            (folder / "truth.json").write_text(json.dumps({"intervals": full, "parameters": parameters, "clocks": true}))
            made = [{"class": c, "start_us": s, "end_us": e, "start_low_us": s - 9, "start_high_us": s + 9} for c, s, e in labels]
            marks = [{"interval": i, "reason": r, "confirmed": False} for i, r in flags]
            (folder / "labels.json").write_text(json.dumps({"intervals": made, "flags": marks, "clocks": clocks, "remarks": list(remarks)}))
            return judge.judge_run(folder)

    def test_a_label_is_matched_once_and_errors_keep_their_sign(self):
        result = self.run_of([("press", 1000000, 1200000), ("slip", 2000000, 3000000)], [("press", 1000005, 1200000), ("slip", 1999000, 3000000)])
        self.assertEqual([o["error"] for o in result["onsets"]], [5, -1000])
        self.assertEqual([o["covered"] for o in result["onsets"]], [True, False])
        self.assertEqual(result["spurious"], [])

    def test_a_slip_labelled_as_press_is_missed_and_superfluous(self):
        result = self.run_of([("slip", 2000000, 3000000)], [("press", 2000000, 3000000)], [(0, "doubtful")])
        self.assertFalse(result["onsets"][0]["found"])
        self.assertEqual([(s["class"], s["on"], s["flagged"]) for s in result["spurious"]], [("press", "slip", True)])

    def test_a_missed_press_without_a_flag_misses_a_goal(self):
        goals = {name: kept for name, _, _, kept in judge.goals_of([self.run_of([("press", 1000000, 1200000)], [])], set())}
        self.assertFalse(goals["wrong, missed or superfluous without a flag"])
        self.assertFalse(goals["presses of 2 mm/s or more missed"])
        self.assertTrue(goals["ordinary runs flagged"])

    def test_a_clock_that_is_certain_and_wrong_misses_a_goal(self):
        kept = lambda *runs: [k for _, _, _, k in judge.clock_goals_of(runs)]
        self.assertEqual(kept(self.run_of([], [], robot=(900, 1000))), [True, True])
        self.assertEqual(kept(self.run_of([], [], robot=(-1500, 1000))), [False, True])
        self.assertEqual(kept(self.run_of([], [], robot=(-2500, 1000))), [False, False])
        self.assertEqual(kept(self.run_of([], [], robot=(-2500, 1000), remarks=["the robot's clock is doubtful"])), [False, True])
        self.assertEqual(kept(self.run_of([], [], [(None, "doubtful")], robot=(-2500, 1000))), [False, True])
        self.assertEqual(kept(self.run_of([], [])), [])


if __name__ == "__main__":
    unittest.main()
