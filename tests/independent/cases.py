"""The courses of runs: the ordinary one of the paper, and what else happens."""
import dataclasses

from motion import Motion, Plan, move


@dataclasses.dataclass
class Scene:
    motion: Motion
    numbers: dict
    begins_at: float = 0.0        # s of the motion at which the recording begins
    imu: bool = True
    robot: bool = True
    film: bool = True
    commands: bool = True
    camera_on_stage: bool = False
    firm: bool = False


def devices_of(rng):
    return {"imu": bool(rng.random() < 0.5), "film": bool(rng.random() < 0.7), "commands": bool(rng.random() < 0.5),
            "camera_on_stage": bool(rng.random() < 0.5)}


def half_without_play(numbers, rng):
    if rng.random() < 0.5:
        numbers["play_mm"] = 0.0


def pressed(numbers, rng):
    """A plan that rests, presses and holds."""
    half_without_play(numbers, rng)
    return Plan(numbers, rng).move_stage(numbers["gap_mm"] + numbers["depth_mm"]).wait(numbers["hold_s"])


def ordinary(numbers, rng):
    """The run of the paper: a light press, a hold, a lift that fails. In half of the runs the stage opens again at the end."""
    plan = pressed(numbers, rng).raise_arm()
    if rng.random() < 0.5:
        plan.wait(rng.uniform(0.4, 1.0)).move_stage(-numbers["gap_mm"] - numbers["depth_mm"])
    return Scene(move(plan, rng), numbers, **devices_of(rng))


CASES = {"ordinary": ordinary}
