#include "tactile/windows/write_events.hpp"

#include <algorithm>
#include <memory>
#include <utility>

#include "tactile/core/error.hpp"
#include "tactile/core/in_order.hpp"
#include "tactile/core/parallel.hpp"
#include "tactile/hdf5/hdf5_objects.hpp"
#include "tactile/windows/dataset_layout.hpp"
#include "tactile/windows/event_columns.hpp"

namespace tactile::windows {
namespace fs = std::filesystem;
namespace h5 = hdf5;

namespace {

constexpr std::uint64_t piece_events = 1 << 18;  // about: a packet is not divided

/// Events of a run that one thread reads at once.
struct Piece {
  std::size_t run = 0;
  std::uint64_t first = 0, count = 0;  ///< in events if the older dataset's are kept, else in packets
  std::uint64_t packets = 0;           ///< of the whole recording
};

/// The events of an older dataset's run from `first` on; those before it are in copied chunks.
std::vector<Piece> pieces_of_events(std::size_t run, std::uint64_t first, std::uint64_t end) {
  std::vector<Piece> pieces;
  for (; first < end; first += pieces.back().count)
    pieces.push_back({.run = run, .first = first, .count = std::min(piece_events, end - first)});
  return pieces;
}

/// A run's recording that a thread has open.
struct OpenedRun {
  OpenedRun(const PlannedRun& planned, std::size_t index, microseconds history)
      : run(index), open(planned.folder), histories(histories_of(planned.samples, history)) {}
  std::size_t run;
  OpenRun open;
  std::vector<TimeSpan> histories;
};

/// The packets that may have events to store.
std::vector<Piece> pieces_of_packets(const OpenedRun& opened) {
  std::vector<Piece> pieces;
  const std::span<const events::PacketRecord> packets = opened.open.recording.packets();
  std::uint64_t events = 0;
  for (std::uint64_t i = 0; i < packets.size(); ++i) {
    if (!may_be_stored(opened.open, packets[i], opened.histories)) continue;
    if (pieces.empty() || events >= piece_events) {
      pieces.push_back({.run = opened.run, .first = i, .packets = packets.size()});
      events = 0;
    }
    pieces.back().count = i + 1 - pieces.back().first;
    events += static_cast<std::uint64_t>(packets[i].elements);
  }
  return pieces;
}

/// A dataset's file of events while it is written.
class EventsFile {
 public:
  EventsFile(DatasetPlan& plan, const EventSources& sources, const fs::path& file)
      : plan_(plan), sources_(sources), where_(file.string()) {}
  ~EventsFile() {
    const h5::Session session;
    columns_.reset();
    out_ = {};
  }
  EventsFile(const EventsFile&) = delete;
  EventsFile& operator=(const EventsFile&) = delete;

  void create(const std::string& manifest_hash);
  void copy_first_chunks();
  void write(unsigned threads, const ProgressCallback& progress);
  void close();

 private:
  std::vector<Piece> pieces(unsigned threads) const;
  std::vector<events::Event> read(const Piece& piece, std::optional<OpenedRun>& opened) const;

