#include "tactile/bags/bag.hpp"

#include <fmt/core.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <fstream>

#include "tactile/bags/bag_chunk.hpp"
#include "tactile/bags/bag_file.hpp"
#include "tactile/bags/mcap_bag.hpp"
#include "tactile/bags/ros_bag.hpp"
#include "tactile/bags/ros_fields.hpp"
#include "tactile/bags/sqlite_bag.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/text.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::bags {
namespace fs = std::filesystem;
namespace {

constexpr std::uint32_t zstd_magic = 0xFD2F'B528;
constexpr std::uint64_t most_expansion = 1'000;  // of a compressed file; those of cameras shrink to a third at best
constexpr std::size_t most_files = 65'536;

/// The extension in lower-case letters, without ".zstd".
std::string extension_of(fs::path file) {
  if (lower_case(file.extension().string()) == ".zstd") file = file.stem();
  return lower_case(file.extension().string());
}

bool is_ros2_name(const fs::path& file) {
  const std::string extension = extension_of(file);
  return extension == ".db3" || extension == ".mcap";
}

/// Names in the order of the numbers in them: part_9 is before part_10.
bool is_before(const fs::path& a, const fs::path& b) {
  const auto key = [](const fs::path& file) {
    std::string made, digits;
    for (const char c : file.filename().string() + "\n") {
      if (c >= '0' && c <= '9') {
        digits += c;
        continue;
      }
      if (!digits.empty()) made += std::string(20 - std::min<std::size_t>(digits.size(), 20), '0') + digits;
      digits.clear();
      made += c;
    }
    return made;
  };
  return key(a) < key(b);
}

/// A file of the folder for temporary files with what `compressed` contains, as far as it can be decompressed.
class UnpackedFile {
 public:
  explicit UnpackedFile(const BagFile& compressed)
      : folder_(fs::temp_directory_path() / "tactile-bag"), path_(folder_.path() / "bag") {
    const std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context(ZSTD_createDCtx(), ZSTD_freeDCtx);
    std::vector<std::byte> in(ZSTD_DStreamInSize()), out(ZSTD_DStreamOutSize());
    std::ofstream file(path_, std::ios::binary);
    std::uint64_t at = 0, written = 0;
    for (bool is_sound = true; is_sound && at < compressed.size();) {
      const auto size = static_cast<std::size_t>(std::min<std::uint64_t>(in.size(), compressed.size() - at));
      compressed.read(at, std::span(in).first(size));
      at += size;
      ZSTD_inBuffer input{in.data(), size, 0};
      while (is_sound) {
        ZSTD_outBuffer output{out.data(), out.size(), 0};
        is_sound = ZSTD_isError(ZSTD_decompressStream(context.get(), &output, &input)) == 0U;
        file.write(reinterpret_cast<const char*>(out.data()), static_cast<std::streamsize>(output.pos));
        written += output.pos;
        if (written > most_expansion * compressed.size())
          throw Error(compressed.name() + ": expands to more than a thousand times its size; expected a compressed bag");
        if (input.pos == input.size && output.pos < output.size) break;
      }
    }
    file.close();
    if (!file)
      throw Error(fmt::format("{}: cannot be decompressed into {}; expected room there", compressed.name(),
                              folder_.path().parent_path().string()));
  }

  const fs::path& path() const { return path_; }

 private:
  PartFolder folder_;
  fs::path path_;
};

std::unique_ptr<BagReader> open_file(const fs::path& path) {
  std::array<std::byte, 8> begin{};
  BagFile(path).read(0, begin);
  if (begin[0] == std::byte{0x89}) return std::make_unique<McapReader>(path);
  if (begin[0] == std::byte{'S'}) return std::make_unique<SqliteBagReader>(path);
  if (begin[0] == std::byte{'#'}) return std::make_unique<RosBagReader>(path);
  throw Error(path.string() + ": does not begin as a bag; expected one of ROS 1 (.bag) or ROS 2 (.db3, .mcap)");
}

/// The files of a bag, one after another. Messages that zstd compressed one by one are decompressed.
class BagOfFiles : public BagReader {
 public:
  explicit BagOfFiles(std::vector<fs::path> files) : files_(std::move(files)) {
    for (const fs::path& file : files_) size_ += BagFile(file).size();
    open(0);
  }

