#include "model_arguments.hpp"

#include <fmt/core.h>
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <cmath>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include "option_checks.hpp"
#include "quantity_text.hpp"
#include "tactile/core/error.hpp"
#include "tactile/evaluation/confirmation.hpp"
#include "tactile/windows/write_dataset.hpp"

namespace tactile {

std::filesystem::path dataset_file(const std::string& data) {
  return std::filesystem::is_regular_file(data) ? std::filesystem::path(data) : std::filesystem::path(data) / "dataset.h5";
}

CLI::Validator is_confirmation() {
  return CLI::Validator(
      [](std::string& text) -> std::string {
        try {
          confirmation_in(text);
          return "";
        } catch (const Error& e) {
          return e.what();
        }
      },
      "k/n");
}

bool make_missing_dataset(const std::string& data, const CommonArguments& common) {
  const std::filesystem::path file = dataset_file(data);
  if (std::filesystem::exists(file)) return false;
  spdlog::info("{} is missing: it is made by the defaults of 'tactile windows'", file.string());
  const DatasetSummary summary = write_dataset(data, file, {}, common.threads, progress_line(common));
  for (const std::string& warning : summary.warnings) spdlog::warn("{}", warning);
  for (const std::string& error : summary.errors) spdlog::error("{}", error);
  spdlog::info("{}: {} samples", file.string(), summary.samples);
  return true;
}

std::vector<std::string> objects_to_hold_out(const std::vector<std::string>& named, const Dataset& dataset) {
  if (!named.empty()) return named;
  std::set<std::string> objects;
  for (const DatasetRun& run : dataset.runs()) objects.insert(run.object);
  std::vector<std::string> held_out;
  for (const std::string& object : default_held_out()) {
    if (objects.contains(object)) held_out.push_back(object);
  }
  if (held_out.empty() || held_out.size() == objects.size()) {
    throw Error(fmt::format("{}: {} of its objects is among the paper's five to hold out; expected --held-out with some of {}",
                            dataset.file().string(), held_out.empty() ? "none" : "every one", fmt::join(objects, ", ")));
  }
  return held_out;
}

std::string training_size(const Dataset& dataset, const ModelSettings& settings) {
  const std::size_t samples = samples_of_runs(dataset, split_of(dataset, settings.split).train_runs).size();
  return fmt::format("{}, {}", counted(samples, "sample"), counted(settings.training.epochs, "epoch"));
}

ProgressCallback with_estimates(ProgressCallback progress, unsigned epochs) {
  using Clock = std::chrono::steady_clock;
  using Seconds = std::chrono::duration<double>;
  struct Mark {
    Clock::time_point at;
    std::uint64_t done = 0;
  };
  struct State {
    std::optional<Mark> epoch_begun;  // that of the first call is amid an epoch, where it is one that was broken off
    std::optional<Clock::time_point> promised;
  };
  return [progress = std::move(progress), epochs, state = std::make_shared<State>()](const Progress& now) {
    const Mark mark{Clock::now(), now.done};
    const std::uint64_t epoch_size = now.total / epochs;
    if (!state->epoch_begun) state->epoch_begun = mark;
    if (epoch_size > 0 && now.done % epoch_size == 0 && now.done > state->epoch_begun->done) {
      const Seconds lasted = mark.at - state->epoch_begun->at;
      const Seconds left =
          lasted * (static_cast<double>(now.total - now.done) / static_cast<double>(now.done - state->epoch_begun->done));
      const auto wrong_by = [&] { return std::abs(Seconds(mark.at + left - *state->promised).count()); };
      if (now.done < now.total && (!state->promised || wrong_by() > left.count() / 4)) {
        spdlog::info("epoch {} of {}: about {} more (min:s)", now.done / epoch_size, epochs, clock_text(left.count()));
        state->promised = mark.at + std::chrono::duration_cast<Clock::duration>(left);
      }
      state->epoch_begun = mark;
    }
    if (progress) progress(now);
  };
}

void add_engine_option(CLI::App& command, std::string& engine) {
  command
      .add_option("--engine", engine,
                  "What runs the network: fast, tactile's own, or libtorch, which knows every activation and pooling")
      ->check(one_of({"fast", "libtorch"}))
      ->capture_default_str();
}

}  // namespace tactile
