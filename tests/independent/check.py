#!/usr/bin/env python3
"""Tests of the generator and the judge, with values worked out by hand."""
import csv
import json
import pathlib
import tempfile
import unittest

import numpy as np

import cases
import devices
import generate
import judge
import motion
import pixels
import ranges
import skin


SEEDS = range(3)


def numbers_of(seed, **given):
    return ranges.draw(np.random.default_rng(seed), given)


def scene_of(case, seed):
    rng = np.random.default_rng(seed)
    return cases.CASES[case](ranges.draw(rng), rng)


def at(motion, x, seconds):
    return float(np.interp(seconds, motion.t, x))


class TheNumbers(unittest.TestCase):
    def test_each_row_has_a_range_and_a_source(self):
        for rows in (ranges.RIG, ranges.RUN):
            for name, (low, high, scale, source) in rows.items():
                self.assertTrue(low < high and scale in ("flat", "log") and source, name)
        for choices in (ranges.RIG_CHOICES, ranges.RUN_CHOICES):
            for name, (kinds, source) in choices.items():
                self.assertAlmostEqual(sum(part for part, _ in kinds.values()), 1, msg=name)

    def test_the_camera_sees_the_dots_and_the_lift_is_long_enough_to_slip(self):
        for seed in range(100):
            n = numbers_of(seed)
            self.assertGreaterEqual(n["dot_contrast"], 2 * max(n["threshold_on"], n["threshold_off"]))
            self.assertLessEqual(n["blur_px"], 0.7 * n["dot_radius_mm"] * n["px_per_mm"] + 1e-9)
            self.assertGreater(n["transmission"] * (n["lift_mm"] - 0.2), 1.3 * n["shear_mm"])

    def test_runs_of_a_session_share_the_rig_and_nothing_else(self):
        one, two = (ranges.draw(np.random.default_rng(seed), rig=np.random.default_rng(9)) for seed in (1, 2))
        self.assertEqual({k: one[k] for k in ranges.RIG}, {k: two[k] for k in ranges.RIG})
        self.assertEqual([k for k in ranges.RUN if one[k] == two[k]], [])


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

    def test_dots_are_bright_or_dark_and_one_side_is_lit(self):
        given = dict(dots_missing=0.0, grid_jitter=0.0, light_fall=0.0, light_side=0.8, light_angle=0.0, dot_part=0.2, dot_contrast=1.5)
        dark, bright = (skin.Skin(numbers_of(2, dots=dots, **given), np.random.default_rng(1)).picture for dots in ("dark", "bright"))
        level = lambda picture: np.median(picture) - picture.mean()
        self.assertGreater(level(dark), 0)
        self.assertLess(level(bright), 0)
        self.assertAlmostEqual(float(np.median(dark[:, -100:]) - np.median(dark[:, :100])), 0.8 * (800 - 100) / 320, delta=0.2)

    def test_a_sway_moves_the_whole_skin_and_a_turn_only_the_contact(self):
        n = numbers_of(1, relief_mm=0.0, patch_off=0.2)
        surface = skin.Skin(n, np.random.default_rng(1))
        u, v, shade = surface.fields(0.0, 0, 0, 0, 0, sway=0.5)
        np.testing.assert_allclose(np.hypot(u, v), 0.5 * n["px_per_mm"], rtol=1e-5)
        self.assertEqual(np.abs(shade).max(), 0)
        still = np.array(surface.fields(n["depth_mm"], 0, 1, 0, 0)[:2])
        turned = np.array(surface.fields(n["depth_mm"], 0, 1, 0, 0, turn=0.1)[:2]) - still
        moved, away = np.hypot(*turned) / n["px_per_mm"], np.hypot(surface.dx, surface.dy)
        self.assertTrue((moved <= 0.1 * away + 1e-6).all())
        self.assertGreater(moved.max(), 0.02 * n["patch_mm"])
        self.assertLess(np.abs(turned[0] * surface.dx + turned[1] * surface.dy).max(), 1e-4)

    def test_friction_has_the_drawn_mean_from_the_first_contact_on(self):
        n = numbers_of(3, friction_spread=0.0, shear_mm=0.5, depth_mm=1.0)
        base = np.linspace(0, 3, 4000)
        shear, limit, gross, _ = motion.sheared(base, np.ones(4000), n, np.random.default_rng(1))
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

    def test_a_stage_and_a_hand_end_at_their_travel_and_never_turn_back(self):
        t = np.arange(0, 6, motion.STEP)
        for drive in ("servo", "cylinder", "hand"):
            n = numbers_of(4, drive=drive, uneven=0.9, thread_mm=0.5, stage_mm_s2=500, brake_part=10)
            way = motion.course(t, 1.0, 3.0, 5.0, n)
            self.assertEqual(np.abs(way[t <= 1.0]).max(), 0)
            np.testing.assert_allclose(way[t >= 1.0 + motion.span(3.0, 5.0, n)], 3.0)
            self.assertGreaterEqual(np.diff(way).min(), -1e-9)

    def test_a_cylinder_stops_harder_than_it_starts_and_a_hand_has_its_highest_speed_in_the_middle(self):
        self.assertEqual(motion.profile(10, 5, 50, 500)[1:], (0.1, 1.945, 0.01))
        t = np.arange(0, 3, motion.STEP)
        rate = np.gradient(motion.course(t, 1.0, 3.0, 5.0, numbers_of(4, drive="hand", uneven=0.0)), motion.STEP)
        self.assertAlmostEqual(rate.max(), 5.0, 3)
        self.assertAlmostEqual(t[rate.argmax()], 1 + 0.5 * 1.875 * 3 / 5, 2)

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

    def test_there_is_more_noise_where_it_is_dark(self):
        n = numbers_of(1, noise_hz_per_px=0.5, noise_spread=0.3, noise_dark=1.0, light_side=0.8, light_angle=0.0, light_fall=0.0, hot_pixels=0)
        (_, pixel, _), _ = pixels.noise(n, np.random.default_rng(1), 2.0)
        x = pixel % ranges.WIDTH
        self.assertAlmostEqual(np.mean(x < 64) / np.mean(x >= ranges.WIDTH - 64), np.exp(0.8 * 1.8), delta=0.1)
        self.assertAlmostEqual(len(pixel) / pixels.PIXELS / 2, 0.5, delta=0.01)

    def test_stamps_tell_the_read_out_and_the_column(self):
        n, rng = numbers_of(1, readout_us=195.163, noise_hz_per_px=0.3), np.random.default_rng(1)
        background, _ = pixels.noise(n, rng, 1.0)
        table = pixels.read_out(n, rng, (np.zeros(0), np.zeros(0, int), np.zeros(0, bool)), background, 10**15)
        phase = (table["t_us"] - 10**15 - (ranges.WIDTH - 1 - table["x"]) * ranges.COLUMN_US) / 195.163
        self.assertGreater(abs(np.exp(2j * np.pi * phase).mean()), 0.999)
        self.assertTrue((np.diff(table["t_us"]) >= 0).all())


