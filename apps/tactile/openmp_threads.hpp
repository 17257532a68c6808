#pragma once

namespace tactile {

/// Lets libtorch's threads sleep while they wait for each other. They spin by default, and where another program wants the same
/// cores a training then takes five to ten times as long. libgomp reads OMP_WAIT_POLICY only as it is loaded, so the program
/// starts itself once more where the variable is not set; call it before anything else is done.
void let_openmp_threads_sleep();

}  // namespace tactile
