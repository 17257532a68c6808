#include "support/paths.hpp"

// The only file of the tests that contains a path of this folder. All others compile to the same bytes in any folder, so that
// ccache finds them.
namespace tactile::test {

const char* const tactile_binary = TACTILE_BINARY;
const char* const data_folder = TACTILE_TEST_DATA;

}  // namespace tactile::test
