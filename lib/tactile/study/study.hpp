#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>

#include "tactile/study/step_runner.hpp"
#include "tactile/study/study_options.hpp"

namespace tactile {

/// What came of a study.
struct StudySummary {
  nlohmann::json study;  ///< as study.json has it; docs/format.md lists its keys
  std::filesystem::path file;
  std::size_t done = 0;  ///< steps done now
  std::size_t kept = 0;  ///< steps found done

  /// A sentence for each object or run that could not be read or labelled; the study is one of the others.
  std::vector<std::string> errors;
};

/// The paper's study: runs simulated where there are none, labelled, cut into samples and rendered; a network trained for each
/// history; one history chosen, and judged over full runs; the same with objects held out. Whatever is done and unchanged is
/// kept; ended at any moment it goes on where it was, to the same results.
///
/// @param new_progress  asked at the begin of each step for what is told of it
/// @param tell  told of each step as it begins, or is found done
/// @param warn  told, before it is done, in a sentence what somebody may not expect: that the dataset which lies in `data` was
///              made with other settings, and is made anew
/// @throws Error  if an option is out of its range, another study is at work in the same folder, or a step fails: it names the
///                step's command and what went wrong
StudySummary run_study(const StudyOptions& options, const NewProgress& new_progress = {},
                       const std::function<void(const std::string& step, bool kept)>& tell = {},
                       const std::function<void(const std::string& sentence)>& warn = {});

}  // namespace tactile
