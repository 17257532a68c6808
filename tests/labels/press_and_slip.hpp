#pragma once

#include "alignment/made_run.hpp"

namespace tactile::test {

/// A press of 200 ms at 0.8 s; then the skin fires from 3 ms after the start of `lift_after_press` to 3 ms before its end.
inline const MadeRun press_and_slip{.bursts = {{800'000, 1'000'000}, {1'503'000, 2'097'000}}};

/// At 1.5 s; it moves for 0.6 s.
inline const robot::RobotLog lift_after_press = made_lift(1'500'000, 500'000, 0.06, -123'456'789);

}  // namespace tactile::test
