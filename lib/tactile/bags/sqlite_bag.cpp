#include "tactile/bags/sqlite_bag.hpp"

#include <fmt/core.h>
#include <sqlite3.h>

#include <algorithm>
#include <array>
#include <limits>
#include <map>

#include "tactile/bags/bag_chunk.hpp"
#include "tactile/bags/bag_file.hpp"
#include "tactile/core/error.hpp"

namespace tactile::bags {
namespace fs = std::filesystem;
namespace {

constexpr int steps_between_checks = 10'000;
constexpr int most_checks = 10'000;  // of one row: 10^8 steps are seconds, and a row of a plain table takes tens
constexpr int most_errors = 4096;    // broken places that are passed over

struct CloseDatabase {
  void operator()(sqlite3* database) const { sqlite3_close(database); }
};
struct Finalise {
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};
using Database = std::unique_ptr<sqlite3, CloseDatabase>;
using Statement = std::unique_ptr<sqlite3_stmt, Finalise>;

/// The path in the form of SQLite's URIs, in which some characters have a meaning.
std::string uri_of(const fs::path& file, const char* mode) {
  std::string uri = "file:";
  for (const char c : fs::absolute(file).string()) {
    if (c == '%' || c == '?' || c == '#') {
      uri += fmt::format("%{:02X}", static_cast<unsigned>(c));
    } else {
      uri += c;
    }
  }
  return uri + "?" + mode;
}

std::string text_at(sqlite3_stmt* row, int column) {
  const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(row, column));
  return text == nullptr ? std::string() : std::string(text, static_cast<std::size_t>(sqlite3_column_bytes(row, column)));
}

}  // namespace

struct SqliteBagReader::State {
  explicit State(const fs::path& of) : path(of), file(of) {
    std::array<std::byte, 32> begin{};
    file.read(0, begin);
    const std::string_view magic("SQLite format 3\0", 16);
    if (std::string_view(reinterpret_cast<const char*>(begin.data()), magic.size()) != magic)
      throw Error(file.name() + ": does not begin as an SQLite file; expected a .db3 of ROS 2");
    // A file whose recorder was killed may have a log that only its folder's owner may read. Then the file itself must do.
    reopen();
    read_topics();
    const auto byte_at = [&](std::size_t i) { return std::to_integer<std::uint64_t>(begin.at(i)); };
    const std::uint64_t page = (byte_at(16) << 8 | byte_at(17)) == 1 ? 65'536 : byte_at(16) << 8 | byte_at(17);
    const std::uint64_t pages = byte_at(28) << 24 | byte_at(29) << 16 | byte_at(30) << 8 | byte_at(31);
    missing_bytes = pages * page > file.size() ? pages * page - file.size() : 0;
    std::error_code no_log;
    const std::uintmax_t log = fs::file_size(path.string() + "-wal", no_log);  // rows that are not in the file yet
    most_bytes = file.size() + (no_log ? 0 : log);
    restart();
  }

  fs::path path;
  BagFile file;
  Database database;
  Statement select;
  std::map<std::int64_t, BagConnection> topics;
  std::uint64_t missing_bytes = 0;  ///< of the pages that the file's header counts
  std::int64_t newest_row = 0;
  std::uint64_t given_bytes = 0;
  std::uint64_t most_bytes = 0;  ///< of all rows
  std::uint64_t row_bytes = 0;   ///< that the rows so far take in the file, at least
  int checks = 0, errors = 0;
  bool is_done = false;
  BagProblems problems;

  [[noreturn]] void fail(const char* what) const {
    throw Error(fmt::format("{}: {} ({}); expected a ROS 2 bag with the tables topics and messages", file.name(), what,
                            database ? sqlite3_errmsg(database.get()) : "out of memory"));
  }

  /// Of a damaged file, SQLite may give other rows once it has pages in memory: each reading begins with none.
  void reopen() {
    select.reset();
    if (!open("mode=ro") && !open("mode=ro&immutable=1")) fail("cannot be read");
  }

