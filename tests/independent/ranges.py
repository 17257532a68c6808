"""Every number that a run is drawn from, with its range and its source.

A row is (low, high, scale, source). `log` draws the logarithm evenly, `flat` the value itself. `assumed` means that no published value was found.
"""
import math

# Sources, by the short name used in the rows.
#   paper   Faris et al., arXiv:2403.10120
#   v2e     Hu, Liu, Delbruck: v2e, CVPR workshops 2021: thresholds, their mismatch, photoreceptor, shot noise
#   esim    Rebecq, Gehrig, Scaramuzza: ESIM, CoRL 2018: crossings interpolated in time, refractory time
#   dvx     measured on recordings of DVXplorer cameras: read-out, stamps of columns, noise, hot pixels, IMU rate
#   hertz   Johnson, Contact Mechanics, 1985, chapters 4 and 7: Hertz; Cattaneo and Mindlin
#   tip     TacTip, GelSight and FingerVision: markers of 0.5 to 1.2 mm radius and pitch of 1.5 to 3 mm on soft skins
#   ur      URScript manual and RTDE guide: movel, 125 Hz (CB) and 500 Hz (e-Series)
RANGES = {
    # the picture
    "px_per_mm": (13, 19, "flat", "paper: the skin is 40 mm wide and fills most of the picture"),
    "pitch_mm": (1.8, 2.8, "flat", "tip"),
    "dot_radius_mm": (0.45, 0.75, "flat", "tip"),
    "dot_contrast": (0.7, 1.6, "flat", "assumed: natural logarithm of skin over dot"),
    "blur_px": (1.2, 2.4, "flat", "assumed: lens close to its near limit"),
    "grid_jitter": (0.02, 0.12, "flat", "assumed: part of the pitch"),
    "distance_mm": (24, 40, "flat", "assumed: lens to skin in a finger of a few centimetres"),
    # the skin
    "lever_mm": (0.6, 2.5, "flat", "tip: pins of 1 to 3 mm inside the skin turn with its tilt; a squeezed gel flows outwards as far"),
    "reach_mm": (7, 14, "flat", "assumed: the skin is clamped at its border"),
    "shade_per_mm": (-0.18, 0.18, "flat", "assumed: light falls off with the distance from the LED strips"),
    "shade_per_tilt": (-0.35, 0.35, "flat", "assumed: light falls from above and below"),
    "creep_part": (0.02, 0.12, "flat", "hertz: rubber under constant load creeps by a few to ten percent"),
    "creep_s": (0.08, 0.6, "log", "assumed"),
    "recovery_s": (0.006, 0.03, "log", "assumed: a skin that is let go returns by itself"),
    # the object
    "depth_mm": (0.35, 1.3, "flat", "paper: a light press, not enough to hold the object"),
    "patch_mm": (2.0, 5.5, "flat", "assumed: radius of the contact at full depth"),
    "patch_growth": (0.15, 0.5, "flat", "hertz: 0.5 for a sphere; flat objects touch nearly at once"),
    "patch_stretch": (0.7, 1.5, "log", "assumed: long contacts"),
    "patch_off_mm": (0, 4, "flat", "assumed"),
    "relief_mm": (0.01, 0.08, "log", "assumed: printed and textured surfaces"),
    "relief_length_mm": (0.8, 3.0, "flat", "assumed"),
    "shape_mm": (0.02, 0.2, "log", "assumed: objects are not straight along the line that they slip"),
    "shape_length_mm": (4, 10, "flat", "assumed"),
    # the stage
    "press_mm_s": (1, 20, "log", "assumed: small linear stages"),
    "stage_mm_s2": (100, 500, "log", "assumed"),
    "gap_mm": (0.6, 3.0, "flat", "assumed: travel to the first contact"),
    "command_lag_s": (0.01, 0.06, "flat", "assumed: from the output bit to the first motion"),
    "rest_s": (0.7, 1.6, "flat", "assumed"),
    "hold_s": (0.6, 2.2, "flat", "assumed"),
    # the arm
    "lift_mm_s": (15, 80, "log", "assumed: careful lifts; ur: movel's default is 250"),
    "lift_mm_s2": (250, 1200, "log", "ur: movel's default is 1200"),
    "lift_mm": (20, 50, "flat", "assumed"),
    "lift_smooth_s": (0.004, 0.016, "log", "ur: controller cycles of 8 and 2 ms; the jerk is limited"),
    "play_mm": (0, 0.12, "flat", "assumed: play of stage and mount; half of the runs have none"),
    "mount_hz": (22, 60, "log", "assumed: first mode of arm and gripper"),
    "mount_damping": (0.04, 0.15, "log", "assumed"),
    "mount_part": (0.05, 0.3, "flat", "assumed"),
    "mount_angle_deg": (-12, 12, "flat", "assumed: between lift and columns of the camera"),
    # friction
    "shear_mm": (0.35, 1.3, "flat", "hertz: shear at which the last point slips; some tenths of the contact's size on soft skins"),
    "transmission": (0.6, 0.97, "flat", "assumed: the rest bends the finger"),
    "friction_drop": (0.06, 0.5, "log", "assumed: static to kinetic friction of rubber"),
    "slip_relax_s": (0.0006, 0.003, "log", "assumed: recoil of a soft skin of some ten grams per millimetre"),
    "friction_spread": (0.03, 0.18, "flat", "assumed: friction along the object"),
    # the camera
    "threshold_on": (0.16, 0.34, "flat", "v2e: 0.2 nominal; the DVXplorer's default is less sensitive"),
    "threshold_off": (0.16, 0.34, "flat", "v2e"),
    "threshold_spread": (0.02, 0.05, "flat", "v2e: 0.03"),
    "photoreceptor_s": (0.0002, 0.0015, "log", "v2e: some hundred Hz in dim light, thousands in bright light"),
    "refractory_s": (0.0002, 0.001, "log", "esim, v2e"),
    "noise_hz_per_px": (0.05, 0.45, "log", "dvx: 0.44 in a still, dim scene; less is assumed in a lit one"),
    "noise_spread": (0.5, 1.2, "flat", "dvx: logarithm of the rate from pixel to pixel"),
    "hot_pixels": (15, 140, "log", "dvx: 49 of 320 x 240, 130 of 640 x 480"),
    "readout_us": (195.0, 197.3, "flat", "dvx: 195.163 to 197.283"),
    "imu_hz": (795, 810, "flat", "dvx: 807"),
    "imu_noise_g": (0.002, 0.008, "log", "assumed: consumer MEMS at full bandwidth"),
    # clocks and logs
    "drift_ppm": (-60, 60, "flat", "assumed: quartz, up to 50 ppm each"),
    "pose_noise_mm": (0.003, 0.02, "log", "assumed: encoders of an arm that stands still"),
    "speed_noise_mm_s": (0.05, 0.4, "log", "assumed"),
    "row_loss": (0.0, 0.01, "flat", "measured on UR logs: steps of 10 ms with some of 12, 14 and 30"),
}
COLUMN_US = 0.305          # dvx: stamp of a column after its right neighbour
WIDTH, HEIGHT = 640, 480   # dvx


def draw(rng, given=None):
    """All numbers of one run. `given` fixes some of them."""
    numbers = {}
    for name, (low, high, scale, _) in RANGES.items():
        u = rng.random()  # drawn even if the value is given, so that a given value changes no other
        numbers[name] = math.exp(math.log(low) + u * math.log(high / low)) if scale == "log" else low + u * (high - low)
    numbers.update(given or {})
    return numbers
