"""What the other devices write: the robot's log, the IMU of the camera, the film, each on its own clock."""
import csv
import fractions
import math

import av
import cv2
import h5py
import numpy as np

from ranges import HEIGHT, WIDTH


class Clock:
    """camera_us = clock_us + offset_us + drift_ppm 1e-6 (clock_us - reference_us)"""

    def __init__(self, offset_us, drift_ppm, reference_us):
        self.offset_us, self.drift_ppm, self.reference_us = offset_us, drift_ppm, reference_us

    def camera(self, clock_us):
        return clock_us + self.offset_us + self.drift_ppm * 1e-6 * (clock_us - self.reference_us)

    def truth(self):
        return {"offset_us": int(round(self.offset_us)), "drift_ppm": self.drift_ppm, "reference_us": int(round(self.reference_us))}


def robot_rows(numbers, rng, seconds):
    """Stamps [s after the first row] as one of three kinds of recorder writes them."""
    kind = rng.choice(["record.py of a UR10", "record.py of a UR10e", "ur_rtde"])
    period = {"record.py of a UR10": 0.008, "record.py of a UR10e": 0.002, "ur_rtde": 0.01}[str(kind)]
    n = int(seconds / period) + 1
    stamps = np.arange(n) * period
    if kind == "ur_rtde":  # reads the newest package of 2 ms on a period of its own
        stamps = 0.002 * np.floor((stamps + rng.uniform(0, 0.0021, n)) / 0.002)
    keep = rng.random(n) >= numbers["row_loss"]
    keep[0] = keep[-1] = True
    return stamps[keep], str(kind)


def write_robot_log(path, motion, numbers, rng, epoch_us, drift_ppm, with_commands):
    """Pose and speed of the tool as RTDE names them. Returns the clock and the kind of log."""
    before, after = rng.uniform(0.2, 1.5), rng.uniform(0.2, 1.0)
    seconds = motion.t[-1] + before + after
    stamps, kind = robot_rows(numbers, rng, seconds)
    start = round(rng.uniform(200, 80000) / 0.002) * 0.002
    clock = Clock(epoch_us - before * 1e6 - start * 1e6, drift_ppm, start * 1e6)
    t = (clock.camera((start + stamps) * 1e6) - epoch_us) / 1e6
    z = np.interp(t, motion.t, motion.lift)
    v = np.interp(t, motion.t, np.gradient(motion.lift, motion.t))
    pose = np.array([-420.0, 310.0, 180.0]) + rng.uniform(-40, 40, 3) + rng.normal(0, numbers["pose_noise_mm"], (len(t), 3))
    speed = rng.normal(0, numbers["speed_noise_mm_s"], (len(t), 3))
    pose[:, 2] += z
    speed[:, 2] += v
    turn = np.array([2.2, -2.2, 0.03]) + rng.normal(0, 1e-5, (len(t), 3))
    spin = rng.normal(0, 2e-4, (len(t), 3))
    bits = np.zeros(len(t), int)
    for when, on in motion.commands:
        bits[t >= when] = int(on)
    names = ["timestamp"] + [f"actual_TCP_pose_{k}" for k in range(6)] + [f"actual_TCP_speed_{k}" for k in range(6)]
    columns = np.column_stack([start + stamps, pose / 1000, turn, speed / 1000, spin])
    with open(path, "w", newline="") as file:
        writer = csv.writer(file, delimiter="," if kind == "ur_rtde" else " ")
        writer.writerow(names + (["actual_digital_output_bits"] if with_commands else []))
        for row, bit in zip(columns.tolist(), bits.tolist()):
            writer.writerow([f"{row[0]:.6f}"] + [f"{x:.9g}" for x in row[1:]] + ([bit] if with_commands else []))
    return clock, kind