  bool open(const char* mode) {
    sqlite3* opened = nullptr;
    const int result = sqlite3_open_v2(uri_of(path, mode).c_str(), &opened,
                                       SQLITE_OPEN_READONLY | SQLITE_OPEN_URI | SQLITE_OPEN_NOMUTEX, nullptr);
    database.reset(opened);
    if (result != SQLITE_OK) return false;
    const auto most = static_cast<int>(std::min<std::uint64_t>(most_chunk, std::max<std::uint64_t>(file.size(), 1U << 20)));
    sqlite3_limit(opened, SQLITE_LIMIT_LENGTH, most);  // before memory is allocated for a row
    sqlite3_db_config(opened, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
    sqlite3_progress_handler(
        opened, steps_between_checks, [](void* state) { return ++static_cast<State*>(state)->checks > most_checks ? 1 : 0; },
        this);
    // Without the first, a file that is shorter than its header says cannot be read at all. The file itself stays read-only.
    const char* settings = "PRAGMA writable_schema = ON; PRAGMA cell_size_check = ON; SELECT count(*) FROM sqlite_schema";
    checks = 0;
    return sqlite3_exec(opened, settings, nullptr, nullptr, nullptr) == SQLITE_OK;
  }

  Statement prepare(const char* sql) {
    sqlite3_stmt* made = nullptr;
    if (sqlite3_prepare_v2(database.get(), sql, -1, &made, nullptr) != SQLITE_OK) fail("cannot be read");
    return Statement(made);
  }

  void read_topics() {
    checks = 0;
    const Statement tables = prepare(
        "SELECT count(*) FROM sqlite_schema WHERE type = 'table' AND rootpage > 0 "
        "AND name IN ('topics', 'messages') AND instr(sql, 'GENERATED') + instr(sql, ' AS ') = 0");
    if (sqlite3_step(tables.get()) != SQLITE_ROW || sqlite3_column_int(tables.get(), 0) != 2)
      fail("has no tables of messages and topics");
    const Statement rows = prepare("SELECT id, name, type, serialization_format FROM topics");
    for (;;) {
      checks = 0;
      const int result = sqlite3_step(rows.get());
      if (result != SQLITE_ROW) {
        if (result != SQLITE_DONE) ++problems.broken_chunks;
        return;
      }
      BagConnection topic{.topic = text_at(rows.get(), 1), .type = text_at(rows.get(), 2)};
      if (topic.topic.size() > most_name || topic.type.size() > most_name) continue;
      if (topics.size() == most_topics)
        throw Error(fmt::format("{}: has more than {} topics; expected fewer", file.name(), most_topics));
      topic.serialisation = text_at(rows.get(), 3) == "cdr" ? RosSerialisation::cdr : RosSerialisation::other;
      if (topic.serialisation == RosSerialisation::cdr) topic.message = ros_message_named(topic.type);
      topics.insert_or_assign(sqlite3_column_int64(rows.get(), 0), topic);
    }
  }

  void restart() {
    select = prepare("SELECT rowid, topic_id, timestamp, data FROM messages WHERE rowid > ?1 ORDER BY rowid");
    problems = {.truncated_bytes = missing_bytes};
    newest_row = std::numeric_limits<std::int64_t>::min();
    given_bytes = row_bytes = 0;
    errors = 0;
    is_done = false;
    seek();
  }

  void seek() {
    sqlite3_reset(select.get());
    sqlite3_bind_int64(select.get(), 1, newest_row);
  }

  /// Continues after a place that cannot be read: with the next row, or one further away each time, as long as rows are broken.
  /// @return  false if there is none, or there were too many such places
  bool pass_over_error(std::int64_t& step) {
    if (missing_bytes == 0) ++problems.broken_chunks;
    if (++errors > most_errors || newest_row > std::numeric_limits<std::int64_t>::max() - step) return false;
    newest_row = std::max<std::int64_t>(newest_row, 0) + step;
    step = 2 * std::min(step, std::numeric_limits<std::int64_t>::max() / 2);
    seek();
    return true;
  }

  std::optional<BagMessage> next() {
    for (std::int64_t step = 1; !is_done;) {
      checks = 0;
      const int result = sqlite3_step(select.get());
      if (result == SQLITE_ROW) {
        step = 1;
        newest_row = sqlite3_column_int64(select.get(), 0);
        if (takes_more_than_the_file(select.get())) {
          ++problems.broken_chunks;
          is_done = true;
          return std::nullopt;
        }
        if (const auto message = message_of(select.get())) return message;
      } else if (result == SQLITE_DONE || !pass_over_error(step)) {
        is_done = true;
      }
    }
    return std::nullopt;
  }

  /// Pages of a damaged file may be given again and again: a file of 100 kB then has a million rows.
  bool takes_more_than_the_file(sqlite3_stmt* row) {
    constexpr std::uint64_t least_row = 4;
    row_bytes += least_row;
    if (sqlite3_column_type(row, 3) == SQLITE_BLOB) row_bytes += static_cast<std::uint64_t>(sqlite3_column_bytes(row, 3));
    return row_bytes > most_bytes;
  }

  std::optional<BagMessage> message_of(sqlite3_stmt* row) {
    const auto topic = topics.find(sqlite3_column_int64(row, 1));
    if (topic == topics.end()) {
      ++problems.unknown_messages;
      return std::nullopt;
    }
    const void* data = sqlite3_column_type(row, 3) == SQLITE_BLOB ? sqlite3_column_blob(row, 3) : nullptr;
    if (data == nullptr) {
      ++problems.broken_records;
      return std::nullopt;
    }
    const auto size = static_cast<std::size_t>(sqlite3_column_bytes(row, 3));
    given_bytes += size;
    return BagMessage{.connection = &topic->second,
                      .received = HostTime{microseconds{sqlite3_column_int64(row, 2) / 1'000}},
                      .data = {static_cast<const std::byte*>(data), size}};
  }
};

SqliteBagReader::SqliteBagReader(const fs::path& file) : state_(std::make_unique<State>(file)) {}
SqliteBagReader::~SqliteBagReader() = default;

std::optional<BagMessage> SqliteBagReader::next() { return state_->next(); }
void SqliteBagReader::rewind() {
  state_->reopen();
  state_->restart();
}
std::uint64_t SqliteBagReader::bytes_read() const {
  return state_->is_done ? file_size() : std::min(state_->given_bytes, file_size());
}
std::uint64_t SqliteBagReader::file_size() const { return state_->file.size(); }
const BagProblems& SqliteBagReader::problems() const { return state_->problems; }

}  // namespace tactile::bags
