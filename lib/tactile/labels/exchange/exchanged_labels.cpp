#include "tactile/labels/exchange/exchanged_labels.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <limits>

#include "tactile/core/error.hpp"
#include "tactile/core/text.hpp"

namespace tactile::labels {
namespace {

struct FormatNames {
  ExchangeFormat format;
  std::string_view name, ending;
};

constexpr std::array<FormatNames, 2> formats{
    {{ExchangeFormat::label_studio, "label-studio", ".json"}, {ExchangeFormat::csv, "csv", ".csv"}}};

constexpr std::array<std::pair<TimeOrigin, std::string_view>, 3> origins{
    {{TimeOrigin::first_event, "first-event"}, {TimeOrigin::camera, "camera"}, {TimeOrigin::video, "video"}}};

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

bool is_plain_id(std::string_view id) {
  return !id.empty() && id.size() <= 64 && is_letter(id.front()) && std::all_of(id.begin(), id.end(), [](char c) {
    return is_letter(c) || is_digit(c) || c == '-' || c == '_' || c == '.';
  });
}

}  // namespace

std::string_view name_of(ExchangeFormat format) { return formats[static_cast<std::size_t>(format)].name; }
std::string_view ending_of(ExchangeFormat format) { return formats[static_cast<std::size_t>(format)].ending; }

std::optional<ExchangeFormat> exchange_format_named(std::string_view name) {
  for (const FormatNames& known : formats) {
    if (known.name == name) return known.format;
  }
  return std::nullopt;
}

std::optional<ExchangeFormat> exchange_format_by_ending(const std::filesystem::path& file) {
  const std::string ending = lower_case(file.extension().string());
  for (const FormatNames& known : formats) {
    if (known.ending == ending) return known.format;
  }
  return std::nullopt;
}

std::string_view name_of(TimeOrigin origin) { return origins[static_cast<std::size_t>(origin)].second; }

std::optional<TimeOrigin> time_origin_named(std::string_view name) {
  for (const auto& [origin, known] : origins) {
    if (known == name) return origin;
  }
  return std::nullopt;
}

ClockRelation FileTimes::to_camera(CameraTime first_event) const {
  if (origin == TimeOrigin::camera) return {};
  return {.offset_us = saturating_add(us_of(first_event), zero_us), .drift_ppm = drift_ppm, .reference_us = 0};
}

void check_count(std::size_t count, std::size_t most, std::string_view of_what, const std::filesystem::path& file) {
  if (count > most) throw Error(fmt::format("{}: has more than {} {}; expected fewer", file.string(), most, of_what));
}

void check_ids(const LabelsToExport& labels) {
  for (const LabelledInterval& interval : labels.labels.intervals) {
    if (is_plain_id(interval.id)) continue;
    throw Error(
        fmt::format("{}: the id {} cannot be kept in other tools; expected a letter, then at most 63 letters, digits, '-', '_' "
                    "and '.'",
                    labels.run, shown_text(interval.id)));
  }
}

std::string doubts_of(const Labels& labels, std::optional<std::size_t> interval_index) {
  std::string text;
  for (const LabelFlag& flag : labels.flags) {
    if (flag.confirmed || flag.interval_index != interval_index) continue;
    text += (text.empty() ? "" : "; ") + flag.reason;
  }
  return text;
}

std::string seconds_text(std::int64_t us) {
  const bool is_negative = us < 0;
  const std::uint64_t size = is_negative ? 0 - static_cast<std::uint64_t>(us) : static_cast<std::uint64_t>(us);
  return fmt::format("{}{}.{:06}", is_negative ? "-" : "", size / 1'000'000, size % 1'000'000);
}

std::optional<ReadSeconds> seconds_in(std::string_view text) {
  const bool is_negative = text.starts_with('-');
  if (is_negative || text.starts_with('+')) text.remove_prefix(1);
  const std::size_t point = std::min(text.find_first_of(".,"), text.size());
  const std::string_view whole = text.substr(0, point);
  const std::string_view decimals = point < text.size() ? text.substr(point + 1) : std::string_view();
  if (whole.empty() && decimals.empty()) return std::nullopt;
  if (!std::all_of(whole.begin(), whole.end(), is_digit) || !std::all_of(decimals.begin(), decimals.end(), is_digit))
    return std::nullopt;
  std::int64_t us = 0;
  const auto append = [&](int digit) {
    return !__builtin_mul_overflow(us, std::int64_t{10}, &us) &&
           !__builtin_add_overflow(us, std::int64_t{is_negative ? -digit : digit}, &us);
  };
  for (const char c : whole) {
    if (!append(c - '0')) return std::nullopt;
  }
  for (std::size_t i = 0; i < 6; ++i) {
    if (!append(i < decimals.size() ? decimals[i] - '0' : 0)) return std::nullopt;
  }
  if (decimals.size() > 6 && decimals[6] >= '5') us = saturating_add(us, is_negative ? -1 : 1);
  constexpr std::array<std::int64_t, 6> roundings{500, 500, 500,
                                                  500, 50,  5};  // few decimals mean dropped zeros, not a low resolution
  return ReadSeconds{.us = us, .rounding_us = decimals.size() < roundings.size() ? roundings[decimals.size()] : 1};
}

}  // namespace tactile::labels
