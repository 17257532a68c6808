#pragma once

namespace tactile::cli {

/// From now on Ctrl-C, SIGTERM and SIGHUP wait until they are released: at the start of a program, which cannot handle them yet,
/// and before it starts another program in its place, where they still wait.
void hold_signals();
void release_signals();

/// From now on Ctrl-C, SIGTERM and SIGHUP (a closed terminal) raise a flag. The same signal again ends the process.
void catch_signals();

/// From now on writing fails if the program that reads our output has ended, or if a file exceeds the limit of its size
/// (`ulimit -f`): the signals that would end the process without a sentence are ignored.
void fail_at_broken_pipes();
void fail_at_file_size_limit();

bool interrupted();
int exit_code_of_interruption();  ///< as shells give it: 130 after Ctrl-C, 143 after SIGTERM, 129 after SIGHUP

}  // namespace tactile::cli
