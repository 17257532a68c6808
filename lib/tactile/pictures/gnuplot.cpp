#include "tactile/pictures/gnuplot.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <iterator>
#include <optional>
#include <system_error>
#include <utility>

#include "tactile/core/error.hpp"
#include "tactile/core/process.hpp"
#include "tactile/core/text_lines.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::pictures {
namespace {

constexpr std::size_t largest_picture = std::size_t{256} << 20;  // [B]
constexpr std::size_t kept_words = 8192;                         // [B] of what gnuplot complains of

/// A file descriptor, closed when it goes. It is not handed down to other programs.
class Descriptor {
 public:
  explicit Descriptor(int number = -1) : number_(number) {}
  ~Descriptor() { close(); }
  Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(number_, other.number_);
    return *this;
  }
  int number() const { return number_; }
  bool is_open() const { return number_ >= 0; }
  void close() {
    if (is_open()) ::close(std::exchange(number_, -1));
  }

 private:
  int number_;
};

[[noreturn]] void fail_to_run(int error) {
  throw Error(fmt::format("gnuplot: cannot be run ({}); expected free processes and files, and room for files",
                          std::error_code(error, std::generic_category()).message()));
}

/// A file in memory without a name that holds `text`.
Descriptor file_in_memory(std::string_view text) {
  Descriptor file(::memfd_create("figure", MFD_CLOEXEC));
  if (!file.is_open()) fail_to_run(errno);
  while (!text.empty()) {
    const ssize_t written = ::write(file.number(), text.data(), text.size());
    if (written < 0 && errno != EINTR) fail_to_run(errno);
    if (written > 0) text.remove_prefix(static_cast<std::size_t>(written));
  }
  if (::lseek(file.number(), 0, SEEK_SET) != 0) fail_to_run(errno);
  return file;
}

/// {ours, the child's}.
std::pair<Descriptor, Descriptor> make_pipe() {
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) fail_to_run(errno);
  return {Descriptor(ends[0]), Descriptor(ends[1])};
}

/// A running gnuplot; ended when it goes.
class Gnuplot {
 public:
  explicit Gnuplot(std::string_view script) {
    const Descriptor child_in = file_in_memory(script);
    auto [from_child, child_out] = make_pipe();
    auto [words, child_err] = make_pipe();
    // In a group of its own, Ctrl-C does not reach it: the current picture is finished. -d: it reads no settings of the user. It
    // reads a named file in large parts, but its standard input byte by byte.
    try {
      process_.emplace(ProcessOptions{.program = "gnuplot",
                                      .arguments = {"-d", "/dev/stdin"},
                                      .in = child_in.number(),
                                      .out = child_out.number(),
                                      .err = child_err.number(),
                                      .own_group = true});
    } catch (const std::system_error& e) {
      if (e.code().value() == ENOENT)
        throw Error("gnuplot: is not installed; expected it for pictures; 'apt install gnuplot-nox' installs it");
      fail_to_run(e.code().value());
    }
    from_child_ = std::move(from_child);
    words_ = std::move(words);
  }
  struct Answer {
    std::string picture;
    std::string words;
    int status = 0;  ///< of `waitpid`
  };

  Answer answer() {
    Answer answer;
    while (from_child_.is_open() || words_.is_open()) {
      // poll passes over one that is closed, whose number is -1.
      std::array<pollfd, 2> ends{{{from_child_.number(), POLLIN, 0}, {words_.number(), POLLIN, 0}}};
      if (::poll(ends.data(), ends.size(), -1) < 0 && errno != EINTR) fail_to_run(errno);
      if (ends[0].revents != 0) answer.picture += some_of(from_child_);
      if (ends[1].revents != 0) answer.words += some_of(words_);
      if (answer.picture.size() > largest_picture)
        throw Error(fmt::format("gnuplot: the picture is larger than {} MB; expected a smaller one", largest_picture >> 20));
      // Its last message is the reason why it ended.
      if (answer.words.size() > kept_words) answer.words.erase(0, answer.words.size() - kept_words);
    }
    answer.status = process_->wait();
    return answer;
  }

 private:
  /// What comes; closes what has ended.
  static std::string some_of(Descriptor& from) {
    std::string part(65536, '\0');
    const ssize_t taken = ::read(from.number(), part.data(), part.size());
    const bool again = taken < 0 && errno == EINTR;
    part.resize(taken > 0 ? static_cast<std::size_t>(taken) : 0);
    if (taken <= 0 && !again) from.close();
    return part;
  }

  Descriptor from_child_, words_;
  std::optional<ChildProcess> process_;
};

