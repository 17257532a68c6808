#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tactile/core/whole_file.hpp"

namespace tactile::test {

// Words of EVT2.
inline std::uint32_t evt2_time(std::uint32_t high) { return 0x8U << 28 | high; }
inline std::uint32_t evt2_event(unsigned on, unsigned low_us, unsigned x, unsigned y) {
  return on << 28 | low_us << 22 | x << 11 | y;
}
inline std::uint32_t evt2_trigger(unsigned rising, unsigned low_us, unsigned channel) {
  return 0xAU << 28 | low_us << 22 | channel << 8 | rising;
}

// Words of EVT3.
inline std::uint16_t evt3_word(unsigned type, unsigned value) { return static_cast<std::uint16_t>(type << 12 | value); }
inline std::uint16_t evt3_time_high(unsigned high) { return evt3_word(0x8, high); }
inline std::uint16_t evt3_time_low(unsigned low) { return evt3_word(0x6, low); }
inline std::uint16_t evt3_row(unsigned y) { return evt3_word(0x0, y); }
inline std::uint16_t evt3_event(unsigned on, unsigned x) { return evt3_word(0x2, on << 11 | x); }
inline std::uint16_t evt3_trigger(unsigned rising, unsigned channel) { return evt3_word(0xA, channel << 8 | rising); }

/// Writes a RAW file: the header, then the words.
template <class Word>
void write_raw(const std::filesystem::path& file, std::string_view header, const std::vector<Word>& words,
               std::string_view rest = {}) {
  std::string bytes(header);
  bytes.append(reinterpret_cast<const char*>(words.data()), words.size() * sizeof(Word));
  write_whole(file, bytes.append(rest), IfThere::replace);
}

inline constexpr std::string_view evt3_header =
    "% integrator_name Prophesee\n% serial_number 42\n% format EVT3;height=480;width=640\n% end\n";
inline constexpr std::string_view evt2_header = "% evt 2.0\n% geometry 640x480\n% serial_number 42\n";

/// Words of EVT3 with an event every 10 us from `high` on, at x and y that follow from its number, and a trigger at every 1000th.
inline std::vector<std::uint16_t> steady_evt3(unsigned events, unsigned high = 1) {
  std::vector<std::uint16_t> words;
  unsigned last_high = ~0U;
  for (unsigned i = 0; i < events; ++i) {
    const unsigned us = 4096 * high + 10 * i;
    if (us >> 12 != last_high) words.push_back(evt3_time_high(us >> 12 & 0xFFF));
    last_high = us >> 12;
    words.push_back(evt3_time_low(us & 0xFFF));
    words.push_back(evt3_row(i % 480));
    if (i % 1000 == 999) words.push_back(evt3_trigger(i / 1000 % 2, 3));
    words.push_back(evt3_event(i % 2, i % 640));
  }
  return words;
}

}  // namespace tactile::test
