#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "tactile/events/event.hpp"
#include "tactile/hdf5/hdf5_objects.hpp"

namespace tactile::windows {

/// The columns of /events while they are written. Chunk k of every column is written before chunk k + 1 of any. So the bytes
/// depend only on the events, not on pieces or threads. Copied chunks that another version packed may differ.
class EventColumns {
 public:
  static constexpr hsize_t rows_per_chunk = hsize_t{1} << 16;

  /// Full chunks: the first one in `joined`, if that is not empty, the others in `events` from `begin` on.
  struct Chunks {
    std::vector<events::Event> joined{}, events{};
    std::size_t begin = 0, count = 0;  ///< `count`: of chunks, with the joined one
  };
  using PackedChunks = std::vector<std::vector<std::uint8_t>>;  ///< all columns of a chunk, then of the next

  EventColumns(hid_t group, std::string where);
  EventColumns(const EventColumns&) = delete;
  EventColumns& operator=(const EventColumns&) = delete;

  /// Copies the first chunks of another dataset as they are stored. Call it before `full_chunks_with`.
  /// @param older  its group /events  @throws hdf5::Damaged  if a chunk is damaged
  void copy_chunks(hid_t older, std::uint64_t chunks, const std::string& older_where);

  /// Takes the next events. @return  the chunks that are full with them; events that fill no chunk wait for the next call
  Chunks full_chunks_with(std::vector<events::Event> events);
  /// It needs no Session, so several threads may pack at the same time.
  static PackedChunks packed(const Chunks& chunks);
  void write(const PackedChunks& chunks);  ///< in the order of `full_chunks_with`
  void finish();                           ///< writes the last chunk, which need not be full

 private:
  std::string where_;
  std::vector<hdf5::Id> tables_;     ///< t_us, x, y, on
  std::vector<events::Event> rest_;  ///< fewer than fill a chunk
};

}  // namespace tactile::windows
