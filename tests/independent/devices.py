"""What the other devices write: the robot's log, the IMU of the camera, the film, each on its own clock."""
import csv
import fractions
import math

import av
import cv2
import h5py
import numpy as np

from ranges import HEIGHT, WIDTH


PERIODS = {"record.py of a UR10": 0.008, "record.py of a UR10e": 0.002, "ur_rtde": 0.01, "tactile record": 0.002}
FILM_HZ = {"15 Hz": 15, "60 Hz": 60}  # all others: 30


class Clock:
    """camera_us = clock_us + offset_us + drift_ppm 1e-6 (clock_us - reference_us)"""

    def __init__(self, offset_us, drift_ppm, reference_us):
        self.offset_us, self.drift_ppm, self.reference_us = offset_us, drift_ppm, reference_us

    def camera(self, clock_us):
        return clock_us + self.offset_us + self.drift_ppm * 1e-6 * (clock_us - self.reference_us)

    def stamp(self, camera_us):
        """The inverse of `camera`."""
        return self.reference_us + (camera_us - self.camera(self.reference_us)) / (1 + self.drift_ppm * 1e-6)

    def seen_from(self, reference_us):
        """The same line with another reference."""
        return Clock(self.camera(reference_us) - reference_us, self.drift_ppm, reference_us)

    def truth(self):
        return {"offset_us": int(round(self.offset_us)), "drift_ppm": self.drift_ppm, "reference_us": int(round(self.reference_us))}


def clocks_of(numbers, rng, begin_us):
    """The clocks that all runs of a session share. `begin_us`: camera time at which the session begins."""
    started = rng.uniform(200, 80000) * 1e6
    return {"robot": Clock(begin_us - started, numbers["drift_ppm"], started),
            "video": Clock(begin_us - 2e6, numbers["film_drift_ppm"], 0),
            "host": Clock(-1000 * numbers["host_late_ms"], numbers["host_drift_ppm"], begin_us),
            "imu": Clock(-1e6 * numbers["imu_lag_s"], 0.0, 0)}


def host_times(rng, clock, camera_us, log):
    """When a host receives rows of a robot. `log`: `late` by a constant 20 ms; in `bursts`."""
    host = clock.stamp(camera_us) + 200 + rng.exponential(1000, len(camera_us)) + (20000 if log == "late" else 0)
    if log == "bursts":
        ends = np.unique(np.append(np.cumsum(rng.integers(4, 40, len(host))).clip(0, len(host) - 1), len(host) - 1))
        host = host[ends[np.searchsorted(ends, np.arange(len(host)))]] + rng.exponential(3000, len(host))
    return np.maximum.accumulate(np.round(host)).astype(np.int64)


def robot_rows(numbers, rng, seconds, log):
    """Stamps [s after the first row] as the recorder writes them."""
    kind = numbers["recorder"]
    period = PERIODS[kind]
    n = int(seconds / period) + 1
    stamps = np.arange(n) * period
    if kind == "ur_rtde":  # reads the newest package of 2 ms on a period of its own
        stamps = 0.002 * np.floor((stamps + rng.uniform(0, 0.0021, n)) / 0.002)
    keep = rng.random(n) >= (0.1 if log == "bursts" else numbers["row_loss"])
    for start in rng.uniform(0, seconds, 3 if log == "bursts" else 0):
        keep &= np.abs(stamps - start) > rng.uniform(0.005, 0.045)
    keep[0] = keep[-1] = True
    return stamps[keep]


