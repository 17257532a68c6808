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

#include "tactile/capture/packet_queue.hpp"
#include "tactile/capture/recent_lateness.hpp"
#include "tactile/capture/recorded_stream.hpp"
#include "tactile/capture/run_drops.hpp"
#include "tactile/core/clock_pairs.hpp"
#include "tactile/events/recording_writer.hpp"

namespace tactile::capture {

struct RunWriterOptions {
  events::Compression compression = events::Compression::lz4;
  std::chrono::milliseconds sync_period{1'000};  ///< > 0
  bool pairs_clocks = true;                      ///< whether sources are live, so that `pairs` can be computed
  std::optional<microseconds> duration = {};     ///< in camera time from the first element on; later elements are left out
};

/// Writes the packets of the queue into a run's recording, on its own thread. Another thread syncs the disk, however long that
/// takes. A file next to the recording has the packets' checksums until it is removed. Elements that step back in time or do
/// not fit their stream are left out and counted.
class RunWriter {
 public:
  /// Creates the file. @throws Error  as RecordingWriter does
  RunWriter(const std::filesystem::path& file, std::vector<RecordedStream> streams, PacketQueue& queue,
            const RunWriterOptions& options);
  ~RunWriter();  ///< stops
  RunWriter(const RunWriter&) = delete;
  RunWriter& operator=(const RunWriter&) = delete;

  /// The state so far.
  struct Written {
    std::uint64_t events = 0, others = 0;  ///< written
    RunDrops drops;                        ///< found by this writer
    std::optional<CameraTime> first;       ///< start of the duration: the first packet
    bool reached_duration = false;
    std::optional<ClockOffset> clock;  ///< of the first stream's camera; nothing unless its source is live
    microseconds lateness{0};          ///< of its packets, as `RecentLateness`
    std::string error;                 ///< why the file can no longer be written
  };

  void start();
  Written written() const;
  void stop();  ///< closes the queue, and returns once its packets are written

  // After `stop`.
  void close() { file_.close(); }                                  ///< @throws Error as RecordingWriter does
  const events::RecordingWriter& file() const { return file_; }    ///< for its contents
  const ClockPairs<CameraClock>& pairs() const { return pairs_; }  ///< of the first stream's camera

 private:
  void write_all();
  void write_packet(QueuedPacket& queued);
  void note_arrival(const ClockPair<CameraClock>& pair);
  void leave_out_misfits(const events::Stream& stream, CameraPacket& packet, RunDrops& drops) const;
  bool cut_to_duration(CameraPacket& packet, const std::optional<CameraTime>& first) const;
  void sync_all();
  void fail(const std::string& error);

  const std::filesystem::path path_;
  const std::vector<RecordedStream> streams_;
  const RunWriterOptions options_;
  PacketQueue& queue_;
  events::RecordingWriter file_;                   ///< used by the writing thread until it has ended, as are the next two
  std::vector<std::optional<CameraTime>> newest_;  ///< the last time written, of each stream
  ClockPairs<CameraClock> pairs_;

  mutable std::mutex guard_;  ///< of all that follows
  Written so_far_;            ///< changed by the writing thread only, except `error`
  RecentLateness lateness_;
  std::condition_variable sync_wanted_;
  bool wants_sync_ = false, ends_ = false;
  std::thread writing_, syncing_;
};

}  // namespace tactile::capture