/// Its last line: gnuplot prints the command, a mark at the place, and what it expected there.
std::string complaint_in(const std::string& words) {
  std::string last;
  for (std::size_t begin = 0; begin < words.size();) {
    const std::size_t end = std::min(words.find('\n', begin), words.size());
    std::string line = words.substr(begin, end - begin);
    line.erase(0, line.find_first_not_of(" \t"));
    if (constexpr std::string_view input = "\"/dev/stdin\" "; line.starts_with(input)) line.erase(0, input.size());
    line.erase(line.find_last_not_of(" \t\r") + 1);
    if (!line.empty()) last = line;
    begin = end + 1;
  }
  return last;
}

std::string terminal_for(const std::filesystem::path& file) {
  if (file.extension() == ".png") return "pngcairo noenhanced";
  // A point is 4/3 px here as there: what places words by their size in the one finds it in the other.
  if (file.extension() == ".svg") return "svg noenhanced fontscale 1.33333 background rgb 'white'";
  throw Error(fmt::format("{}: is no picture that can be drawn; expected .png or .svg", file.string()));
}

void check(const Plot& plot) {
  constexpr int least = 100, most = 10'000;
  for (const int side : {plot.width_px, plot.height_px}) {
    if (side < least || side > most)
      throw Error(fmt::format("figure: {} x {} pixels; expected {} to {} for both", plot.width_px, plot.height_px, least, most));
  }
  for (const PlotTable& table : plot.tables) {
    const auto fits = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; };
    if (table.name.empty() || std::isalpha(static_cast<unsigned char>(table.name[0])) == 0 ||
        !std::all_of(table.name.begin(), table.name.end(), fits))
      throw Error(
          fmt::format("figure: a table is called '{}'; expected a letter, then letters, digits and underscores", table.name));
    if (table.columns == 0 || table.values.size() % table.columns != 0) {
      throw Error(fmt::format("figure: table {} has {} values in rows of {}; expected whole rows", table.name,
                              table.values.size(), table.columns));
    }
  }
}

void add_table(std::string& script, const PlotTable& table) {
  fmt::format_to(std::back_inserter(script), "${} << end_of_table\n", table.name);
  for (std::size_t i = 0; i < table.values.size(); ++i) {
    const char separator = (i + 1) % table.columns == 0 ? '\n' : ' ';
    if (std::isfinite(table.values[i]))
      fmt::format_to(std::back_inserter(script), "{:.9g}{}", table.values[i], separator);
    else
      fmt::format_to(std::back_inserter(script), "NaN{}", separator);
  }
  script += "end_of_table\n";
}

}  // namespace

std::string plot_text(std::string_view text) {
  // Within single quotes gnuplot replaces nothing. A quote written twice would stand for itself, but not as a text's first
  // character (gnuplot 5.4), so that the typographic one takes its place.
  std::string quoted = "'";
  while (!text.empty()) {
    const std::size_t length = character_at(text);
    const auto first = static_cast<unsigned char>(text[0]);
    if (length == 0)
      quoted += '?';
    else if (first < 0x20 || first == 0x7F)
      quoted += ' ';
    else if (first == '\'')
      quoted += "\u2019";
    else
      quoted += text.substr(0, length);
    text.remove_prefix(std::max<std::size_t>(length, 1));
  }
  return quoted + "'";
}

void check_is_picture(const std::filesystem::path& file) { terminal_for(file); }

void draw(const Plot& plot, const std::filesystem::path& file) {
  check(plot);
  std::string script = fmt::format("set encoding utf8\nset minussign\nset terminal {} size {},{} font 'DejaVu Sans,10'\n",
                                   terminal_for(file), plot.width_px, plot.height_px);
  for (const PlotTable& table : plot.tables) add_table(script, table);
  script += plot.script;
  script += "\nunset multiplot\nunset output\n";
  const Gnuplot::Answer answer = Gnuplot(script).answer();
  if (!WIFEXITED(answer.status)) {
    throw Error(fmt::format("{}: gnuplot was ended by signal {}; expected it to draw the picture", file.string(),
                            WTERMSIG(answer.status)));
  }
  if (WEXITSTATUS(answer.status) != 0 || answer.picture.empty()) {
    const std::string complaint = complaint_in(answer.words);
    throw Error(fmt::format("{}: gnuplot could not draw it ({}); expected a script that it knows, and numbers within its axes",
                            file.string(), complaint.empty() ? "no message" : complaint));
  }
  write_whole(file, answer.picture);
}

}  // namespace tactile::pictures
