#pragma once

namespace tactile {

/// Loads a part of the program whose libraries take long to load. It is a shared library in the program's folder, and calls
/// functions of the program. It stays loaded.
/// @param file    name of the part, as "tactile-torch.so"
/// @param symbol  name of an object in it, with C linkage
/// @return        the object
/// @throws Error  if the part is not there, or cannot be loaded, as where there is too little memory
void* load_part(const char* file, const char* symbol);

}  // namespace tactile
