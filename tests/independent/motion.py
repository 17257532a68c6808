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
    lift: np.ndarray         # displacement of the arm
    shake: np.ndarray        # of the gripper against the arm
    stage: np.ndarray        # displacement of the stage
    commands: list           # (time, on) of the stage's output
    truths: list             # intervals: dicts with what, class, labelled, start, end, gross (times in s)
    lift_start: float | None
    press_speeds: list       # of the stage at each first contact, or its highest if it presses deeper


def profile(travel, speed, acceleration):
    speed = min(speed, math.sqrt(abs(travel) * acceleration))
    return speed, speed / acceleration, abs(travel) / speed - speed / acceleration


def duration(travel, speed, acceleration):
    _, rise, flat = profile(travel, speed, acceleration)
    return 2 * rise + flat


def ramp(t, start, travel, speed, acceleration):
    """Displacement of a move that speeds up evenly, keeps its speed and slows down evenly."""
    speed, rise, flat = profile(travel, speed, acceleration)
    s = np.clip(t - start, 0, 2 * rise + flat)
    up, down, middle = np.minimum(s, rise), np.maximum(s - rise - flat, 0), np.clip(s - rise, 0, flat + rise)
    return math.copysign(1, travel) * (0.5 * acceleration * up**2 + speed * middle - 0.5 * acceleration * down**2)


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


def sheared(base, depth, numbers, rng, held):
    """Shear of the skin by the displacement `base` of the gripper against the object: sticks, slips when the limit is reached, sticks again.

    `held` is the largest shear that the object's weight causes; the object leaves the table then, and nothing slips.
    """
    n, full = len(base), numbers["depth_mm"]
    rough = np.convolve(rng.standard_normal(4039), np.ones(40), "valid")  # along 100 mm, a new value each mm
    rough = 1 + numbers["friction_spread"] * rough / rough.std()
    shear, slid, gross, sliding, q, travel = np.zeros(n), np.zeros(n), np.zeros(n), False, 0.0, 0.0
    limits, fast, back = np.zeros(n), 1 - math.exp(-STEP / numbers["slip_relax_s"]), 1 - math.exp(-STEP / numbers["recovery_s"])
    ever, slipping, long = 0.0, 0, max(2, round(3 * numbers["slip_relax_s"] / STEP))
    steady = rng.random() < 0.3  # the others stick again after each slip, as rubber does
    steps = np.diff(base, prepend=base[0]).tolist()
    for i, (db, d) in enumerate(zip(steps, depth.tolist())):
        limit = numbers["shear_mm"] * min(1.0, d / full) * rough[min(int(travel * 40), 3999)]
        limits[i] = limit
        q += db
        if held is not None and abs(q) > held:
            q = math.copysign(held, q)
        if limit <= 1e-6:
            q -= back * q
            ever = 0.0
        elif sliding or abs(q) >= limit:
            rest = math.copysign(limit * (1 - numbers["friction_drop"]), q)
            before, q = q, q + (rest - q) * fast if sliding else math.copysign(limit, q)
            travel += abs(before - q) if sliding else 0.0
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
    """Moves of stage and arm, one after the other."""

    def __init__(self, numbers, rng):
        self.numbers, self.rng, self.now = numbers, rng, numbers["rest_s"]
        self.stage_moves, self.commands, self.arm_moves, self.jolts, self.knocks = [], [], [], [], []

    def move_stage(self, travel, speed=None):
        n, speed = self.numbers, speed or self.numbers["press_mm_s"]
        start = self.now + n["command_lag_s"]
        self.commands.append((self.now, travel > 0))
        self.stage_moves.append((start, travel, speed))
        self.now = start + duration(travel, speed, n["stage_mm_s2"])
        return self

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

    def move_arm(self, travel=None):
        """A lift, or a move down if `travel` is negative."""
        n = self.numbers
        travel = n["lift_mm"] if travel is None else travel
        begin, self.now = self.now, self.now + duration(travel, n["lift_mm_s"], n["lift_mm_s2"]) + n["lift_smooth_s"]
        self.arm_moves.append((begin, travel, self.now))
        return self


