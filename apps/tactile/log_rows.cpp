#include "log_rows.hpp"

#include "tactile/core/error.hpp"
#include "tactile/core/numbers.hpp"
#include "tactile/core/table_file.hpp"

namespace tactile::cli {

std::optional<LogRows> log_rows(const std::filesystem::path& file, std::string_view column, double unit_s,
                                double longest_step_s) {
  try {
    TableFile table(file, {.name = "a log", .header = column, .ends_in_any_bytes = true});
    const std::optional<std::size_t> index = table.find(column);
    if (!index) return std::nullopt;
    LogRows found;
    std::uint64_t steps = 0, empty = 0;
    double stepped_s = 0;
    std::optional<double> before;
    while (table.next() && table.is_ended()) {
      if (table.is_blank()) {
        ++empty;
        before.reset();
        continue;
      }
      if (found.rows > 0) found.gaps += empty;
      empty = 0;
      ++found.rows;
      const std::optional<double> t = *index < table.cells().size() ? number_in(table.cells()[*index]) : std::nullopt;
      if (t && before) {
        const double step_s = unit_s * (*t - *before);
        if (step_s > 0 && step_s <= longest_step_s) {
          ++steps;
          stepped_s += step_s;
        }
      }
      before = t;
    }
    if (steps > 0) found.rate_hz = static_cast<double>(steps) / stepped_s;
    return found;
  } catch (const Error&) {
    return std::nullopt;
  }
}

}  // namespace tactile::cli
