#include "tactile/model/definition/engine_kind.hpp"

#include <array>

#include "tactile/core/enum_names.hpp"

namespace tactile::model {

namespace {
constexpr std::array<std::string_view, 3> names{"fast", "libtorch", "opencv"};
}  // namespace

std::string_view name_of(EngineKind engine) { return names.at(static_cast<std::size_t>(engine)); }
EngineKind engine_named(std::string_view name) { return enumerator_named<EngineKind>(name, names, "engine"); }

}  // namespace tactile::model
