#include "tactile/model/training/training_log.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "support/temporary_folder.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::model {
namespace {

namespace fs = std::filesystem;

std::string bytes_of(const std::string& hexadecimal) {
  std::string bytes;
  for (std::size_t i = 0; i < hexadecimal.size(); i += 2)
    bytes += static_cast<char>(std::stoi(hexadecimal.substr(i, 2), nullptr, 16));
  return bytes;
}

/// Written by the RecordWriter and the protobuf messages of tensorboard 2.21.0.
TEST(EventFile, HasTheBytesOfTensorBoardsOwnWriter) {
  const std::string written = bytes_of(
      "1800000000000000a37f4b220900001040fc54d9411a0d627261696e2e4576656e743a32338d2fe90f000000000000006d53"
      "2b090900001040fc54d94110033a0208019481124c3800000000000000a3797d570900006040fc54d94110ac022a2a0a110a"
      "0a747261696e2f6c6f7373150000003e0a150a0e747261696e2f6163637572616379150000403f5c61a212");
  EXPECT_EQ(version_record(1700000000.25) + restart_record(1700000000.25, 3) +
                scalars_record(1700000001.5, 300, {{"train/loss", 0.125F}, {"train/accuracy", 0.75F}}),
            written);
}

std::vector<fs::path> files_in(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

/// The records of a file without their wall time, which is the first of their fields.
std::vector<std::string> records_of(const fs::path& file) {
  const std::string bytes = read_text(file);
  constexpr std::size_t head = 12, foot = 4, wall_time = 9;
  std::vector<std::string> records;
  for (std::size_t at = 0; at < bytes.size();) {
    const std::size_t length = static_cast<unsigned char>(bytes[at]);
    records.push_back(bytes.substr(at + head + wall_time, length - wall_time));
    at += head + length + foot;
  }
  return records;
}

std::vector<EpochResult> epochs(unsigned count) {
  std::vector<EpochResult> history(count);
  for (unsigned i = 0; i < count; ++i) {
    history[i].epoch = i + 1;
    history[i].loss = 1.0 / (i + 1);
    history[i].accuracy = 0.5;
    history[i].learning_rate = 0.001;
    history[i].images_per_s = 100;
  }
  return history;
}

std::string scalars_of(const EpochResult& epoch) {
  constexpr std::size_t head = 12, foot = 4, wall_time = 9;
  const std::string record = scalars_record(0, epoch.epoch,
                                            {{"train/loss", static_cast<float>(epoch.loss)},
                                             {"train/accuracy", static_cast<float>(epoch.accuracy)},
                                             {"learning_rate", static_cast<float>(epoch.learning_rate)},
                                             {"gradient_norm", 0.0F},
                                             {"images_per_s", 100.0F}});
  return record.substr(head + wall_time, record.size() - head - wall_time - foot);
}

TEST(TrainingLog, HasEachFinishedEpochOnceHoweverOftenItIsSeen) {
  const test::TemporaryFolder folder;
  TrainingLog log(folder / "history.csv", folder / "board/mine");
  EXPECT_FALSE(fs::exists(folder / "history.csv")) << "no epoch is finished";
  log.see(epochs(1));
  EXPECT_EQ(read_history(folder / "history.csv").size(), 1U);
  log.see(epochs(1));
  log.see(epochs(3));
  EXPECT_EQ(read_text(folder / "history.csv"), history_csv(epochs(3)));
  const auto files = files_in(folder / "board/mine");
  ASSERT_EQ(files.size(), 1U);
  EXPECT_NE(files.front().filename().string().find("tfevents"), std::string::npos) << "TensorBoard reads no other names";
  const auto records = records_of(files.front());
  ASSERT_EQ(records.size(), 4U);
  for (unsigned i = 0; i < 3; ++i) EXPECT_EQ(records[i + 1], scalars_of(epochs(3)[i])) << i;
}

TEST(TrainingLog, ReplacesWhatAnInterruptedTrainingSawAfterItsLastState) {
  const test::TemporaryFolder folder;
  {
    TrainingLog killed(folder / "history.csv", folder / "board");
    killed.see(epochs(3));
  }
  TrainingLog log(folder / "history.csv", folder / "board");
  log.begin(epochs(2));
  EXPECT_EQ(read_text(folder / "history.csv"), history_csv(epochs(2)));
  log.see(epochs(3));
  const auto files = files_in(folder / "board");
  ASSERT_EQ(files.size(), 2U);
  const auto records = records_of(files.back());
  ASSERT_EQ(records.size(), 3U);
  EXPECT_EQ(records[1], bytes_of("10033a020801")) << "step 3, and the start of a session";
  EXPECT_EQ(records[2], scalars_of(epochs(3).back()));
}

TEST(TrainingLog, AlsoHasTheEpochsBeforeItWasAskedFor) {
  const test::TemporaryFolder folder;
  TrainingLog log(folder / "history.csv", folder / "board");
  log.begin(epochs(2));
  EXPECT_EQ(records_of(files_in(folder / "board").front()).size(), 3U);
}

}  // namespace
}  // namespace tactile::model