class TheCases(unittest.TestCase):
    def labelled(self, scene):
        return [x["class"] for x in scene.motion.truths if x["labelled"]]

    def test_every_case_has_truths_that_end_after_they_begin(self):
        for name in cases.CASES:
            for x in scene_of(name, 1).motion.truths:
                self.assertLess(x["start"], x["end"], name)

    def test_a_late_slip_comes_after_a_firm_shear(self):
        for seed in SEEDS:
            m = scene_of("late-slip", seed).motion
            slip = next(x for x in m.truths if x["what"] == "slip")
            self.assertTrue(0.2 <= slip["start"] - m.lift_start <= 1.5)
            self.assertEqual(at(m, m.slid, slip["start"] - motion.STEP), 0)
            self.assertGreater(at(m, m.slid, slip["end"]), 0)
            self.assertAlmostEqual(at(m, m.carried - m.lift, slip["start"] - 0.01), 0, 6)
            self.assertGreater(at(m, m.lift - m.carried, slip["end"]), 1)

    def test_slow_presses_and_releases_are_slow(self):
        for seed in SEEDS:
            self.assertTrue(0.4 < scene_of("slow-press", seed).motion.press_speeds[0] < 1.5)
            m = scene_of("slow-release", seed).motion
            release = next(x for x in m.truths if x["what"] == "release")
            inside = (m.t > release["start"]) & (m.t < release["end"])
            self.assertLess(np.abs(np.gradient(m.stage, motion.STEP))[inside].max(), 1.5)

    def test_two_touches_are_two_presses_and_two_slips(self):
        for seed in SEEDS:
            self.assertEqual(self.labelled(scene_of("two-touches", seed)), ["press", "slip"] * 2)

    def test_a_press_at_once_begins_in_the_first_50_ms(self):
        for seed in SEEDS:
            scene = scene_of("press-at-once", seed)
            self.assertTrue(0 < scene.motion.truths[0]["start"] - scene.begins_at <= 0.05)

    def test_a_push_moves_the_skin_while_nothing_is_held(self):
        for seed in SEEDS:
            m = scene_of("push", seed).motion
            swayed = m.sway > 1e-4
            self.assertTrue(swayed.any() and m.truths[0]["what"] == "vibration" and not m.truths[0]["labelled"])
            self.assertEqual(m.depth[swayed].max(), 0)
            self.assertTrue((np.abs(m.shake[swayed]) > 1e-4).any())

    def test_an_object_that_is_carried_away_leaves_and_comes_back(self):
        for seed in SEEDS:
            scene = scene_of("carried-away", seed)
            m = scene.motion
            self.assertEqual(self.labelled(scene), ["press", "press", "slip"])
            again = [x for x in m.truths if x["what"] == "press"][1]
            self.assertLess(at(m, m.depth, again["start"]), 0.25 * scene.numbers["depth_mm"])  # what creep left
            self.assertLess(at(m, m.aside, again["start"]), scene.numbers["depth_mm"] + 0.01)
            self.assertGreater(m.aside.max(), 5)

    def test_a_twist_sticks_and_a_twist_slip_slips(self):
        for seed in SEEDS:
            m = scene_of("twist", seed).motion
            self.assertEqual([x["what"] for x in m.truths if x["what"] == "turn"], ["turn"] * 2)
            self.assertEqual(at(m, m.slid, m.lift_start), 0)
            scene = scene_of("twist-slip", seed)
            m = scene.motion
            slip = next(x for x in m.truths if x["what"] == "slip")
            self.assertEqual(self.labelled(scene), ["press", "slip"])
            self.assertTrue(at(m, m.slid, slip["start"]) == 0 < at(m, m.slid, slip["end"]))
            self.assertGreater(np.ptp(m.wrist), 0.25)
            self.assertEqual(np.ptp(m.lift), 0)

    def test_nothing_is_nothing_and_a_machine_hums(self):
        for seed in SEEDS:
            m = scene_of("nothing", seed).motion
            self.assertEqual((m.truths, m.depth.max(), np.abs(m.sway).max()), ([], 0, 0))
            m = scene_of("machine", seed).motion
            self.assertTrue(20 <= m.hum_hz <= 120 and m.depth.max() == 0)
            crossings = np.count_nonzero(np.diff(np.sign(m.sway)))
            self.assertAlmostEqual(crossings / m.t[-1] / 2, m.hum_hz, delta=1)

    def test_the_cases_of_missing_devices_lack_them(self):
        for name, robot, imu, film in (("no-imu", 1, 0, 1), ("no-film", 1, 1, 0), ("no-robot", 0, 1, 1), ("events-alone", 0, 0, 0)):
            scene = scene_of(name, 1)
            self.assertEqual((scene.robot, scene.imu, scene.film), (robot, imu, film))


