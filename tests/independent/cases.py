"""The courses of runs: the ordinary one of the paper, and what else happens."""
import dataclasses

from motion import Motion, Plan, move


@dataclasses.dataclass
class Scene:
    motion: Motion
    numbers: dict
    begins_at: float = 0.0        # s of the motion at which the recording begins
    ends_at: float | None = None  # s of the motion at which it ends
    imu: bool = True
    robot: bool = True
    film: bool = True
    commands: bool = True
    camera_on_stage: bool = False
    firm: bool = False


def devices_of(rng):
    return {"imu": bool(rng.random() < 0.5), "film": bool(rng.random() < 0.7), "commands": bool(rng.random() < 0.5),
            "camera_on_stage": bool(rng.random() < 0.5)}


def closing(numbers):
    return numbers["gap_mm"] + numbers["depth_mm"]


def pressed(numbers, rng, hold=None):
    """A plan that rests, presses and holds. In half of the runs the mount has no play."""
    if rng.random() < 0.5:
        numbers["play_mm"] = 0.0
    return Plan(numbers, rng).move_stage(closing(numbers)).wait(numbers["hold_s"] if hold is None else hold)


def ordinary(numbers, rng):
    """The run of the paper: a light press, a hold, a lift that fails. In half of the runs the stage opens again at the end."""
    plan = pressed(numbers, rng).move_arm()
    if rng.random() < 0.5:
        plan.wait(rng.uniform(0.4, 1.0)).move_stage(-closing(numbers))
    return Scene(move(plan, rng), numbers, **devices_of(rng))


def second_press(numbers, rng):
    """The stage opens and presses a second time before the lift."""
    plan = pressed(numbers, rng).move_stage(-closing(numbers)).wait(rng.uniform(0.3, 1.0)).move_stage(closing(numbers))
    plan.wait(rng.uniform(0.5, 1.2)).move_arm()
    return Scene(move(plan, rng), numbers, **devices_of(rng))


def deeper_press(numbers, rng):
    """The stage presses deeper after a hold."""
    plan = pressed(numbers, rng, 0.6).move_stage(0.4 * numbers["depth_mm"]).wait(rng.uniform(0.5, 1.2)).move_arm()
    return Scene(move(plan, rng), numbers, **devices_of(rng))


def release_before_lift(numbers, rng):
    """The stage opens before the lift: the arm lifts nothing."""
    plan = pressed(numbers, rng).move_stage(-closing(numbers)).wait(rng.uniform(0.4, 1.0)).move_arm()
    return Scene(move(plan, rng), numbers, **devices_of(rng))


def firm_lift(numbers, rng):
    """The object comes with the gripper: the skin shears by the object's weight, and nothing slips."""
    plan = pressed(numbers, rng).move_arm()
    return Scene(move(plan, rng, firm=True), numbers, firm=True, **devices_of(rng))


def micro_slips(numbers, rng):
    """The object jerks a few times while it is held, then the lift fails."""
    plan = pressed(numbers, rng, 0.5)
    for _ in range(int(rng.integers(1, 4))):
        plan.jolt(rng.uniform(0.06, 0.2) * numbers["shear_mm"], rng.uniform(0.002, 0.01)).wait(rng.uniform(0.25, 0.6))
    return Scene(move(plan.move_arm(), rng), numbers, **devices_of(rng))


def leaves_early(numbers, rng):
    """The tips pass the object's upper edge while the arm still lifts."""
    plan = pressed(numbers, rng).move_arm()
    return Scene(move(plan, rng, leaves_after=rng.uniform(5, 12)), numbers, **devices_of(rng))


def begins_in_hold(numbers, rng):
    """The object is held when the recording begins."""
    plan = pressed(numbers, rng, 1.5)
    begins = plan.now - rng.uniform(0.7, 1.2)
    return Scene(move(plan.move_arm(), rng), numbers, begins_at=begins, **devices_of(rng))


def begins_in_press(numbers, rng):
    """The recording begins while the stage presses."""
    numbers["press_mm_s"] = min(numbers["press_mm_s"], 4.0)
    motion = move(pressed(numbers, rng, 1.2).move_arm(), rng)
    press = motion.truths[0]
    return Scene(motion, numbers, begins_at=press["start"] + 0.4 * (press["end"] - press["start"]), **devices_of(rng))


def ends_in_slip(numbers, rng):
    """The recording ends while the arm lifts."""
    motion = move(pressed(numbers, rng).move_arm(), rng)
    slip = next(x for x in motion.truths if x["what"] == "slip")
    return Scene(motion, numbers, ends_at=slip["start"] + rng.uniform(0.25, 0.5) * (slip["end"] - slip["start"]), **devices_of(rng))


