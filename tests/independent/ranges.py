"""Every number that a run is drawn from, with its range and its source.

A row is (low, high, scale, source). `log` draws the logarithm evenly, `flat` the value itself. `assumed` means that no published value was found.
A choice has names, each with its probability and the rows that it replaces.
"""
import math

# Sources, by the short name used in the rows.
#   paper   Faris et al., arXiv:2403.10120
#   v2e     Hu, Liu, Delbruck: v2e, CVPR workshops 2021: thresholds, their mismatch, photoreceptor, shot noise (0 to 5 Hz a pixel)
#   esim    Rebecq, Gehrig, Scaramuzza: ESIM, CoRL 2018: crossings interpolated in time, refractory time
#   dvx     measured on recordings of DVXplorer cameras: read-out, stamps of columns, noise, hot pixels, IMU rate
#   hertz   Johnson, Contact Mechanics, 1985, chapters 4 and 7: Hertz; Cattaneo and Mindlin
#   tip     TacTip, GelSight and FingerVision: markers of 0.3 to 1.2 mm radius and pitch of 1.2 to 4 mm on soft skins; white pins on black, too
#   ur      URScript manual and RTDE guide: movel, 125 Hz (CB) and 500 Hz (e-Series)
#   air     handbooks of pneumatic cylinders: 50 to 500 mm/s, some from 5 mm/s; below some ten mm/s the seal's friction makes the speed uneven
#   hand    Flash and Hogan 1985: reaching has the least jerk; Novak and Newell 2017, Lakie et al. 2015: tremor of 6 to 12 Hz
#   quartz  manuals of cameras: up to 100 ppm each; 20 to 50 ppm are usual

# What stays the same in a session: camera, skin, light and clocks.
RIG = {
    # the picture
    "px_per_mm": (9, 22, "log", "paper: the skin is 40 mm wide and fills most of the picture; the lens can be changed"),
    "pitch_mm": (1.2, 4.2, "log", "tip"),
    "dot_part": (0.17, 0.36, "flat", "tip: radius as a part of the pitch"),
    "dot_contrast": (0.25, 1.8, "log", "assumed: natural logarithm of the intensities of skin and dot; paint and filament fade"),
    "dots_missing": (0, 0.15, "flat", "assumed: prints wear off"),
    "blur_px": (0.8, 3.5, "log", "assumed: lens close to its near limit"),
    "grid_jitter": (0.0, 0.15, "flat", "assumed: part of the pitch"),
    "distance_mm": (18, 50, "log", "assumed: lens to skin in a finger of a few centimetres"),
    "light_fall": (0, 0.8, "flat", "assumed: logarithm; dark above and below, or in the middle"),
    "light_side": (0, 0.9, "flat", "assumed: logarithm, from the middle to a side; one LED strip is nearer or weaker"),
    "light_angle": (0, 2 * math.pi, "flat", "assumed: the lit side"),
    # the skin
    "lever_mm": (0.3, 2.5, "log", "tip: pins of 1 to 3 mm inside the skin turn with its tilt; a squeezed gel flows outwards as far"),
    "reach_mm": (4, 18, "log", "assumed: the skin is clamped at its border"),
    "shade_per_mm": (-0.3, 0.3, "flat", "assumed: light falls off with the distance from the LED strips"),
    "shade_per_tilt": (-0.5, 0.5, "flat", "assumed: light falls from above and below"),
    "creep_part": (0.01, 0.25, "log", "hertz: rubber under constant load creeps by a few to ten percent; printed filament by more"),
    "creep_s": (0.05, 2.0, "log", "assumed"),
    "recovery_s": (0.004, 0.08, "log", "assumed: a skin that is let go returns by itself"),
    # the camera
    "threshold_on": (0.12, 0.5, "log", "v2e: 0.2 nominal; esim: 0.4 to 0.5; a camera's settings for its sensitivity"),
    "threshold_ratio": (0.7, 1.4, "log", "assumed: OFF over ON"),
    "threshold_spread": (0.01, 0.08, "log", "v2e: 0.02 to 0.05"),
    "photoreceptor_s": (0.0001, 0.004, "log", "v2e: 30 to 300 Hz in dim light, thousands in bright light"),
    "refractory_s": (0.0001, 0.002, "log", "esim, v2e: 0.5 ms"),
    "noise_hz_per_px": (0.01, 0.8, "log", "dvx: 0.44 in a still, dim scene; v2e: 0 to 5"),
    "noise_spread": (0.3, 1.4, "flat", "dvx: logarithm of the rate from pixel to pixel"),
    "noise_dark": (0, 1.5, "flat", "v2e: shot noise falls with light, to a quarter at white: exponent of the rate over the intensity"),
    "hot_pixels": (3, 300, "log", "dvx: 49 of 320 x 240, 130 of 640 x 480"),
    "readout_us": (195.0, 197.3, "flat", "dvx: 195.163 to 197.283"),
    "imu_hz": (795, 810, "flat", "dvx: 807"),
    "imu_noise_g": (0.001, 0.02, "log", "assumed: consumer MEMS at full bandwidth"),
    "imu_lag_s": (0.0, 0.002, "flat", "assumed: delay of the sensor's own low-pass filter"),
    # the arm's mount
    "play_mm": (0, 0.2, "flat", "assumed: play of stage and mount; half of the runs have none"),
    "mount_hz": (12, 80, "log", "assumed: first mode of arm and gripper"),
    "mount_damping": (0.02, 0.25, "log", "assumed"),
    "mount_part": (0.03, 0.35, "log", "assumed"),
    "mount_angle_deg": (-30, 30, "flat", "assumed: between lift and columns of the camera"),
    "transmission": (0.4, 0.98, "flat", "assumed: the rest bends the finger"),
    # clocks and logs
    "drift_ppm": (-100, 100, "flat", "quartz: the robot's"),
    "film_drift_ppm": (-100, 100, "flat", "quartz"),
    "host_drift_ppm": (-60, 60, "flat", "quartz: the host's against the camera's"),
    "host_late_ms": (0.3, 8, "log", "assumed: the earliest packet of a camera at the host"),
    "pose_noise_mm": (0.002, 0.05, "log", "assumed: encoders of an arm that stands still"),
    "speed_noise_mm_s": (0.03, 0.8, "log", "assumed"),
    "row_loss": (0.0, 0.02, "flat", "measured on UR logs: steps of 10 ms with some of 12, 14 and 30"),
    "film_late_ms": (5, 100, "log", "assumed: exposure, transfer and driver, until the host has a frame"),
}

