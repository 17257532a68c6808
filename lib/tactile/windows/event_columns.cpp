#include "tactile/windows/event_columns.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

#include "tactile/core/parallel.hpp"
#include "tactile/core/start_beside.hpp"

namespace tactile::windows {
namespace h5 = hdf5;

namespace {

constexpr std::array<const char*, 4> names{"t_us", "x", "y", "on"};
constexpr std::size_t chunks_at_once = 16;  // enough for all cores; 1 Mi events

template <class T, class Get>
std::vector<std::uint8_t> packed(std::span<const events::Event> events, Get get) {
  std::vector<std::uint8_t> bytes(EventColumns::rows_per_chunk * sizeof(T));  // rows that do not exist are 0
  for (std::size_t i = 0; i < events.size(); ++i) {
    const T value = get(events[i]);
    std::memcpy(&bytes[i * sizeof(T)], &value, sizeof(T));
  }
  return h5::packed_chunk(bytes, sizeof(T));
}

std::vector<std::uint8_t> packed_column(std::size_t column, std::span<const events::Event> events) {
  if (column == 0) return packed<std::int64_t>(events, [](const events::Event& event) { return us_of(event.t); });
  if (column == 1)
    return packed<std::uint16_t>(events, [](const events::Event& event) { return static_cast<std::uint16_t>(event.x); });
  if (column == 2)
    return packed<std::uint16_t>(events, [](const events::Event& event) { return static_cast<std::uint16_t>(event.y); });
  return packed<std::uint8_t>(events, [](const events::Event& event) { return event.on; });
}

}  // namespace

EventColumns::EventColumns(hid_t group, std::string where, unsigned threads) : where_(std::move(where)), threads_(threads) {
  const std::array<hid_t, names.size()> types{H5T_STD_I64LE, H5T_STD_U16LE, H5T_STD_U16LE, H5T_STD_U8LE};
  for (std::size_t column = 0; column < names.size(); ++column)
    tables_.push_back(h5::create_table(group, names[column], types[column], {}, rows_per_chunk, where_));
}

void EventColumns::copy_chunks(hid_t older, std::uint64_t chunks, const std::string& older_where) {
  if (chunks == 0) return;
  std::vector<h5::Id> tables;
  for (const char* name : names) {
    tables.push_back(h5::open_table(older, name, older_where));
    if (h5::rows_per_chunk(tables.back(), older_where) != rows_per_chunk)
      throw h5::Damaged(older_where + ": has chunks of another size; expected a dataset of this version");
  }
  for (std::uint64_t chunk = 0; chunk < chunks; ++chunk) {
    for (std::size_t column = 0; column < names.size(); ++column) {
      const auto bytes = h5::read_packed_chunk(tables[column], chunk * rows_per_chunk, older_where);
      h5::append_packed_chunk(tables_[column], bytes, rows_per_chunk, where_);
    }
  }
  appended_ += chunks * rows_per_chunk;
}

void EventColumns::append(std::span<const events::Event> events) {
  pending_.insert(pending_.end(), events.begin(), events.end());
  appended_ += events.size();
  while (pending_.size() >= chunks_at_once * rows_per_chunk) start_packing(chunks_at_once * rows_per_chunk);
}

void EventColumns::finish() {
  start_packing(pending_.size());
  write_packed();
}

/// Packs the first pending events beside the caller, who appends further ones meanwhile.
void EventColumns::start_packing(std::size_t events) {
  write_packed();
  const auto end = pending_.begin() + static_cast<std::ptrdiff_t>(events);
  being_packed_.assign(pending_.begin(), end);
  pending_.erase(pending_.begin(), end);
  packed_.resize((events + rows_per_chunk - 1) / rows_per_chunk * names.size());
  packing_ = start_beside(threads_, [this] {
    parallel_for(packed_.size(), threads_, [&](std::size_t i) {
      const auto rest = std::span<const events::Event>(being_packed_).subspan(i / names.size() * rows_per_chunk);
      packed_[i] = packed_column(i % names.size(), rest.first(std::min<std::size_t>(rows_per_chunk, rest.size())));
    });
  });
}

/// Waits until chunks are packed, and writes them.
void EventColumns::write_packed() {
  if (packing_.valid()) packing_.get();
  for (std::size_t i = 0; i < packed_.size(); ++i) {
    const std::size_t rows = std::min<std::size_t>(rows_per_chunk, being_packed_.size() - i / names.size() * rows_per_chunk);
    h5::append_packed_chunk(tables_[i % names.size()], packed_[i], rows, where_);
  }
  packed_.clear();
}

}  // namespace tactile::windows
