# Writes version.cpp with the version of the project and the git revision.
execute_process(
  COMMAND git -C ${SOURCE_DIR} describe --always --dirty --abbrev=12
  OUTPUT_VARIABLE revision OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
if(failed)
  set(revision "unknown revision")
endif()
set(text "#include \"tactile/core/version.hpp\"\n\nnamespace tactile {\nstd::string_view version() { return \"${VERSION}\"; }\nstd::string_view revision() { return \"${revision}\"; }\n}  // namespace tactile\n")
set(old "")
if(EXISTS ${OUTPUT})
  file(READ ${OUTPUT} old)
endif()
if(NOT text STREQUAL old)
  file(WRITE ${OUTPUT} "${text}")
endif()
