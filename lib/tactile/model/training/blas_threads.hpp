#pragma once

namespace tactile {

/// Keeps OpenBLAS, which has threads of its own, to the one that calls it. Nothing where another library is the BLAS.
/// @param threads  that will call it
/// @throws Error   if there is no memory for that many
void prepare_blas(unsigned threads);

}  // namespace tactile
