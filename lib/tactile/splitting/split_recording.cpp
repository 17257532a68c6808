#include "tactile/splitting/split_recording.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <map>
#include <set>
#include <system_error>

#include "tactile/alignment/run_signals.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/machine.hpp"
#include "tactile/core/run_files.hpp"
#include "tactile/core/run_numbers.hpp"
#include "tactile/core/runs_below.hpp"
#include "tactile/core/sha256.hpp"
#include "tactile/core/version.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/events/camera_streams.hpp"
#include "tactile/events/simulated_recording.hpp"
#include "tactile/splitting/cut_devices.hpp"

namespace tactile::splitting {
namespace fs = std::filesystem;
namespace {

std::vector<std::string> objects_of(const SplitOptions& options, std::size_t pieces) {
  std::vector<std::string> objects = options.objects;
  if (objects.size() == 1) objects.assign(pieces, objects.front());
  if (objects.size() != pieces)
    throw Error(fmt::format("{} objects for {} runs; expected one for all, or one for each run", objects.size(), pieces));
  for (const std::string& object : objects) {
    if (const std::string why = why_not_an_object_name(object); !why.empty()) throw Error(why);
  }
  return objects;
}

/// How a device's file is cut, for a person; empty if there is none.
std::string plan_text(const std::optional<fs::path>& file, const DeviceClockSearch& search, const SplitProposal& proposal,
                      microseconds margin, const char* what) {
  if (!file) return {};
  if (proposal.cuts.empty()) return "whole, because the recording is one run";
  if (search.clock)
    return fmt::format("cut with {:g} s of margin, by {}", 1e-6 * static_cast<double>(margin.count()), search.clock->how);
  return fmt::format("each run has the whole {}, because its clock is not known: {}", what, search.why_not);
}

nlohmann::json hash_or_null(const std::optional<fs::path>& file) {
  return file ? nlohmann::json(sha256_of_file(*file)) : nlohmann::json();
}

/// What makes two pieces the same: the member `split` of run.json, without the piece's times.
/// @param stream  null if all streams are in the pieces
nlohmann::json origin_of(const SplitSource& source, const SplitResult& result, const std::string& sha256, std::uint64_t bytes,
                         const nlohmann::json& stream) {
  nlohmann::json origin = {{"from", source.origin},
                           {"sha256", sha256},
                           {"bytes", bytes},
                           {"session", result.session},
                           {"robot", result.robot},
                           {"robot_sha256", hash_or_null(source.robot)},
                           {"robot_columns", source.robot_columns},
                           {"film", result.film},
                           {"film_sha256", hash_or_null(source.video)},
                           {"film_times_sha256", hash_or_null(source.video_times)}};
  if (!stream.is_null()) origin["stream"] = stream;
  return origin;
}

/// The runs in DATA that were cut from the same streams of this recording, by their origin.
std::map<nlohmann::json, RunFolder> earlier_pieces(const fs::path& data, const std::string& sha256,
                                                   const nlohmann::json& stream) {
  std::map<nlohmann::json, RunFolder> pieces;
  if (!fs::is_directory(data)) return pieces;
  for (const RunFolder& run : find_runs(data)) {
    try {
      const RunInfo info = read_run_info(run);
      const nlohmann::json origin = info.extra.value("split", nlohmann::json());
      if (!origin.is_object() || origin.value("sha256", nlohmann::json()) != sha256) continue;
      if (origin.value("stream", nlohmann::json()) != stream) continue;
      const RunFiles files = check_files(run, info, FileComparison::size);
      if (files.missing.empty() && files.changed.empty()) pieces.emplace(origin, run);
    } catch (const Error&) {  // a run that cannot be read is no piece
    }
  }
  return pieces;
}

/// A piece on its way to its folder.
struct Piece {
  RunFolder target;
  std::unique_ptr<WholeFile> whole;  ///< nothing if it is kept
  RunFolder written;                 ///< where its files are made
  nlohmann::json origin = nlohmann::json::object();
  std::vector<fs::path> files;
};

/// Free numbers for the pieces of each object, in their order.
class FreeNumbers {
 public:
  FreeNumbers(fs::path data, std::optional<int> first) : data_(std::move(data)), first_(first) {}

