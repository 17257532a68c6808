#pragma once

namespace tactile::test {

extern const char* const tactile_binary;  ///< the program under test
extern const char* const data_folder;     ///< tests/data
extern const char* const source_folder;   ///< the repository
extern const char* const build_folder;    ///< what CMake built into
extern const char* const cmake_program;

}  // namespace tactile::test
