#include "support/paths.hpp"

// The only file of the tests that contains a path of this folder. All others compile to the same bytes in any folder, so that
// ccache finds them.
namespace tactile::test {

const char* const tactile_binary = TACTILE_BINARY;
const char* const data_folder = TACTILE_TEST_DATA;
const char* const source_folder = TACTILE_SOURCE_FOLDER;
const char* const build_folder = TACTILE_BUILD_FOLDER;
const char* const cmake_program = TACTILE_CMAKE;

}  // namespace tactile::test
