#include "tactile/model/definition/engine_kind.hpp"

#include "tactile/core/enum_names.hpp"

namespace tactile::model {

std::string_view name_of(EngineKind engine) { return engine_names.at(static_cast<std::size_t>(engine)); }
EngineKind engine_named(std::string_view name) { return enumerator_named<EngineKind>(name, engine_names, "engine"); }

}  // namespace tactile::model
