#pragma once

namespace tactile::cli {

/// From now on Ctrl-C, SIGTERM and SIGHUP wait until they are released: at the start of a program, which cannot handle them yet,
/// and before it starts another program in its place, where they still wait.
void hold_signals();
void release_signals();

/// From now on Ctrl-C raises a flag. The second Ctrl-C ends the process.
void catch_ctrl_c();

/// The same for SIGTERM and SIGHUP (a closed terminal), for commands whose usual end they are. The program that reads our output
/// may end, too: SIGPIPE is ignored, and writing fails instead.
void catch_termination();

bool interrupted();

}  // namespace tactile::cli
