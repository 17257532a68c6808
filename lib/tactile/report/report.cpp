#include "tactile/report/report.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <utility>

#include "tactile/core/error.hpp"
#include "tactile/core/error_text.hpp"
#include "tactile/core/runs_below.hpp"
#include "tactile/core/version.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/report/frames_picture.hpp"
#include "tactile/report/html_page.hpp"
#include "tactile/report/prediction_file.hpp"

namespace tactile {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t most_runs_over_time = 6;
constexpr std::size_t most_settings = 80;  // of a trade, beside its fronts

HtmlCell number(const std::string& text, const std::string& second_line = {}) {
  return {.text = text, .tone = HtmlTone::number, .second_line = second_line};
}

/// "95.12", below it "93.10 to 97.00"; of shares in percent.
HtmlCell cell_of(const Figure& measured, double factor, std::string_view unit = {}) {
  if (!std::isfinite(measured.value)) return number("-");
  const std::string interval =
      measured.has_interval() ? fmt::format("{:.2f} to {:.2f}", factor * *measured.low, factor * *measured.high) : std::string();
  return number(fmt::format("{:.2f}{}", factor * measured.value, unit), interval);
}

HtmlCell percent_cell(const Figure& measured) { return cell_of(measured, 100); }

HtmlCell plain_number(double value, int digits = 2) {
  return number(std::isfinite(value) ? fmt::format("{:.{}f}", value, digits) : std::string("-"));
}

HtmlTable table_of(const ReportedTable& table) {
  HtmlTable html{.caption = table.caption, .head = table.head, .rows = {}};
  for (const std::vector<std::string>& row : table.rows) {
    html.rows.emplace_back();
    for (const std::string& text : row) html.rows.back().push_back({.text = text});
  }
  return html;
}

std::string with_unit(const Figure& measured, const std::string& unit) {
  if (!std::isfinite(measured.value)) return "not measured";
  const bool is_whole = measured.value == std::round(measured.value);  // a count, or a delay of whole ticks
  const bool is_one = measured.value == 1 && unit.ends_with('s') && unit != "ms";
  std::string text = fmt::format("{:.{}f} {}", measured.value, is_whole ? 0 : 2, is_one ? unit.substr(0, unit.size() - 1) : unit);
  const auto bound = [&](std::optional<double> value) {
    return value ? fmt::format("{:.{}f}", *value, *value == std::round(*value) ? 0 : 2) : std::string("unknown");
  };
  text += measured.low || measured.high ? fmt::format(" ({} to {})", bound(measured.low), bound(measured.high))
                                        : std::string(" (no interval)");
  return text;
}

HtmlCell verdict_cell(const ClaimOutcome& outcome, const std::string& second_line) {
  const Verdict verdict = outcome.verdict;
  const HtmlTone tone = verdict == Verdict::holds      ? HtmlTone::good
                        : verdict == Verdict::does_not ? HtmlTone::bad
                                                       : HtmlTone::open;
  return {.text = std::string(name_of(verdict)), .tone = tone, .second_line = second_line};
}

std::string summary_of(const HistoryCurve& curve) {
  const auto best = best_of(curve);
  if (best == curve.points.end()) return "no accuracy";
  return fmt::format("{:.1f} % at {:g} ms", 100 * best->accuracy.value, best->history_ms);
}

/// Of an id from a file what a figure's name may hold.
std::string name_part(std::string_view id) {
  std::string name;
  for (const char c : id) {
    const bool fits = (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9');
    if (fits)
      name += c;
    else if (!name.empty() && name.back() != '-')
      name += '-';
  }
  while (!name.empty() && name.back() == '-') name.pop_back();
  return name.substr(0, 40);
}

class Report {
 public:
  Report(const ReportInput& input, fs::path out, const FigureCallback& tell)
      : input_(input), out_(std::move(out)), tell_(tell), page_(title()), missing_(input.missing) {}

  ReportSummary write() {
    begin();
    claims();
    frames();
    histories();
    for (const ReportedEvaluation& evaluation : input_.evaluations) this->evaluation(evaluation);
    runs();
    unseen();
    trade();
    trainings();
    settings();
    return finish();
  }

 private:
  std::string title() const { return input_.title.empty() ? "Report of results" : input_.title; }
  std::string titled(const std::string& words) const { return input_.simulated ? words + " (simulated runs)" : words; }

  /// Draws a figure and puts it onto the page.
  void figure(const std::string& wanted_name, const Plot& plot, const std::string& in_words, const std::string& caption) {
    std::string name = wanted_name;
    for (int i = 2; std::find(drawn_.begin(), drawn_.end(), name) != drawn_.end(); ++i)
      name = fmt::format("{}-{}", wanted_name, i);
    if (tell_) tell_(name);
    const fs::path svg = out_ / "figures" / (name + ".svg");
    draw(plot, svg);
    draw(plot, out_ / "figures" / (name + ".png"));
    page_.figure({.id = "figure-" + name,
                  .svg = read_text(svg),
                  .width_px = plot.width_px,
                  .height_px = plot.height_px,
                  .in_words = in_words,
                  .caption = caption});
    drawn_.push_back(name);
  }

  void begin() {
    if (input_.simulated) {
      page_.warning(
          "The data is simulated. Every figure on this page was measured on runs that never happened; none of it says anything "
          "about a real "
          "sensor, and where it differs from the paper, the simulation may be the reason as well as the method.");
    }
    if (!input_.summary.empty()) page_.paragraph(input_.summary);
    page_.paragraph(
        "The yardstick is Faris et al., arXiv:2403.10120; its figures are called \"paper\" here. Intervals are 95 % bootstrap "
        "intervals over "
        "runs and objects; where fewer than three could be drawn there is none. Those from few are too narrow: of such intervals "
        "of "
        "a mean, meant to hold it in 95 % of cases, about 76 % do with 3 runs or objects, 82 % with 4, 86 % with 7 and 91 % with "
        "10. Those of false alarms per minute end no lower than what so many alarms in so much time may mean.");
    if (!input_.remarks.empty()) page_.list(input_.remarks);
  }

  void claims() {
    if (input_.claims.empty()) return;
    page_.section("claims", "The paper's claims");
    page_.paragraph(
        "A claim holds, or does not, only where the whole interval lies on one side of the limit; else one cannot tell, and the "
        "reason is told. A claim about every object takes three runs of each, and does not hold once one object lies beyond the "
        "limit with an interval that allows for looking at so many; one over objects takes five. Measured "
        "on the runs "
        "reported on, which no setting was chosen on; beside it the paper's own way, on all test runs.");
    HtmlTable table{.caption = "The paper's claims, one by one",
                    .head = {"claim", "verdict", "paper", "measured", "in the paper's way"},
                    .rows = {},
                    .stacks = true};
    const auto joined = [](std::initializer_list<std::string> parts) {
      std::string text;
      for (const std::string& part : parts) {
        if (!part.empty()) text += (text.empty() ? "" : text.ends_with('.') ? " " : ". ") + part;
      }
      return text;
    };
    for (const Claim& claim : input_.claims) {
      if (!std::isfinite(claim.measured.value)) missing_.push_back("The claim was not measured: " + claim.claim + ".");
      const std::string asked = std::isfinite(claim.limit)
                                    ? fmt::format("; asked: {} {:g} {}", name_of(claim.asked), claim.limit, claim.unit)
                                    : std::string();
      const std::string measured = with_unit(claim.measured, claim.unit) + asked;
      const bool has_words = !claim.in_words.empty();
      std::vector<HtmlCell> row{{.text = claim.claim},
                                verdict_cell(claim, claim.why),
                                {.text = claim.paper},
                                {.text = has_words ? claim.in_words : measured,
                                 .second_line = joined({has_words ? measured : std::string(), claim.note})}};
      if (claim.all_test) {
        row.push_back(
            verdict_cell(*claim.all_test, joined({claim.all_test->why, claim.all_test->in_words,
                                                  with_unit(claim.all_test->measured, claim.unit), claim.all_test->note})));
      } else {
        row.push_back({.text = "-"});
      }
      table.rows.push_back(std::move(row));
    }
    page_.table(table);
    claims_by_object();
    for (const ReportedTable& left_out : input_.left_out) page_.table(table_of(left_out));
  }

  /// Objects by the claims that are about each of them.
  void claims_by_object() {
    HtmlTable table{.caption =
                        "By object, on the runs reported on: ✓ where the claim is true of the object by its value; below a "
                        "value its 95 % interval, where there is one, and its runs",
                    .head = {"object"},
                    .rows = {}};
    std::vector<const Claim*> about_objects;
    std::set<std::string> names;
    for (const Claim& claim : input_.claims) {
      if (claim.objects.empty()) continue;
      about_objects.push_back(&claim);
      table.head.push_back(fmt::format("{}: {} {:g} {}", claim.id, name_of(claim.asked), claim.limit, claim.unit));
      for (const auto& [object, value] : claim.objects) names.insert(object);
    }
    for (const std::string& name : names) {
      table.rows.push_back({{.text = name}});
      for (const Claim* claim : about_objects) {
        const auto found = claim->objects.find(name);
        if (found == claim->objects.end()) {
          table.rows.back().push_back(number(""));
          continue;
        }
        const Figure& value = found->second;
        const bool is_kept = claim->asked == Asked::below ? value.value < claim->limit : value.value > claim->limit;
        HtmlCell cell = cell_of(value, 1);
        if (is_kept) cell.text = "✓ " + cell.text;
        const std::string runs = fmt::format("{} run{}", value.n, value.n == 1 ? "" : "s");
        cell.second_line = cell.second_line.empty() ? runs : cell.second_line + ", " + runs;
        table.rows.back().push_back(std::move(cell));
      }
    }
    page_.table(table);
  }

  void frames() {
    std::vector<RunFolder> runs;
    std::error_code ignored;
    if (!input_.data.empty() && fs::is_directory(input_.data, ignored)) runs = find_runs(input_.data);
    std::erase_if(runs, [](const RunFolder& one) { return !is_there(one.labels()); });
    // The paper's own example, else the first labelled run with a press and a slip.
    std::stable_partition(runs.begin(), runs.end(), [](const RunFolder& one) { return one.object == "water-bottle"; });
    const HeatmapOptions options{.history = microseconds{std::llround(1000 * input_.history_ms)}};
    std::vector<TouchFrame> frames;
    auto run = runs.begin();
    for (; run != runs.end(); ++run) {
      try {
        frames = frames_of(*run, options);
      } catch (const std::exception& e) {
        errors_.push_back(sentence_of(e, run->name()));
        missing_.push_back(fmt::format("Frames of {} cannot be drawn: {}.", run->name(), errors_.back()));
      }
      if (!frames.empty()) break;
    }
    if (frames.empty()) {
      missing_.push_back("Frames of a press and a slip need a folder of labelled runs; none was found.");
      return;
    }
    page_.section("frames", "What the sensor sees");
    figure("frames", frames_plot(titled(fmt::format("{}: {:g} ms of events", run->name(), input_.history_ms)), frames),
           "Six moments around a press and a slip: event counts above, noise-reduced heatmaps below.",
           fmt::format("Raw and noise-reduced frames of {}: before the press, in it, before the slip, in it. Above, the events "
                       "of the last {:g} ms "
                       "per pixel; below, the heatmap that the network is shown. Bright is much, by its square root.",
                       run->name(), input_.history_ms));
  }

  void histories() {
    if (input_.histories.empty()) return;
    page_.section("history", "Effect of longer histories");
    bool first = true;
    for (const ReportedHistories& histories : input_.histories) {
      if (histories.is_beside) page_.begin_folded("The same on " + histories.runs);
      figure(first ? "accuracy-by-history" : "accuracy-by-history-" + name_part(histories.runs),
             accuracy_by_history_plot(titled("Accuracy by history, " + histories.runs), histories.curves),
             fmt::format("Accuracy against history for each object; the mean is highest with {}.",
                         summary_of(histories.curves.front())),
             fmt::format("Accuracy by event history t_h, as in the paper's figure 6, on {}. Mean over objects: best with {}.",
                         histories.runs, summary_of(histories.curves.front())));
      std::set<double> columns;
      for (const HistoryCurve& curve : histories.curves) {
        for (const HistoryCurve::Point& point : curve.points) columns.insert(point.history_ms);
      }
      HtmlTable table{.caption = fmt::format("Accuracy [%] by history t_h, on {}; below each its 95 % interval", histories.runs),
                      .head = {"object"},
                      .rows = {}};
      for (const double history : columns) table.head.push_back(fmt::format("{:g} ms", history));
      table.head.emplace_back("best");
      for (const HistoryCurve& curve : histories.curves) {
        std::vector<HtmlCell> row{{.text = curve.name}};
        for (const double history : columns) {
          const auto point = std::find_if(curve.points.begin(), curve.points.end(),
                                          [history](const HistoryCurve::Point& p) { return p.history_ms == history; });
          row.push_back(point == curve.points.end() ? number("-") : percent_cell(point->accuracy));
        }
        const auto best = best_of(curve);
        row.push_back(number(best == curve.points.end() ? std::string("-") : fmt::format("{:g} ms", best->history_ms)));
        table.rows.push_back(std::move(row));
      }
      page_.table(table);
      if (histories.is_beside) page_.end_folded();
      first = false;
    }
    for (const ReportedTable& table : input_.choice) page_.table(table_of(table));
  }

  static std::vector<std::string> objects_of(const DelayTable& press, const DelayTable& slip) {
    std::set<std::string> names;
    for (const DelayTable* delays : {&press, &slip}) {
      for (const auto& object : delays->objects) names.insert(object.first);
    }
    return {names.begin(), names.end()};
  }

  static bool has_standard_errors(const ReportedEvaluation& evaluation) {
    const auto has_one = [](const auto& object) { return std::isfinite(object.second.sem_ms); };
    return std::any_of(evaluation.press.objects.begin(), evaluation.press.objects.end(), has_one) ||
           std::any_of(evaluation.slip.objects.begin(), evaluation.slip.objects.end(), has_one);
  }

  void delay_table(const std::string& caption, const std::vector<std::pair<std::string, const DelayTable*>>& classes,
                   const std::vector<ReportedFalseAlarms>& detectors = {}) {
    HtmlTable table{.caption = caption,
                    .head = {"object", "class", "mean [ms]", "standard error", "intervals", "missed", "early"},
                    .rows = {}};
    const auto add = [&](const std::string& object, const std::string& touch, const DelaySummary& delay) {
      table.rows.push_back({{.text = object},
                            {.text = touch},
                            plain_number(delay.mean_ms.value),
                            plain_number(delay.sem_ms),
                            number(fmt::format("{}", delay.intervals)),
                            number(fmt::format("{}", delay.misses)),
                            number(fmt::format("{}", delay.early))});
    };
    for (const auto& [touch, delays] : classes) {
      if (delays == nullptr || delays->all.intervals == 0) continue;
      add("all objects", touch, delays->all);
      for (const auto& [object, delay] : delays->objects) add(object, touch, delay);
    }
    for (const ReportedFalseAlarms& detector : detectors) {
      if (detector.of == "network") continue;
      if (detector.press.intervals > 0) add("all objects, by " + detector.of, "press", detector.press);
      if (detector.slip.intervals > 0) add("all objects, by " + detector.of, "slip", detector.slip);
    }
    page_.table(table);
  }

  void evaluation(const ReportedEvaluation& evaluation) {
    const std::string suffix =
        evaluation.id.empty() || evaluation.id == "reported" ? std::string() : "-" + name_part(evaluation.id);
    const std::string where = evaluation.runs.size() > 60 ? std::string("its test runs") : evaluation.runs;
    const std::string what =
        fmt::format("{} ({:g} ms){}", evaluation.model, evaluation.history_ms, where.empty() ? "" : ", " + where);
    page_.section("evaluation" + suffix, "Detection: " + what);
    if (evaluation.is_beside) page_.begin_folded("The same figures in the paper's own way");
    page_.paragraph(fmt::format("Model {}, history {:g} ms, a tick every {:g} ms, confirmed {}. Runs: {}.", evaluation.model,
                                evaluation.history_ms, evaluation.tick_ms,
                                evaluation.confirm.empty() ? "1/1" : evaluation.confirm,
                                evaluation.runs.empty() ? "those of its evaluation" : evaluation.runs));

    if (!evaluation.accuracies.empty()) {
      page_.heading("Accuracy");
      HtmlTable table{
          .caption =
              "Accuracy [%] on balanced samples; below each its 95 % interval. Guard: how far samples of none keep from every "
              "interval; the paper keeps 0 ms. Baselines are simpler methods on the same samples.",
          .head = {"object"},
          .rows = {}};
      for (const std::string& name : evaluation.accuracy_of) table.head.push_back(name);
      for (const ReportedAccuracy& row : evaluation.accuracies) {
        table.rows.push_back({{.text = row.object}});
        for (const Figure& value : row.values) table.rows.back().push_back(percent_cell(value));
      }
      page_.table(table);
    }

    page_.heading("Detection delay");
    const std::vector<std::string> objects = objects_of(evaluation.press, evaluation.slip);
    if (objects.empty()) {
      missing_.push_back("Detection delays (the paper's figure 7) of " + evaluation.model + ".");
    } else {
      figure(
          "delays" + suffix,
          delay_plot(titled("Detection delay, " + evaluation.model), objects, evaluation.press.objects, evaluation.slip.objects),
          fmt::format("Mean detection delay of each object: press {:.1f} ms and slip {:.1f} ms over all.",
                      evaluation.press.all.mean_ms.value, evaluation.slip.all.mean_ms.value),
          fmt::format("Detection delay of press and slip{}, as in the paper's figure 7. One tick, {:g} ms, "
                      "is the best "
                      "possible. Means leave out what was missed or said early, which is told beside the bars.",
                      has_standard_errors(evaluation)
                          ? " with standard errors, where an object has two intervals that were detected"
                          : "; no object has the two detected intervals that a standard error takes",
                      evaluation.tick_ms));
      delay_table("Detection delay against the labels, and that of trivial detectors, which know nothing, on the same intervals",
                  {{"press", &evaluation.press}, {"slip", &evaluation.slip}}, evaluation.false_alarms);
    }
    const auto pointer = [](const std::optional<DelayTable>& delays) { return delays ? &*delays : nullptr; };
    delay_table(
        "Detection delay against the truth of the simulation; gross: against the first motion between object and tip, negative "
        "where slip was "
        "told before it",
        {{"press", pointer(evaluation.true_press)},
         {"slip", pointer(evaluation.true_slip)},
         {"slip, gross", pointer(evaluation.gross_slip)}});

    if (!evaluation.false_alarms.empty()) {
      page_.heading("False alarms");
      HtmlTable table{.caption =
                          "False alarms over every tick of the runs, beside trivial detectors, which know nothing. Those that "
                          "begin within the guard after an interval, or in motion that nobody labels, are counted apart",
                      .head = {"detector", "per minute", "false alarms", "minutes of none", "after intervals",
                               "in unlabelled motion", "mean delay of press [ms]", "mean delay of slip [ms]"},
                      .rows = {}};
      const auto count = [](const std::optional<std::uint64_t>& alarms) {
        return number(alarms ? fmt::format("{}", *alarms) : std::string("-"));
      };
      const auto delay = [](const DelaySummary& bar) {
        HtmlCell cell = plain_number(bar.mean_ms.value);
        if (bar.misses == bar.intervals && bar.misses > 0)
          cell.second_line = fmt::format("all {} missed", bar.misses);
        else if (bar.early == bar.intervals && bar.early > 0)
          cell.second_line = fmt::format("all {} early", bar.early);
        else if (bar.misses + bar.early > 0)
          cell.second_line = fmt::format("{} missed, {} early", bar.misses, bar.early);
        return cell;
      };
      for (const ReportedFalseAlarms& row : evaluation.false_alarms) {
        table.rows.push_back({{.text = row.of},
                              cell_of(row.per_min, 1),
                              count(row.count),
                              plain_number(row.none_min, 3),
                              count(row.after_intervals),
                              count(row.unlabelled),
                              delay(row.press),
                              delay(row.slip)});
      }
      page_.table(table);
    }
    if (!evaluation.operating_curve.empty()) {
      figure("operating-curve" + suffix,
             operating_curve_plot(titled("Delay against false alarms, " + evaluation.model), evaluation.operating_curve,
                                  evaluation.own_point),
             "Mean detection delay, and the share of intervals missed or said early, against false alarms per minute.",
             "What waiting for more certainty costs: mean detection delay of press and slip, and the share of intervals missed "
             "or said early, "
             "against false "
             "alarms per minute, where press or slip is said from a probability on. Diamonds: the network's own verdicts, the "
             "likeliest class, without a threshold.");
    } else {
      missing_.push_back("Delay against false alarms of " + evaluation.model + ".");
    }
    if (evaluation.confusion) {
      page_.heading("Confusion");
      figure("confusion" + suffix, confusion_plot(titled("Confusion, " + evaluation.model), *evaluation.confusion),
             "Table of three true classes by three said classes.",
             "What was said of balanced samples of each class: the share of the class, and samples.");
      HtmlTable table{.caption = "Samples by their true class (rows) and what was said of them",
                      .head = {"true", "said none", "said press", "said slip"},
                      .rows = {}};
      for (std::size_t i = 0; i < touch_count; ++i) {
        table.rows.push_back({{.text = std::string(name_of(all_touches[i]))}});
        for (const std::uint64_t count : evaluation.confusion->counts[i])
          table.rows.back().push_back(number(fmt::format("{}", count)));
      }
      page_.table(table);
    } else {
      missing_.push_back("The confusion of " + evaluation.model + ".");
    }
    HtmlTable scores{
        .caption = "Scores of each class [%], on balanced samples", .head = {"class", "precision", "recall", "F1"}, .rows = {}};
    for (const auto& [touch, values] : evaluation.per_class)
      scores.rows.push_back({{.text = touch}, percent_cell(values[0]), percent_cell(values[1]), percent_cell(values[2])});
    page_.table(scores);

    const bool has_bins = std::any_of(evaluation.calibration.bins.begin(), evaluation.calibration.bins.end(),
                                      [](const ReliabilityBin& bin) { return bin.samples > 0; });
    if (has_bins) {
      page_.heading("Calibration");
      figure("reliability" + suffix, reliability_plot(titled("Reliability, " + evaluation.model), evaluation.calibration.bins),
             "Share said right against the largest probability, with the number of samples below.",
             fmt::format("Reliability: how often the network is right, by how sure it is; what stands on fewer than {} samples "
                         "is hollow. Expected calibration error: {:.2f} %.",
                         few_samples, 100 * evaluation.calibration.error.value));
    } else {
      missing_.push_back("The reliability of " + evaluation.model + ".");
    }
    const auto press_over_time = evaluation.over_time.find("press"), slip_over_time = evaluation.over_time.find("slip");
    if (press_over_time != evaluation.over_time.end() && slip_over_time != evaluation.over_time.end()) {
      page_.heading("Within intervals");
      figure("over-time" + suffix,
             over_time_plot(titled("Right verdicts within intervals, " + evaluation.model), press_over_time->second,
                            slip_over_time->second),
             "Share of ticks said right since the onset and before the end of presses and slips.",
             "Verdicts over the whole of each interval, however long: since its onset, and before its end, where the paper sees "
             "them get worse. "
             "Training knows the first 500 ms alone.");
    }
    HtmlTable over_time{.caption =
                            "Share of ticks said right [%]: in the first 500 ms of intervals, later, in their last 200 ms, ahead "
                            "of those in intervals that are longer, and the end of these less that. Last: the ticks behind an "
                            "interval that still say press or slip; part of them is the history itself",
                        .head = {"class", "first", "later", "last", "ahead of the last", "last less that", "still said after"},
                        .rows = {}};
    for (const char* touch : {"press", "slip", "both"}) {
      const auto found = evaluation.over_time.find(touch);
      if (found == evaluation.over_time.end()) continue;
      const ShareOverTime& share = found->second.all;
      over_time.rows.push_back({{.text = touch},
                                percent_cell(share.first),
                                percent_cell(share.later),
                                percent_cell(share.last),
                                percent_cell(share.before_last),
                                percent_cell(share.last_minus_before),
                                percent_cell(share.still_said)});
    }
    page_.table(over_time);
    if (evaluation.is_beside) page_.end_folded();
  }

  void runs() {
    if (input_.runs.empty()) return;
    page_.section("runs", "Whole runs over time");
    for (std::size_t i = 0; i < std::min(input_.runs.size(), most_runs_over_time); ++i) {
      const ReportedRun& run = input_.runs[i];
      PredictionPicture picture = read_prediction(run.csv, run.history_ms);
      picture.title = titled(fmt::format("{} as {} sees it", run.run, run.model));
      picture.remarks.push_back(fmt::format("History t_h {:g} ms.", run.history_ms));
      std::error_code ignored;
      const bool has_outcome = !run.outcome.empty() && fs::is_regular_file(run.outcome, ignored);
      if (has_outcome)
        add_outcome(picture, run.outcome);
      else
        missing_.push_back(fmt::format("How the intervals of {} were met: {} is not there.", run.run, run.outcome.string()));
      figure("run-" + name_part(run.run), prediction_plot(picture),
             fmt::format("What {} says over the whole of {}.", run.model, run.run),
             fmt::format("A whole run, as in the paper's figure 8: {} by {}. Event rate, probabilities of press and slip, and "
                         "what was said beside "
                         "what was labelled{}.",
                         run.run, run.model, picture.has_truth ? " and what truly happened" : ""));
    }
    if (input_.runs.size() > most_runs_over_time)
      page_.paragraph(fmt::format("{} more runs over time lie in the study's folder.", input_.runs.size() - most_runs_over_time));
  }

  void unseen() {
    if (input_.unseen.empty()) return;
    page_.section("unseen", "Unseen objects");
    bool first = true;
    for (const UnseenSection& unseen : input_.unseen) {
      const UnseenComparison& comparison = unseen.comparison;
      const UnseenComparison::Models models = comparison.models.value_or(UnseenComparison::Models{});
      if (unseen.is_beside) page_.begin_folded("The same on " + unseen.runs);
      const std::string where = unseen.runs.size() > 60 ? std::string("runs that neither model learned from") : unseen.runs;
      figure(first ? "unseen" : "unseen-" + name_part(where),
             unseen_plot(titled("Seen and unseen objects, " + where), comparison.objects),
             fmt::format("Accuracy on {} objects with them in training and without: {:.1f} % and {:.1f} % on average.",
                         comparison.objects.size(), 100 * comparison.mean.seen.value, 100 * comparison.mean.held_out.value),
             fmt::format("Accuracy on each object with it in training ({}) and without ({}), as in the paper's figure 9, on {}, "
                         "which neither model "
                         "learned from.",
                         models.seen, models.held_out, where));
      HtmlTable table{
          .caption =
              "Accuracy [%] on held-out objects, and what not having seen them changes [points]; below each its 95 % interval",
          .head = {"object", "seen", "held out", "difference"},
          .rows = {}};
      const auto add_row = [&](const std::string& name, const SeenAndHeldOut& of) {
        table.rows.push_back({{.text = name}, percent_cell(of.seen), percent_cell(of.held_out), percent_cell(of.difference)});
      };
      add_row("mean over objects", comparison.mean);
      for (const auto& [object, of_object] : comparison.objects) add_row(object, of_object);
      page_.table(table);
      if (unseen.is_beside) page_.end_folded();
      first = false;
    }
    for (const ReportedTable& table : input_.splits) page_.table(table_of(table));
  }

  void trade() {
    if (!input_.trade) return;
    const ReportedTrade& trade = *input_.trade;
    page_.section("trade", "Speed against accuracy");
    if (trade.simulated && !input_.simulated)
      page_.warning("This part was measured on simulated runs, and says nothing about a real sensor.");
    if (!trade.sentence.empty()) page_.paragraph(trade.sentence);
    page_.paragraph(fmt::format("{} Measured on {}. Settings were chosen on {} runs and are reported on {} others.",
                                trade.times_are, trade.machine, trade.choice_runs.size(), trade.reported_runs.size()));
    const auto on = [&](bool ReportedSetting::*front) {
      return std::count_if(trade.settings.begin(), trade.settings.end(),
                           [front](const ReportedSetting& setting) { return setting.*front; });
    };
    figure("trade-accuracy", trade_accuracy_plot(trade),
           fmt::format("Accuracy against time per tick of {} settings, {} of them on the front.", trade.settings.size(),
                       on(&ReportedSetting::on_accuracy_front)),
           "Accuracy against the time that 99 of 100 ticks do not exceed. The front was found on the runs to choose on; where it "
           "is no "
           "front here, chance is the reason.");
    figure("trade-delay", trade_delay_plot(trade),
           fmt::format("Mean detection delay against false alarms of {} settings, {} of them on the front.",
                       trade.settings.size(), on(&ReportedSetting::on_delay_front)),
           "Mean delay of presses and slips, computing included, against false alarms per minute; what is missed stands beside.");
    HtmlTable table{.caption =
                        "Each setting by what is other than usual; below each figure its 95 % interval. Differences are to the "
                        "usual setting, paired over runs",
                    .head = {"setting", "seeds", "accuracy [%]", "to usual [points]", "delay [ms]", "to usual [ms]", "p95 [ms]",
                             "missed [%]", "false alarms/min", "to usual", "p50 [us]", "p99 [us]", "front"},
                    .rows = {}};
    std::size_t left_out = 0;
    for (const ReportedSetting& setting : trade.settings) {
      const bool on_front = setting.on_accuracy_front || setting.on_delay_front;
      if (table.rows.size() >= most_settings && !on_front) {
        ++left_out;
        continue;
      }
      const std::string fronts = std::string(setting.on_accuracy_front ? "accuracy" : "") +
                                 (setting.on_accuracy_front && setting.on_delay_front ? ", " : "") +
                                 (setting.on_delay_front ? "delay" : "");
      table.rows.push_back({{.text = setting.text},
                            plain_number(static_cast<double>(setting.seeds), 0),
                            percent_cell(setting.accuracy),
                            percent_cell(setting.accuracy_difference),
                            cell_of(setting.delay_us, 1e-3),
                            cell_of(setting.delay_difference_us, 1e-3),
                            cell_of(setting.delay_p95_us, 1e-3),
                            percent_cell(setting.missed),
                            cell_of(setting.false_alarms_per_min, 1),
                            cell_of(setting.false_alarms_difference, 1),
                            cell_of(setting.us_p50, 1),
                            cell_of(setting.us_p99, 1),
                            {.text = fronts}});
    }
    page_.table(table);
    if (left_out > 0) page_.paragraph(fmt::format("{} more settings, on no front, are told in trade.csv.", left_out));
    for (const std::string& sentence : trade.left_out) missing_.push_back("Speed against accuracy: " + sentence);
    if (trade.growth.by_rate.empty()) return;
    page_.heading("How the cost grows");
    figure("trade-growth", trade_growth_plot(trade),
           fmt::format(
               "Time per tick against event rate, history and resolution: at {:g} events per second {:.0f} us, and {:.0f} us the "
               "dense way.",
               trade.growth.by_rate.back().events_per_s, trade.growth.by_rate.back().sparse.p50_us,
               trade.growth.by_rate.back().dense.p50_us),
           "Time per tick against the event rate, the history and the sensor's resolution, beside the dense way, which computes "
           "every "
           "pixel and every output of the network.");
  }

  void trainings() {
    if (input_.trainings.empty()) return;
    page_.section("training", "Training");
    figure("training", training_plot(titled("Training"), input_.trainings), "Loss and accuracy of each training, epoch by epoch.",
           "Loss and accuracy on the training samples, epoch by epoch.");
    HtmlTable table{
        .caption = "The last epoch of each training", .head = {"model", "epoch", "loss", "accuracy in training [%]"}, .rows = {}};
    for (const TrainingCurve& curve : input_.trainings) {
      if (curve.epochs.empty()) continue;
      const TrainingCurve::Epoch& last = curve.epochs.back();
      table.rows.push_back(
          {{.text = curve.name}, plain_number(last.epoch, 0), plain_number(last.loss, 4), plain_number(100 * last.accuracy)});
    }
    page_.table(table);
  }

  void settings() {
    page_.section("missing", "What was not measured");
    if (missing_.empty())
      page_.paragraph("Everything that this report has a place for was measured.");
    else
      page_.list(missing_);
    page_.section("settings", "Settings, seeds, software, machine and times");
    for (const ReportedTable& table : input_.settings) page_.table(table_of(table));
    page_.paragraph(
        fmt::format("This page was written by tactile {} ({}). Its figures lie beside it as SVG and PNG, in figures/.", version(),
                    revision()));
  }

  ReportSummary finish() {
    ReportSummary summary{.title = title(),
                          .simulated = input_.simulated,
                          .page = out_ / "report.html",
                          .figures = drawn_,
                          .missing = missing_,
                          .errors = errors_,
                          .claims = input_.claims.size()};
    for (const Claim& claim : input_.claims) {
      summary.hold += claim.verdict == Verdict::holds ? 1U : 0U;
      summary.do_not += claim.verdict == Verdict::does_not ? 1U : 0U;
    }
    write_whole(summary.page, page_.text());
    remove_old_figures();
    return summary;
  }

  /// Those that an earlier report drew, and this one did not; what else lies there stays.
  void remove_old_figures() const {
    static constexpr std::array<std::string_view, 12> ours{"frames",    "accuracy-by-history",
                                                           "delays",    "operating-curve",
                                                           "confusion", "reliability",
                                                           "over-time", "run-",
                                                           "unseen",    "training",
                                                           "figure-",   "trade-"};
    std::error_code ignored;
    std::vector<fs::path> old;
    for (const auto& entry : fs::directory_iterator(out_ / "figures", ignored)) {
      const fs::path& file = entry.path();
      const std::string stem = file.stem().string();
      const bool is_picture = file.extension() == ".svg" || file.extension() == ".png";
      const bool is_ours = std::any_of(ours.begin(), ours.end(), [&](std::string_view name) { return stem.starts_with(name); });
      if (is_picture && is_ours && std::find(drawn_.begin(), drawn_.end(), stem) == drawn_.end()) old.push_back(file);
    }
    for (const fs::path& file : old) fs::remove(file, ignored);
  }

  const ReportInput& input_;
  fs::path out_;
  const FigureCallback& tell_;
  HtmlPage page_;
  std::vector<std::string> missing_, errors_;
  std::vector<std::string> drawn_;
};

}  // namespace

ReportSummary write_report(const ReportInput& input, const fs::path& out, const FigureCallback& tell) {
  return Report(input, out, tell).write();
}

ReportSummary write_report(const fs::path& study, const fs::path& out, const FigureCallback& tell) {
  return write_report(read_study(study), out, tell);
}

}  // namespace tactile
