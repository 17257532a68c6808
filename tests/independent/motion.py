"""What stage, arm, skin and object do, on a time axis of 0.25 ms. Lengths in mm, times in s from the start of the recording."""
import dataclasses
import math

import numpy as np

STEP = 0.00025


@dataclasses.dataclass
class Motion:
    t: np.ndarray            # time
    depth: np.ndarray        # of the contact's centre in the skin
    shear: np.ndarray        # of the skin where it sticks to the object
    limit: np.ndarray        # shear at which the whole contact slips
    gross: np.ndarray        # 1 while the whole contact has slipped and did not stick again from rest
    slid: np.ndarray         # displacement of the object over the skin
    turn: np.ndarray         # of the skin where it sticks to the object that is turned [rad]
    sway: np.ndarray         # of the whole skin against the camera
    lift: np.ndarray         # displacement of the arm
    wrist: np.ndarray        # rotation of the arm's tool about the grip [rad]
    shake: np.ndarray        # of the gripper against the arm
    stage: np.ndarray        # displacement of the stage
    carried: np.ndarray      # height of the object that comes with the gripper
    aside: np.ndarray        # way of the object that a hand takes out of the grip
    commands: list           # (time, on) of the stage's output
    truths: list             # intervals: dicts with what, class, labelled, start, end, gross (times in s)
    lift_start: float | None
    press_speeds: list       # of stage or object at each first contact, or its highest if it presses deeper
    hum_hz: float = 0.0      # of a machine next to the arm


def profile(travel, speed, acceleration, braking=None):
    """Highest speed, and the seconds of speeding up, of even speed and of braking."""
    braking = braking or acceleration
    speed = min(speed, math.sqrt(2 * abs(travel) * acceleration * braking / (acceleration + braking)))
    rise, fall = speed / acceleration, speed / braking
    return speed, rise, max(0.0, abs(travel) / speed - 0.5 * (rise + fall)), fall


def duration(travel, speed, acceleration, braking=None):
    return sum(profile(travel, speed, acceleration, braking)[1:])


def ramp(t, start, travel, speed, acceleration, braking=None):
    """Displacement of a move that speeds up evenly, keeps its speed and slows down evenly."""
    speed, rise, flat, fall = profile(travel, speed, acceleration, braking)
    s = np.clip(t - start, 0, rise + flat + fall)
    up, down, middle = np.minimum(s, rise), np.maximum(s - rise - flat, 0), np.clip(s - rise, 0, flat + fall)
    return math.copysign(1, travel) * (0.5 * acceleration * up**2 + speed * middle - 0.5 * (braking or acceleration) * down**2)


def least_jerk(t, start, seconds):
    """From 0 to 1 as a hand moves; its highest speed is 1.875 of its mean."""
    s = np.clip((t - start) / seconds, 0, 1)
    return s**3 * (10 - 15 * s + 6 * s**2)


def span(travel, speed, n):
    """Seconds that stage or hand take."""
    return 1.875 * abs(travel) / speed if n["drive"] == "hand" else duration(travel, speed, n["stage_mm_s2"], n["brake_part"] * n["stage_mm_s2"])


def course(t, start, travel, speed, n):
    """Displacement of stage or hand. Its speed rises and falls by the part `uneven`: with each turn of a screw, or at a hand's tremor."""
    seconds = span(travel, speed, n)
    if n["drive"] == "hand":
        part, waves = least_jerk(t, start, seconds), max(1, round(9 * seconds))
    else:
        part = ramp(t, start, travel, speed, n["stage_mm_s2"], n["brake_part"] * n["stage_mm_s2"]) / travel
        waves = max(1, round(abs(travel) / n["thread_mm"]))
    phase, size = n["uneven_phase"], n["uneven"] / (2 * math.pi * waves)
    return travel * (part + size * (np.sin(2 * math.pi * waves * part + phase) - math.sin(phase)))


def smooth(values, seconds):
    """Mean over the past, so that a motion never begins before its command."""
    n = max(1, round(seconds / STEP))
    total = np.concatenate([np.full(n, values[0]), values]).cumsum()
    return (total[n:] - total[:-n]) / n


def shaken(acceleration, hz, damping, part):
    """Displacement of a mass on the arm that hangs on a damped spring."""
    w, y, v, out = 2 * math.pi * hz, 0.0, 0.0, np.empty(len(acceleration))
    for i, a in enumerate(acceleration.tolist()):
        v += STEP * (-a - 2 * damping * w * v - w * w * y)
        y += STEP * v
        out[i] = y
    return part * out


