#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>

#include "interval_methods.hpp"
#include "tactile/core/parallel.hpp"
#include "tactile/core/robust_statistics.hpp"

namespace tactile::study {
namespace {

constexpr std::size_t draws = 400;  // fewer than the default, for the time; the interval in use hardly depends on them
constexpr std::array<std::string_view, 3> sizes{"small", "typical", "large"};
// Typical: with another training single objects differ by up to 17 points.
const std::array<Effects, 3> of_logits{{{0.1, 0.4, 0.2, 0.2, 0.1}, {0.3, 1.0, 0.5, 0.4, 0.3}, {0.6, 1.4, 1.0, 0.8, 0.5}}};
const std::array<Effects, 3> of_logarithms{{{0.05, 0.2, 0.1, 0.1, 0.5}, {0.15, 0.5, 0.25, 0.2, 0.7}, {0.3, 0.7, 0.5, 0.4, 1.0}}};

struct Coverage {
  std::size_t trials = 0, given = 0, covered = 0;
  double width = 0;  // in the median

  double share() const { return given > 0 ? static_cast<double>(covered) / static_cast<double>(given) : NAN; }
};

struct Row {
  std::string title;
  bool of_one = false;
  std::array<std::vector<Coverage>, 3> sizes;  // of each method
};

struct Arguments {
  std::uint64_t seed = 1;
  std::size_t repeats = 1000;
  unsigned threads = 0;
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

Row row_of(Quantity quantity, double level, const std::string& name, const Layout& layout, const Arguments& arguments) {
  Row row{fmt::format("{}; {}", name, layout.in_words()), layout.objects == 1, {}};
  const bool share = quantity == Quantity::accuracy || quantity == Quantity::difference || quantity == Quantity::best_of_five;
  for (std::size_t size = 0; size < sizes.size(); ++size) {
    const Scenario scenario{quantity, level, layout, share ? of_logits[size] : of_logarithms[size]};
    row.sizes[size] = coverage_of(scenario, arguments, fmt::format("{} {}", row.title, sizes[size]));
  }
  return row;
}

void print_row(const Row& row) {
  fmt::print("| {} |", row.title);
  for (const auto& of_methods : row.sizes) {
    const Coverage& used = of_methods.front();
    const double none = 100 * static_cast<double>(used.trials - used.given) / static_cast<double>(used.trials);
    fmt::print(" {:.1f}{} |", 100 * used.share(), none < 0.05 ? "" : fmt::format(" ({:.1f} none)", none));
  }
  fmt::print("\n");
  std::fflush(stdout);
}

std::vector<Row> print_accuracies(const Arguments& arguments) {
  std::vector<Row> rows;
  const auto add = [&](const Layout& layout) {
    for (const double level : {0.99, 0.95, 0.8}) {
      rows.push_back(row_of(Quantity::accuracy, level, fmt::format("accuracy {:.0f} %", 100 * level), layout, arguments));
      print_row(rows.back());
    }
  };
  for (const std::size_t trainings : {1U, 3U, 5U}) {
    for (const auto& [objects, runs] : {std::pair{3U, 2U}, {5U, 3U}, {10U, 2U}, {10U, 7U}}) add({objects, runs, trainings});
  }
  add({10, 7, 2});
  for (const Layout& layout : {Layout{10, 3, 3, 1}, {10, 10, 3, 2}, {10, 10, 5, 2}}) add(layout);
  for (const Layout& layout : {Layout{1, 3, 1},
                               {1, 7, 1},
                               {1, 9, 1},
                               {1, 7, 2},
                               {1, 3, 3},
                               {1, 7, 3},
                               {1, 9, 5},
                               {1, 3, 3, 1},
                               {1, 10, 3, 2},
                               {1, 10, 5, 2}})
    add(layout);
  return rows;
}

std::vector<Row> print_others(const Arguments& arguments) {
  std::vector<Row> rows;
  const auto add = [&](Quantity quantity, double level, const std::string& name) {
    for (const Layout& layout :
         {Layout{10, 7, 1}, {5, 3, 3}, {10, 7, 3}, {10, 3, 3, 1}, {10, 10, 5, 2}, {1, 7, 1}, {1, 7, 3}, {1, 10, 5, 2}}) {
      rows.push_back(row_of(quantity, level, name, layout, arguments));
      print_row(rows.back());
    }
  };
  add(Quantity::difference, 0.95, "difference of two accuracies");
  add(Quantity::best_of_five, 0, "best of four accuracies less another");
  add(Quantity::mean_delay, 0, "mean delay");
  add(Quantity::median_delay, 0, "median delay");
  add(Quantity::rate, 0, "alarms per minute");
  return rows;
}

void print_methods(const std::vector<Row>& rows) {
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
      for (const Row& row : rows) {
        const Coverage& coverage = row.sizes[size][m];
        if (coverage.given == 0) continue;
        sum += coverage.share();
        lowest = std::min(lowest, coverage.share());
        enough += coverage.share() >= 0.93 ? 1 : 0;
        nearly += coverage.share() >= 0.9 ? 1 : 0;
        widths.push_back(coverage.width / row.sizes[size].front().width);
      }
      const auto count = static_cast<double>(widths.size());
      fmt::print("| {} | {} | {:.1f} | {:.1f} | {:.0f} % | {:.0f} % | {:.2f} |\n", methods[m].name, sizes[size],
                 100 * sum / count, 100 * lowest, 100 * static_cast<double>(enough) / count,
                 100 * static_cast<double>(nearly) / count, median(widths));
    }
  }
}

/// Claims about every object that are true, each object exactly at the limit: the share that an interval of one object refutes.
void print_claims(const Arguments& arguments) {
  const auto& methods = interval_methods();
  fmt::print(
      "\n| true claim about each of ten objects | method | small | typical | large |\n| --- | --- | ---: | ---: | ---: |\n");
  for (const auto& [quantity, level, name] : {std::tuple{Quantity::accuracy, 0.95, "accuracy of at least 95 %"},
                                              {Quantity::accuracy, 0.99, "accuracy of at least 99 %"},
                                              {Quantity::mean_delay, 0.0, "mean delay of at most its limit"}}) {
    for (const Layout& layout : {Layout{10, 7, 1}, {10, 7, 2}, {10, 7, 3}, {10, 10, 3, 2}, {10, 10, 5, 2}, {10, 3, 3, 1}}) {
      std::array<std::vector<std::size_t>, 3> wrong;
      for (std::size_t size = 0; size < sizes.size(); ++size) {
        Scenario scenario{quantity, level, layout, (quantity == Quantity::accuracy ? of_logits : of_logarithms)[size]};
        scenario.effects.object = 0;
        if (layout.trainings == 1) scenario.effects.both = 0;
        std::vector<std::vector<char>> refuted(arguments.repeats, std::vector<char>(methods.size()));
        parallel_for(arguments.repeats, arguments.threads, [&](std::size_t i) {
          Random random(seed_for(arguments.seed, {"claim", name, layout.in_words(), sizes[size], std::to_string(i)}));
          const Trial trial = draw(scenario, random);
          const results::BootstrapOptions options{draws, 1 - 0.05 / 10, random.bits()};
          for (const auto& object : trial.objects) {
            const Trial of_object{{object}, trial.statistic, trial.range, trial.truth};
            for (std::size_t m = 0; m < methods.size(); ++m) {
              const Bounds bounds = methods[m].bounds(of_object, options);
              if (bounds && (quantity == Quantity::accuracy ? bounds->second < trial.truth : bounds->first > trial.truth))
                refuted[i][m] = 1;
            }
          }
        });
        wrong[size].resize(methods.size());
        for (const auto& of_trial : refuted) {
          for (std::size_t m = 0; m < methods.size(); ++m) wrong[size][m] += of_trial[m] ? 1U : 0U;
        }
      }
      for (const std::size_t m : {std::size_t{0}, std::size_t{2}, methods.size() - 1}) {
        fmt::print("| {}; {} | {} |", name, layout.in_words(), methods[m].name);
        for (const auto& of_size : wrong)
          fmt::print(" {:.1f} |", 100 * static_cast<double>(of_size[m]) / static_cast<double>(arguments.repeats));
        fmt::print("\n");
        std::fflush(stdout);
      }
    }
  }
}

void print_study(const Arguments& arguments) {
  fmt::print("Seed {}, {} repeats: the standard error of a coverage of 95 % is {:.1f} points, of 90 % {:.1f}.\n\n",
             arguments.seed, arguments.repeats, 100 * std::sqrt(0.95 * 0.05 / static_cast<double>(arguments.repeats)),
             100 * std::sqrt(0.9 * 0.1 / static_cast<double>(arguments.repeats)));
  fmt::print("| coverage of 95 % intervals [%] | small effects | typical | large |\n| --- | ---: | ---: | ---: |\n");
  std::vector<Row> rows = print_accuracies(arguments);
  for (Row& row : print_others(arguments)) rows.push_back(std::move(row));
  print_methods(rows);
  print_claims(arguments);
}

}  // namespace
}  // namespace tactile::study

int main(int argc, char** argv) {
  tactile::study::Arguments arguments;
  bool brief = false;
  CLI::App app("Prints how often intervals contain the true value, on made-up results, as Markdown");
  app.add_option("--seed", arguments.seed, "Seed of all made-up results")->capture_default_str();
  app.add_option("--repeats", arguments.repeats, "Made-up results of each design")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_flag("--short", brief, "100 repeats");
  app.add_option("--threads", arguments.threads, "0: as many as there are cores")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  if (brief) arguments.repeats = 100;
  tactile::study::print_study(arguments);
}
