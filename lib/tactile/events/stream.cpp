#include "tactile/events/stream.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>

#include "tactile/core/enum_names.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/numbers.hpp"

namespace tactile::events {
namespace {
constexpr std::array<std::string_view, 5> type_names{"events", "frames", "imu", "triggers", "other"};
constexpr std::array<std::string_view, 5> compression_names{"none", "lz4", "lz4-high", "zstd", "zstd-high"};
}  // namespace

std::string_view name_of(StreamType type) { return type_names.at(static_cast<std::size_t>(type)); }
std::string_view name_of(Compression compression) { return compression_names.at(static_cast<std::size_t>(compression)); }

Compression compression_named(std::string_view name) {
  return enumerator_named<Compression>(name, compression_names, "compression");
}

Stream completed(Stream stream, std::string_view source) {
  if (stream.name.empty()) stream.name = name_of(stream.type);
  if (stream.source.empty()) stream.source = source;
  return stream;
}

const Stream& event_stream(std::span<const Stream> streams, std::string_view where, std::string_view choice) {
  std::vector<const Stream*> all;
  for (const Stream& stream : streams) {
    if (stream.type == StreamType::events) all.push_back(&stream);
  }
  const std::string name(where);
  if (all.empty()) throw Error(name + ": no event stream; expected an EVTS stream");
  std::vector<const Stream*> chosen = all;
  if (!choice.empty()) {
    const auto id = whole_number_in(choice);
    std::erase_if(chosen, [&](const Stream* s) { return !id || s->id != *id; });
    if (chosen.empty())
      std::copy_if(all.begin(), all.end(), std::back_inserter(chosen), [&](const Stream* s) { return s->source == choice; });
  }
  if (chosen.size() == 1) return *chosen.front();
  std::string list;
  for (const Stream* stream : all) {
    list +=
        fmt::format("{}{}{}", list.empty() ? "" : ", ", stream->id, stream->source.empty() ? "" : " (" + stream->source + ")");
  }
  if (choice.empty())
    throw Error(fmt::format("{}: has {} event streams; expected a choice of {} by id or source", name, all.size(), list));
  throw Error(fmt::format("{}: '{}' names {} of its event streams; expected one of {} by id or source", name, choice,
                          chosen.empty() ? "none" : "more than one", list));
}

}  // namespace tactile::events
