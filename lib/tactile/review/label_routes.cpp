#include "tactile/review/label_routes.hpp"

#include <fmt/core.h>

#include <cstdint>

#include "tactile/core/error_text.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/text.hpp"
#include "tactile/labels/edit_history.hpp"

namespace tactile::review {
namespace {

using nlohmann::json;

constexpr std::int64_t most_us = 24LL * 3600 * 1'000'000;  // a day: no run is longer
constexpr const char* where = "the edit";

CameraTime time_of(const json& edit, const char* key, CameraTime first) {
  const auto us = member<std::int64_t>(edit, key, where);
  if (us < -most_us || us > most_us)
    throw Refusal(400, fmt::format("{}: '{}' is {}; expected microseconds after the first event", where, key, us));
  return after(first, microseconds{us});
}

bool flag_of(const json& edit, const char* key) { return edit.contains(key) && member<bool>(edit, key, where); }

Touch touch_of(const json& edit) {
  const Touch touch = touch_named(member<std::string>(edit, "touch", where));
  if (touch == Touch::none) throw Refusal(400, fmt::format("{}: 'touch' is none; expected press or slip", where));
  return touch;
}

microseconds within_of(const json& edit) {
  if (!edit.contains("within_us")) return labels::seen_within;
  const auto within = member<std::int64_t>(edit, "within_us", where);
  if (within < 1 || within > most_us)
    throw Refusal(400, fmt::format("{}: 'within_us' is {}; expected microseconds from 1", where, within));
  return microseconds{within};
}

labels::MoveEnd move_of(const json& edit, CameraTime first) {
  const auto end = member<std::string>(edit, "end", where);
  if (end != "start" && end != "end")
    throw Refusal(400, fmt::format("{}: 'end' is {}; expected start or end", where, shown_text(end)));
  labels::MoveEnd move{.id = member<std::string>(edit, "id", where),
                       .which = end == "start" ? labels::IntervalEnd::start : labels::IntervalEnd::end,
                       .to = time_of(edit, "to_us", first),
                       .end_earlier = flag_of(edit, "end_earlier")};
  move.within = within_of(edit);
  return move;
}

labels::LabelEdit edit_of_kind(const std::string& kind, const json& edit, CameraTime first) {
  if (kind == "move") return move_of(edit, first);
  if (kind == "add") {
    return labels::AddInterval{.touch = touch_of(edit),
                               .start = time_of(edit, "start_us", first),
                               .end = time_of(edit, "end_us", first),
                               .within = within_of(edit),
                               .end_earlier = flag_of(edit, "end_earlier")};
  }
  if (kind == "reject") return labels::RejectInterval{member<std::string>(edit, "id", where)};
  if (kind == "class") return labels::ChangeClass{member<std::string>(edit, "id", where), touch_of(edit)};
  if (kind == "confirm") return labels::ConfirmInterval{member<std::string>(edit, "id", where)};
  if (kind == "confirm-run") return labels::ConfirmRun{};
  if (kind == "lift") return labels::LiftFlag{static_cast<std::size_t>(member<std::uint32_t>(edit, "flag", where))};
  throw Refusal(400, fmt::format("{}: 'kind' is {}; expected move, add, reject, class, confirm, confirm-run or lift", where,
                                 shown_text(kind)));
}

/// Runs `make`; an `Error` says that what was asked for cannot be done: 400.
template <class Make>
auto asked(const Make& make) {
  try {
    return make();
  } catch (const Refusal&) {
    throw;
  } catch (const Error& e) {
    throw Refusal(400, sentence_of(e));
  }
}

std::string version_in(const json& body) {
  return asked([&] { return member<std::string>(body, "version", "the request"); });
}

}  // namespace

labels::LabelEdit edit_in(const json& edit, CameraTime first) {
  return asked([&] { return edit_of_kind(member<std::string>(edit, "kind", where), edit, first); });
}

labels::SaveOutcome save_asked_edit(const RunFolder& run, const json& body, CameraTime first, const std::string& who) {
  const std::string version = version_in(body);
  const labels::EditNote note{
      .who = who,
      .why = asked([&] { return body.contains("why") ? member<std::string>(body, "why", "the request") : std::string(); })};
  const labels::LabelEdit edit = edit_in(asked([&] { return member<json>(body, "edit", "the request"); }), first);
  return asked([&] { return labels::save_edit(run, version, edit, note); });
}

labels::SaveOutcome save_asked_step(const RunFolder& run, const json& body, bool is_undo) {
  const std::string version = version_in(body);
  const auto count = asked([&] { return body.contains("count") ? member<std::uint32_t>(body, "count", "the request") : 1U; });
  if (count < 1 || count > labels::most_history_entries)
    throw Refusal(400, fmt::format("the request: 'count' is {}; expected 1 to {} edits", count, labels::most_history_entries));
  return asked([&] { return is_undo ? labels::save_undo(run, version, count) : labels::save_redo(run, version, count); });
}

}  // namespace tactile::review
