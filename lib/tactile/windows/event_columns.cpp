#include "tactile/windows/event_columns.hpp"

#include <array>
#include <cstring>
#include <utility>

namespace tactile::windows {
namespace h5 = hdf5;

namespace {

constexpr std::array<const char*, 4> names{"t_us", "x", "y", "on"};

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

EventColumns::EventColumns(hid_t group, std::string where) : where_(std::move(where)) {
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
}

EventColumns::Chunks EventColumns::full_chunks_with(std::vector<events::Event> events) {
  Chunks full{.events = std::move(events)};
  const std::span<const events::Event> all(full.events);
  if (!rest_.empty() && rest_.size() + all.size() >= rows_per_chunk) {
    full.begin = rows_per_chunk - rest_.size();
    full.joined = std::exchange(rest_, {});
    full.joined.insert(full.joined.end(), all.begin(), all.begin() + static_cast<std::ptrdiff_t>(full.begin));
  }
  const std::size_t whole = rest_.empty() ? (all.size() - full.begin) / rows_per_chunk : 0;
  full.count = whole + (full.joined.empty() ? 0 : 1);
  const auto left = all.subspan(full.begin + whole * rows_per_chunk);
  rest_.insert(rest_.end(), left.begin(), left.end());
  return full;
}

EventColumns::PackedChunks EventColumns::packed(const Chunks& chunks) {
  PackedChunks packed;
  const auto pack_chunk = [&packed](std::span<const events::Event> events) {
    for (std::size_t column = 0; column < names.size(); ++column) packed.push_back(packed_column(column, events));
  };
  if (!chunks.joined.empty()) pack_chunk(chunks.joined);
  const std::span<const events::Event> all(chunks.events);
  for (std::size_t at = chunks.begin; packed.size() < chunks.count * names.size(); at += rows_per_chunk)
    pack_chunk(all.subspan(at, rows_per_chunk));
  return packed;
}

void EventColumns::write(const PackedChunks& chunks) {
  for (std::size_t i = 0; i < chunks.size(); ++i)
    h5::append_packed_chunk(tables_[i % names.size()], chunks[i], rows_per_chunk, where_);
}

void EventColumns::finish() {
  for (std::size_t column = 0; column < names.size() && !rest_.empty(); ++column)
    h5::append_packed_chunk(tables_[column], packed_column(column, rest_), rest_.size(), where_);
}

}  // namespace tactile::windows
