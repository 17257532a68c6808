#include "tactile/model/definition/engine_kind.hpp"

#include <string>

#include "tactile/core/error.hpp"

namespace tactile {

std::string_view name_of(EngineKind engine) { return engine == EngineKind::fast ? "fast" : "libtorch"; }

EngineKind engine_named(std::string_view name) {
  for (const EngineKind engine : {EngineKind::fast, EngineKind::libtorch}) {
    if (name == name_of(engine)) return engine;
  }
  throw Error("engine '" + std::string(name) + "' is unknown; expected fast or libtorch");
}

}  // namespace tactile
