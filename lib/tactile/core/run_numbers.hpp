#pragma once

#include <filesystem>
#include <set>
#include <string>

namespace tactile {

inline constexpr int most_runs = 99;  ///< of an object

/// The numbers of the runs of an object: every folder or file in `object` that has a run's name. Empty without such a folder.
/// @throws Error  if the folder cannot be read
std::set<int> run_numbers_in(const std::filesystem::path& object);

/// "07" for 7. @param number  1 to 99
std::string run_id_of(int number);

}  // namespace tactile
