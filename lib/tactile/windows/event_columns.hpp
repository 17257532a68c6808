#pragma once

#include <cstdint>
#include <future>
#include <span>
#include <string>
#include <vector>

#include "tactile/events/event.hpp"
#include "tactile/hdf5/hdf5_objects.hpp"

namespace tactile::windows {

/// The columns of /events while they are written. Chunk k of every column is written before chunk k + 1 of any. So the bytes of
/// the file follow from the events alone: not from the pieces in which they come, the threads, or the file that chunks are copied
/// from, unless another version has packed that.
class EventColumns {
 public:
  static constexpr hsize_t rows_per_chunk = hsize_t{1} << 16;

  /// @param threads  that pack chunks, beside the caller if it is not 1; 0: one per core
  EventColumns(hid_t group, std::string where, unsigned threads);
  EventColumns(const EventColumns&) = delete;
  EventColumns& operator=(const EventColumns&) = delete;

  /// Copies the first chunks of another dataset as they are stored. Call it before `append`.
  /// @param older  its group /events  @throws hdf5::Damaged  if a chunk is damaged
  void copy_chunks(hid_t older, std::uint64_t chunks, const std::string& older_where);
  void append(std::span<const events::Event> events);
  void finish();  ///< writes all chunks, of which the last need not be full
  std::uint64_t appended() const { return appended_; }

 private:
  void start_packing(std::size_t events);
  void write_packed();

  std::string where_;
  unsigned threads_;
  std::vector<hdf5::Id> tables_;  ///< t_us, x, y, on
  std::vector<events::Event> pending_, being_packed_;
  std::vector<std::vector<std::uint8_t>> packed_;  ///< chunks of `being_packed_`: all columns of one, then of the next
  std::uint64_t appended_ = 0;
  std::future<void> packing_;  ///< the last member, so that it ends first
};

}  // namespace tactile::windows
