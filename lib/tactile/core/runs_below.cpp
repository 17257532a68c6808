#include "tactile/core/runs_below.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <system_error>
#include <tuple>
#include <utility>

#include "tactile/core/error.hpp"
#include "tactile/core/text.hpp"

namespace tactile {
namespace fs = std::filesystem;
namespace {

constexpr int most_runs = 99;

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// `02.discarded-1`, as `record` renames a run that is redone.
bool is_discarded(std::string_view name) {
  constexpr std::string_view middle = ".discarded-";
  if (name.size() <= 2 + middle.size() || !is_run_id(name.substr(0, 2)) || name.substr(2, middle.size()) != middle) return false;
  const std::string_view count = name.substr(2 + middle.size());
  return std::all_of(count.begin(), count.end(), is_digit);
}

std::string name_of(const fs::path& folder) { return folder.filename().string(); }

std::string id_of(int number) { return (number < 10 ? "0" : "") + std::to_string(number); }

/// The number from 1 to 99 in `name`; 0 if there is none, or several.
int only_number_in(std::string_view name) {
  int number = 0, count = 0;
  for (std::size_t i = 0; i < name.size(); ++i) {
    if (!is_digit(name[i])) continue;
    if (i == 0 || !is_digit(name[i - 1])) {
      ++count;
      number = 0;
    }
    number = std::min(10 * number + (name[i] - '0'), most_runs + 1);
  }
  return count == 1 && number <= most_runs ? number : 0;
}

/// The first id that is not in `taken`, with `wanted` first; empty if all are.
std::string free_id(const std::set<std::string>& taken, int wanted) {
  if (wanted > 0 && !taken.contains(id_of(wanted))) return id_of(wanted);
  for (int number = 1; number <= most_runs; ++number) {
    if (!taken.contains(id_of(number))) return id_of(number);
  }
  return {};
}

std::string not_readable(const fs::path& path, const std::error_code& why) {
  return path.string() + ": cannot be read (" + why.message() + "); expected a folder of runs, a run or its recording";
}

/// What is there by a name: `folder` stands for a file where a recording is asked for.
enum class Found { nothing, it, unreadable };

/// @param why  set if it is unreadable
Found look_at(const fs::path& path, fs::file_type type, std::error_code& why) {
  const fs::file_status status = fs::status(path, why);
  if (status.type() == type) return Found::it;
  if (status.type() == fs::file_type::none) return Found::unreadable;
  std::error_code ignored;
  const bool leads_nowhere = status.type() == fs::file_type::not_found && fs::is_symlink(fs::symlink_status(path, ignored));
  return leads_nowhere ? Found::unreadable : Found::nothing;
}

/// The names of the AEDAT4 files in a folder.
std::vector<std::string> recordings_in(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code failed;
  for (fs::directory_iterator entry(folder, failed), end; !failed && entry != end; entry.increment(failed)) {
    const bool is_named_so = lower_case(entry->path().extension().string()) == ".aedat4";
    if (is_named_so && is_file(entry->path())) names.push_back(name_of(entry->path()));
  }
  std::sort(names.begin(), names.end());
  return names;
}

/// ": its run is"
std::string its_runs_are(std::size_t count) {
  return count == 1 ? ": its run is" : ": its " + std::to_string(count) + " runs are";
}

/// The number of folders in `folder` that hold a recording.
std::size_t recordings_below(const fs::path& folder) {
  std::size_t count = 0;
  std::error_code failed;
  for (fs::directory_iterator entry(folder, failed), end; !failed && entry != end; entry.increment(failed))
    count += !name_of(entry->path()).starts_with('.') && is_file(entry->path() / "events.aedat4") ? 1 : 0;
  return count;
}

/// The names in a folder, and its subfolders.
struct Listing {
  std::set<std::string> names;
  std::vector<fs::path> folders;  ///< by name, without hidden ones and discarded runs
};

class Search {
 public:
  explicit Search(const fs::path& data) {
    const Listing objects = listing_of(data, is_object_name);
    taken_ = objects.names;
    for (const fs::path& object : objects.folders) look_into(object, taken_);
    // Without any object, `data` is the folder of an object, and these are its runs.
    for (const fs::path& folder : in_place_of_objects_) {
      if (!found_.runs.empty()) report_recording_in_place_of_object(folder, taken_);
    }
    for (const fs::path& folder : empty_in_place_of_objects_) {
      if (found_.runs.empty()) report_no_recording(folder, true);
    }
    std::sort(found_.without_recording.begin(), found_.without_recording.end());
    std::sort(found_.runs.begin(), found_.runs.end(),
              [](const RunFolder& a, const RunFolder& b) { return std::tie(a.object, a.run) < std::tie(b.object, b.run); });
  }

