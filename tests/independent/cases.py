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
    log: str = "usual"            # how the robot's log differs
    film_kind: str = "usual"      # how the film's times differ


def devices_of(numbers, rng):
    """A hand that presses gives no command."""
    return {"imu": bool(rng.random() < 0.5), "film": bool(rng.random() < 0.7), "commands": bool(rng.random() < 0.5) and numbers["drive"] != "hand",
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
    return Scene(move(plan, rng), numbers, **devices_of(numbers, rng))


def second_press(numbers, rng):
    """The stage opens and presses a second time before the lift."""
    plan = pressed(numbers, rng).move_stage(-closing(numbers)).wait(rng.uniform(0.3, 1.0)).move_stage(closing(numbers))
    plan.wait(rng.uniform(0.5, 1.2)).move_arm()
    return Scene(move(plan, rng), numbers, **devices_of(numbers, rng))


def deeper_press(numbers, rng):
    """The stage presses deeper after a hold."""
    plan = pressed(numbers, rng, 0.6).move_stage(0.4 * numbers["depth_mm"]).wait(rng.uniform(0.5, 1.2)).move_arm()
    return Scene(move(plan, rng), numbers, **devices_of(numbers, rng))


def release_before_lift(numbers, rng):
    """The stage opens before the lift: the arm lifts nothing."""
    plan = pressed(numbers, rng).move_stage(-closing(numbers)).wait(rng.uniform(0.4, 1.0)).move_arm()
    return Scene(move(plan, rng), numbers, **devices_of(numbers, rng))


def firm_lift(numbers, rng):
    """The object comes with the gripper: the skin shears by the object's weight, and nothing slips."""
    plan = pressed(numbers, rng).move_arm()
    return Scene(move(plan, rng, firm=True), numbers, **devices_of(numbers, rng))


def micro_slips(numbers, rng):
    """The object jerks a few times while it is held, then the lift fails."""
    plan = pressed(numbers, rng, 0.5)
    for _ in range(int(rng.integers(1, 4))):
        plan.jolt(rng.uniform(0.06, 0.2) * numbers["shear_mm"], rng.uniform(0.002, 0.01)).wait(rng.uniform(0.25, 0.6))
    return Scene(move(plan.move_arm(), rng), numbers, **devices_of(numbers, rng))


def leaves_early(numbers, rng):
    """The tips pass the object's upper edge while the arm still lifts."""
    plan = pressed(numbers, rng).move_arm()
    return Scene(move(plan, rng, leaves_after=rng.uniform(5, 12)), numbers, **devices_of(numbers, rng))


def begins_in_hold(numbers, rng):
    """The object is held when the recording begins."""
    plan = pressed(numbers, rng, 1.5)
    begins = plan.now - rng.uniform(0.7, 1.2)
    return Scene(move(plan.move_arm(), rng), numbers, begins_at=begins, **devices_of(numbers, rng))


def begins_in_press(numbers, rng):
    """The recording begins while the stage presses."""
    numbers.update(drive="servo", press_mm_s=min(numbers["press_mm_s"], 4.0))
    motion = move(pressed(numbers, rng, 1.2).move_arm(), rng)
    press = motion.truths[0]
    return Scene(motion, numbers, begins_at=press["start"] + 0.4 * (press["end"] - press["start"]), **devices_of(numbers, rng))


def ends_in_slip(numbers, rng):
    """The recording ends while the arm lifts."""
    motion = move(pressed(numbers, rng).move_arm(), rng)
    slip = next(x for x in motion.truths if x["what"] == "slip")
    return Scene(motion, numbers, ends_at=slip["start"] + rng.uniform(0.25, 0.5) * (slip["end"] - slip["start"]), **devices_of(numbers, rng))


def lift_at_once(numbers, rng):
    """The lift begins right after the press."""
    return Scene(move(pressed(numbers, rng, rng.uniform(0.03, 0.15)).move_arm(), rng), numbers, **devices_of(numbers, rng))


def two_lifts(numbers, rng):
    """The arm stops on its way, waits and lifts again: two slips."""
    plan = pressed(numbers, rng).move_arm(0.5 * numbers["lift_mm"]).wait(rng.uniform(0.6, 1.2)).move_arm(0.5 * numbers["lift_mm"])
    return Scene(move(plan, rng), numbers, **devices_of(numbers, rng))


def arm_comes_down(numbers, rng):
    """The arm comes down to the object before the stage presses."""
    numbers["play_mm"] = 0.0
    plan = Plan(numbers, rng).move_arm(-rng.uniform(20, 50)).wait(rng.uniform(0.6, 1.2))
    plan.move_stage(closing(numbers)).wait(numbers["hold_s"]).move_arm()
    return Scene(move(plan, rng), numbers, **devices_of(numbers, rng))


def slow_lift(numbers, rng):
    """A lift at 4 to 8 mm/s that begins gently."""
    numbers.update(lift_mm_s=rng.uniform(4, 8), lift_mm_s2=rng.uniform(40, 120), lift_mm=rng.uniform(8, 14))
    return Scene(move(pressed(numbers, rng).move_arm(), rng), numbers, **devices_of(numbers, rng))


def smooth_slip(numbers, rng):
    """A slip without stick-slip over a smooth object: after the first shear hardly anything moves."""
    numbers.update(friction_drop=0.02, friction_spread=0.01, relief_mm=0.002, slip_relax_s=0.003)
    return Scene(move(pressed(numbers, rng).move_arm(), rng), numbers, **devices_of(numbers, rng))


def much_noise(numbers, rng):
    """Pale dots, and as much noise as a real camera makes in the dark."""
    numbers.update(noise_hz_per_px=1.2, hot_pixels=300, dot_contrast=0.6, threshold_on=0.3, threshold_off=0.3)
    return Scene(move(pressed(numbers, rng).move_arm(), rng), numbers, **devices_of(numbers, rng))


def alone(numbers, rng):
    """No IMU, no film and no output of the stage: events and the robot's log only."""
    return Scene(move(pressed(numbers, rng).move_arm(), rng), numbers, imu=False, film=False, commands=False)


def only_a_press(numbers, rng):
    """A press and a release, and the arm rests."""
    return Scene(move(pressed(numbers, rng).move_stage(-closing(numbers)), rng), numbers, **devices_of(numbers, rng))


def uneven_press(numbers, rng):
    """The stage's screw drives unevenly: its speed rises and falls with each turn, nearly to a halt."""
    numbers.update(drive="servo", uneven=rng.uniform(0.5, 0.95), thread_mm=rng.uniform(0.1, 0.5), press_mm_s=min(numbers["press_mm_s"], 6.0))
    return Scene(move(pressed(numbers, rng).move_arm(), rng), numbers, **devices_of(numbers, rng))


def knocks(numbers, rng):
    """Somebody bumps into the arm once before the press and once while the object is held."""
    numbers.update(play_mm=0.0)
    plan = Plan(numbers, rng).knock(rng.uniform(0.03, 0.12)).wait(0.8).move_stage(closing(numbers)).wait(0.7)
    plan.knock(rng.uniform(0.03, 0.12)).wait(rng.uniform(0.6, 1.0)).move_arm()
    return Scene(move(plan, rng), numbers, **devices_of(numbers, rng))


def brief_touch(numbers, rng):
    """The stage touches the object and opens at once, then presses for good."""
    numbers.update(drive="servo", press_mm_s=max(numbers["press_mm_s"], 5.0), stage_mm_s2=max(numbers["stage_mm_s2"], 200))
    plan = pressed(numbers, rng, 0.05).move_stage(-closing(numbers)).wait(rng.uniform(0.5, 1.0)).move_stage(closing(numbers))
    return Scene(move(plan.wait(numbers["hold_s"]).move_arm(), rng), numbers, **devices_of(numbers, rng))


def late_slip(numbers, rng):
    """The lift holds the object firmly, and 0.2 to 1.5 s later the object is caught or the grip fails."""
    late = rng.uniform(0.2, 1.5)
    numbers["lift_mm_s"] = rng.uniform(12, 50)
    numbers["lift_mm"] = numbers["lift_mm_s"] * (late + rng.uniform(0.4, 1.0)) + 1.5 * numbers["shear_mm"] / numbers["transmission"]
    return Scene(move(pressed(numbers, rng).move_arm(), rng, late=(late, bool(rng.random() < 0.5))), numbers, **devices_of(numbers, rng))


def slow_press(numbers, rng):
    """A press at 0.5 to 1.5 mm/s."""
    numbers.update(drive="servo", uneven=rng.uniform(0, 0.15), press_mm_s=rng.uniform(0.5, 1.3), gap_mm=rng.uniform(0.3, 1.2))
    return Scene(move(pressed(numbers, rng).move_arm(), rng), numbers, **devices_of(numbers, rng))


def two_touches(numbers, rng):
    """Press and failing lift, twice: the stage opens and the arm comes down between."""
    numbers.update(lift_mm=min(numbers["lift_mm"], 25.0), lift_mm_s=max(numbers["lift_mm_s"], 10.0), hold_s=min(numbers["hold_s"], 2.0))
    plan = pressed(numbers, rng).move_arm().wait(rng.uniform(0.3, 0.8)).move_stage(-closing(numbers)).wait(rng.uniform(0.2, 0.6))
    plan.move_arm(-numbers["lift_mm"]).wait(rng.uniform(0.4, 1.0)).move_stage(closing(numbers)).wait(numbers["hold_s"]).move_arm()
    return Scene(move(plan, rng), numbers, **devices_of(numbers, rng))


def press_at_once(numbers, rng):
    """The press begins in the first 50 ms of the recording."""
    motion = move(pressed(numbers, rng).move_arm(), rng)
    return Scene(motion, numbers, begins_at=motion.truths[0]["start"] - rng.uniform(0.003, 0.05), **devices_of(numbers, rng))


def push(numbers, rng):
    """Somebody pushes the arm firmly while nothing is held, and the skin sways with it. In half of the runs a press and a failing lift follow."""
    plan = Plan(numbers, rng).push(rng.uniform(1, 5), rng.uniform(0.08, 0.5), rng.uniform(0.2, 0.7)).wait(rng.uniform(0.5, 1.2))
    if rng.random() < 0.5:
        plan.move_stage(closing(numbers)).wait(numbers["hold_s"]).move_arm()
    return Scene(move(plan, rng), numbers, **devices_of(numbers, rng))


def carried_away(numbers, rng):
    """A hand takes the object out of the grip and brings it back; then the lift fails."""
    way = numbers["depth_mm"] + rng.uniform(5, 20)
    plan = pressed(numbers, rng).move_object(-way, rng.uniform(15, 60)).wait(rng.uniform(0.4, 1.5)).move_object(way, rng.uniform(8, 40))
    return Scene(move(plan.wait(rng.uniform(0.5, 1.5)).move_arm(), rng), numbers, **devices_of(numbers, rng))


def twist_angle(numbers, part):
    """The angle that loads the ring of friction with this part of its limit."""
    return part * numbers["shear_mm"] / (0.6 * numbers["patch_mm"])


def twist(numbers, rng):
    """A hand turns the object a little in the grip and back, and nothing slips; then the lift fails."""
    numbers["friction_spread"] = min(numbers["friction_spread"], 0.1)
    angle, seconds = rng.choice([-1, 1]) * twist_angle(numbers, rng.uniform(0.3, 0.6)), rng.uniform(0.1, 0.5)
    plan = pressed(numbers, rng).twist(angle, seconds).wait(rng.uniform(0.3, 0.8)).twist(-angle, seconds).wait(rng.uniform(0.4, 1.0)).move_arm()
    return Scene(move(plan, rng), numbers, **devices_of(numbers, rng))


def twist_slip(numbers, rng):
    """The arm turns its wrist, and the object slips in the grip."""
    angle = rng.choice([-1, 1]) * max(rng.uniform(0.3, 1.0), twist_angle(numbers, 2.0))
    return Scene(move(pressed(numbers, rng).twist(angle, rng.uniform(0.4, 1.2), by_arm=True, slips=True), rng), numbers, **devices_of(numbers, rng))


def slow_release(numbers, rng):
    """The stage opens at 0.3 to 1.5 mm/s. In half of the runs a lift failed before."""
    numbers.update(drive="servo", uneven=rng.uniform(0, 0.15))
    plan = pressed(numbers, rng)
    if rng.random() < 0.5:
        plan.move_arm().wait(rng.uniform(0.4, 1.0))
    plan.move_stage(-numbers["depth_mm"] - 0.3, rng.uniform(0.3, 1.3))
    return Scene(move(plan, rng), numbers, **devices_of(numbers, rng))


def nothing(numbers, rng):
    """Noise alone."""
    return Scene(move(Plan(numbers, rng).wait(rng.uniform(1.5, 4)), rng), numbers, **devices_of(numbers, rng))


def machine(numbers, rng):
    """Nothing but the vibration of a machine at 20 to 120 Hz."""
    plan = Plan(numbers, rng).wait(rng.uniform(0.5, 1.5))
    plan.hum = (rng.uniform(20, 120), rng.uniform(0.01, 0.06))
    return Scene(move(plan, rng), numbers, **devices_of(numbers, rng))


def late_host_times(numbers, rng):
    """The host times of the robot's log are late by 20 ms."""
    numbers["recorder"] = "tactile record"
    return dataclasses.replace(ordinary(numbers, rng), log="late")


def bursts_in_the_log(numbers, rng):
    """The robot's rows reach the host in bursts, and a tenth of them is lost."""
    numbers["recorder"] = "tactile record"
    return dataclasses.replace(ordinary(numbers, rng), log="bursts")


def film_by_index(numbers, rng):
    """The film's times are index / 30, though the camera dropped frames."""
    return dataclasses.replace(ordinary(numbers, rng), film=True, film_kind="index")


def film_drifts(numbers, rng):
    """The film drifts by 23 ms over 4 s."""
    return dataclasses.replace(ordinary(numbers, rng), film=True, film_kind="drifts")


def film_repeats(numbers, rng):
    """Some frames have the time of the frame before."""
    return dataclasses.replace(ordinary(numbers, rng), film=True, film_kind="repeats")


def film_15(numbers, rng):
    """A film of 15 frames a second."""
    return dataclasses.replace(ordinary(numbers, rng), film=True, film_kind="15 Hz")


def film_60(numbers, rng):
    """A film of 60 frames a second."""
    return dataclasses.replace(ordinary(numbers, rng), film=True, film_kind="60 Hz")


def no_imu(numbers, rng):
    """The camera has no IMU."""
    return dataclasses.replace(ordinary(numbers, rng), imu=False, film=True)


def no_film(numbers, rng):
    """There is no film."""
    return dataclasses.replace(ordinary(numbers, rng), imu=True, film=False)


def no_robot(numbers, rng):
    """There is no robot's log."""
    return dataclasses.replace(ordinary(numbers, rng), robot=False, imu=True, film=True)


def events_alone(numbers, rng):
    """There are only events."""
    return dataclasses.replace(ordinary(numbers, rng), robot=False, imu=False, film=False)


CASES = {f.__name__.replace("_", "-"): f for f in
         (ordinary, second_press, deeper_press, release_before_lift, firm_lift, late_slip, micro_slips, leaves_early, begins_in_hold, begins_in_press,
          press_at_once, ends_in_slip, lift_at_once, two_lifts, two_touches, arm_comes_down, slow_lift, slow_press, smooth_slip, slow_release,
          much_noise, alone, only_a_press, uneven_press, knocks, push, brief_touch, carried_away, twist, twist_slip, nothing, machine,
          late_host_times, bursts_in_the_log, film_by_index, film_drifts, film_repeats, film_15, film_60, no_imu, no_film, no_robot, events_alone)}
