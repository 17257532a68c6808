#pragma once

namespace tactile::test {

extern const char* const tactile_binary;  ///< the program that is tested
extern const char* const data_folder;     ///< tests/data

}  // namespace tactile::test
