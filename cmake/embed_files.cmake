# Writes a C++ file with the contents of files, as tactile::review::web_files() returns them. To be run by cmake -P with OUT, the file to
# write, and FILES, separated by |; each is served under its own name.
string(REPLACE "|" ";" FILES "${FILES}")
set(arrays "")
set(entries "")
set(count 0)
foreach(file IN LISTS FILES)
  get_filename_component(name "${file}" NAME)
  file(READ "${file}" bytes HEX)
  string(LENGTH "${bytes}" digits)
  math(EXPR size "${digits} / 2")
  # A text of escapes compiles faster than a list of numbers; pieces keep it below what compilers must take.
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "\\\\x\\1" bytes "${bytes}")
  string(REGEX REPLACE "((\\\\x[0-9a-f][0-9a-f])(\\\\x[0-9a-f][0-9a-f])?(\\\\x[0-9a-f][0-9a-f])?(\\\\x[0-9a-f][0-9a-f])?(\\\\x[0-9a-f][0-9a-f])?(\\\\x[0-9a-f][0-9a-f])?(\\\\x[0-9a-f][0-9a-f])?(\\\\x[0-9a-f][0-9a-f])?)" "  \"\\1\"\n" bytes "${bytes}")
  string(APPEND arrays "constexpr char content_${count}[] =\n${bytes}  \"\";\n")
  string(APPEND entries "    {\"${name}\", std::string_view(content_${count}, ${size})},\n")
  math(EXPR count "${count} + 1")
endforeach()
file(WRITE "${OUT}" "// Made by cmake/embed_files.cmake.
#include <array>

#include \"tactile/review/web_files.hpp\"

namespace tactile::review {
namespace {

${arrays}
constexpr std::array<WebFile, ${count}> files{{
${entries}}};

}  // namespace

std::span<const WebFile> web_files() { return files; }

}  // namespace tactile::review
")
