#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
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

namespace tactile {

/// A source and the thread that receives from it, which does all that is asked of the source. What comes between `begin` and
/// `pause` goes to the queue; a source that is not live waits there for room, what finds none of a live one is counted. Asked by
/// one thread at a time.
class Receiver {
 public:
  /// Receives nothing until it is asked to.
  /// @param index  the source's among all, for the packets
  /// @param queue  must outlive this
  Receiver(std::unique_ptr<CameraSource> source, std::size_t index, PacketQueue& queue);
  ~Receiver();
  Receiver(const Receiver&) = delete;
  Receiver& operator=(const Receiver&) = delete;

  const std::string& name() const { return name_; }
  bool live() const { return live_; }
  bool begins_again() const { return begins_again_; }

  // Each waits for the source's thread, up to the 50 ms and one packet that it may be busy with.
  void discard();                    ///< from now on what comes of a live source outside a run is thrown away
  void begin(const RunFolder& run);  ///< @throws what the source throws
  nlohmann::json camera();
  void end(const RunFolder& run, bool wants_robot, bool wants_video);  ///< @throws what the source throws

  void pause();  ///< at once: nothing more goes to the queue, and what comes of a live source is thrown away

  std::optional<HostTime> ended_at() const;
  std::string error() const;              ///< why the source is gone; empty if it is not
  void add_drops(RunDrops& drops) const;  ///< the present run's

 private:
  void ask(std::function<void()> task);
  bool rests() const;
  bool do_what_is_asked();
  void receive_all();
  void hand_over(PacketQueue::Packet& packet);
  void note_end(const std::string& error);
  void note_drops();

  const std::unique_ptr<CameraSource> source_;  ///< the thread's alone, once that runs
  const std::size_t index_;
  PacketQueue& queue_;
  const std::string name_;
  const bool live_, begins_again_;
  std::atomic<bool> hands_over_{false}, discards_{false};

  mutable std::mutex guard_;  ///< of all that follows
  std::condition_variable wake_;
  std::packaged_task<void()> task_;
  bool has_task_ = false, stops_ = false;
  std::optional<HostTime> ended_at_;
  std::string error_;
  LostElements queue_full_;
  SourceDrops drops_at_begin_, drops_now_;  ///< changed by the thread alone

  std::thread thread_;
};

}  // namespace tactile