  DatasetPlan& plan_;
  const EventSources& sources_;
  std::string where_;
  h5::Id out_;
  std::optional<EventColumns> columns_;
  std::uint64_t copied_ = 0;  ///< events, in chunks
};

void EventsFile::create(const std::string& manifest_hash) {
  const h5::Session session;
  out_ = h5::create_file(where_, h5::Structure::checked);
  const h5::Id group = h5::create_group(out_, "events", where_);
  h5::write_attribute(group, "manifest_sha256", manifest_hash, where_);
  columns_.emplace(group, where_);
}

/// Copies the chunks before the first run that is not as in the older dataset: later chunks hold other rows than there.
/// @throws UnusableDataset  if one is damaged
void EventsFile::copy_first_chunks() {
  const OlderDataset& older = *sources_.older;
  std::uint64_t same_rows = 0;
  for (std::uint32_t i = 0; i < sources_.kept.size() && sources_.kept[i] == i; ++i) same_rows += older.events_of(i);
  const std::uint64_t chunks = same_rows / EventColumns::rows_per_chunk;
  const h5::Session session;
  try {
    const fs::path dataset = older.dataset().file(), file = dataset_layout::folder_of(dataset) / events_file_of(dataset);
    const h5::Id in = h5::open_file(file, false);
    columns_->copy_chunks(h5::open_group(in, "events", file.string()), chunks, file.string());
  } catch (const h5::Damaged& e) {
    throw UnusableDataset(e);
  }
  copied_ = chunks * EventColumns::rows_per_chunk;
}

/// All pieces, in the order of the file.
std::vector<Piece> EventsFile::pieces(unsigned threads) const {
  std::vector<std::vector<Piece>> of_runs(plan_.runs.size());
  parallel_for(plan_.runs.size(), threads, [&](std::size_t i) {
    const PlannedRun& run = plan_.runs[i];
    if (!sources_.kept[i] && !run.samples.empty()) of_runs[i] = pieces_of_packets({run, i, sources_.history});
  });
  std::vector<Piece> all;
  std::uint64_t copied = copied_;  // of the runs from i on
  for (std::size_t i = 0; i < of_runs.size(); ++i) {
    if (const auto same = sources_.kept[i]) {
      const std::uint64_t events = sources_.older->events_of(*same), there = std::min(copied, events);
      copied -= there;
      of_runs[i] = pieces_of_events(i, there, events);
    }
    all.insert(all.end(), of_runs[i].begin(), of_runs[i].end());
  }
  return all;
}

std::vector<events::Event> EventsFile::read(const Piece& piece, std::optional<OpenedRun>& opened) const {
  if (const auto same = sources_.kept[piece.run]) return sources_.older->events(*same, piece.first, piece.count);
  if (!opened || opened->run != piece.run) opened.emplace(plan_.runs[piece.run], piece.run, sources_.history);
  const std::span<const events::PacketRecord> packets = opened->open.recording.packets();
  if (packets.size() != piece.packets) {
    throw Error(plan_.runs[piece.run].folder.events().string() +
                ": was changed while it was read; expected a recording that stays, run the command again");
  }
  std::vector<events::Event> events;
  for_stored_events(opened->open, packets.subspan(piece.first, piece.count), opened->histories,
                    [&](std::span<const events::Event> some) { events.insert(events.end(), some.begin(), some.end()); });
  return events;
}

/// Threads read and pack pieces. Their events are divided into chunks, and written, in the order of the file.
void EventsFile::write(unsigned threads, const ProgressCallback& progress) {
  const std::vector<Piece> pieces = this->pieces(threads);
  const std::size_t runs = plan_.runs.size();
  std::vector<std::optional<OpenedRun>> opened(std::clamp<std::size_t>(threads_or_all(threads), 1, pieces.size() + 1));
  InOrder dividing(1), writing(2 * opened.size());
  parallel_for_with(std::span(opened), pieces.size(), [&](std::size_t i, std::optional<OpenedRun>& run) {
    try {
      std::vector<events::Event> events = read(pieces[i], run);
      EventColumns::Chunks chunks;
      const bool divided = dividing.now(i, [&] {
        plan_.rows[pieces[i].run].events += events.size();
        chunks = columns_->full_chunks_with(std::move(events));
      });
      if (!divided) return;
      const auto packed = std::make_shared<EventColumns::PackedChunks>(EventColumns::packed(chunks));
      chunks = {};
      writing.later(i, [&, i, packed] {
        {
          const h5::Session session;
          columns_->write(*packed);
        }
        report_progress(progress, runs + pieces[i].run, 2 * runs, plan_.runs[pieces[i].run].folder.name());
      });
    } catch (...) {
      dividing.fail();
      writing.fail();
      throw;
    }
  });
  if (runs > 0) report_progress(progress, 2 * runs, 2 * runs, plan_.runs.back().folder.name());
}

void EventsFile::close() {
  const h5::Session session;
  columns_->finish();
  columns_.reset();
  out_.close(where_);
}

/// Numbers the events: each run's follow those of the runs before. @return  how many there are
std::uint64_t number_events(DatasetPlan& plan, const EventSources& sources) {
  std::uint64_t next = 0;
  for (std::size_t i = 0; i < plan.rows.size(); ++i) {
    if (const auto same = sources.kept[i]) plan.rows[i].events = sources.older->events_of(*same);
    plan.rows[i].first_event = next;
    next += plan.rows[i].events;
  }
  return next;
}

}  // namespace

std::string events_file_of(const fs::path& dataset) {
  const h5::Session session;
  return h5::linked_file(h5::open_file(dataset, false), "events");
}

std::uint64_t write_events(DatasetPlan& plan, const EventSources& sources, const fs::path& file, const std::string& manifest_hash,
                           unsigned threads, const ProgressCallback& progress) {
  EventsFile events(plan, sources, file);
  events.create(manifest_hash);
  if (sources.older != nullptr) events.copy_first_chunks();
  events.write(threads, progress);
  events.close();
  for (std::size_t i = 0; i < plan.runs.size(); ++i) {
    const PlannedRun& run = plan.runs[i];
    if (!sources.kept[i] && !run.samples.empty() && !run.was_read) plan.read_runs.push_back(run.folder.name());
  }
  return number_events(plan, sources);
}

}  // namespace tactile::windows
