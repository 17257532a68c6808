#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <array>
#include <cmath>
#include <cstdio>
#include <exception>

#include "interval_methods.hpp"
#include "tactile/core/parallel.hpp"
#include "tactile/core/robust_statistics.hpp"

namespace tactile::study {
namespace {

constexpr std::size_t draws = 400;  // fewer than the default, for the time; the interval in use hardly depends on them
constexpr std::array<std::string_view, 3> sizes{"small", "typical", "large"};
// Typical: with another training single objects differ by up to 17 points.
constexpr std::array<Effects, 3> of_logits{{{0.1, 0.4, 0.2, 0.2, 0.1}, {0.3, 1.0, 0.5, 0.4, 0.3}, {0.6, 1.4, 1.0, 0.8, 0.5}}};
constexpr std::array<Effects, 3> of_logarithms{
    {{0.05, 0.2, 0.1, 0.1, 0.5}, {0.15, 0.5, 0.25, 0.2, 0.7}, {0.3, 0.7, 0.5, 0.4, 1.0}}};

struct Arguments {
  std::uint64_t seed = 1;
  std::size_t repeats = 800;
  unsigned threads = 0;
  std::string only;  ///< designs whose name has it; empty: all

  bool takes(const Layout& layout) const { return layout.in_words().find(only) != std::string::npos; }
};

struct Coverage {
  std::size_t trials = 0, given = 0, covered = 0;
  double width = 0;  // in the median

  double share() const { return given > 0 ? static_cast<double>(covered) / static_cast<double>(given) : NAN; }
};

using OfSizes = std::array<std::vector<Coverage>, 3>;  // of each method

/// A quantity of the tables, a column.
struct Column {
  Quantity quantity;
  double level;
  std::string name;

