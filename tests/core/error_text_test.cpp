#include "tactile/core/error_text.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <new>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "support/error_of.hpp"
#include "support/temporary_folder.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/json_text.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile {
namespace {

/// What `sentence_of` makes of what `action` throws.
template <class Action>
std::string sentence_after(const Action& action) {
  try {
    action();
  } catch (const std::exception& e) {
    return sentence_of(e);
  }
  ADD_FAILURE() << "nothing was thrown";
  return {};
}

TEST(SentenceOf, LeavesAnErrorAsItIs) {
  EXPECT_EQ(sentence_of(Error("fan/03: no event; expected some")), "fan/03: no event; expected some");
}

TEST(SentenceOf, NamesThePathAndTheReasonOfAFileSystemsError) {
  const test::TemporaryFolder folder;
  std::filesystem::create_symlink("loop", folder / "loop");
  EXPECT_EQ(sentence_after([&] { return std::filesystem::is_directory(folder / "loop"); }),
            (folder / "loop").string() +
                ": cannot be used (Too many levels of symbolic links); expected a file or folder that can be read, and written "
                "if it is an output");
}

TEST(SentenceOf, PutsMemoryAndJsonIntoPlainWords) {
  for (const std::string& sentence : {sentence_of(std::bad_alloc()), sentence_of(std::bad_array_new_length()),
                                      sentence_of(std::length_error("vector::_M_default_append"))})
    EXPECT_EQ(sentence, "not enough memory; expected more memory, fewer --threads, or a smaller recording");
  EXPECT_TRUE(sentence_of(std::bad_alloc(), "fan/03").starts_with("fan/03: not enough memory"));
  EXPECT_EQ(sentence_of(Error("fan/03/robot.csv: no row"), "fan/03"), "fan/03/robot.csv: no row") << "it names the file itself";
  const nlohmann::json list = nlohmann::json::array({1});
  EXPECT_EQ(sentence_after([&] { list.value("key", 1); }),
            "a value in a JSON file is a list; expected an object or a list; expected a file as tactile writes it");
}

TEST(Member, ReportsWhatItIsAndWhatIsExpected) {
  const nlohmann::json json = {{"class", 5}, {"list", "a"}, {"number", {1}}, {"truth", nullptr}, {"text", {{"a", 1}}}};
  const auto text_of = [&](auto type, const char* key) {
    return test::error_of([&] { member<decltype(type)>(json, key, "labels.json"); });
  };
  EXPECT_EQ(text_of(std::string(), "class"), "labels.json: 'class' is a number; expected a text");
  EXPECT_EQ(text_of(std::vector<int>(), "list"), "labels.json: 'list' is a text; expected a list");
  EXPECT_EQ(text_of(0.5, "number"), "labels.json: 'number' is a list; expected a number");
  EXPECT_EQ(text_of(true, "truth"), "labels.json: 'truth' is null; expected true or false");
  EXPECT_EQ(text_of(std::string(), "text"), "labels.json: 'text' is an object; expected a text");
}

TEST(JsonText, TakesNamesThatAreNoUtf8) {
  const nlohmann::json json = {{"name", "caf\xE9"}};
  EXPECT_EQ(json_text(json), "{\"name\":\"caf\xEF\xBF\xBD\"}");
  EXPECT_EQ(hash_of(json).size(), 64U);
  EXPECT_EQ(differences(json, {{"name", 1}}), "name: \"caf\xEF\xBF\xBD\" before, 1 now");
}

TEST(ReadText, NamesALinkThatLeadsToItself) {
  const test::TemporaryFolder folder;
  std::filesystem::create_symlink("labels.json", folder / "labels.json");
  EXPECT_EQ(test::error_of([&] { read_text(folder / "labels.json"); }),
            (folder / "labels.json").string() + ": cannot be read (Too many levels of symbolic links); expected a readable file");
}

TEST(SentenceOf, NamesTheOutputAndNotTheHiddenFolderInWhichItIsMade) {
  const auto sentence = [](const std::string& text) { return sentence_of(Error(text)); };
  EXPECT_EQ(sentence("data/.01.part-Ab3Xyz/01/events.aedat4: full"), "data/01/events.aedat4: full");
  EXPECT_EQ(sentence(".a.csv.part-Ab3Xyz/a.csv: full, as './.b.part-Ab3Xyw/b'"), "a.csv: full, as './b'");
  EXPECT_EQ(sentence("my.part-7/a.csv: full"), "my.part-7/a.csv: full");
  EXPECT_EQ(sentence("my.part-Ab3Xyz/a.csv: full"), "my.part-Ab3Xyz/a.csv: full");
  EXPECT_EQ(sentence(".a.part-Ab3Xyz: full"), ".a.part-Ab3Xyz: full");
}

}  // namespace
}  // namespace tactile