def imu_samples(motion, numbers, rng, epoch_us, on_stage):
    """The camera's IMU: gravity, the arm's acceleration with the shaking of the gripper, and the stage's if the camera sits on it."""
    t = np.arange(0, motion.t[-1], 1 / numbers["imu_hz"]) + rng.normal(0, 2e-5, int(math.ceil(motion.t[-1] * numbers["imu_hz"])))
    twice = lambda x: np.interp(t, motion.t, np.gradient(np.gradient(x, motion.t), motion.t)) / 9806.65
    axes = np.linalg.qr(rng.standard_normal((3, 3)))[0]
    force = np.zeros((len(t), 3))
    force[:, 2] = 1 + twice(motion.lift + motion.shake)
    if on_stage:
        force[:, 0] = twice(motion.stage)
    return {"t_us": epoch_us + np.round(np.sort(t) * 1e6).astype(np.int64), "temperature_c": np.full(len(t), 38, np.float32),
            "acceleration_g": (force @ axes.T + rng.normal(0, numbers["imu_noise_g"], (len(t), 3)) + rng.normal(0, 0.01, 3)).astype(np.float32),
            "angular_rate_dps": rng.normal(0, 0.08, (len(t), 3)).astype(np.float32),
            "magnetic_field_ut": np.zeros((len(t), 3), np.float32)}


def write_recording(path, events, imu):
    """A recording as HDF5, for `tactile convert`."""
    with h5py.File(path, "w") as file:
        file.attrs["recording_format"] = 1
        file.attrs["sensor_width"], file.attrs["sensor_height"], file.attrs["source"] = WIDTH, HEIGHT, "DVXplorer_independent"
        for group, table in (("events", events), ("imu", imu)):
            for name, values in (table or {}).items():
                if name != "skin":
                    file.create_dataset(f"{group}/{name}", data=values, chunks=(min(65536, len(values)),) + values.shape[1:])


def draw_scene(shape, lift, gap, object_lift, light):
    """The gripper from the side: a fixed finger, the sensor on its stage, an object on a table. 1 mm is 2 px."""
    picture = np.full(shape, light, np.uint8)
    box = lambda x0, y0, x1, y1, value: cv2.rectangle(picture, (int(x0 * 16), int(y0 * 16)), (int(x1 * 16), int(y1 * 16)), value, -1, cv2.LINE_AA, 4)
    box(0, 210, 320, 240, 60)
    y = 150 - 2 * lift
    box(140, 130 - 2 * object_lift, 180, 210 - 2 * object_lift, 150)
    box(100, y - 70, 240, y - 50, 40)
    box(180, y - 50, 200, y + 30, 90)
    box(120 - 2 * gap, y - 50, 139 - 2 * gap, y + 30, 25)
    return picture


def write_film(path, table_path, motion, numbers, rng, epoch_us, drift_ppm, object_lift):
    """About 30 frames a second with uneven times. A frame shows the middle of its exposure."""
    late = rng.uniform(-0.3, 0.8)
    pts = np.cumsum(np.maximum(0.02, rng.normal(1 / 30, 0.0015, int((motion.t[-1] - late + 0.3) * 30))))
    pts = np.round((pts - pts[0]) * 1e6).astype(np.int64)
    clock = Clock(epoch_us + late * 1e6, drift_ppm, 0)
    times = (clock.camera(pts) - epoch_us) / 1e6
    with av.open(str(path), "w") as film:
        stream = film.add_stream("libx264" if "libx264" in av.codecs_available else "mpeg4", rate=30)
        stream.width, stream.height, stream.pix_fmt = 320, 240, "yuv420p"
        stream.codec_context.time_base = stream.time_base = fractions.Fraction(1, 90000)
        for p, t in zip(pts.tolist(), times.tolist()):
            at = lambda x: float(np.interp(t, motion.t, x))
            gap = max(0.0, numbers["gap_mm"] - at(motion.stage))
            picture = draw_scene((240, 320), at(motion.lift + motion.shake), gap, at(object_lift), 190)
            picture = np.clip(picture + rng.normal(0, 2.0, picture.shape), 0, 255).astype(np.uint8)
            frame = av.VideoFrame.from_ndarray(np.repeat(picture[..., None], 3, 2), format="rgb24")
            frame.pts, frame.time_base = round(p * 0.09), stream.time_base
            film.mux(stream.encode(frame))
        film.mux(stream.encode())
    host = 1.7e15 + pts + np.round(rng.exponential(1500, len(pts)))
    with open(table_path, "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["index", "pts_us", "host_time_us"])
        writer.writerows(zip(range(len(pts)), pts.tolist(), host.astype(np.int64).tolist()))
    return clock
