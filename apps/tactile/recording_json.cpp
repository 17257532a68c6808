#include "recording_json.hpp"

namespace tactile::cli {

nlohmann::json json_of(const events::RecordingProblems& problems) {
  return {{"truncated_bytes", problems.truncated_bytes},       {"skipped_bytes", problems.skipped_bytes},
          {"resized_packets", problems.resized_packets},       {"header_not_patched", problems.header_not_patched},
          {"broken_packets", problems.broken_packets},         {"mismatched_packets", problems.mismatched_packets},
          {"undeclared_packets", problems.undeclared_packets}, {"empty_packets", problems.empty_packets},
          {"unwrapped_packets", problems.unwrapped_packets},   {"out_of_range_events", problems.out_of_range_events},
          {"missing_packets", problems.missing_packets},       {"missing_elements", problems.missing_elements}};
}

}  // namespace tactile::cli
