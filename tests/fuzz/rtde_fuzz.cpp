#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "abort_unless.hpp"
#include "tactile/core/error.hpp"
#include "tactile/robot/rtde_protocol.hpp"

namespace {

using namespace tactile;

/// Decodes a package as a client and as a controller do, with the recipe of the stream.
void decode(const robot::RtdePackage& package, robot::RtdeRecipe& recipe, std::vector<robot::RtdeNumber>& numbers) {
  switch (package.type) {
    case robot::RtdePackageType::protocol_version:
      if (package.payload.size() == 2) {
        robot::protocol_version_in(package.payload);
      } else {
        robot::accepted_in(package.payload);
      }
      break;
    case robot::RtdePackageType::controller_version:
      text_of(robot::controller_version_in(package.payload));
      break;
    case robot::RtdePackageType::text:
      robot::text_in(package.payload);
      break;
    case robot::RtdePackageType::setup_outputs:
    case robot::RtdePackageType::setup_inputs: {
      const robot::RtdeSetupReply reply = robot::setup_reply_in(package.payload);
      recipe = {.id = reply.recipe_id, .fields = {}};
      for (const std::string& name : reply.types) {
        if (const auto type = robot::rtde_field_type_called(name)) recipe.fields.push_back({name, *type});
      }
      robot::columns_of(recipe);
      robot::outputs_request_in(package.payload);
      break;
    }
    case robot::RtdePackageType::start:
    case robot::RtdePackageType::pause:
      robot::accepted_in(package.payload);
      break;
    case robot::RtdePackageType::data:
      if (!robot::read_rtde_data(recipe, package.payload, numbers)) break;
      // There is a number for every column, and the package that is written from them has the same size.
      test::abort_unless(numbers.size() == robot::columns_of(recipe).size());
      test::abort_unless(robot::rtde_data_package(recipe, numbers).size() == package.payload.size() + 3);
      break;
  }
}

}  // namespace

/// For any stream in pieces of any size, packages are read, or there is an Error. The first byte is the size of the pieces, 0 for
/// one piece.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::size_t piece = data[0] == 0 ? size : data[0];
  const auto stream = std::as_bytes(std::span(data, size)).subspan(1);
  robot::RtdeReassembly reassembly;
  robot::RtdeRecipe recipe;
  std::vector<robot::RtdeNumber> numbers;
  try {
    for (std::size_t begin = 0; begin < stream.size(); begin += piece) {
      reassembly.append(stream.subspan(begin, std::min(piece, stream.size() - begin)));
      while (const auto package = reassembly.next()) {
        try {
          decode(*package, recipe, numbers);
        } catch (const Error&) {  // the packages after it can still be read
        }
      }
    }
  } catch (const Error&) {
  }
  return 0;
}