def followed(depth, numbers):
    """Depth of the skin: it follows the object at once, creeps further, and returns by itself when it is let go."""
    skin, creep, out = 0.0, 0.0, np.empty(len(depth))
    back, slow = STEP / numbers["recovery_s"], STEP / numbers["creep_s"]
    for i, d in enumerate(depth.tolist()):
        skin = d if d >= skin else max(d, skin - back * skin)
        creep += slow * (numbers["creep_part"] * d - creep)
        out[i] = skin + creep
    return out


def sheared(base, depth, numbers, rng, held=None, grip=None):
    """Shear of the skin by the displacement `base` of the gripper against the object: sticks, slips when the limit is reached, sticks again.

    `held`: the largest shear that the object's weight causes, as a part of the limit; the object leaves the table then, and nothing slips. Infinite
    where the object cannot come along. `grip`: part of the friction that is left.
    """
    n, full = len(base), numbers["depth_mm"]
    held = np.full(n, np.inf) if held is None else held
    grip = np.ones(n) if grip is None else grip
    rough = np.convolve(rng.standard_normal(4039), np.ones(40), "valid")  # along 100 mm, a new value each mm
    rough = np.maximum(0.3, 1 + numbers["friction_spread"] * rough / rough.std())
    shear, slid, gross, sliding, q, travel = np.zeros(n), np.zeros(n), np.zeros(n), False, 0.0, 0.0
    limits, fast, back = np.zeros(n), 1 - math.exp(-STEP / numbers["slip_relax_s"]), 1 - math.exp(-STEP / numbers["recovery_s"])
    ever, slipping, long = 0.0, 0, max(2, round(3 * numbers["slip_relax_s"] / STEP))
    steady = rng.random() < 0.3  # the others stick again after each slip, as rubber does
    steps = np.diff(base, prepend=base[0]).tolist()
    for i, (db, d, h, g) in enumerate(zip(steps, depth.tolist(), held.tolist(), grip.tolist())):
        limit = g * numbers["shear_mm"] * min(1.0, d / full) * rough[min(int(travel * 40), 3999)]
        limits[i] = limit
        q += db
        if h < math.inf and abs(q) > h * limit:
            q = math.copysign(h * limit, q)
        if limit <= 1e-6:
            q -= back * q
            ever = 0.0
        elif sliding or abs(q) >= limit:
            rest = math.copysign(limit * (1 - numbers["friction_drop"]), q)
            before, slips = q, sliding or abs(q) > 1.1 * limit
            q = q + (rest - q) * fast if slips else math.copysign(limit, q)
            travel += abs(before - q) if slips else 0.0
            slipping = slipping + 1 if sliding else 0
            sliding, ever = (steady and abs(q) > 0.98 * abs(rest)) or slipping < long, 1.0
        shear[i], slid[i], gross[i] = q, travel, ever
    return shear, limits, gross, slid


def wavy(slid, depth, numbers, rng):
    """Depth of the contact as the object's shape passes it."""
    waves = rng.uniform(0.5, 2, 4) / numbers["shape_length_mm"]
    height = sum(np.sin(2 * math.pi * w * slid + p) - math.sin(p) for w, p in zip(waves, rng.uniform(0, 2 * math.pi, 4))) / 2
    return np.maximum(0.3 * depth, depth * (1 + numbers["shape_mm"] / numbers["depth_mm"] * height))


def interval(what, start, end, labelled=False, gross=None, kind=None):
    kinds = {"press": "press", "release": "press", "re-contact": "press", "relaxation": "press"}
    return {"what": what, "class": kind or kinds.get(what, "slip"), "labelled": labelled, "start": start, "end": end, "gross": gross}


def first_time(t, mask, default=None):
    found = np.flatnonzero(mask)
    return float(t[found[0]]) if len(found) else default


def backlash(travel, play):
    """What is left of a displacement beyond the play of the mount, which a move in the other direction crosses first. A lift crosses it too."""
    out, now = np.empty(len(travel)), travel[0]
    for i, x in enumerate(travel.tolist()):
        now = max(x - play, min(x, now))
        out[i] = now
    return out