  RunsBelow found() && { return std::move(found_); }

 private:
  /// An unreadable entry counts as an object or a run if it has the name of one.
  Listing listing_of(const fs::path& folder, bool (*is_named_well)(std::string_view)) {
    Listing listing;
    std::error_code failed;
    for (fs::directory_iterator entry(folder, failed), end; !failed && entry != end; entry.increment(failed)) {
      const std::string name = name_of(entry->path());
      listing.names.insert(name);
      if (name.starts_with('.') || is_discarded(name)) continue;
      std::error_code why;
      const Found what = look_at(entry->path(), fs::file_type::directory, why);
      if (what == Found::it) listing.folders.push_back(entry->path());
      if (what == Found::unreadable && is_named_well(name)) found_.unreadable.push_back(not_readable(entry->path(), why));
    }
    if (failed) found_.unreadable.push_back(not_readable(folder, failed));
    std::sort(listing.folders.begin(), listing.folders.end());
    return listing;
  }

  bool holds_recording(const fs::path& folder) {
    std::error_code why;
    const fs::path file = folder / "events.aedat4";
    const Found what = look_at(file, fs::file_type::regular, why);
    if (what == Found::unreadable) found_.unreadable.push_back(not_readable(file, why));
    return what == Found::it;
  }

  void look_into(const fs::path& object, std::set<std::string>& names_beside) {
    const std::string name = name_of(object);
    const bool is_named_well = is_object_name(name);
    if (holds_recording(object)) {
      is_run_id(name) ? in_place_of_objects_.push_back(object) : report_recording_in_place_of_object(object, names_beside);
      return;
    }
    Listing runs = listing_of(object, is_run_id);
    std::size_t recordings = 0;
    for (const fs::path& run : runs.folders) {
      if (!holds_recording(run)) {
        if (const std::size_t deeper = recordings_below(run); deeper > 0) {
          report_too_deep(run, deeper);
        } else if (is_run_id(name_of(run))) {
          report_no_recording(run, is_named_well);
        }
        continue;
      }
      ++recordings;
      const std::string id = name_of(run);
      if (!is_run_id(id)) {
        report_run(run, runs.names);
      } else if (is_named_well) {
        found_.runs.push_back({run, name, id});
      }
    }
    if (recordings > 0 && !is_named_well) report_object(object, recordings, names_beside);
    if (is_run_id(name) && runs.folders.empty()) empty_in_place_of_objects_.push_back(object);
  }

  void report_recording_in_place_of_object(const fs::path& folder, std::set<std::string>& names_beside) {
    const std::string object = needed_object_name(name_of(folder));
    const bool is_number = object.find_first_not_of("0123456789") == std::string::npos;
    if (found_.runs.empty() && is_number) return report_run(folder, names_beside);
    found_.misnamed.push_back(folder.string() +
                              ": is left out, because it has a recording where an object's runs belong; move it to " +
                              (folder.parent_path() / (is_number ? "<object>" : object) / "01").string());
  }

  /// Of a folder in the place of a run that is the folder of an object.
  void report_too_deep(const fs::path& object, std::size_t recordings) {
    const fs::path above = object.parent_path();
    found_.misnamed.push_back(object.string() + its_runs_are(recordings) + " left out, one folder too deep; move it to " +
                              (above.parent_path() / object.filename()).string() + ", or name " + above.string() +
                              " as the folder of runs");
  }

  /// Of a folder that would be a run if it had a recording of the right name.
  void report_no_recording(const fs::path& run, bool object_is_named_well) {
    const std::vector<std::string> recordings = recordings_in(run);
    if (recordings.empty()) {
      std::error_code ignored;
      const bool is_unreadable = fs::exists(fs::symlink_status(run / "events.aedat4", ignored));  // and listed as that
      if (object_is_named_well && !is_unreadable) found_.without_recording.push_back(run);
      return;
    }
    found_.misnamed.push_back(run.string() + ": is left out, because a run's recording is named events.aedat4; rename " +
                              (recordings.size() == 1 ? "" : "the right one of ") +
                              fmt::format("{} to it", fmt::join(recordings, ", ")));
  }

