#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "tactile/capture/clock_pairs.hpp"
#include "tactile/capture/packet_queue.hpp"
#include "tactile/capture/recorded_stream.hpp"
#include "tactile/capture/run_drops.hpp"
#include "tactile/events/recording_writer.hpp"

namespace tactile {

struct RunWriterOptions {
  Compression compression = Compression::lz4;
  std::chrono::milliseconds sync_period{1'000};  ///< > 0
  bool pairs_clocks = true;                      ///< whether elements come when they happen, so that `pairs` can be made
  std::optional<microseconds> duration = {};     ///< of the camera, from the first element on: what comes later is cut off
};

/// Writes a run's recording of what the queue brings, on a thread of its own, and brings it to the disk from another, which may
/// take as long as the disk pleases. The packets' checksums lie beside it until they are removed. Elements that step back in time
/// or do not fit their stream are left out and counted.
class RunWriter {
 public:
  /// Makes the file. @throws Error as RecordingWriter does
  RunWriter(const std::filesystem::path& file, std::vector<RecordedStream> streams, PacketQueue& queue,
            const RunWriterOptions& options);
  ~RunWriter();  ///< stops
  RunWriter(const RunWriter&) = delete;
  RunWriter& operator=(const RunWriter&) = delete;

  /// What was done so far.
  struct Written {
    std::uint64_t events = 0, others = 0;  ///< handed to the file
    RunDrops drops;                        ///< those that were found here
    std::optional<CameraTime> first;       ///< of the first packet, which a duration counts from
    bool reached_duration = false;
    std::string error;  ///< why the file cannot be written any more
  };

  void start();
  Written written() const;
  void stop();  ///< closes the queue, and returns once what it still holds is written

  // Once it is stopped.
  void close() { file_.close(); }                        ///< @throws Error as RecordingWriter does
  const RecordingWriter& file() const { return file_; }  ///< for what it holds
  const ClockPairs& pairs() const { return pairs_; }     ///< of the first stream's camera

 private:
  void write_all();
  void write_packet(QueuedPacket& queued);
  void leave_out_misfits(const Stream& stream, CameraPacket& packet, RunDrops& drops) const;
  bool cut_to_duration(CameraPacket& packet, const std::optional<CameraTime>& first) const;
  void sync_all();
  void fail(const std::string& error);

  const std::filesystem::path path_;
  const std::vector<RecordedStream> streams_;
  const RunWriterOptions options_;
  PacketQueue& queue_;
  RecordingWriter file_;                           ///< the writing thread's until that has ended, as are the next two
  std::vector<std::optional<CameraTime>> newest_;  ///< that was written of each stream
  ClockPairs pairs_;

  mutable std::mutex guard_;  ///< of all that follows
  Written so_far_;            ///< changed by the writing thread alone, but for `error`
  std::condition_variable sync_wanted_;
  bool wants_sync_ = false, ends_ = false;
  std::thread writing_, syncing_;
};

}  // namespace tactile
