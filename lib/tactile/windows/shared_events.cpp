#include "tactile/windows/shared_events.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <tuple>

#include "tactile/core/parallel.hpp"

namespace tactile::windows {
namespace {

constexpr double events_in_slice = 1 << 19;        // on average; a burst may have many times that
constexpr std::size_t most_open_recordings = 200;  // a system allows about 1000 open files

using Pair = std::pair<std::uint32_t, std::uint32_t>;

/// An event for the comparison; small, because a slice has many.
struct Mark {
  std::int64_t t_us = 0;
  std::uint32_t place = 0;  ///< pixel and polarity
  std::uint32_t in_window : 1 = 0;
  std::uint32_t run_index : 31 = 0;
};
static_assert(sizeof(Mark) == 16);

std::uint32_t place_of(const events::Event& event) {
  return static_cast<std::uint32_t>(event.x) << 17 | static_cast<std::uint32_t>(event.y) << 2 | event.on;
}

/// A recording that is read once, slice by slice.
class SlicedRecording {
 public:
  SlicedRecording(const PlannedRun& run, std::uint32_t run_index, microseconds history)
      : run_(run), run_index_(run_index), windows_(histories_of(run.samples, history)) {}

  const PlannedRun& run() const { return run_; }

  /// Reads the events of a slice. Slices must ascend.
  void read(CameraTime begin, CameraTime end) {
    marks_.clear();
    if (!open_) open_ = std::make_unique<OpenRun>(run_.folder);
    events::for_events_between(open_->recording, open_->stream_id, begin, end, [&](std::span<const events::Event> events) {
      for (const events::Event& event : events) {
        while (window_ < windows_.size() && windows_[window_].end <= event.t) ++window_;
        const bool in_window = window_ < windows_.size() && windows_[window_].begin <= event.t;
        events_in_windows_ += in_window ? 1 : 0;
        marks_.push_back({us_of(event.t), place_of(event), in_window, run_index_ & 0x7fff'ffffU});
      }
    });
  }
  void close() { open_.reset(); }

  std::span<const Mark> marks() const { return marks_; }
  std::uint64_t events_in_windows() const { return events_in_windows_; }  ///< in all slices so far

 private:
  const PlannedRun& run_;
  std::uint32_t run_index_;
  std::vector<TimeSpan> windows_;
  std::size_t window_ = 0;
  std::uint64_t events_in_windows_ = 0;
  std::unique_ptr<OpenRun> open_;
  std::vector<Mark> marks_;
};

/// Counts for each pair the events in windows of the first that the second contains too.
void count_equal(std::vector<Mark>& marks, std::map<Pair, std::uint64_t>& shared) {
  const auto key = [](const Mark& mark) { return std::tuple(mark.t_us, mark.place, +mark.run_index); };
  std::sort(marks.begin(), marks.end(), [&](const Mark& a, const Mark& b) { return key(a) < key(b); });
  for (auto first = marks.cbegin(); first != marks.cend();) {
    const auto last = std::find_if(first, marks.cend(),
                                   [&](const Mark& mark) { return mark.t_us != first->t_us || mark.place != first->place; });
    for (auto mine = first; mine != last && first->run_index != (last - 1)->run_index; ++mine) {
      if (mine->in_window == 0) continue;
      for (auto other = first; other != last; ++other) {
        const bool is_new = other == first || (other - 1)->run_index != other->run_index;  // a run may contain it twice
        if (is_new && other->run_index != mine->run_index) ++shared[{+mine->run_index, +other->run_index}];
      }
    }
    first = last;
  }
}

/// The begins and ends of the recordings. Between two of them the set of recordings is constant.
std::vector<CameraTime> ends_of(std::span<const PlannedRun> runs) {
  std::vector<CameraTime> ends;
  for (const PlannedRun& run : runs) {
    ends.push_back(run.first_event);
    ends.push_back(after(run.last_event, microseconds{1}));
  }
  std::sort(ends.begin(), ends.end());
  ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
  return ends;
}

double length_us(CameraTime begin, CameraTime end) { return static_cast<double>(us_of(end)) - static_cast<double>(us_of(begin)); }

class Comparison {
 public:
  Comparison(std::span<const PlannedRun> runs, microseconds history, unsigned threads)
      : ends_(ends_of(runs)), windows_until_(runs.size()), threads_(threads) {
    for (std::uint32_t i = 0; i < runs.size(); ++i) recordings_.emplace_back(runs[i], i, history);
  }

  void run(const ProgressCallback& progress) {
    for (std::size_t i = 0; i + 1 < ends_.size(); ++i) {
      compare_between(i);
      report_progress(progress, i + 1, ends_.size() - 1, "recordings of one time");
    }
  }

  /// Both directions of each pair that overlaps in time.
  std::vector<SharedEvents> result() const {
    std::vector<SharedEvents> pairs;
    for (std::uint32_t a = 0; a < recordings_.size(); ++a) {
      for (std::uint32_t b = 0; b < recordings_.size(); ++b) {
        const PlannedRun &mine = recordings_[a].run(), &other = recordings_[b].run();
        const CameraTime begin = std::max(mine.first_event, other.first_event),
                         last = std::min(mine.last_event, other.last_event);
        if (a == b || begin > last) continue;
        const auto found = shared_.find({a, b});
        pairs.push_back({.run_index = a,
                         .other_index = b,
                         .events = windows_before(a, after(last, microseconds{1})) - windows_before(a, begin),
                         .shared = found == shared_.end() ? 0 : found->second});
      }
    }
    return pairs;
  }

 private:
  void compare_between(std::size_t i) {
    const CameraTime begin = ends_[i], end = ends_[i + 1];
    std::vector<SlicedRecording*> there;
    double expected = 0;
    for (SlicedRecording& recording : recordings_) {
      const PlannedRun& run = recording.run();
      if (run.last_event < begin) recording.close();
      if (run.first_event > begin || run.last_event < begin) continue;
      there.push_back(&recording);
      expected +=
          static_cast<double>(run.recorded_events) * length_us(begin, end) / (1 + length_us(run.first_event, run.last_event));
    }
    if (there.size() < 2) return;
    const double slices = std::max(1.0, std::ceil(expected / events_in_slice));
    const microseconds step{static_cast<std::int64_t>(std::min(0x1p62, length_us(begin, end) / slices)) + 1};
    for (CameraTime from = begin; from < end;) {
      const CameraTime to = std::min(end, after(from, step));
      compare_slice(there, from, to);
      from = to;
    }
    for (const SlicedRecording* recording : there) {
      windows_until_[static_cast<std::size_t>(recording - recordings_.data())].emplace_back(end, recording->events_in_windows());
    }
  }

  void compare_slice(const std::vector<SlicedRecording*>& there, CameraTime from, CameraTime to) {
    parallel_for(there.size(), threads_, [&](std::size_t i) {
      there[i]->read(from, to);
      if (there.size() > most_open_recordings) there[i]->close();
    });
    marks_.clear();
    for (const SlicedRecording* recording : there) {
      marks_.insert(marks_.end(), recording->marks().begin(), recording->marks().end());
    }
    count_equal(marks_, shared_);
  }

  /// The number of events in windows of a run before `t`, one of `ends_`, while other recordings overlapped.
  std::uint64_t windows_before(std::uint32_t run_index, CameraTime t) const {
    const auto& until = windows_until_[run_index];
    const auto later = std::partition_point(until.begin(), until.end(), [&](const auto& each) { return each.first <= t; });
    return later == until.begin() ? 0 : std::prev(later)->second;
  }

  std::vector<CameraTime> ends_;
  std::vector<SlicedRecording> recordings_;
  std::vector<std::vector<std::pair<CameraTime, std::uint64_t>>> windows_until_;  ///< by run: events in windows before a time
  std::map<Pair, std::uint64_t> shared_;
  std::vector<Mark> marks_;
  unsigned threads_;
};

}  // namespace

std::vector<SharedEvents> shared_events(std::span<const PlannedRun> runs, microseconds history, unsigned threads,
                                        const ProgressCallback& progress) {
  Comparison comparison(runs, history, threads);
  comparison.run(progress);
  return comparison.result();
}

}  // namespace tactile::windows