class TheDevices(unittest.TestCase):
    BEGIN = 1_700_000_000_000_000

    def setUp(self):
        self.numbers = numbers_of(3, drive="servo", hold_s=0.5, recorder="tactile record")
        self.motion = cases.ordinary(self.numbers, np.random.default_rng(3)).motion
        self.clocks = devices.clocks_of(self.numbers, np.random.default_rng(3), self.BEGIN)
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.table = pathlib.Path(self.folder.name) / "table.csv"

    def rows(self):
        with open(self.table, newline="") as file:
            names, *rows = csv.reader(file)
        return dict(zip(names, np.array(rows, float).T))

    def film(self, kind):
        """The film's times [us], and how much later the host has the frames than its clock says."""
        clock = devices.write_film(self.table.with_suffix(".mp4"), self.table, self.motion, self.numbers, np.random.default_rng(1), self.BEGIN,
                                   self.clocks, kind)
        rows = self.rows()
        return rows["pts_us"], self.clocks["host"].camera(rows["host_time_us"]) - clock.camera(rows["pts_us"]), clock

    def test_a_clock_has_an_inverse_and_any_reference(self):
        clock = devices.Clock(5000.0, 200.0, 10_000.0)
        self.assertAlmostEqual(clock.stamp(clock.camera(777_000.0)), 777_000.0)
        self.assertAlmostEqual(clock.seen_from(500_000.0).camera(777_000.0), clock.camera(777_000.0))

    def test_films_have_their_rates_and_their_clocks_are_true(self):
        for kind, hz in (("usual", 30), ("15 Hz", 15), ("60 Hz", 60), ("drifts", 30)):
            pts, late, clock = self.film(kind)
            self.assertEqual(pts[0], 0)
            self.assertAlmostEqual(1e6 / np.median(np.diff(pts)), hz, delta=1)
            self.assertAlmostEqual(np.median(late) / 1000 - self.numbers["film_late_ms"], 1.0, delta=1)
            self.assertLess(np.abs(late[-9:].mean() - late[:9].mean()), 2500)
        self.assertAlmostEqual(abs(clock.drift_ppm) * 1e-6 * 4000, 23)

    def test_films_by_index_have_even_times_and_repeating_ones_repeat(self):
        pts, late, _ = self.film("index")
        np.testing.assert_allclose(pts, np.arange(len(pts)) * 1e6 / 30, atol=1)
        self.assertGreater(np.ptp(late), 60_000)
        self.assertGreater(np.count_nonzero(np.diff(self.film("repeats")[0]) == 0), 2)

    def test_host_times_of_the_robot_are_late_or_in_bursts(self):
        delays, counts = {}, {}
        for log in ("usual", "late", "bursts"):
            clock = devices.write_robot_log(self.table, self.motion, self.numbers, np.random.default_rng(1), self.BEGIN, self.clocks, True, log)
            rows = self.rows()
            delays[log] = rows["host_time_us"] - self.clocks["host"].stamp(clock.camera(rows["timestamp"] * 1e6))
            counts[log] = len(rows["timestamp"])
        self.assertAlmostEqual(np.median(delays["late"]) - np.median(delays["usual"]), 20_000, delta=200)
        self.assertGreater(np.std(delays["bursts"]), 5 * np.std(delays["usual"]))
        self.assertLess(counts["bursts"], 0.95 * counts["usual"])

    def test_the_log_shows_the_lift_at_the_time_of_its_clock(self):
        clock = devices.write_robot_log(self.table, self.motion, self.numbers, np.random.default_rng(1), self.BEGIN, self.clocks, True)
        rows = self.rows()
        t = (clock.camera(rows["timestamp"] * 1e6) - self.BEGIN) / 1e6
        height = 1000 * (rows["actual_TCP_pose_2"] - rows["actual_TCP_pose_2"][0])
        np.testing.assert_allclose(height, np.interp(t, self.motion.t, self.motion.lift), atol=0.5)

    def test_the_imu_is_late_by_its_filter(self):
        numbers = {**self.numbers, "imu_lag_s": 0.1, "imu_noise_g": 1e-6, "imu_hz": 800}
        samples = devices.imu_samples(self.motion, numbers, np.random.default_rng(1), self.BEGIN, False)
        felt = np.abs(samples["acceleration_g"] - samples["acceleration_g"][:50].mean(0)).max(1) > 1e-3
        first = (samples["t_us"][felt][0] - self.BEGIN) / 1e6
        self.assertAlmostEqual(first - self.motion.lift_start, 0.1, delta=0.02)


