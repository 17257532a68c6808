#pragma once

namespace tactile {

/// Ctrl-C raises a flag from here on; pressed once more it ends the process, as it always does.
void catch_ctrl_c();

/// The same for SIGTERM, for commands whose normal end it is.
void catch_termination();

bool interrupted();

}  // namespace tactile
