#pragma once

namespace tactile::cli {

/// Lets libtorch's threads sleep while they wait for each other. By default they spin. If another program uses the same cores, a
/// training then takes five to ten times as long. libgomp reads OMP_WAIT_POLICY only when it is loaded. Therefore the program
/// starts itself again if the variable is not set. Call this first.
void let_openmp_threads_sleep();

}  // namespace tactile::cli
