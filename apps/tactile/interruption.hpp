#pragma once

namespace tactile {

/// From here on Ctrl-C, SIGTERM and SIGHUP wait until they are released: first in a program, which cannot meet them yet, and
/// ahead of becoming another one, for what waits is waiting there too.
void hold_signals();
void release_signals();

/// Ctrl-C raises a flag from here on; pressed once more it ends the process, as it always does.
void catch_ctrl_c();

/// The same for SIGTERM and SIGHUP (a terminal that is closed), for commands whose normal end they are. What reads our output may
/// end too: SIGPIPE is ignored, and writing fails instead.
void catch_termination();

bool interrupted();

}  // namespace tactile
