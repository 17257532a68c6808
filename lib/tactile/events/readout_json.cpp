#include "tactile/events/readout_json.hpp"

#include <cmath>

namespace tactile::events {
namespace {

nlohmann::json finite_or_null(double value) { return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(); }

}  // namespace

nlohmann::json json_of(const Measured& measured) {
  return {{"value", finite_or_null(measured.value)}, {"uncertainty", finite_or_null(measured.uncertainty)}};
}

std::string_view name_of(Scan scan) { return scan == Scan::none ? "none" : scan == Scan::columns ? "columns" : "rows"; }

std::string_view name_of(Readout::Kind kind) {
  return kind == Readout::Kind::none ? "none" : kind == Readout::Kind::unsteady ? "unsteady" : "steady";
}

nlohmann::json json_of(const Readout& readout) {
  const bool is_steady = readout.kind == Readout::Kind::steady;
  const bool has_scan = is_steady && readout.scan != Scan::none;
  const auto if_there = [](bool there, const auto& json) { return there ? nlohmann::json(json) : nlohmann::json(); };
  return {{"kind", name_of(readout.kind)},
          {"period_us", if_there(readout.kind != Readout::Kind::none, json_of(readout.period_us))},
          {"scan", if_there(is_steady, name_of(readout.scan))},
          {"us_per_line", if_there(has_scan, json_of(readout.step_us))},
          {"jitter_us", if_there(is_steady, json_of(readout.jitter_us))},
          {"wander_us", if_there(is_steady, json_of(readout.wander_us))},
          {"wander_s", if_there(is_steady, readout.wander_s)},
          {"coherence", if_there(is_steady, readout.coherence)},
          {"precision_us", if_there(readout.stamp_step_us > 0, readout.precision_us())},
          {"stamp_step_us", readout.stamp_step_us},
          {"events", readout.events}};
}

}  // namespace tactile::events