  RunFolder next(const std::string& object) {
    const fs::path folder = data_ / object;
    if (!next_.contains(object)) {
      taken_[object] = run_numbers_in(folder);
      next_[object] = first_.value_or(taken_[object].empty() ? 1 : *taken_[object].rbegin() + 1);
    }
    int& number = next_[object];
    while (taken_[object].contains(number)) ++number;
    if (number > most_runs) {
      throw Error(fmt::format("{}: no free number up to {} for all runs; expected another --object, --out or --first-run",
                              folder.string(), most_runs));
    }
    const std::string id = run_id_of(number++);
    return {folder / id, object, id};
  }

 private:
  fs::path data_;
  std::optional<int> first_;
  std::map<std::string, std::set<int>> taken_;
  std::map<std::string, int> next_;
};

void check_others(const fs::path& data, const std::map<nlohmann::json, RunFolder>& earlier, std::size_t matching) {
  if (earlier.size() == matching) return;
  std::string names;
  for (const auto& [origin, run] : earlier) names += (names.empty() ? "" : ", ") + run.name();
  throw Error(fmt::format(
      "{}: {} {} made from this recording before, with other cuts, another robot log, film or session; the same events would be "
      "there twice. Expected another --out, or these runs removed, with the edits of their labels; 'tactile label --session "
      "NAME' gives runs another session",
      data.string(), names, earlier.size() == 1 ? "was" : "were"));
}

/// One reading serves all pieces, so all of their files are open at once: the lock of a folder, and a film with its times.
void check_open_files(const SplitSource& source, std::size_t pieces) {
  constexpr std::size_t of_piece = 3, others = 64;
  const std::size_t needed = of_piece * pieces + others;
  if (const std::size_t allowed = allow_open_files(needed); allowed < needed) {
    throw Error(
        fmt::format("{}: {} pieces need {} open files, and this system allows {}; expected fewer pieces, or a higher limit "
                    "(ulimit -Hn)",
                    source.name, pieces, needed, allowed));
  }
}

void copy_whole(const fs::path& from, const fs::path& to) {
  std::error_code failed;
  fs::copy_file(from, to, failed);
  if (failed)
    throw Error(from.string() + ": cannot be copied (" + failed.message() + "); expected a readable file and a disk with room");
}

/// The original among the runs of DATA would be used like one of them.
std::string warning_of_original(const SplitSource& source, const fs::path& data) {
  std::error_code unknown;
  const fs::path place = fs::weakly_canonical(source.recording, unknown);
  const fs::path below = place.lexically_relative(fs::weakly_canonical(data, unknown));
  if (unknown || below.empty() || below.begin()->string() == ".." || std::distance(below.begin(), below.end()) != 3) return {};
  return fmt::format("{} has the same events as its pieces: move it out of {} before 'tactile windows'", source.origin,
                     data.string());
}

/// One call of `split_recording`.
class Splitting {
 public:
  Splitting(const SplitSource& source, events::RecordingReader& recording, const SplitProposal& proposal,
            const SplitOptions& options)
      : source_(source),
        recording_(recording),
        proposal_(proposal),
        options_(options),
        runs_(runs_of(proposal)),
        kept_(events::camera_streams(recording.streams(), recording.stream(proposal.event_stream))) {}

  SplitResult run(const ProgressCallback& progress) {
    const std::vector<std::string> objects = objects_of(options_, runs_.size());
    result_.robot = plan_text(source_.robot, proposal_.robot, proposal_, options_.margin, "log");
    result_.film = plan_text(source_.video, proposal_.film, proposal_, options_.margin, "film");
    std::uint64_t hashed = 0;
    const std::string sha256 = sha256_of_file(source_.recording, [&](std::uint64_t bytes) {
      report_progress(progress, hashed += bytes, recording_.file_size(), "hashing " + source_.recording.filename().string());
    });
    result_.session =
        options_.session.empty() ? session_of(source_, recording_.stream(proposal_.event_stream), sha256) : options_.session;
    const nlohmann::json stream =
        kept_.size() < recording_.streams().size() ? nlohmann::json(proposal_.event_stream) : nlohmann::json();
    place_pieces(objects, origin_of(source_, result_, sha256, recording_.file_size(), stream),
                 earlier_pieces(options_.data, sha256, stream));
    if (std::any_of(pieces_.begin(), pieces_.end(), [](const Piece& piece) { return piece.whole != nullptr; })) {
      write_events(progress);
      write_robot();
      write_film();
      for (std::size_t i = 0; i < pieces_.size(); ++i) write_info(i);
    }
    for (std::size_t i = 0; i < pieces_.size(); ++i) commit(i);
    result_.warning = warning_of_original(source_, options_.data);
    result_.problems = recording_.problems();
    return std::move(result_);
  }

