#pragma once

#include <memory>

#include "tactile/characterise/first_reading.hpp"
#include "tactile/characterise/noise_model.hpp"

namespace tactile::characterise {

/// Measures what depends on which pixels are ordinary, recording by recording.
class SecondReading {
 public:
  /// @param is_touched  there are touched recordings: passages are measured
  SecondReading(const FirstReading& first, const UnusualPixels& unusual, bool is_touched);
  ~SecondReading();
  SecondReading(const SecondReading&) = delete;
  SecondReading& operator=(const SecondReading&) = delete;

  void read_quiet(OpenRecording& open, const ReadRecording& recording, const ProgressCallback& progress);
  /// Only the passages of markers, and which pixels are not dead.
  void read_touched(OpenRecording& open, const ProgressCallback& progress);

  /// Puts everything that was measured into `sensor`, whose unusual pixels are there.
  void put_into(Sensor& sensor) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tactile::characterise
