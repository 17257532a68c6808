#pragma once

#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "tactile/labels/exchange/exchanged_labels.hpp"
#include "tactile/labels/labels.hpp"
#include "tactile/labels/recording_span.hpp"

namespace tactile::labels {

/// How exactly a person sees a time, to either side, where no better is known: half a tick of 2 ms.
inline constexpr microseconds seen_within{1'000};

enum class IntervalEnd : std::uint8_t { start, end };

/// Moves one end. The 95 % interval is `to` ± `within`. The onset's evidence stays.
struct MoveEnd {
  std::string id;
  IntervalEnd which = IntervalEnd::start;
  CameraTime to{};
  microseconds within = seen_within;  ///< > 0: half of what the person could distinguish, such as the spacing of events there
  bool end_earlier = false;           ///< a start within the interval before it ends that one there; else it is an error
};

/// @param touch  press or slip
struct AddInterval {
  Touch touch = Touch::press;
  CameraTime start{}, end{};
  microseconds within = seen_within;
  bool end_earlier = false;
};

struct RejectInterval {
  std::string id;
};

struct ChangeClass {
  std::string id;
  Touch touch = Touch::press;
};

/// A person looked at it, and it is right.
struct ConfirmInterval {
  std::string id;
};

/// The same of all intervals and flags of the run.
struct ConfirmRun {};

/// A person looked at what the flag doubts, and the label is right. Saved only with a reason.
struct LiftFlag {
  std::size_t flag_index = 0;
};

/// A file of another tool, as one edit (`with_edits`).
struct ImportFile {
  ImportedLabels labels;
  FileTimes times;
};

using LabelEdit =
    std::variant<MoveEnd, AddInterval, RejectInterval, ChangeClass, ConfirmInterval, ConfirmRun, LiftFlag, ImportFile>;

/// The labels after an edit, without a trace in their history. A moved, added or changed interval has the `source` person, is
/// confirmed, and so are its flags. A removed one is `rejected`.
/// @throws Error  if there is no such interval or flag; if an interval would have no length, lie outside the recording or overlap
/// another
Labels with_edit(Labels labels, const LabelEdit& edit, const RecordingSpan& recording);

/// What the edit does to `before`: "start of press-1 from 1.230100 s to 1.234500 s", in seconds after the first event.
/// @throws Error  as `with_edit`
std::string words_of(const LabelEdit& edit, const Labels& before, const RecordingSpan& recording);

/// All that differs in the intervals, by id, each in the words of the edit that would make it; `before` comes first, then what
/// was added.
std::vector<std::string> words_of_changes(const Labels& before, const Labels& after, const RecordingSpan& recording);

/// The tick nearest to `t`; of two, the earlier. @throws Error if `tick` is not above 0
CameraTime nearest_tick(CameraTime t, microseconds tick);
/// The time in `events`, by time, that is nearest to `t`; of two, the earlier. Nothing if there are none.
std::optional<CameraTime> nearest_event(CameraTime t, std::span<const CameraTime> events);

}  // namespace tactile::labels