class Plan:
    """Moves of stage, object and arm, one after the other."""

    def __init__(self, numbers, rng):
        self.numbers, self.rng, self.now = numbers, rng, numbers["rest_s"]
        self.stage_moves, self.object_moves, self.commands, self.arm_moves = [], [], [], []
        self.jolts, self.knocks, self.pushes, self.twists, self.hum = [], [], [], [], (0.0, 0.0)

    def move_stage(self, travel, speed=None):
        n, speed = self.numbers, speed or self.numbers["press_mm_s"]
        start = self.now + n["command_lag_s"]
        self.commands.append((self.now, travel > 0))
        self.stage_moves.append((start, travel, speed, n))
        self.now = start + span(travel, speed, n)
        return self

    def move_object(self, travel, speed):
        """A hand moves the object towards the skin, or away from it."""
        by_hand = {**self.numbers, "drive": "hand"}
        self.object_moves.append((self.now, travel, speed, by_hand))
        return self.wait(span(travel, speed, by_hand))

    def wait(self, seconds):
        self.now += seconds
        return self

    def jolt(self, shear, seconds):
        """The object moves by itself while it is held."""
        self.jolts.append((self.now, shear, seconds))
        return self

    def knock(self, travel):
        """Somebody bumps into the arm: its mount rings with this first swing."""
        self.knocks.append((self.now, travel))
        return self

    def push(self, travel, sway, seconds):
        """Somebody pushes the arm, and it comes back; the skin sways against the camera."""
        self.pushes.append((self.now, travel, sway, seconds))
        return self.wait(seconds)

    def twist(self, angle, seconds, by_arm=False, slips=False):
        """A hand turns the object in the grip, or the arm turns the grip."""
        self.twists.append((self.now, angle, seconds, by_arm, slips))
        return self.wait(seconds)

    def move_arm(self, travel=None):
        """A lift, or a move down if `travel` is negative."""
        n = self.numbers
        travel = n["lift_mm"] if travel is None else travel
        begin, self.now = self.now, self.now + duration(travel, n["lift_mm_s"], n["lift_mm_s2"]) + n["lift_smooth_s"]
        self.arm_moves.append((begin, travel, self.now))
        return self


def closed_by(moves, t):
    return sum((course(t, *move) for move in moves), np.zeros(len(t)))


def presses_and_releases(plan, t, closed):
    """Depth of the object in the skin, and the truths of presses and releases."""
    n, truths, speeds = plan.numbers, [], []
    depth = np.maximum(0, closed - n["gap_mm"])
    for start, travel, speed, drive in sorted(plan.stage_moves + plan.object_moves, key=lambda x: x[0]):
        end = start + span(travel, speed, drive)
        before, after = np.interp(start, t, depth), np.interp(end, t, depth)
        if travel > 0 and after > 0:
            during = slice(int(start / STEP), int(end / STEP) + 2)
            begin = start if before > 0 else float(np.interp(n["gap_mm"] + 1e-9, closed[during], t[during]))
            truths.append(interval("press", begin, end, labelled=True))
            rate = np.gradient(closed[during], STEP)
            speeds.append(float(rate.max() if before > 0 else np.interp(begin, t[during], rate)))
        elif travel < 0 and before > 0:
            gone = first_time(t, (t > start) & (depth == 0), end)
            truths.append(interval("release", start, gone + 3 * n["recovery_s"] if after == 0 else end))
    return depth, truths, speeds


def ringing(n, start):
    return interval("vibration", start, start + 3 / (2 * math.pi * n["mount_hz"] * n["mount_damping"]))


def shaken_arm(plan, t, lift):
    """Motion of the gripper against the arm by the arm's own moves, knocks, pushes and a machine; the skin's sway by the last two; their truths."""
    n, truths, sway = plan.numbers, [], np.zeros(len(t))
    acceleration = np.gradient(np.gradient(lift, STEP), STEP)
    for start, travel in plan.knocks:
        acceleration[int(start / STEP)] -= 2 * math.pi * n["mount_hz"] * travel / n["mount_part"] / STEP
        truths.append(ringing(n, start))
    shake = shaken(acceleration, n["mount_hz"], n["mount_damping"], n["mount_part"])
    for start, travel, swing, seconds in plan.pushes:
        bump = np.sin(math.pi * np.clip((t - start) / seconds, 0, 1))**2
        shake, sway = shake + travel * bump, sway + swing * bump
        truths.append(interval("vibration", start, start + seconds))
    hz, swing = plan.hum
    if hz:
        shake, sway = shake + 0.3 * swing * np.sin(2 * math.pi * hz * t), sway + swing * np.sin(2 * math.pi * hz * t)
        truths.append(interval("vibration", 0.0, float(t[-1])))
    return shake, sway, truths


def jolted(plan, t, base):
    """Adds the object's own small motions to the displacement of the gripper, and their truths."""
    truths = []
    for start, shear, seconds in plan.jolts:
        base = base + shear * (1 - np.exp(-np.maximum(0, t - start) / seconds))
        truths.append(interval("micro-slip", start, start + 4 * seconds))
    return base, truths