  void report_run(const fs::path& run, std::set<std::string>& taken) {
    const int wanted = only_number_in(name_of(run));
    const std::string needed = free_id(taken, wanted);
    const std::string begin = run.string() + ": is left out, because a run's name is two digits from 01 on; ";
    if (needed.empty()) {
      found_.misnamed.push_back(begin + "rename it, once one of 01 to 99 is free");
      return;
    }
    const bool is_second = wanted > 0 && needed != id_of(wanted);
    found_.misnamed.push_back(begin + "rename it to " + needed +
                              (is_second ? ", which is free; " + id_of(wanted) + " is taken" : std::string()));
    taken.insert(needed);
  }

  void report_object(const fs::path& object, std::size_t recordings, std::set<std::string>& taken) {
    const std::string needed = needed_object_name(name_of(object));
    std::string text = object.string() + its_runs_are(recordings) +
                       " left out, because an object's name is lower-case letters, digits and inner hyphens; ";
    if (needed.empty()) {
      text += "rename it, such as to usb-hub";
    } else if (taken.contains(needed)) {
      text += needed + " is taken: move " + (recordings == 1 ? "the run" : "the runs") +
              " there under free numbers, or rename it otherwise";
    } else {
      text += "rename it to " + needed;
      taken.insert(needed);
    }
    found_.misnamed.push_back(std::move(text));
  }

  RunsBelow found_;
  std::set<std::string> taken_;                      ///< names in the data folder, and proposed ones
  std::vector<fs::path> in_place_of_objects_;        ///< folders with a recording and the name of a run
  std::vector<fs::path> empty_in_place_of_objects_;  ///< those without a recording and without folders
};

std::set<std::string> names_in(const fs::path& folder) {
  std::set<std::string> names;
  std::error_code failed;
  for (fs::directory_iterator entry(folder, failed), end; !failed && entry != end; entry.increment(failed))
    names.insert(name_of(entry->path()));
  return names;
}

}  // namespace

std::string needed_object_name(std::string_view name) {
  std::string needed;
  for (const char c : name) {
    const char lower = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    if ((lower >= 'a' && lower <= 'z') || is_digit(lower)) {
      needed += lower;
    } else if (!needed.empty() && needed.back() != '-') {
      needed += '-';
    }
  }
  if (needed.ends_with('-')) needed.pop_back();
  return needed;
}

std::string why_not_an_object_name(std::string_view name) {
  if (is_object_name(name)) return {};
  const std::string needed = needed_object_name(name);
  return fmt::format("'{}' is not a name for an object; expected lower-case letters, digits and inner hyphens, such as {}", name,
                     needed.empty() ? "usb-hub" : needed);
}

RunsBelow look_for_runs(const fs::path& data) {
  std::error_code why;
  if (fs::status(data, why).type() != fs::file_type::directory) {
    const bool is_unknown = why && why != std::errc::no_such_file_or_directory;
    throw Error(data.string() + (is_unknown ? ": cannot be read (" + why.message() + ")" : std::string(": no such folder")) +
                "; expected a folder of runs, DATA/<object>/<run>");
  }
  return Search(data).found();
}

std::string sentence_on_missing_recordings(const std::vector<fs::path>& without_recording) {
  if (without_recording.empty()) return {};
  std::vector<std::string> names;
  for (const fs::path& run : without_recording) names.push_back(run.string());
  return fmt::format("left out, because events.aedat4 is missing: {}", fmt::join(names, ", "));
}

std::string what_is_misnamed(const fs::path& folder) {
  const RunFolder run = run_folder_at(folder);
  if (is_discarded(run.run)) return {};
  if (!is_run_id(run.run)) {
    const std::set<std::string> taken = names_in(fs::absolute(folder).lexically_normal() / "..");
    const std::string needed = free_id(taken, only_number_in(run.run));
    return folder.string() + ": a run's name is two digits from 01 on; rename it" + (needed.empty() ? "" : " to " + needed);
  }
  if (!is_object_name(run.object)) {
    const std::string needed = needed_object_name(run.object);
    return folder.string() + ": an object's name is lower-case letters, digits and inner hyphens; rename the folder " +
           run.object + (needed.empty() ? "" : " to " + needed);
  }
  return {};
}

RunFolder named_run_at(const fs::path& folder) {
  if (const std::string why = what_is_misnamed(folder); !why.empty()) throw Error(why);
  return run_folder_at(folder);
}

bool is_there(const fs::path& path) {
  std::error_code ignored;
  return fs::status(path, ignored).type() != fs::file_type::not_found;
}

bool is_file(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

}  // namespace tactile
