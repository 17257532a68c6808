#include "tactile/report/axis_tics.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "tactile/core/text_lines.hpp"
#include "tactile/pictures/plot_script.hpp"

namespace tactile::report {

double log_position(double value) { return value > 0 ? std::log10(value) : NAN; }

double log_position_from_zero(double value) { return value >= 0 ? std::log10(value + 1) : NAN; }

double drawn_from_zero(double value) { return log_position_from_zero(value < 0 ? 0 : value); }

AxisRange range_around(double least, double most, double shortest, double pixels) {
  if (!(least <= most)) least = most = 0;  // there is no value
  const double lacking = std::max(0.0, shortest - (most - least)) / 2;
  least -= lacking, most += lacking;
  const double margin = 0.05 * (most - least);
  return {least - margin, most + margin, pixels};
}

bool AxisTics::add(const std::vector<std::pair<double, std::string>>& tics) {
  const std::size_t before = tics_.size();
  for (const auto& [position, label] : tics) {
    if (!range_.holds(position)) continue;
    const double pixel = range_.pixel_at(position);
    const double room = is_upright_ ? line : character * static_cast<double>(characters_in(label)) + gap;
    if (std::any_of(tics_.begin(), tics_.end(),
                    [&](const Tic& other) { return std::abs(other.pixel - pixel) < (other.room + room) / 2; })) {
      tics_.resize(before);
      return false;
    }
    tics_.push_back({position, pixel, room, label});
  }
  return true;
}

void AxisTics::add_bare(double position) { bare_ += fmt::format(", '' {:.9g}", position); }

std::string AxisTics::text(bool with_labels) const {
  std::string text;
  for (const Tic& tic : tics_)
    text += fmt::format(", {} {:.9g}", with_labels ? pictures::plot_text(tic.label) : "''", tic.position);
  text += bare_;
  return text.empty() ? "'' 0" : text.substr(2);
}

AxisTics decade_tics(const AxisRange& range, bool from_zero, bool is_upright) {
  constexpr std::size_t few = 4;
  constexpr int least_decade = -9, most_decade = 12;
  const auto position_of = from_zero ? log_position_from_zero : log_position;
  AxisTics tics(range, is_upright);
  const auto of_each = [&](const std::vector<double>& steps, int first, int every) {
    std::vector<std::pair<double, std::string>> values;
    for (int decade = first; decade <= most_decade; decade += every) {
      for (const double step : steps) {
        const double value = step * std::pow(10, decade);
        values.emplace_back(position_of(value), fmt::format("{:.10g}", value));
      }
    }
    return values;
  };
  for (int every = 1; every <= 8; ++every) {
    // Counted from 1, so that every second one is 1, 100, 10000.
    auto decades = of_each({1}, from_zero ? 0 : -every * (-least_decade / every), every);
    if (from_zero) decades.emplace_back(position_of(0), "0");
    if (tics.add(decades)) break;
  }
  const int first = from_zero ? 0 : least_decade;
  tics.add(of_each(from_zero ? std::vector<double>{3} : std::vector<double>{2, 5}, first, 1));
  const int first_fine = from_zero ? -1 : least_decade;
  for (const auto& steps : from_zero ? std::vector<std::vector<double>>{{5}, {2}, {4, 7}, {1.2, 1.5, 2.5, 6, 8}}
                                     : std::vector<std::vector<double>>{{1.5, 3, 7}, {1.2, 2.5, 4, 6, 8}}) {
    if (tics.size() < few) tics.add(of_each(steps, first_fine, 1));
  }
  return tics;
}

}  // namespace tactile::report