def write_robot_log(path, motion, numbers, rng, epoch_us, clocks, with_commands, log="usual"):
    """Pose and speed of the tool as RTDE names them. Returns the clock from its first row on."""
    before, after = rng.uniform(0.2, 1.5), rng.uniform(0.2, 1.0)
    stamps = robot_rows(numbers, rng, motion.t[-1] + before + after, log)
    start = round(clocks["robot"].stamp(epoch_us - before * 1e6) / 2000) * 0.002
    clock = clocks["robot"].seen_from(start * 1e6)
    camera_us = clock.camera((start + stamps) * 1e6)
    t = (camera_us - epoch_us) / 1e6
    at = lambda x: np.interp(t, motion.t, x)
    pose = np.array([-420.0, 310.0, 180.0]) + rng.uniform(-40, 40, 3) + rng.normal(0, numbers["pose_noise_mm"], (len(t), 3))
    speed = rng.normal(0, numbers["speed_noise_mm_s"], (len(t), 3))
    pose[:, 2] += at(motion.lift)
    speed[:, 2] += at(np.gradient(motion.lift, motion.t))
    turn = np.array([2.2, -2.2, 0.03]) + rng.normal(0, 1e-5, (len(t), 3))
    spin = rng.normal(0, 2e-4, (len(t), 3))
    turn[:, 2] += at(motion.wrist)
    spin[:, 2] += at(np.gradient(motion.wrist, motion.t))
    columns = {"timestamp": [f"{x:.6f}" for x in start + stamps]}
    for name, values in (("pose", np.hstack([pose / 1000, turn])), ("speed", np.hstack([speed / 1000, spin]))):
        columns |= {f"actual_TCP_{name}_{k}": [f"{x:.9g}" for x in values[:, k]] for k in range(6)}
    if with_commands:
        bits = np.zeros(len(t), int)
        for when, on in motion.commands:
            bits[t >= when] = int(on)
        columns["actual_digital_output_bits"] = bits.tolist()
    if numbers["recorder"] == "tactile record":
        columns["host_time_us"] = host_times(rng, clocks["host"], camera_us, log).tolist()
    with open(path, "w", newline="") as file:
        writer = csv.writer(file, delimiter=" " if numbers["recorder"].startswith("record.py") else ",")
        writer.writerow(columns)
        writer.writerows(zip(*columns.values()))
    return clock


def imu_samples(motion, numbers, rng, epoch_us, on_stage):
    """The camera's IMU: gravity, the arm's acceleration with the shaking of the gripper, the stage's if the camera sits on it, the wrist's turn."""
    n = int(math.ceil(motion.t[-1] * numbers["imu_hz"]))
    stamps = np.sort(np.arange(n) / numbers["imu_hz"] + rng.normal(0, 2e-5, n))
    t = stamps - numbers["imu_lag_s"]
    at = lambda x: np.interp(t, motion.t, x)
    rate = lambda x: np.gradient(x, motion.t)
    axes = np.linalg.qr(rng.standard_normal((3, 3)))[0]
    force, spin = np.zeros((n, 3)), np.zeros((n, 3))
    force[:, 2] = 1 + at(rate(rate(motion.lift + motion.shake))) / 9806.65
    force[:, 0] = at(rate(rate(motion.stage))) / 9806.65 if on_stage else 0
    spin[:, 0] = np.degrees(at(rate(motion.wrist)))
    return {"t_us": epoch_us + np.round(stamps * 1e6).astype(np.int64), "temperature_c": np.full(n, 38, np.float32),
            "acceleration_g": (force @ axes.T + rng.normal(0, numbers["imu_noise_g"], (n, 3)) + rng.normal(0, 0.01, 3)).astype(np.float32),
            "angular_rate_dps": (spin @ axes.T + rng.normal(0, 0.08, (n, 3))).astype(np.float32),
            "magnetic_field_ut": np.zeros((n, 3), np.float32)}


def write_recording(path, events, imu):
    """A recording as HDF5, for `tactile convert`."""
    with h5py.File(path, "w") as file:
        file.attrs["recording_format"] = 1
        file.attrs["sensor_width"], file.attrs["sensor_height"], file.attrs["source"] = WIDTH, HEIGHT, "DVXplorer_independent"
        for group, table in (("events", events), ("imu", imu)):
            for name, values in (table or {}).items():
                if name != "skin":
                    file.create_dataset(f"{group}/{name}", data=values, chunks=(min(65536, len(values)),) + values.shape[1:])


def draw_scene(shape, lift, gap, object_lift, aside, light):
    """The gripper from the side: a fixed finger, the sensor on its stage, an object on a table. 1 mm is 2 px."""
    picture = np.full(shape, light, np.uint8)
    box = lambda x0, y0, x1, y1, value: cv2.rectangle(picture, (int(x0 * 16), int(y0 * 16)), (int(x1 * 16), int(y1 * 16)), value, -1, cv2.LINE_AA, 4)
    box(0, 210, 320, 240, 60)
    y = 150 - 2 * lift
    box(140 + 2 * aside, 130 - 2 * object_lift, 180 + 2 * aside, 210 - 2 * object_lift, 150)
    box(100, y - 70, 240, y - 50, 40)
    box(180, y - 50, 200, y + 30, 90)
    box(120 - 2 * gap, y - 50, 139 - 2 * gap, y + 30, 25)
    return picture