def stage_and_presses(plan, t):
    """Displacement of the stage, depth of the object in the skin, and the truths of presses and releases."""
    n, stage, truths, speeds = plan.numbers, np.zeros(len(t)), [], []
    for start, travel, speed in plan.stage_moves:
        stage += ramp(t, start, travel, speed, n["stage_mm_s2"])
    thread = n.get("thread_mm", 1.0)
    stage += n.get("uneven", 0.0) * thread / (2 * math.pi) * (np.cos(2 * math.pi * stage / thread) - 1)
    depth = np.maximum(0, stage - n["gap_mm"])
    for start, travel, speed in plan.stage_moves:
        end = start + duration(travel, speed, n["stage_mm_s2"])
        before, after = np.interp(start, t, depth), np.interp(end, t, depth)
        if travel > 0 and after > 0:
            during = slice(int(start / STEP), int(end / STEP) + 2)
            begin = start if before > 0 else float(np.interp(n["gap_mm"] + 1e-9, stage[during], t[during]))
            truths.append(interval("press", begin, end, labelled=True))
            speeds.append(float(profile(travel, speed, n["stage_mm_s2"])[0] if before > 0 else np.interp(begin, t, np.gradient(stage, STEP))))
        elif travel < 0 and before > 0:
            gone = first_time(t, (t > start) & (depth == 0), end)
            truths.append(interval("release", start, gone + 3 * n["recovery_s"] if after == 0 else end))
    return stage, depth, truths, speeds


def shaken_arm(plan, t, lift):
    """Ringing of the mount by the arm's own moves and by knocks, and the truths of the knocks."""
    n, truths = plan.numbers, []
    acceleration = np.gradient(np.gradient(lift, STEP), STEP)
    for start, travel in plan.knocks:
        acceleration[int(start / STEP)] -= 2 * math.pi * n["mount_hz"] * travel / n["mount_part"] / STEP
        truths.append(interval("vibration", start, start + 3 / (2 * math.pi * n["mount_hz"] * n["mount_damping"])))
    return shaken(acceleration, n["mount_hz"], n["mount_damping"], n["mount_part"]), truths


def jolted(plan, t, base):
    """Adds the object's own small motions to the displacement of the gripper, and their truths."""
    truths = []
    for start, shear, seconds in plan.jolts:
        base = base + shear * (1 - np.exp(-np.maximum(0, t - start) / seconds))
        truths.append(interval("micro-slip", start, start + 4 * seconds))
    return base, truths


def move(plan, rng, firm=False, leaves_after=None, tail=0.8):
    """Carries out the plan. `firm`: the object comes with the gripper. `leaves_after`: lift [mm] after which the tips pass the object's edge."""
    n = plan.numbers
    t = np.arange(0, plan.now + tail, STEP)
    stage, depth, truths, speeds = stage_and_presses(plan, t)
    lift = np.zeros(len(t))
    for start, travel, _ in plan.arm_moves:
        lift += smooth(ramp(t, start, travel, n["lift_mm_s"], n["lift_mm_s2"]), n["lift_smooth_s"])
    shake, knocked = shaken_arm(plan, t, lift)
    base, more = jolted(plan, t, n["transmission"] * backlash(lift + shake, n["play_mm"]))
    lifts = [x for x in plan.arm_moves if x[1] > 0]
    if leaves_after is not None:
        gone = first_time(t, (t > lifts[0][0]) & (lift > leaves_after + n["shear_mm"]), t[-1])
        depth = depth * np.clip(1 - (t - gone) / 0.04, 0, 1)
        truths = [x for x in truths if x["what"] != "release" or x["start"] < gone]
        truths.append(interval("release", gone, gone + 0.04 + 3 * n["recovery_s"]))
    shear, limit, gross, slid = sheared(base, depth, n, rng, 0.7 * n["shear_mm"] if firm else None)
    truths += more + knocked
    for lifted in lifts:
        truths += lift_truths(t, n, lifted, base, depth, gross, slid, firm)
    return Motion(t, followed(wavy(slid, depth, n, rng), n), shear, limit, gross, slid, lift, shake, stage, plan.commands,
                  sorted(truths, key=lambda x: x["start"]), lifts[0][0] if lifts else None, speeds)


def lift_truths(t, n, lifted, base, depth, gross, slid, firm):
    """The slip begins when the lift begins to shear the skin, and ends when the arm stops or the object is gone."""
    begin, _, stop = lifted
    ringing = interval("vibration", stop, min(t[-1], stop + 3 / (2 * math.pi * n["mount_hz"] * n["mount_damping"])))
    start = first_time(t, (t > begin) & (t < stop) & (depth > 0) & (base > np.interp(begin, t, base) + 1e-6))
    if start is None:
        return [interval("vibration", begin, stop), ringing]
    lost = first_time(t, (t > start) & (depth == 0), stop)
    if firm:
        return [interval("vibration", start, stop), ringing]
    slipped = first_time(t, (t > start) & (t < stop) & (gross > 0) & (slid > np.interp(start, t, slid)))
    return [interval("slip", start, min(stop, lost), labelled=True, gross=slipped), ringing]
