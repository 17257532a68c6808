#include "tactile/review/split_desk.hpp"

#include <array>
#include <string_view>
#include <utility>

#include "tactile/core/error_text.hpp"
#include "tactile/review/page_message.hpp"
#include "tactile/review/run_events.hpp"
#include "tactile/splitting/split_recording.hpp"
#include "tactile/splitting/split_source.hpp"

namespace tactile::review {

SplitDesk::~SplitDesk() { end_work(); }

void SplitDesk::end_work() {
  ends_ = true;
  if (work_.joinable()) work_.join();
  ends_ = false;
}

void SplitDesk::advance(std::uint64_t done, std::uint64_t total) {
  if (ends_) throw Cancelled{};
  const std::scoped_lock lock(guard_);
  if (total > 0) share_ = static_cast<double>(done) / static_cast<double>(total);
}

void SplitDesk::set(State state, const std::string& error) {
  const std::scoped_lock lock(guard_);
  state_ = state;
  error_ = error;
}

void SplitDesk::begin_proposal(const RunFolder& run, microseconds quiet) {
  end_work();
  {
    const std::scoped_lock lock(guard_);
    name_ = run.name();
    run_ = run;
    quiet_ = quiet;
    state_ = State::proposing;
    share_ = 0;
    error_.clear();
    proposal_.reset();
    result_ = nullptr;
  }
  work_ = std::thread([this, run, quiet] {
    try {
      const splitting::SplitSource source = splitting::split_source_at(run.folder);
      events::RecordingReader recording(source.recording);
      splitting::ProposeOptions options;
      options.course.quiet = quiet;
      splitting::SplitProposal proposal = splitting::propose_runs(
          source, recording, options, [this](const Progress& progress) { advance(progress.done, progress.total); });
      const std::scoped_lock lock(guard_);
      object_ = source.info && is_object_name(source.info->object) ? source.info->object : run.object;
      proposal_ = std::move(proposal);
      state_ = State::proposed;
    } catch (const Cancelled&) {
      // another run is on the desk, or the server ends
    } catch (const std::exception& e) {
      set(State::failed, sentence_of(e));
    }
  });
}

nlohmann::json SplitDesk::look(const RunFolder& run, microseconds quiet) {
  const std::scoped_lock one(asking_);
  bool is_here = false;
  {
    const std::scoped_lock lock(guard_);
    is_here = name_ == run.name() && quiet_ == quiet;
    if (!is_here && state_ == State::cutting)
      throw Refusal(409, name_ + " is being cut; expected to wait until its runs are written");
  }
  if (!is_here) begin_proposal(run, quiet);
  const std::scoped_lock lock(guard_);
  return json();
}

nlohmann::json SplitDesk::cut(const RunFolder& run, const std::vector<microseconds>& cuts,
                              const std::vector<std::string>& objects) {
  const std::scoped_lock one(asking_);
  splitting::SplitProposal proposal;
  {
    const std::scoped_lock lock(guard_);
    if (name_ != run.name() || !proposal_ || state_ == State::cutting || state_ == State::proposing)
      throw Refusal(409, run.name() + ": has no proposal now; expected to look at its cuts first");
    proposal = *proposal_;
  }
  std::vector<CameraTime> times;
  times.reserve(cuts.size());
  for (const microseconds cut : cuts) times.push_back(after(proposal.first, cut));
  const splitting::SplitSource source = splitting::split_source_at(run.folder);
  try {
    events::RecordingReader recording(source.recording);
    proposal = splitting::with_cuts(std::move(proposal), recording, std::move(times));
  } catch (const Error& e) {
    throw Refusal(400, e.what());
  }
  end_work();
  {
    const std::scoped_lock lock(guard_);
    state_ = State::cutting;
    share_ = 0;
    error_.clear();
    proposal_ = proposal;
    result_ = nullptr;
  }
  work_ = std::thread([this, source, proposal = std::move(proposal), objects] {
    try {
      events::RecordingReader recording(source.recording);
      const splitting::SplitOptions options{.data = out_, .objects = objects, .session = {}};
      const splitting::SplitResult result = splitting::split_recording(
          source, recording, proposal, options, [this](const Progress& progress) { advance(progress.done, progress.total); });
      const std::scoped_lock lock(guard_);
      result_ = splitting::json_of(result);
      state_ = State::cut;
    } catch (const Cancelled&) {
      set(State::failed, "the server ended before all runs were written; expected to cut once more");
    } catch (const std::exception& e) {
      set(State::failed, sentence_of(e));
    }
  });
  const std::scoped_lock lock(guard_);
  return json();
}

nlohmann::json SplitDesk::json() const {
  constexpr std::array<std::string_view, 5> states{"proposing", "proposed", "cutting", "cut", "failed"};
  nlohmann::json view = {{"state", states.at(static_cast<std::size_t>(state_))},
                         {"share", share_},
                         {"error", error_.empty() ? nlohmann::json() : nlohmann::json(error_)},
                         {"quiet_s", 1e-6 * static_cast<double>(quiet_.count())},
                         {"out", out_.string()},
                         {"object", object_},
                         {"length_us", nullptr},
                         {"cuts_us", nlohmann::json::array()},
                         {"touches", nlohmann::json::array()},
                         {"result", result_}};
  if (!proposal_) return view;
  const CameraTime first = proposal_->first;
  view["length_us"] = between(first, proposal_->last).count();
  for (const CameraTime cut : proposal_->cuts) view["cuts_us"].push_back(between(first, cut).count());
  for (const splitting::SeenTouch& touch : proposal_->touches) {
    view["touches"].push_back({{"kind", splitting::name_of(touch.kind)},
                               {"begin_us", between(first, touch.begin).count()},
                               {"end_us", between(first, touch.end).count()}});
  }
  return view;
}

}  // namespace tactile::review