  const std::array<Effects, 3>& effects() const {
    const bool of_samples = quantity == Quantity::accuracy || quantity == Quantity::missed || quantity == Quantity::difference ||
                            quantity == Quantity::best_of_five;
    return of_samples ? of_logits : of_logarithms;
  }
};

std::vector<Coverage> coverage_of(const Scenario& scenario, const Arguments& arguments, const std::string& title) {
  const auto& methods = interval_methods();
  struct Outcome {
    Bounds bounds;
    bool covered = false;
  };
  std::vector<std::vector<Outcome>> outcomes(arguments.repeats, std::vector<Outcome>(methods.size()));
  parallel_for(arguments.repeats, arguments.threads, [&](std::size_t i) {
    Random random(seed_for(arguments.seed, {title, std::to_string(i)}));
    const Trial trial = draw(scenario, random);
    const results::BootstrapOptions options{draws, 0.95, random.bits()};
    for (std::size_t m = 0; m < methods.size(); ++m) {
      const Bounds bounds = methods[m].bounds(trial, options);
      constexpr double rounding = 1e-9;
      outcomes[i][m] = {bounds, bounds && bounds->first <= trial.truth + rounding && trial.truth - rounding <= bounds->second};
    }
  });
  std::vector<Coverage> coverages(methods.size());
  for (std::size_t m = 0; m < methods.size(); ++m) {
    std::vector<double> widths;
    for (const auto& of_trial : outcomes) {
      coverages[m].covered += of_trial[m].covered ? 1 : 0;
      if (of_trial[m].bounds) widths.push_back(of_trial[m].bounds->second - of_trial[m].bounds->first);
    }
    coverages[m].trials = outcomes.size();
    coverages[m].given = widths.size();
    coverages[m].width = median(widths);
  }
  return coverages;
}

/// "96.1 / 94.8 / 92.0", with the share of intervals without bounds where there are any.
std::string text_of(const OfSizes& coverages) {
  std::string text;
  for (const auto& of_methods : coverages) {
    const Coverage& used = of_methods.front();
    const double none = 100 * static_cast<double>(used.trials - used.given) / static_cast<double>(used.trials);
    text += fmt::format("{}{:.1f}{}", text.empty() ? "" : " / ", 100 * used.share(),
                        none < 0.05 ? "" : fmt::format(" ({:.1f} none)", none));
  }
  return text;
}

void print_head(const std::string& first, const std::vector<Column>& columns) {
  fmt::print("\n| {} |", first);
  for (const Column& column : columns) fmt::print(" {} |", column.name);
  fmt::print("\n| --- |");
  for (std::size_t i = 0; i < columns.size(); ++i) fmt::print(" --- |");
  fmt::print("\n");
}

void print_coverages(const std::vector<Column>& columns, const std::vector<Layout>& layouts, const Arguments& arguments,
                     std::vector<OfSizes>& all) {
  print_head("coverage [%], effects small / typical / large", columns);
  for (const Layout& layout : layouts) {
    if (!arguments.takes(layout)) continue;
    fmt::print("| {} |", layout.in_words());
    for (const Column& column : columns) {
      OfSizes coverages;
      for (std::size_t size = 0; size < sizes.size(); ++size)
        coverages[size] = coverage_of({column.quantity, column.level, layout, column.effects()[size]}, arguments,
                                      fmt::format("{}, {}, {}", column.name, layout.in_words(), sizes[size]));
      fmt::print(" {} |", text_of(coverages));
      std::fflush(stdout);
      all.push_back(std::move(coverages));
    }
    fmt::print("\n");
  }
}

std::vector<Layout> layouts_of_accuracies() {
  std::vector<Layout> layouts;
  for (const std::size_t trainings : {1U, 3U, 5U}) {
    for (const auto& [objects, runs] : {std::pair{3U, 2U}, {5U, 3U}, {10U, 2U}, {10U, 7U}})
      layouts.push_back({objects, runs, trainings});
  }
  for (const std::size_t worlds : {3U, 5U, 8U}) layouts.push_back({worlds, 40, 1});  // as a study has them: objects are worlds
  for (const Layout& layout : {Layout{10, 3, 3, 1},
                               {10, 3, 5, 1},
                               {10, 10, 3, 2},
                               {10, 10, 5, 2},
                               {1, 3, 1},
                               {1, 7, 1},
                               {1, 9, 1},
                               {1, 3, 3},
                               {1, 7, 3},
                               {1, 9, 5},
                               {1, 3, 3, 1},
                               {1, 3, 5, 1},
                               {1, 10, 3, 2},
                               {1, 10, 5, 2}})
    layouts.push_back(layout);
  return layouts;
}

void print_methods(const std::vector<OfSizes>& all) {
  fmt::print(
      "\n| method | size | mean coverage [%] | lowest [%] | designs with at least 93 % | at least 90 % | width, of that in use "
      "|\n");
  fmt::print("| --- | --- | ---: | ---: | ---: | ---: | ---: |\n");
  const auto& methods = interval_methods();
  for (std::size_t m = 0; m < methods.size(); ++m) {
    for (std::size_t size = 0; size < sizes.size(); ++size) {
      double sum = 0, lowest = 1;
      std::size_t enough = 0, nearly = 0;
      std::vector<double> widths;
      for (const OfSizes& coverages : all) {
        const Coverage& coverage = coverages[size][m];
        if (coverage.given == 0) continue;
        sum += coverage.share();
        lowest = std::min(lowest, coverage.share());
        enough += coverage.share() >= 0.93 ? 1 : 0;
        nearly += coverage.share() >= 0.9 ? 1 : 0;
        widths.push_back(coverage.width / coverages[size].front().width);
      }
      const auto count = static_cast<double>(widths.size());
      fmt::print("| {} | {} | {:.1f} | {:.1f} | {:.0f} % | {:.0f} % | {:.2f} |\n", methods[m].name, sizes[size],
                 100 * sum / count, 100 * lowest, 100 * static_cast<double>(enough) / count,
                 100 * static_cast<double>(nearly) / count, median(widths));
    }
  }
}

void print_study(const Arguments& arguments) {
  const auto error_at = [&](double share) {
    return 100 * std::sqrt(share * (1 - share) / static_cast<double>(arguments.repeats));
  };
  fmt::print("Seed {}, {} repeats. The standard error of a coverage of 95 % is {:.1f} points, of one of 90 % {:.1f}.\n",
             arguments.seed, arguments.repeats, error_at(0.95), error_at(0.9));
  std::vector<OfSizes> all;
  print_coverages(
      {{Quantity::accuracy, 0.99, "accuracy 99 %"}, {Quantity::accuracy, 0.95, "95 %"}, {Quantity::accuracy, 0.8, "80 %"}},
      layouts_of_accuracies(), arguments, all);
  print_coverages({{Quantity::difference, 0.95, "difference of two accuracies"},
                   {Quantity::best_of_five, 0, "best of four accuracies less a fifth"},
                   {Quantity::mean_delay, 0, "mean delay"},
                   {Quantity::quantile_of_delays, 0.5, "median delay"},
                   {Quantity::quantile_of_delays, 0.9, "90 % of delays, at most 100 ms"},
                   {Quantity::missed, 0.02, "missed 2 %"},
                   {Quantity::missed, 0.005, "0.5 %"},
                   {Quantity::rate, 3, "3 alarms per minute"},
                   {Quantity::rate, 0.3, "0.3"}},
                  {{8, 40, 1},
                   {10, 7, 1},
                   {5, 3, 3},
                   {10, 7, 3},
                   {10, 3, 3, 1},
                   {10, 3, 5, 1},
                   {10, 10, 5, 2},
                   {1, 7, 1},
                   {1, 7, 3},
                   {1, 3, 5, 1},
                   {1, 10, 5, 2}},
                  arguments, all);
  print_methods(all);
}

}  // namespace
}  // namespace tactile::study

int main(int argc, char** argv) try {
  tactile::study::Arguments arguments;
  bool brief = false;
  CLI::App app("Prints how often intervals contain the true value, on made-up results, as Markdown");
  app.add_option("--seed", arguments.seed, "Seed of all made-up results")->capture_default_str();
  app.add_option("--repeats", arguments.repeats, "Made-up results of each design")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--only", arguments.only, "Only designs whose name has this text, such as '3 runs, 5 trainings'");
  app.add_flag("--short", brief, "100 repeats");
  app.add_option("--threads", arguments.threads, "0: as many as there are cores")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  if (brief) arguments.repeats = 100;
  tactile::study::print_study(arguments);
} catch (const std::exception& error) {
  std::fprintf(stderr, "coverage_study: %s\n", error.what());
  return 1;
}