def twisted(plan, t, depth, rng):
    """Turn of the skin that sticks to the object, what slides, the arm's own turn, and the truths."""
    n, truths, zero = plan.numbers, [], np.zeros(len(t))
    if not plan.twists:
        return zero, zero, zero, truths
    radius = 0.6 * n["patch_mm"]  # of the ring whose friction holds the object
    parts = [angle * least_jerk(t, start, seconds) for start, angle, seconds, _, _ in plan.twists]
    shear, _, gross, slid = sheared(radius * sum(parts), depth, n, rng)
    for part, (begin, _, seconds, _, slips) in zip(parts, plan.twists):
        start = first_time(t, (t > begin) & (np.abs(radius * part) > 1e-6), begin)
        slipped = first_time(t, (t > start) & (gross > 0) & (slid > np.interp(start, t, slid)))
        truths.append(interval("slip" if slips else "turn", start, begin + seconds, slips, slipped if slips else None))
    return shear / radius, slid, sum((part for part, x in zip(parts, plan.twists) if x[3]), zero), truths


def carried_by(lift, t, lifted, firm, late):
    """Height of the object, the shear that it takes as a part of the limit, and the part of the friction that is left."""
    free, grip = np.full(len(t), np.inf), np.ones(len(t))
    if firm:
        return lift, np.full(len(t), 0.6), grip
    if late is None:
        return np.zeros(len(t)), free, grip
    seconds, caught = late
    lost = lifted[0] + seconds
    height = float(np.interp(lost, t, lift))
    falls = 0 if caught else 4900 * np.maximum(0, t - lost)**2
    return np.where(t < lost, lift, np.maximum(0, height - falls)), np.where(t < lost, 0.6, np.inf), np.where((t < lost) | caught, 1.0, 0.4)


def move(plan, rng, firm=False, late=None, leaves_after=None, tail=0.8):
    """Carries out the plan. `firm`: the object comes with the gripper. `late`: it does so for these seconds, then it is caught or the grip fails
    (seconds, caught). `leaves_after`: lift [mm] after which the tips pass the object's edge."""
    n = plan.numbers
    t = np.arange(0, plan.now + tail, STEP)
    stage, brought = closed_by(plan.stage_moves, t), closed_by(plan.object_moves, t)
    depth, truths, speeds = presses_and_releases(plan, t, stage + brought)
    lift = np.zeros(len(t))
    for start, travel, _ in plan.arm_moves:
        lift += smooth(ramp(t, start, travel, n["lift_mm_s"], n["lift_mm_s2"]), n["lift_smooth_s"])
    shake, sway, knocked = shaken_arm(plan, t, lift)
    base, more = jolted(plan, t, n["transmission"] * backlash(lift + shake, n["play_mm"]))
    lifts = [x for x in plan.arm_moves if x[1] > 0]
    if leaves_after is not None:
        gone = first_time(t, (t > lifts[0][0]) & (lift > leaves_after + n["shear_mm"]), t[-1])
        depth = depth * np.clip(1 - (t - gone) / 0.04, 0, 1)
        truths = [x for x in truths if x["what"] != "release" or x["start"] < gone]
        truths.append(interval("release", gone, gone + 0.04 + 3 * n["recovery_s"]))
    carried, held, grip = carried_by(lift, t, lifts[0] if lifts else None, firm, late)
    shear, limit, gross, slid = sheared(base, depth, n, rng, held, grip)
    turn, turned, wrist, twists = twisted(plan, t, depth, rng)
    truths += more + knocked + twists
    for lifted in lifts:
        truths += lift_truths(t, n, lifted, base, depth, gross, slid, firm, late)
    return Motion(t, followed(wavy(slid, depth, n, rng), n), shear, limit, gross, slid + turned, turn, sway, lift, wrist, shake, stage, carried,
                  -brought, plan.commands, sorted(truths, key=lambda x: x["start"]), lifts[0][0] if lifts else None, speeds, plan.hum[0])


def lift_truths(t, n, lifted, base, depth, gross, slid, firm, late):
    """The slip begins when the lift begins to shear the skin, or when the object stops to come along; it ends when the arm stops or the object is
    gone."""
    begin, _, stop = lifted
    start = first_time(t, (t > begin) & (t < stop) & (depth > 0) & (base > np.interp(begin, t, base) + 1e-6))
    if start is None:
        return [interval("vibration", begin, stop), ringing(n, stop)]
    lost = first_time(t, (t > start) & (depth == 0), stop)
    if firm:
        return [interval("firm shear", start, stop), ringing(n, stop)]
    held = [] if late is None else [interval("firm shear", start, begin + late[0])]
    start = start if late is None else begin + late[0]
    slipped = first_time(t, (t > start) & (t < stop) & (gross > 0) & (slid > np.interp(start, t, slid)))
    return held + [interval("slip", start, min(stop, lost), labelled=True, gross=slipped), ringing(n, stop)]