  std::optional<BagMessage> next() override {
    for (;;) {
      auto message = current_->next();
      if (!message) {
        if (index_ + 1 == files_.size()) return std::nullopt;
        passed_ += current_size_;
        before_ += current_->problems();
        open(index_ + 1);
        continue;
      }
      if (message->connection->serialisation != RosSerialisation::cdr || message->data.size() < sizeof zstd_magic ||
          number_at<std::uint32_t>(message->data) != zstd_magic)
        return message;
      if (const auto contents = chunk_.zstd_message(message->data)) {
        message->data = *contents;
        return message;
      }
      ++before_.broken_records;
    }
  }

  void rewind() override {
    before_ = {};
    passed_ = 0;
    if (index_ == 0) return current_->rewind();
    open(0);
  }

  std::uint64_t bytes_read() const override {
    // A file that is decompressed has another size than the bag's.
    const std::uint64_t all = current_->file_size(), done = current_->bytes_read();
    const double part = all == 0 ? 0 : static_cast<double>(done) / static_cast<double>(all);
    return passed_ + (done == all ? current_size_ : static_cast<std::uint64_t>(part * static_cast<double>(current_size_)));
  }
  std::uint64_t file_size() const override { return size_; }
  const BagProblems& problems() const override {
    sum_ = before_;
    sum_ += current_->problems();
    return sum_;
  }
  std::string_view format() const override { return current_->format(); }

 private:
  void open(std::size_t index) {
    const BagFile file(files_.at(index));
    std::array<std::byte, sizeof zstd_magic> begin{};
    file.read(0, begin);
    current_.reset();
    unpacked_.reset();
    if (number_at<std::uint32_t>(begin) == zstd_magic) unpacked_ = std::make_unique<UnpackedFile>(file);
    current_ = open_file(unpacked_ ? unpacked_->path() : files_.at(index));
    current_size_ = file.size();
    index_ = index;
  }

  std::vector<fs::path> files_;
  std::size_t index_ = 0;
  std::unique_ptr<UnpackedFile> unpacked_;
  std::unique_ptr<BagReader> current_;
  std::uint64_t size_ = 0, passed_ = 0, current_size_ = 0;
  BagChunk chunk_;
  BagProblems before_;  ///< of the files before the current one, and of compressed messages
  mutable BagProblems sum_;
};

}  // namespace

BagProblems& BagProblems::operator+=(const BagProblems& more) {
  truncated_bytes += more.truncated_bytes;
  broken_chunks += more.broken_chunks;
  broken_records += more.broken_records;
  unknown_messages += more.unknown_messages;
  return *this;
}

bool is_bag(const fs::path& place) {
  std::error_code unknown;
  if (!fs::is_directory(place, unknown)) return extension_of(place) == ".bag" || is_ros2_name(place);
  for (fs::directory_iterator entry(place, unknown), end; !unknown && entry != end; entry.increment(unknown)) {
    if (is_ros2_name(entry->path())) return true;
  }
  return false;
}

std::vector<fs::path> files_of_bag(const fs::path& place) {
  if (!fs::is_directory(place)) {
    if (!fs::exists(place)) throw Error(place.string() + ": no such file; expected a bag");
    return {place};
  }
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(place)) {
    if (is_ros2_name(entry.path()) && entry.is_regular_file()) files.push_back(entry.path());
    if (files.size() > most_files)
      throw Error(fmt::format("{}: has more than {} files; expected a bag", place.string(), most_files));
  }
  if (files.empty()) throw Error(place.string() + ": has no .db3 or .mcap file; expected the folder of a ROS 2 bag");
  std::sort(files.begin(), files.end(), is_before);
  return files;
}

std::unique_ptr<BagReader> open_bag(const fs::path& place) { return std::make_unique<BagOfFiles>(files_of_bag(place)); }

}  // namespace tactile::bags
