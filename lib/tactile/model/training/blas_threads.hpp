#pragma once

namespace tactile::model {

/// Limits OpenBLAS to the calling thread. Has no effect with another BLAS library.
/// @param threads  number of threads that will call it
/// @throws Error   if there is no memory for that many
void prepare_blas(unsigned threads);

}  // namespace tactile::model
