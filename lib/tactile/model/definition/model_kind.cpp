#include "tactile/model/definition/model_kind.hpp"

#include "tactile/core/enum_names.hpp"

namespace tactile::model {

std::string_view name_of(ModelKind kind) { return kind_names.at(static_cast<std::size_t>(kind)); }
ModelKind kind_named(std::string_view name) { return enumerator_named<ModelKind>(name, kind_names, "kind of model"); }

}  // namespace tactile::model