 private:
  void place_pieces(const std::vector<std::string>& objects, const nlohmann::json& origin,
                    const std::map<nlohmann::json, RunFolder>& earlier) {
    FreeNumbers numbers(options_.data, options_.first_run);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < runs_.size(); ++i) {
      Piece& piece = pieces_.emplace_back();
      SplitRun& run = result_.runs.emplace_back();
      piece.origin = origin;
      piece.origin["begin_us"] = us_of(runs_[i].begin);
      piece.origin["end_us"] = us_of(runs_[i].end);
      piece.origin["piece"] = i + 1;
      piece.origin["of"] = runs_.size();
      const auto found = earlier.find(piece.origin);
      run.is_kept = found != earlier.end() && found->second.object == objects[i];
      kept += run.is_kept ? 1 : 0;
      if (run.is_kept) piece.target = found->second;
    }
    check_others(options_.data, earlier, kept);
    for (std::size_t i = 0; i < runs_.size(); ++i) {
      if (!result_.runs[i].is_kept) pieces_[i].target = numbers.next(objects[i]);
      result_.runs[i].run = pieces_[i].target;
    }
    if (kept == runs_.size()) return;
    check_open_files(source_, runs_.size());
    // Those that are kept are written too, but not committed: one reading serves all.
    for (std::size_t i = 0; i < runs_.size(); ++i) {
      Piece& piece = pieces_[i];
      piece.whole = std::make_unique<WholeFile>(piece.target.folder, IfThere::refuse);
      fs::create_directory(piece.whole->path());
      piece.written = {piece.whole->path(), piece.target.object, piece.target.run};
    }
  }

  void write_events(const ProgressCallback& progress) {
    std::vector<fs::path> files;
    for (const Piece& piece : pieces_) files.push_back(piece.written.events());
    const std::vector<events::WrittenPiece> written = events::cut_recording(recording_, kept_, proposal_.cuts, files, progress);
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
      for (const events::PieceStream& stream : written[i].streams) {
        if (stream.stream.id != proposal_.event_stream) continue;
        result_.runs[i].events = stream.elements;
        if (stream.elements == 0)
          throw Error(fmt::format("{}: piece {} has no event that can be read; expected other cuts", source_.name, i + 1));
      }
      result_.runs[i].packets_copied = written[i].packets_copied;
      result_.runs[i].packets_encoded = written[i].packets_encoded;
      pieces_[i].files.push_back(files[i]);
    }
  }

  bool is_cut(const DeviceClockSearch& search) const { return search.clock && !proposal_.cuts.empty(); }

  void write_robot() {
    if (!source_.robot) return;
    std::vector<fs::path> files;
    for (const Piece& piece : pieces_) files.push_back(piece.written.robot());
    if (is_cut(proposal_.robot)) {
      const std::vector<DeviceSpan> spans = spans_of(*proposal_.robot.clock, proposal_.cuts, options_.margin);
      const std::vector<std::uint64_t> rows = cut_robot_log(source_, proposal_.robot.clock, spans, files);
      for (std::size_t i = 0; i < pieces_.size(); ++i) {
        result_.runs[i].robot_rows = rows[i];
        if (rows[i] == 0) fs::remove(files[i]);
      }
    } else if (source_.robot_columns.empty()) {
      for (const fs::path& file : files) copy_whole(*source_.robot, file);
    } else {
      cut_robot_log(source_, {}, std::vector<DeviceSpan>(pieces_.size()), files);
    }
    for (Piece& piece : pieces_) {
      if (is_file(piece.written.robot())) piece.files.push_back(piece.written.robot());
    }
  }

  void write_film() {
    if (!source_.video) return;
    std::vector<FilmFiles> files;
    for (const Piece& piece : pieces_) files.push_back({piece.written.video(), piece.written.video_times()});
    if (is_cut(proposal_.film)) {
      const std::vector<DeviceSpan> spans = spans_of(*proposal_.film.clock, proposal_.cuts, options_.margin);
      const std::vector<std::uint64_t> frames = cut_film(source_, *proposal_.film.clock, spans, files);
      for (std::size_t i = 0; i < pieces_.size(); ++i) result_.runs[i].frames = frames[i];
    } else {
      for (const FilmFiles& file : files) {
        copy_whole(*source_.video, file.film);
        if (source_.video_times) copy_whole(*source_.video_times, file.times);
      }
    }
    for (Piece& piece : pieces_) {
      for (const fs::path& file : {piece.written.video(), piece.written.video_times()}) {
        if (is_file(file)) piece.files.push_back(file);
      }
    }
  }

