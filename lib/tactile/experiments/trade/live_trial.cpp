#include "tactile/experiments/trade/live_trial.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/wait.h>

#include <csignal>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/process.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/events/file_descriptor.hpp"
#include "tactile/model/inference/decision.hpp"

namespace tactile::trade {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds to_start{30};  // of a process: it loads libtorch
constexpr std::chrono::milliseconds between_looks{50};

/// A command whose output and log go to files.
class LoggedProcess {
 public:
  LoggedProcess(const fs::path& program, const fs::path& folder, const std::string& name, std::vector<std::string> arguments)
      : name_(name),
        out_(folder / (name + ".json")),
        log_(folder / (name + ".log")),
        process_(started(program, std::move(arguments), opened(out_), opened(log_))) {}

  /// Its exit status once it has ended.
  std::optional<int> status() { return process_.status_if_ended(); }
  void stop() const { process_.send(SIGINT); }

  std::string log() const { return read_text(log_); }
  const fs::path& out() const { return out_; }

  Error failure(const std::string& why) const {
    std::string last;
    std::ifstream lines(log_);
    for (std::string line; std::getline(lines, line);) {
      if (!line.empty()) last = line;
    }
    return Error(fmt::format(
        "the trial of the recommended setting: 'tactile {}' {}; expected it to end without an error. Its last line: {}", name_,
        why, last.empty() ? "none" : last));
  }

 private:
  static events::FileDescriptor opened(const fs::path& file) {
    events::FileDescriptor descriptor(::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644));
    if (!descriptor.is_open()) throw Error(file.string() + ": cannot be written; expected a writable place with room");
    return descriptor;
  }
  static ChildProcess started(const fs::path& program, std::vector<std::string> arguments, const events::FileDescriptor& out,
                              const events::FileDescriptor& log) {
    return ChildProcess(
        {.program = program.string(), .arguments = std::move(arguments), .out = out.number(), .err = log.number()});
  }

  std::string name_;
  fs::path out_, log_;
  ChildProcess process_;
};

/// Looks until `found` gives something, at most for this long.
template <class Found>
auto waited_for(Clock::duration at_most, const ProgressCallback& progress, const std::string& what, Found found) {
  const Clock::time_point begun = Clock::now();
  auto result = found();
  while (!result && Clock::now() - begun < at_most) {
    report_progress(progress, 0, 0, what);
    std::this_thread::sleep_for(between_looks);
    result = found();
  }
  return result;
}

/// "127.0.0.1:40213" of the line "serving events of … on …", once it is complete.
std::optional<std::string> address_in(const std::string& log) {
  const std::size_t line = log.find("serving events of ");
  const std::size_t end = line == std::string::npos ? line : log.find('\n', line);
  if (end == std::string::npos) return std::nullopt;
  const std::string text = log.substr(line, end - line);
  return text.substr(text.rfind(" on ") + 4);
}

/// As words of a command line; a switch that is off is left out.
std::vector<std::string> words_of(const nlohmann::json& options) {
  std::vector<std::string> words;
  for (const auto& [name, value] : options.items()) {
    if (value.is_boolean()) {
      if (value.get<bool>()) words.push_back("--" + name);
    } else {
      words.insert(words.end(), {"--" + name, value.is_string() ? value.get<std::string>() : value.dump()});
    }
  }
  return words;
}

}  // namespace

nlohmann::json detect_options(const TradeSetting& setting, const fs::path& model) {
  nlohmann::json options{{"model", model.string()},
                         {"tick-us", setting.rendering.tick.count()},
                         {"engine", name_of(setting.engine)},
                         {"precision", name_of(setting.precision)}};
  const model::Decision decision = model::usual_decision(setting.kind, {});
  if (decision.thresholds) {
    options["thresholds"] = text_of(*decision.thresholds);
  } else {
    options["confirm"] = text_of(decision.confirmation);
  }
  return options;
}

nlohmann::json run_live_trial(const TradeSetting& setting, const LiveTrialOptions& options, const ProgressCallback& progress) {
  fs::create_directories(options.folder);
  LoggedProcess serve(options.program, options.folder, "serve",
                      {"serve", options.run.string(), "--host", "127.0.0.1", "--port", "0", "--loop", "--json"});
  const auto address = waited_for(to_start, progress, "starting the stream", [&]() -> std::optional<std::string> {
    if (serve.status()) throw serve.failure("ended at once");
    return address_in(serve.log());
  });
  if (!address) throw serve.failure("served nothing");
  std::vector<std::string> arguments{"detect",     "--from",
                                     *address,     "--json",
                                     "--duration", fmt::format("{:g}", std::chrono::duration<double>(options.length).count())};
  const std::vector<std::string> words = words_of(detect_options(setting, options.model));
  arguments.insert(arguments.end(), words.begin(), words.end());
  LoggedProcess detect(options.program, options.folder, "detect", arguments);
  const auto status =
      waited_for(options.length + to_start, progress, "the recommended setting in detect", [&] { return detect.status(); });
  if (!status) throw detect.failure("does not end");
  if (!WIFEXITED(*status) || WEXITSTATUS(*status) != 0) throw detect.failure("failed");
  serve.stop();
  waited_for(std::chrono::seconds(5), progress, "ending the stream", [&] { return serve.status(); });
  return read_json(detect.out());
}

LiveTrial live_trial_in(const nlohmann::json& detected) {
  try {
    const nlohmann::json &work = detected.at("latency_us").at("work"), &ticks = detected.at("ticks");
    return {.ticks = ticks.at(ticks.contains("told") ? "told" : "reported").get<std::uint64_t>(),
            .us_p50 = work.at("p50").get<double>(),
            .us_p99 = work.at("p99").get<double>(),
            .us_p999 = work.at("p999").get<double>(),
            .missed_share = ticks.at("missed_share").get<double>()};
  } catch (const nlohmann::json::exception&) {
    throw Error("the trial of the recommended setting: 'tactile detect' reported no times; expected ticks within the trial");
  }
}

}  // namespace tactile::trade
