#include "support/paths.hpp"

// The only file of the tests that knows where they lie: the others compile to the same bytes in any folder, and ccache finds
// them.
namespace tactile::test {

const char* const tactile_binary = TACTILE_BINARY;
const char* const data_folder = TACTILE_TEST_DATA;

}  // namespace tactile::test
