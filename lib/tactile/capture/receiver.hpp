#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <thread>

#include "tactile/capture/camera_source.hpp"
#include "tactile/capture/packet_queue.hpp"
#include "tactile/capture/run_drops.hpp"

namespace tactile::capture {

/// A source and its thread, on which all functions of the source are called. Packets between `begin` and `pause` go to the queue.
/// If there is no room, a source that is not live waits; packets of a live one are dropped and counted. Used by one thread at a
/// time.
class Receiver {
 public:
  /// Receives nothing until `discard` or `begin`.
  /// @param index  of the source, for its packets
  /// @param queue  must outlive this
  /// @param see    called with each packet that arrives, on the source's thread; may be empty
  Receiver(std::unique_ptr<CameraSource> source, std::size_t index, PacketQueue& queue,
           std::function<void(const CameraPacket&)> see = {});
  ~Receiver();
  Receiver(const Receiver&) = delete;
  Receiver& operator=(const Receiver&) = delete;

  const std::string& name() const { return name_; }
  bool live() const { return live_; }
  bool begins_again() const { return begins_again_; }

  // Each waits for the source's thread, which may be busy for 50 ms and one packet.
  void discard();                    ///< from now on packets of a live source outside a run are discarded
  void begin(const RunFolder& run);  ///< @throws what the source throws
  nlohmann::json camera();
  void end(const RunFolder& run, bool wants_robot, bool wants_video);  ///< @throws what the source throws

  void pause();  ///< immediately: no more packets go to the queue, and those of a live source are discarded

  std::uint64_t packets() const { return packets_.load(std::memory_order_relaxed); }  ///< that arrived so far
  std::optional<HostTime> ended_at() const;
  std::string error() const;              ///< why the source is lost; empty if it is not
  void add_drops(RunDrops& drops) const;  ///< of the present run

 private:
  void ask(std::function<void()> task);
  bool rests() const;
  bool do_what_is_asked();
  void receive_all();
  void hand_over(PacketQueue::Packet& packet);
  void note_end(const std::string& error);
  void note_drops();

  const std::unique_ptr<CameraSource> source_;  ///< used by the thread only, once it runs
  const std::size_t index_;
  PacketQueue& queue_;
  const std::string name_;
  const bool live_, begins_again_;
  const std::function<void(const CameraPacket&)> see_;
  std::atomic<std::uint64_t> packets_{0};
  std::atomic<bool> hands_over_{false}, discards_{false};

  mutable std::mutex guard_;  ///< of all that follows
  std::condition_variable wake_;
  std::packaged_task<void()> task_;
  bool has_task_ = false, stops_ = false;
  std::optional<HostTime> ended_at_;
  std::string error_;
  LostElements queue_full_;
  SourceDrops drops_at_begin_, drops_now_;  ///< changed by the thread only

  std::thread thread_;
};

}  // namespace tactile::capture