class TheRuns(unittest.TestCase):
    def run_of(self, folder, run, session=None):
        """A run without a touch. A copy stands for `tactile convert`."""
        copy = pathlib.Path(folder) / "copy"
        copy.write_text('#!/bin/sh\ncp "$2" "$3"\n')
        copy.chmod(0o755)
        generate.make_run(folder, "quiet", run, "nothing", 5, copy, session)
        return pathlib.Path(folder) / "quiet" / run

    def test_one_seed_gives_the_same_bytes(self):
        with tempfile.TemporaryDirectory() as one, tempfile.TemporaryDirectory() as two:
            first, second = self.run_of(one, "02"), self.run_of(two, "02")
            self.assertLessEqual({"events.aedat4", "robot.csv", "video.mp4"}, {f.name for f in first.iterdir()})
            for file in first.iterdir():
                self.assertEqual(file.read_bytes(), (second / file.name).read_bytes(), file.name)

    def test_a_session_shares_the_clocks_of_robot_film_and_imu(self):
        with tempfile.TemporaryDirectory() as folder:
            truths = []
            for run in ("01", "02", "03", "04"):
                made = self.run_of(folder, run, "monday")
                self.assertEqual(json.loads((made / "run.json").read_text())["session"], "monday")
                truths.append(json.loads((made / "truth.json").read_text())["clocks"])
            for name in ("robot", "video", "host", "imu"):
                lines = [devices.Clock(**c[name]) for c in truths if c[name]]
                self.assertGreater(len(lines), 1, name)
                np.testing.assert_allclose([x.camera(lines[0].reference_us) - lines[0].camera(lines[0].reference_us) for x in lines], 0, atol=1)
            self.assertGreater(truths[1]["robot"]["reference_us"] - truths[0]["robot"]["reference_us"], 30e6)


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
            made = [{"class": c, "start_us": s, "end_us": e, "start_low_us": s - 9, "start_high_us": s + 9, "end_low_us": e - 9,
                     "end_high_us": e + 9, **dict(zip(["probability"], more))} for c, s, e, *more in labels]
            marks = [{"interval": i, "reason": r, "confirmed": False} for i, r in flags]
            (folder / "labels.json").write_text(json.dumps({"intervals": made, "flags": marks, "clocks": clocks, "remarks": list(remarks)}))
            return judge.judge_run(folder)

    def test_a_label_is_matched_once_and_errors_keep_their_sign(self):
        result = self.run_of([("press", 1000000, 1200000), ("slip", 2000000, 3000000)], [("press", 1000005, 1200000), ("slip", 1999000, 3000000)])
        self.assertEqual([o["error"] for o in result["onsets"]], [5, -1000])
        self.assertEqual([o["covered"] for o in result["onsets"]], [True, False])
        self.assertEqual(result["spurious"], [])

    def test_a_slip_labelled_as_press_has_the_wrong_class(self):
        result = self.run_of([("slip", 2000000, 3000000)], [("press", 2000000, 3000000), ("press", 5000000, 5100000)], [(0, "doubtful")])
        self.assertFalse(result["onsets"][0]["found"])
        self.assertEqual([(s["class"], s["on"], s["flagged"]) for s in result["spurious"]], [("press", "slip", True), ("press", "nothing", False)])
        self.assertEqual([(kind, flagged) for kind, _, flagged in judge.defects_of(result)], [("wrong class", True), ("superfluous", False)])

    def test_a_summary_counts_errors_ends_intervals_and_defects(self):
        truths = [("press", 1000000, 1200000), ("slip", 2000000, 3000000), ("press", 7000000, 7100000)]
        result = self.run_of(truths, [("press", 1000005, 1200100), ("slip", 2040000, 3000000)], [(1, "late by 40 ms")])
        found = judge.summary_of([result], {"cup/01"})
        self.assertEqual((found["runs"], found["flagged"], found["give samples"], found["touches"]), (1, 1, 1, 3))
        self.assertEqual(found["press onset"], {"n": 1, "median_ms": 0.005, "p95_ms": 0.005, "bias_ms": 0.005, "inside": 1.0})
        self.assertEqual((found["press end"]["bias_ms"], found["press end"]["inside"], found["slip end"]["inside"]), (0.1, 0.0, 1.0))
        self.assertEqual(found["off by more than 30 ms"], {"with a flag": 1, "without": 0})
        self.assertEqual(found["missed"], {"with a flag": 0, "without": 1})
        self.assertEqual(found["reasons"], {"slip: late by N ms": 1})

    def test_reliability_compares_probabilities_with_the_share_that_is_right(self):
        truths = [("press", 1000000, 1200000), ("slip", 2000000, 3000000)]
        labels = [("press", 1000000, 1200000, 1.0), ("press", 2000000, 3000000, 0.6), ("slip", 5000000, 6000000, 0.99)]
        rows = judge.reliability_of([self.run_of(truths, labels)])
        self.assertEqual([(r["n"], r["right"]) for r in rows], [(1, 0.0), (0, None), (0, None), (2, 0.5)])
        self.assertEqual(sum(r["n"] for r in judge.reliability_of([self.run_of(truths, [("press", 1000000, 1200000)])])), 0)

    def test_a_copy_without_a_witness_lacks_its_files(self):
        with tempfile.TemporaryDirectory() as folder:
            run = pathlib.Path(folder) / "runs" / "cup" / "01"
            run.mkdir(parents=True)
            (run / "truth.json").write_text(json.dumps({"parameters": {"case": "ordinary", "imu": False}}))
            for name in ("robot.csv", "video.mp4", "video.csv", "labels.json"):
                (run / name).write_text("")
            left = {w: sorted(f.name for f in judge.copied_without("", run.parent.parent, w).glob("*/*/*")) for w in ("robot", "film", "imu")}
            self.assertEqual(left, {"robot": ["truth.json", "video.csv", "video.mp4"], "film": ["robot.csv", "truth.json"], "imu": []})

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
