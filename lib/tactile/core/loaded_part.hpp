#pragma once

#include <cstddef>

namespace tactile {

/// Loads a part of the program whose libraries take long to load. It is a shared library in the program's folder, and calls
/// functions of the program. It stays loaded.
/// @param file    name of the part, as "tactile-torch.so"
/// @param symbol  name of an object in it, with C linkage
/// @param room    address space that it needs [bytes]; the system loader ends the process in some places where there is less
/// @return        the object
/// @throws Error  if there is no such room, if the part is not there or cannot be loaded, or if the program was replaced since it
///                began: the part is then that of another version
void* load_part(const char* file, const char* symbol, std::size_t room);

}  // namespace tactile
