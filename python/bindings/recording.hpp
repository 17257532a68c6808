#pragma once

#include <memory>
#include <mutex>
#include <string>

#include "tactile/events/recording_reader.hpp"

namespace tactile::python {

/// A recording and its event stream. Threads of Python that read it at the same time wait for each other.
struct Recording {
  Recording(const std::string& file, const std::string& stream_choice)
      : reader(file), stream(events::event_stream(reader, stream_choice)) {}

  std::mutex mutex;
  events::RecordingReader reader;
  events::Stream stream;
};

}  // namespace tactile::python