  RunInfo info_of_recording() const {
    if (source_.info) return *source_.info;
    const events::Stream& stream = recording_.stream(proposal_.event_stream);
    RunInfo info;
    info.simulated = events::is_simulated(recording_.streams());
    info.complete = recording_.problems().truncated_bytes == 0;
    if (stream.size) std::tie(info.width, info.height) = std::pair(stream.size->width, stream.size->height);
    return info;
  }

  void write_info(std::size_t i) {
    Piece& piece = pieces_[i];
    RunInfo info = info_of_recording();
    info.object = piece.target.object;
    info.run = piece.target.run;
    info.session = result_.session;
    info.extra.erase("simulation");  // the simulator replaces only what it made itself
    set_host_times(info, i);
    const auto set_count = [&](const char* device, const char* count, const std::optional<std::uint64_t>& number) {
      const auto found = info.extra.find(device);
      if (number && found != info.extra.end() && found->is_object()) (*found)[count] = *number;
    };
    set_count("robot", "rows", result_.runs[i].robot_rows);
    set_count("video", "frames", result_.runs[i].frames);
    info.extra["files"] = files_json(piece.files);
    info.extra["split"] = piece.origin;
    info.extra["software"] = {{"name", "tactile"}, {"version", version()}, {"revision", revision()}};
    write_run_info(piece.written, info);
  }

  /// Leaves the pairs of the piece, and the nearest one on either side.
  void set_host_times(RunInfo& info, std::size_t i) const {
    info.extra.erase("host_time_us");
    const std::vector<alignment::CameraArrival> arrivals = alignment::arrivals_in(info);
    if (arrivals.empty()) return;
    nlohmann::json pairs = nlohmann::json::array();
    for (std::size_t k = 0; k < arrivals.size(); ++k) {
      const bool is_before = k + 1 < arrivals.size() && arrivals[k + 1].camera < runs_[i].begin;
      const bool is_after = k > 0 && arrivals[k - 1].camera >= runs_[i].end;
      if (!is_before && !is_after) pairs.push_back({us_of(arrivals[k].camera), us_of(arrivals[k].host)});
    }
    const DeviceClock host{.arrivals = arrivals, .how = {}};
    info.extra["host_from_camera"] = std::move(pairs);
    info.extra["host_time_us"] = {{"begin", host.device_us_at(runs_[i].begin)}, {"end", host.device_us_at(runs_[i].end)}};
  }

  void commit(std::size_t i) {
    Piece& piece = pieces_[i];
    SplitRun& run = result_.runs[i];
    if (!run.is_kept) piece.whole->commit();
    if (run.is_kept) run.events = runs_[i].events;
    piece.whole.reset();
    for (const fs::directory_entry& file : fs::directory_iterator(piece.target.folder))
      run.bytes += file.is_regular_file() ? file.file_size() : 0;
  }

  const SplitSource& source_;
  events::RecordingReader& recording_;
  const SplitProposal& proposal_;
  const SplitOptions& options_;
  std::vector<ProposedRun> runs_;
  std::vector<events::Stream> kept_;  ///< streams that the runs have
  std::deque<Piece> pieces_;
  SplitResult result_;
};

}  // namespace

SplitResult split_recording(const SplitSource& source, events::RecordingReader& recording, const SplitProposal& proposal,
                            const SplitOptions& options, const ProgressCallback& progress) {
  return Splitting(source, recording, proposal, options).run(progress);
}

nlohmann::json json_of(const SplitResult& result) {
  const auto or_null = [](const std::optional<std::uint64_t>& count) {
    return count ? nlohmann::json(*count) : nlohmann::json();
  };
  nlohmann::json runs = nlohmann::json::array();
  for (const SplitRun& run : result.runs) {
    runs.push_back({{"run", run.run.name()},
                    {"folder", run.run.folder.string()},
                    {"kept", run.is_kept},
                    {"events", run.events},
                    {"packets_copied", run.packets_copied},
                    {"packets_encoded", run.packets_encoded},
                    {"robot_rows", or_null(run.robot_rows)},
                    {"frames", or_null(run.frames)},
                    {"bytes", run.bytes}});
  }
  const auto text_or_null = [](const std::string& text) { return text.empty() ? nlohmann::json() : nlohmann::json(text); };
  return {{"session", result.session},
          {"robot", text_or_null(result.robot)},
          {"film", text_or_null(result.film)},
          {"runs", runs},
          {"warning", text_or_null(result.warning)}};
}

}  // namespace tactile::splitting