def frame_stamps(kind, rng, clock, first_us, seconds):
    """Camera times of frames and the times [us] that the film's table has for them. A frame shows the middle of its exposure."""
    hz = FILM_HZ.get(kind, 30)
    camera = first_us + 1e6 * np.cumsum(np.maximum(0.6 / hz, rng.normal(1 / hz, 0.045 / hz, int(seconds * hz))))
    pts = np.round(clock.stamp(camera)).astype(np.int64)
    if kind == "index":  # a table made from the frames' numbers, though the camera dropped some
        keep = rng.random(len(camera)) >= 0.02
        middle = len(keep) // 2
        keep[middle:middle + rng.integers(3, 7)] = False
        camera = camera[keep]
        pts = np.round(np.arange(len(camera)) * 1e6 / 30).astype(np.int64)
    if kind == "repeats":
        again = 1 + np.flatnonzero(rng.random(len(pts) - 1) < 0.05)
        pts[again] = pts[again - 1]
    return camera, pts


def film_clock(kind, rng, numbers, clock, epoch_us, in_session):
    """The film's clock and the camera time before its first frame. The times of a film of its own begin with 0; in a session they run on."""
    first_us = epoch_us + rng.uniform(-0.3, 0.8) * 1e6
    if kind == "drifts":  # by 23 ms over 4 s
        return Clock(first_us, float(rng.choice([-1, 1])) * 0.023 / 4 * 1e6, 0), first_us
    return (clock if in_session else Clock(first_us, numbers["film_drift_ppm"], 0)), first_us


def write_film(path, table_path, motion, numbers, rng, epoch_us, clocks, kind="usual", in_session=False):
    """Frames with uneven times, and their table. Returns the clock from the first frame on; without a true line, the one that fits best."""
    clock, first_us = film_clock(kind, rng, numbers, clocks["video"], epoch_us, in_session)
    camera, pts = frame_stamps(kind, rng, clock, first_us, motion.t[-1] - (first_us - epoch_us) / 1e6 + 0.3)
    if not in_session:
        clock = clock.seen_from(pts[0])
        clock, pts = Clock(clock.offset_us + pts[0], clock.drift_ppm, 0), pts - pts[0]
    if kind == "index":
        gradient, offset = np.polyfit(pts, camera - pts - epoch_us, 1)
        clock = Clock(float(offset) + epoch_us, float(gradient) * 1e6, 0)
    draw_film(path, motion, numbers, rng, (camera - epoch_us) / 1e6, pts - pts[0])
    host = np.maximum.accumulate(np.round(clocks["host"].stamp(camera) + 1000 * numbers["film_late_ms"] + rng.exponential(1500, len(pts))))
    with open(table_path, "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["index", "pts_us", "host_time_us"])
        writer.writerows(zip(range(len(pts)), pts.tolist(), host.astype(np.int64).tolist()))
    return clock.seen_from(int(pts[0]))


def draw_film(path, motion, numbers, rng, times, pts):
    count = np.arange(len(pts))
    ticks = np.maximum.accumulate(np.round(pts * 0.09).astype(int) - count) + count  # a film's own times never repeat
    with av.open(str(path), "w") as film:
        stream = film.add_stream("libx264", rate=30, options={"preset": "ultrafast"})  # with others the bytes differ from time to time
        stream.width, stream.height, stream.pix_fmt = 320, 240, "yuv420p"
        stream.codec_context.time_base = stream.time_base = fractions.Fraction(1, 90000)
        stream.codec_context.thread_count = 1
        for t, tick in zip(times.tolist(), ticks.tolist()):
            at = lambda x: float(np.interp(t, motion.t, x))
            gap = max(0.0, numbers["gap_mm"] - at(motion.stage))
            picture = draw_scene((240, 320), at(motion.lift + motion.shake), gap, at(motion.carried), at(motion.aside), 190)
            picture = np.clip(picture + rng.normal(0, 2.0, picture.shape), 0, 255).astype(np.uint8)
            luma = np.round(16 + picture * (219 / 255)).astype(np.uint8)
            frame = av.VideoFrame.from_ndarray(np.vstack([luma, np.full_like(luma[:120], 128)]), format="yuv420p")
            frame.pts, frame.time_base = tick, stream.time_base
            film.mux(stream.encode(frame))
        film.mux(stream.encode())
