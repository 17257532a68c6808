#pragma once

#include "tactile/core/time.hpp"

namespace tactile {

/// The host's time now: the system clock's when the process first asked, and from there on by the steady clock, so that it never
/// steps while a recording runs.
HostTime host_now();

}  // namespace tactile
