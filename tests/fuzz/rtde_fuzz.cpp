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
void decode(const RtdePackage& package, RtdeRecipe& recipe, std::vector<RtdeNumber>& numbers) {
  switch (package.type) {
    case RtdePackageType::protocol_version:
      if (package.payload.size() == 2) {
        protocol_version_in(package.payload);
      } else {
        accepted_in(package.payload);
      }
      break;
    case RtdePackageType::controller_version:
      text_of(controller_version_in(package.payload));
      break;
    case RtdePackageType::text:
      text_in(package.payload);
      break;
    case RtdePackageType::setup_outputs:
    case RtdePackageType::setup_inputs: {
      const RtdeSetupReply reply = setup_reply_in(package.payload);
      recipe = {.id = reply.recipe_id, .fields = {}};
      for (const std::string& name : reply.types) {
        if (const auto type = rtde_field_type_called(name)) recipe.fields.push_back({name, *type});
      }
      columns_of(recipe);
      outputs_request_in(package.payload);
      break;
    }
    case RtdePackageType::start:
    case RtdePackageType::pause:
      accepted_in(package.payload);
      break;
    case RtdePackageType::data:
      if (!read_rtde_data(recipe, package.payload, numbers)) break;
      // There is a number for every column, and the package that is written from them has the same size.
      test::abort_unless(numbers.size() == columns_of(recipe).size());
      test::abort_unless(rtde_data_package(recipe, numbers).size() == package.payload.size() + 3);
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
  RtdeReassembly reassembly;
  RtdeRecipe recipe;
  std::vector<RtdeNumber> numbers;
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
