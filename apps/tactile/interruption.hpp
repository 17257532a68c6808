#pragma once

namespace tactile {

/// Ctrl-C raises a flag from here on; pressed once more it ends the process, as it always does.
void catch_ctrl_c();

/// The same for SIGTERM and SIGHUP (a terminal that is closed), for commands whose normal end they are. What reads our output may
/// end too: SIGPIPE is ignored, and writing fails instead.
void catch_termination();

bool interrupted();

}  // namespace tactile