def lift_at_once(numbers, rng):
    """The lift begins right after the press."""
    return Scene(move(pressed(numbers, rng, rng.uniform(0.03, 0.15)).move_arm(), rng), numbers, **devices_of(rng))


def two_lifts(numbers, rng):
    """The arm stops on its way, waits and lifts again: two slips."""
    plan = pressed(numbers, rng).move_arm(0.5 * numbers["lift_mm"]).wait(rng.uniform(0.6, 1.2)).move_arm(0.5 * numbers["lift_mm"])
    return Scene(move(plan, rng), numbers, **devices_of(rng))


def arm_comes_down(numbers, rng):
    """The arm comes down to the object before the stage presses."""
    numbers["play_mm"] = 0.0
    plan = Plan(numbers, rng).move_arm(-rng.uniform(20, 50)).wait(rng.uniform(0.6, 1.2))
    plan.move_stage(closing(numbers)).wait(numbers["hold_s"]).move_arm()
    return Scene(move(plan, rng), numbers, **devices_of(rng))


def slow_lift(numbers, rng):
    """A lift at 4 to 8 mm/s that begins gently."""
    numbers.update(lift_mm_s=rng.uniform(4, 8), lift_mm_s2=rng.uniform(40, 120), lift_mm=rng.uniform(8, 14))
    return Scene(move(pressed(numbers, rng).move_arm(), rng), numbers, **devices_of(rng))


def smooth_slip(numbers, rng):
    """A slip without stick-slip over a smooth object: after the first shear hardly anything moves."""
    numbers.update(friction_drop=0.02, friction_spread=0.01, relief_mm=0.002, slip_relax_s=0.003)
    return Scene(move(pressed(numbers, rng).move_arm(), rng), numbers, **devices_of(rng))


def much_noise(numbers, rng):
    """Pale dots, and as much noise as a real camera makes in the dark."""
    numbers.update(noise_hz_per_px=0.45, hot_pixels=140, dot_contrast=0.7, threshold_on=0.3, threshold_off=0.3)
    return Scene(move(pressed(numbers, rng).move_arm(), rng), numbers, **devices_of(rng))


def alone(numbers, rng):
    """No IMU, no film and no output of the stage: events and the robot's log only."""
    return Scene(move(pressed(numbers, rng).move_arm(), rng), numbers, imu=False, film=False, commands=False)


def only_a_press(numbers, rng):
    """A press and a release, and the arm rests."""
    return Scene(move(pressed(numbers, rng).move_stage(-closing(numbers)), rng), numbers, **devices_of(rng))


def uneven_press(numbers, rng):
    """The stage's screw drives unevenly: its speed rises and falls with each turn, nearly to a halt."""
    numbers.update(uneven=rng.uniform(0.5, 0.9), thread_mm=rng.uniform(0.1, 0.5), press_mm_s=min(numbers["press_mm_s"], 6.0))
    return Scene(move(pressed(numbers, rng).move_arm(), rng), numbers, **devices_of(rng))


def knocks(numbers, rng):
    """Somebody bumps into the arm once before the press and once while the object is held."""
    numbers.update(play_mm=0.0)
    plan = Plan(numbers, rng).knock(rng.uniform(0.03, 0.12)).wait(0.8).move_stage(closing(numbers)).wait(0.7)
    plan.knock(rng.uniform(0.03, 0.12)).wait(rng.uniform(0.6, 1.0)).move_arm()
    return Scene(move(plan, rng), numbers, **devices_of(rng))


def brief_touch(numbers, rng):
    """The stage touches the object and opens at once, then presses for good."""
    numbers["press_mm_s"] = max(numbers["press_mm_s"], 5.0)
    plan = pressed(numbers, rng, 0.05).move_stage(-closing(numbers)).wait(rng.uniform(0.5, 1.0)).move_stage(closing(numbers))
    return Scene(move(plan.wait(numbers["hold_s"]).move_arm(), rng), numbers, **devices_of(rng))


CASES = {f.__name__.replace("_", "-"): f for f in
         (ordinary, second_press, deeper_press, release_before_lift, firm_lift, micro_slips, leaves_early, begins_in_hold, begins_in_press,
          ends_in_slip, lift_at_once, two_lifts, arm_comes_down, slow_lift, smooth_slip, much_noise, alone, only_a_press,
          uneven_press, knocks, brief_touch)}