# What differs from run to run: the object, what the stage and the arm do, and friction.
RUN = {
    # the object
    "depth_mm": (0.15, 2.0, "log", "paper: a light press, not enough to hold the object"),
    "patch_mm": (1.2, 7.0, "log", "assumed: radius of the contact at full depth"),
    "patch_growth": (0.1, 0.55, "flat", "hertz: 0.5 for a sphere; flat objects touch nearly at once"),
    "patch_stretch": (0.5, 2.0, "log", "assumed: long contacts"),
    "patch_off": (0, 0.85, "flat", "assumed: from the middle of the picture, as a part of the way to its border"),
    "relief_mm": (0.005, 0.12, "log", "assumed: printed and textured surfaces"),
    "relief_length_mm": (0.5, 4.0, "log", "assumed"),
    "shape_mm": (0.01, 0.3, "log", "assumed: objects are not straight along the line that they slip"),
    "shape_length_mm": (3, 15, "log", "assumed"),
    # the stage
    "press_mm_s": (0.5, 30, "log", "assumed: small linear stages"),
    "stage_mm_s2": (30, 2000, "log", "assumed: stepper and servo stages"),
    "brake_part": (0.5, 2, "log", "assumed: braking over speeding up"),
    "uneven": (0.0, 0.15, "flat", "assumed: part by which the speed rises and falls"),
    "uneven_phase": (0, 2 * math.pi, "flat", "assumed"),
    "thread_mm": (0.2, 2.0, "log", "assumed: pitch of small lead screws"),
    "gap_mm": (0.3, 3.0, "flat", "assumed: travel to the first contact"),
    "command_lag_s": (0.003, 0.1, "log", "assumed: from the output bit to the first motion"),
    "rest_s": (0.15, 1.8, "log", "assumed"),
    "hold_s": (0.2, 6.0, "log", "assumed"),
    # the arm
    "lift_mm_s": (4, 250, "log", "assumed: careful lifts; ur: movel's default is 250"),
    "lift_mm_s2": (80, 3000, "log", "ur: movel's default is 1200"),
    "lift_mm": (8, 60, "log", "assumed"),
    "lift_smooth_s": (0.002, 0.016, "log", "ur: controller cycles of 8 and 2 ms; the jerk is limited"),
    # friction
    "friction": (0.3, 1.3, "log", "assumed: rubber and printed filament on common objects"),
    "friction_drop": (0.02, 0.6, "log", "assumed: static to kinetic friction of rubber"),
    "slip_relax_s": (0.0005, 0.006, "log", "assumed: recoil of a soft skin of some ten grams per millimetre"),
    "friction_spread": (0.01, 0.25, "log", "assumed: friction along the object"),
}

