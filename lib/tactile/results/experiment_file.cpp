#include "tactile/results/experiment_file.hpp"

#include <fmt/core.h>

#include "tactile/core/error.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::results {

void check_format(const JsonView& json, std::string_view expected, std::string_view command) {
  const JsonView format = json["format"];
  if (format.text() == expected) return;
  throw Error(fmt::format("{} is '{}'; expected {}, as '{}' writes it into another folder", format.where(), format.text(),
                          expected, command));
}

nlohmann::json read_document(const std::filesystem::path& file, std::string_view command) {
  auto document = nlohmann::json::parse(read_text(file), nullptr, false);
  if (document.is_discarded()) throw Error(fmt::format("{}: no JSON; expected what '{}' wrote", file.string(), command));
  return document;
}

}  // namespace tactile::results
