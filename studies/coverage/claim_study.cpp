#include "claim_study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "interval_methods.hpp"
#include "tactile/core/parallel.hpp"

namespace tactile::study {
namespace {

constexpr std::size_t object_count = 10;
constexpr double confidence = 0.95, together = 1 - (1 - confidence) / object_count;

/// What a claim says of each object.
struct Asked {
  Quantity quantity;
  double limit, good;  // good: far on the claimed side
  bool is_above;
  std::string_view name;

  bool is_beyond(const Bounds& bounds) const { return bounds && (is_above ? bounds->second < limit : bounds->first > limit); }
  bool is_within(const Bounds& bounds) const { return bounds && (is_above ? bounds->first > limit : bounds->second < limit); }
  const std::array<Effects, 3>& effects() const { return is_above ? of_logits : of_logarithms; }
};
constexpr std::array<Asked, 2> claims{{{Quantity::accuracy, 0.95, 0.985, true, "accuracy of at least 95 %"},
                                       {Quantity::mean_delay, 5, 3.2, false, "mean delay of at most 5 ms"}}};

enum class Truth { all_at_limit, one_at_limit, most_beyond };
constexpr std::array<std::pair<Truth, std::string_view>, 3> truths{
    {{Truth::all_at_limit, "true, refuted"}, {Truth::one_at_limit, "false, held"}, {Truth::most_beyond, "false, refuted"}}};

double level_of(const Asked& claim, Truth truth, std::size_t object) {
  if (truth == Truth::all_at_limit) return claim.limit;
  if (truth == Truth::one_at_limit) return object == 0 ? claim.limit : claim.good;
  // Errors of 5 to 19 %, delays of 4 to 13 ms.
  const double place = 0.24 * (static_cast<double>(object) - 4.5);
  return claim.is_above ? 1 - (1 - claim.limit) * std::exp(0.6 * place + 0.7) : claim.limit * std::exp(0.5 * place + 0.42);
}

/// How many times the usual effects act on each object.
struct Spread {
  std::string_view name;
  std::array<double, object_count> factors;
};
constexpr std::array<Spread, 2> spreads{
    {{"alike", {1, 1, 1, 1, 1, 1, 1, 1, 1, 1}}, {"one varies three times as much", {3, 1, 1, 1, 1, 1, 1, 1, 1, 1}}}};

struct Outcome {
  bool is_refuted = false, is_held = false;
};
constexpr std::array<std::string_view, 2> rules{"each object or the mean over them, in use", "each object"};
constexpr std::array<std::string_view, 2> intervals{"mean over these objects", "one object"};

/// Of one made-up study.
struct Judged {
  std::array<Outcome, rules.size()> outcomes;
  std::array<double, intervals.size()> covered{};  // of those that are given
};

double share_covered(const std::vector<Bounds>& bounds, const std::vector<double>& values) {
  double covered = 0, given = 0;
  for (std::size_t i = 0; i < bounds.size(); ++i) {
    constexpr double rounding = 1e-9;
    if (!bounds[i]) continue;
    ++given;
    covered += bounds[i]->first <= values[i] + rounding && values[i] - rounding <= bounds[i]->second ? 1 : 0;
  }
  return given > 0 ? covered / given : NAN;
}

Judged judged(const Asked& claim, const Trial& trial, std::uint64_t seed) {
  const auto options = [&](double of) { return results::BootstrapOptions{draws, of, seed}; };
  const auto of_object = [&](std::size_t i, double of) {
    return bounds_of(evaluation::figure_of_object(trial.objects[i], trial.statistic, options(of), trial.range));
  };
  const auto all_within = [&](const std::vector<Bounds>& all) {
    return std::all_of(all.begin(), all.end(), [&](const Bounds& bounds) { return claim.is_within(bounds); });
  };
  // An interval of higher confidence contains the other, so it need not be made where that is not beyond the limit.
  std::vector<Bounds> plain;
  plain.reserve(trial.objects.size());
  bool by_object = false;
  for (std::size_t i = 0; i < trial.objects.size(); ++i) {
    plain.push_back(of_object(i, confidence));
    by_object = by_object || (claim.is_beyond(plain.back()) && claim.is_beyond(of_object(i, together)));
  }
  const Bounds mean =
      bounds_of(evaluation::figure_of_these_objects(trial.objects, trial.statistic, options(confidence), trial.range));
  const bool is_held = all_within(plain);
  return {{{{by_object || claim.is_beyond(mean), is_held}, {by_object, is_held}}},
          {share_covered({mean}, {trial.truth}), share_covered(plain, trial.truths)}};
}

std::vector<Judged> studies_of(const Asked& claim, Truth truth, const Layout& layout, const Spread& spread, std::size_t size,
                               const std::string& title, const Arguments& arguments) {
  Effects effects = claim.effects()[size];
  effects.object = 0;
  std::vector<ObjectTruth> objects;
  for (std::size_t i = 0; i < object_count; ++i) objects.push_back({level_of(claim, truth, i), spread.factors[i]});
  std::vector<Judged> studies(std::max<std::size_t>(arguments.repeats / 2, 1));
  parallel_for(studies.size(), arguments.threads, [&](std::size_t i) {
    Random random(seed_for(arguments.seed, {"claim", title, std::to_string(i)}));
    const Trial trial = draw_objects(claim.quantity, objects, layout, effects, random);
    studies[i] = judged(claim, trial, random.bits());
  });
  return studies;
}

/// The mean of what a study gives, in percent, without what is not known.
template <class Value>
double percent(const std::vector<Judged>& studies, Value value) {
  double sum = 0, known = 0;
  for (const Judged& study : studies) {
    const double x = value(study);
    if (std::isnan(x)) continue;
    sum += x;
    ++known;
  }
  return known > 0 ? 100 * sum / known : NAN;
}

/// The lines of a table, one for each name, to which columns are added.
template <std::size_t count>
struct Lines {
  explicit Lines(const std::string& design, const std::array<std::string_view, count>& names) {
    for (std::size_t i = 0; i < count; ++i) text[i] = fmt::format("| {}; {} |", design, names[i]);
  }
  void add(std::size_t line, std::size_t size, double value) {
    text[line] += fmt::format("{}{:.1f}{}", size == 0 ? " " : " / ", value, size + 1 == sizes.size() ? " |" : "");
  }
  std::array<std::string, count> text;
};

std::string head(std::string_view first) {
  std::string names = fmt::format("| {} |", first), line = "| --- |";
  for (const Asked& claim : claims) {
    for (const auto& truth : truths) {
      names += fmt::format(" {}: {} |", claim.name, truth.second);
      line += " --- |";
    }
  }
  return names + "\n" + line + "\n";
}

}  // namespace

void print_claims(const Arguments& arguments) {
  fmt::print("\n{}", head("share of claims [%], effects small / typical / large"));
  std::string coverages = head("coverage [%] in these studies, effects small / typical / large");
  for (const Layout& layout : {Layout{object_count, 3, 5, 1}, {object_count, 10, 5, 2}}) {
    if (!arguments.takes(layout)) continue;
    for (const Spread& spread : spreads) {
      const std::string design = fmt::format("{}; {}", layout.in_words(), spread.name);
      Lines of_rules(design, rules);
      Lines of_intervals(design, intervals);
      for (const Asked& claim : claims) {
        for (const auto& [truth, name] : truths) {
          for (std::size_t size = 0; size < sizes.size(); ++size) {
            const auto studies = studies_of(claim, truth, layout, spread, size,
                                            fmt::format("{}, {}, {}, {}", claim.name, name, design, sizes[size]), arguments);
            for (std::size_t i = 0; i < rules.size(); ++i)
              of_rules.add(i, size, percent(studies, [&, is_held = truth == Truth::one_at_limit](const Judged& study) {
                             return (is_held ? study.outcomes[i].is_held : study.outcomes[i].is_refuted) ? 1.0 : 0.0;
                           }));
            for (std::size_t i = 0; i < intervals.size(); ++i)
              of_intervals.add(i, size, percent(studies, [&](const Judged& study) { return study.covered[i]; }));
          }
        }
      }
      for (const auto& line : of_rules.text) fmt::print("{}\n", line);
      std::fflush(stdout);
      for (const auto& line : of_intervals.text) coverages += line + "\n";
    }
  }
  fmt::print("\n{}", coverages);
}

}  // namespace tactile::study
