// Measures reading and writing of recordings, and their lower limits: decompression alone, and reading of the bytes alone.
// `scripts/bench` runs it and makes the table of docs/performance/.
//
// recording_benchmark FOLDER RECORDING… [--benchmark_…]
//   Compares on files in FOLDER, which it writes with the events of the recordings.
// recording_benchmark --read FILE [THREADS]
//   Reads all events of a file once; prints their number and the seconds.

#include <benchmark/benchmark.h>
#include <fcntl.h>
#include <fmt/core.h>
#include <lz4frame.h>
#include <unistd.h>
#include <zstd.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <functional>
#include <memory>
#include <numeric>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "measured_time.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/robust_statistics.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/events/file_descriptor.hpp"
#include "tactile/events/packet_contents.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/events/recording_writer.hpp"

namespace tactile::bench {
namespace {

namespace fs = std::filesystem;
using Step = std::function<void()>;

constexpr std::size_t packet_events = 8192;
constexpr std::size_t events_in_all = 1024 * packet_events;

double quantile(const std::vector<double>& values, double share) {
  return value_of_rank(values, static_cast<std::size_t>(share * static_cast<double>(values.size() - 1) + 0.5));
}

/// Measures both steps in turn; another one comes first in each round, so that other programs affect both alike. The ratio is the
/// median of the ratios of neighbours. Work on one thread is measured by CPU time, work on several by wall-clock time.
void compare(benchmark::State& state, const Step& ours, const Step& alone, const Step& clean_up, bool by_wall) {
  const auto seconds_of = [&](const Step& step) {
    clean_up();
    const auto now = by_wall ? wall_seconds : cpu_seconds;
    const double begin = now();
    step();
    return now() - begin;
  };
  std::vector<double> ours_s, alone_s, ratios;
  seconds_of(ours), seconds_of(alone);
  for (bool ours_first = true; auto _ : state) {
    static_cast<void>(_);
    const double first = seconds_of(ours_first ? ours : alone), second = seconds_of(ours_first ? alone : ours);
    ours_s.push_back(ours_first ? first : second);
    alone_s.push_back(ours_first ? second : first);
    ratios.push_back(alone_s.back() / ours_s.back());
    state.SetIterationTime(ours_s.back());
    ours_first = !ours_first;
  }
  const double million_events = events_in_all / 1e6;
  state.counters["ours"] = million_events / quantile(ours_s, 0.5);
  state.counters["alone"] = million_events / quantile(alone_s, 0.5);
  state.counters["ratio"] = quantile(ratios, 0.5);
  state.counters["ratio_low"] = quantile(ratios, 0.25);
  state.counters["ratio_high"] = quantile(ratios, 0.75);
}

/// The events of the recordings, repeated until there are enough, in ascending time.
std::vector<events::Event> events_of(const std::vector<fs::path>& recordings) {
  std::vector<events::Event> all;
  all.reserve(events_in_all);
  std::int64_t begin = 1'700'000'000'000'000;
  while (all.size() < events_in_all) {
    const std::size_t before = all.size();
    for (const fs::path& file : recordings) {
      events::RecordingReader recording(file);
      std::int64_t first = 0, last = 0;
      bool any = false;
      events::for_all_events(recording, events::event_stream(recording).id, [&](std::span<const events::Event> events) {
        if (!any) first = us_of(events.front().t);
        any = true;
        for (events::Event event : events.first(std::min(events.size(), events_in_all - all.size()))) {
          last = us_of(event.t) - first + begin;
          event.t = camera_time(last);
          all.push_back(event);
        }
      });
      if (any) begin = std::max(begin, last) + 200;
    }
    if (all.size() == before) throw Error("recording_benchmark: no events to work with; expected recordings with events");
  }
  return all;
}

void write_recording(const fs::path& file, std::span<const events::Event> events, events::Compression compression) {
  events::RecordingWriter writer(
      file, {events::event_stream_declaration({640, 480}, "DVXplorer_DXM00000")},
      {.compression = compression, .packet_span = std::chrono::hours(1), .packet_events = packet_events});
  for (std::size_t i = 0; i < events.size(); i += packet_events)
    writer.write_events(0, events.subspan(i, std::min(packet_events, events.size() - i)));
  writer.close();
}

/// Reads the file from the disk into the page cache. It was there in the pieces in which it was written.
void read_from_disk(const fs::path& file) {
  const events::FileDescriptor in(::open(file.c_str(), O_RDONLY | O_CLOEXEC));
  ::posix_fadvise(in.number(), 0, 0, POSIX_FADV_DONTNEED);
  std::vector<std::byte> buffer(std::size_t{1} << 20);
  while (::read(in.number(), buffer.data(), buffer.size()) > 0) continue;
}

void read_recording(const fs::path& file, unsigned threads) {
  events::RecordingReader recording(file, threads);
  std::size_t count = 0;
  for (const events::PacketRecord& packet : recording.packets()) count += recording.read_events(packet).size();
  if (count != events_in_all) throw Error(file.string() + ": not all events were read; expected them all");
}

/// A file in memory, and where its packets are.
struct StoredFile {
  explicit StoredFile(const fs::path& file) : bytes(read_text(file)) {
    const events::RecordingReader recording(file);
    for (const events::PacketRecord& packet : recording.packets())
      packets.push_back(std::as_bytes(std::span(bytes)).subspan(packet.payload_offset, packet.payload_size));
  }
  std::string bytes;
  std::vector<std::span<const std::byte>> packets;
};

constexpr std::size_t content_size = events::event_packet_head + packet_events * sizeof(events::Event);
constexpr std::size_t lz4_block = std::size_t{64} << 10;

/// One context and one buffer with room for LZ4's last block: all that the library needs to be at its fastest.
void decompress_lz4(std::span<const std::span<const std::byte>> packets) {
  LZ4F_dctx* context = nullptr;
  LZ4F_createDecompressionContext(&context, LZ4F_VERSION);
  const std::unique_ptr<std::byte[]> content(new std::byte[content_size + lz4_block]);
  for (const auto& packet : packets) {
    std::size_t made = content_size + lz4_block, used = packet.size();
    const std::size_t rest = LZ4F_decompress(context, content.get(), &made, packet.data(), &used, nullptr);
    if (rest != 0 || made != content_size) throw Error("LZ4F: a packet did not decompress; expected it to");
    benchmark::DoNotOptimize(content.get());
  }
  LZ4F_freeDecompressionContext(context);
}

void decompress_lz4_on(unsigned threads, std::span<const std::span<const std::byte>> packets) {
  const std::size_t share = packets.size() / threads;
  std::vector<std::thread> helpers;
  for (unsigned i = 1; i < threads; ++i) {
    const auto part = packets.subspan(i * share, i + 1 == threads ? packets.size() - i * share : share);
    helpers.emplace_back([part] { decompress_lz4(part); });
  }
  decompress_lz4(packets.first(threads == 1 ? packets.size() : share));
  for (std::thread& helper : helpers) helper.join();
}

void decompress_zstd(std::span<const std::span<const std::byte>> packets) {
  ZSTD_DCtx* context = ZSTD_createDCtx();
  const std::unique_ptr<std::byte[]> content(new std::byte[content_size]);
  for (const auto& packet : packets) {
    if (ZSTD_decompressDCtx(context, content.get(), content_size, packet.data(), packet.size()) != content_size)
      throw Error("zstd: a packet did not decompress; expected it to");
    benchmark::DoNotOptimize(content.get());
  }
  ZSTD_freeDCtx(context);
}

/// Reads the file in pieces of a packet's length into one buffer, and sums the 64-bit words.
void read_and_sum(const fs::path& file) {
  const events::FileDescriptor in(::open(file.c_str(), O_RDONLY | O_CLOEXEC));
  std::vector<std::uint64_t> buffer((content_size + 8) / sizeof(std::uint64_t));
  std::uint64_t sum = 0;
  for (;;) {
    const ssize_t got = ::read(in.number(), buffer.data(), buffer.size() * sizeof(std::uint64_t));
    if (got <= 0) break;
    const auto words = static_cast<std::size_t>(got) / sizeof(std::uint64_t);
    sum = std::accumulate(buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(words), sum);
  }
  benchmark::DoNotOptimize(sum);
}

/// The contents of packets before compression.
std::vector<std::byte> contents_of(std::span<const events::Event> events) {
  std::vector<std::byte> contents(events.size() / packet_events * content_size);
  for (std::size_t i = 0; i < events.size() / packet_events; ++i) {
    std::byte* packet = contents.data() + i * content_size;
    events::write_event_packet_head(packet, packet_events);
    std::memcpy(packet + events::event_packet_head, events.data() + i * packet_events, packet_events * sizeof(events::Event));
  }
  return contents;
}

void compress_lz4(std::span<const std::byte> contents) {
  LZ4F_cctx* context = nullptr;
  LZ4F_createCompressionContext(&context, LZ4F_VERSION);
  LZ4F_preferences_t preferences{};
  preferences.frameInfo.blockSizeID = LZ4F_max64KB;
  preferences.frameInfo.blockMode = LZ4F_blockLinked;
  const std::size_t room = LZ4F_HEADER_SIZE_MAX + LZ4F_compressBound(content_size, &preferences);
  const std::unique_ptr<std::byte[]> frame(new std::byte[room]);
  for (std::size_t at = 0; at < contents.size(); at += content_size) {
    std::size_t size = LZ4F_compressBegin(context, frame.get(), room, &preferences);
    size += LZ4F_compressUpdate(context, frame.get() + size, room - size, contents.data() + at, content_size, nullptr);
    size += LZ4F_compressEnd(context, frame.get() + size, room - size, nullptr);
    if (LZ4F_isError(size) != 0) throw Error("LZ4F: a packet was not compressed; expected it to be");
    benchmark::DoNotOptimize(frame.get());
  }
  LZ4F_freeCompressionContext(context);
}

void write_plainly(const fs::path& file, std::span<const std::byte> contents) {
  const events::FileDescriptor out(::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666));
  for (std::size_t at = 0; at < contents.size(); at += content_size) {
    if (::write(out.number(), contents.data() + at, content_size) != static_cast<ssize_t>(content_size))
      throw Error(file.string() + ": cannot be written; expected a folder with free space");
  }
}

void run(const fs::path& folder, const std::vector<fs::path>& recordings, int argc, char** argv) {
  const std::vector<events::Event> events = events_of(recordings);
  const auto file_of = [&](events::Compression compression) { return folder / (std::string(name_of(compression)) + ".aedat4"); };
  for (const events::Compression compression : {events::Compression::none, events::Compression::lz4, events::Compression::zstd}) {
    fs::remove(file_of(compression));
    write_recording(file_of(compression), events, compression);
    read_from_disk(file_of(compression));
  }
  const fs::path none = file_of(events::Compression::none), lz4 = file_of(events::Compression::lz4),
                 zstd = file_of(events::Compression::zstd);
  // In memory, so that the time of syncing to a disk is not measured.
  const fs::path memory = "/dev/shm";
  const fs::path output = (fs::is_directory(memory) ? memory : folder) / fmt::format("written-{}.aedat4", ::getpid());
  const StoredFile lz4_file(lz4), zstd_file(zstd);
  const std::vector<std::byte> contents = contents_of(events);

  constexpr int repetitions = 31;
  const auto add = [&](const char* name, Step ours, Step alone, int times, bool by_wall = false) {
    benchmark::RegisterBenchmark(name,
                                 [=, &output](benchmark::State& state) {
                                   compare(
                                       state, ours, alone, [&] { fs::remove(output); }, by_wall);
                                 })
        ->UseManualTime()
        ->Iterations(times)
        ->Unit(benchmark::kMillisecond);
  };
  add(
      "read_lz4", [&] { read_recording(lz4, 1); }, [&] { decompress_lz4(lz4_file.packets); }, repetitions);
  add(
      "read_lz4_two_threads", [&] { read_recording(lz4, 2); }, [&] { decompress_lz4_on(2, lz4_file.packets); }, repetitions,
      true);
  add(
      "read_none", [&] { read_recording(none, 1); }, [&] { read_and_sum(none); }, repetitions);
  add(
      "read_zstd", [&] { read_recording(zstd, 1); }, [&] { decompress_zstd(zstd_file.packets); }, repetitions / 2);
  add(
      "write_lz4", [&] { write_recording(output, events, events::Compression::lz4); }, [&] { compress_lz4(contents); },
      repetitions / 2);
  add(
      "write_none", [&] { write_recording(output, events, events::Compression::none); }, [&] { write_plainly(output, contents); },
      repetitions);

  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
  fs::remove(output);
}

}  // namespace
}  // namespace tactile::bench

int main(int argc, char** argv) {
  using namespace tactile;
  using namespace tactile::bench;
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  try {
    if (arguments.size() >= 2 && arguments[0] == "--read") {
      const auto threads = static_cast<unsigned>(arguments.size() > 2 ? std::stoul(arguments[2]) : 1);
      std::size_t count = 0;
      const double begin = wall_seconds();
      events::RecordingReader recording(arguments[1], threads);
      events::for_all_events(recording, events::event_stream(recording).id,
                             [&](std::span<const events::Event> events) { count += events.size(); });
      fmt::print("{} {:.6f}\n", count, wall_seconds() - begin);
      return 0;
    }
    std::vector<fs::path> recordings;
    for (std::size_t i = 1; i < arguments.size(); ++i) {
      if (!arguments[i].starts_with("--")) recordings.emplace_back(arguments[i]);
    }
    if (recordings.empty()) throw Error("recording_benchmark: expected FOLDER RECORDING… or --read FILE [THREADS]");
    run(arguments[0], recordings, argc, argv);
    return 0;
  } catch (const std::exception& e) {
    fmt::print(stderr, "{}\n", e.what());
    return 1;
  }
}