RIG_CHOICES = {
    "dots": ({"dark": (0.7, {}), "bright": (0.3, {})}, "paper: black and white markers; tip: white pins on black"),
    "grid": ({"triangles": (0.6, {}), "squares": (0.4, {})}, "tip"),
    "recorder": ({"record.py of a UR10": (0.25, {}), "record.py of a UR10e": (0.25, {}), "ur_rtde": (0.25, {}), "tactile record": (0.25, {})}, "ur"),
    "imu": ({"800 Hz": (0.7, {}), "400 Hz": (0.15, {"imu_hz": (397, 405, "flat", "dvx: half")}),
             "200 Hz": (0.15, {"imu_hz": (198, 203, "flat", "dvx: a quarter")})}, "assumed: the rate can be set"),
}
RUN_CHOICES = {
    "drive": ({"servo": (0.6, {}),
               "cylinder": (0.2, {"press_mm_s": (8, 50, "log", "air"), "stage_mm_s2": (300, 5000, "log", "assumed"),
                                  "brake_part": (5, 20, "log", "assumed: it runs against a stop"), "uneven": (0.0, 0.6, "flat", "air")}),
               "hand": (0.2, {"press_mm_s": (3, 50, "log", "hand: slow to quick, its highest speed"), "uneven": (0.1, 0.7, "flat", "hand")})},
              "assumed: what closes the gripper"),
    "lift": ({"trapezoid": (0.6, {}), "s-curve": (0.4, {"lift_smooth_s": (0.03, 0.15, "log", "assumed: motion planners with limited jerk")})}, "ur"),
}
COLUMN_US = 0.305          # dvx: stamp of a column after its right neighbour
WIDTH, HEIGHT = 640, 480   # dvx


def draw_rows(rng, rows, choices):
    numbers = {}
    for name, (kinds, _) in choices.items():
        numbers[name] = str(rng.choice(list(kinds), p=[part for part, _ in kinds.values()]))
        rows = {**rows, **kinds[numbers[name]][1]}
    for name, (low, high, scale, _) in rows.items():
        u = rng.random()
        numbers[name] = math.exp(math.log(low) + u * math.log(high / low)) if scale == "log" else low + u * (high - low)
    return numbers


def fit(numbers):
    """What follows from other numbers."""
    n = numbers
    n["threshold_off"] = n["threshold_on"] * n["threshold_ratio"]
    n["dot_radius_mm"] = n["dot_part"] * n["pitch_mm"]
    # Nobody uses dots that the camera hardly sees: the lens is focused and the dots are painted until it sees them.
    n["blur_px"] = min(n["blur_px"], 0.7 * n["dot_radius_mm"] * n["px_per_mm"])
    n["dot_contrast"] = max(n["dot_contrast"], 2 * max(n["threshold_on"], n["threshold_off"]))
    n["patch_mm"] = max(n["patch_mm"], 1.5 * n["depth_mm"], 0.8 * n["lever_mm"])  # hertz: the skin's tilt stays small
    n["shear_mm"] = 1.5 * n["friction"] * n["depth_mm"]  # hertz: Cattaneo and Mindlin for a skin that keeps its volume
    n["gap_mm"] = min(n["gap_mm"], 2.5 * n["press_mm_s"])   # a slow stage starts near the object
    n["lift_mm"] = max(min(n["lift_mm"], 3.5 * n["lift_mm_s"]), 3 + 1.5 * n["shear_mm"] / n["transmission"])  # seconds, and enough to slip
    n["relief_mm"] = min(n["relief_mm"], 0.15 * n["depth_mm"])
    n["shape_mm"] = min(n["shape_mm"], 0.3 * n["depth_mm"])
    return n


def draw(rng, given=None, rig=None):
    """All numbers of one run. `given` fixes some of them; `rig` draws what a session's runs share."""
    numbers = fit({**draw_rows(rig or rng, RIG, RIG_CHOICES), **draw_rows(rng, RUN, RUN_CHOICES)})
    numbers.update(given or {})
    return numbers
