#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

#include "tactile/conversion/convert.hpp"
#include "tactile/events/other_streams.hpp"

namespace tactile::conversion {

/// Whether a file of this format contains the events of one stream only.
constexpr bool holds_one_stream(RecordingFormat format) {
  return format == RecordingFormat::csv || format == RecordingFormat::npz;
}

/// A file of one of the formats, which is written.
class RecordingOutput {
 public:
  virtual ~RecordingOutput() = default;
  virtual void write(std::int32_t stream_id, std::span<const events::Event> events) = 0;
  virtual void write(std::int32_t, std::span<const events::ImuSample>) {}  // called only with what the format can hold
  virtual void write(std::int32_t, std::span<const events::Trigger>) {}
  virtual void write(std::int32_t, const events::Frame&) {}
  virtual std::uint64_t steps_back() const { return 0; }
  virtual void close() = 0;
};

/// Opens a file for the streams of the summary. @param in  named in errors
/// @param threads  that compress packets, > 0
/// @throws Error   if the file cannot be made, or its format needs a sensor size and a stream has none
std::unique_ptr<RecordingOutput> open_output(const std::filesystem::path& file, const std::filesystem::path& in,
                                             const ConvertSummary& summary, unsigned threads);

}  // namespace tactile::conversion
