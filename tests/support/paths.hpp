#pragma once

namespace tactile::test {

extern const char* const tactile_binary;  ///< the program under test
extern const char* const data_folder;     ///< tests/data

}  // namespace tactile::test
