#include "tactile/pictures/picture_folder.hpp"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <set>
#include <string>
#include <system_error>

#include "tactile/core/error.hpp"
#include "tactile/core/table_file.hpp"
#include "tactile/video/picture_codec.hpp"

namespace tactile::pictures {
namespace fs = std::filesystem;
namespace {

constexpr const char* list_name = "pictures.csv";

/// A link to a folder stands for the folder, and a name that ends in a slash for one without.
fs::path folder_meant(const fs::path& target) {
  std::error_code failed;
  fs::path there = fs::canonical(target, failed);
  if (!failed) return there;
  const fs::path plain = fs::absolute(target).lexically_normal();
  return plain.has_filename() ? plain : plain.parent_path();
}

/// What a list in the folder names, itself included; nothing where there is none.
std::set<fs::path> listed_in(const fs::path& folder) {
  std::set<fs::path> names;
  try {
    TableFile list(folder / list_name, {.name = "the list of the pictures", .header = "file"});
    if (list.names().size() < 2 || list.names().front() != "file" || list.separator() != ',') return names;
    names.insert(list_name);
    while (list.next()) {
      if (!list.is_blank()) names.insert(list.cells().front());
    }
  } catch (const Error&) {
    return {};  // no list of ours
  }
  return names;
}

}  // namespace

void check_picture_folder(const fs::path& target) {
  const fs::path folder = folder_meant(target);
  if (!fs::exists(folder)) return;
  if (!fs::is_directory(folder))
    throw Error(target.string() + ": is a file; expected a folder for pictures, or a name that is free");
  const std::set<fs::path> ours = listed_in(folder);
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder)) {
    const fs::path name = entry.path().lexically_relative(folder);
    if ((entry.is_directory() && !entry.is_symlink()) || ours.contains(name)) continue;
    throw Error(target.string() + ": holds " + name.string() +
                ", which is no picture that its pictures.csv lists; expected an empty folder, one of pictures made before, or a "
                "name that is free");
  }
}

PictureFolder::PictureFolder(const fs::path& target, const std::string& columns)
    : target_(folder_meant(target)),
      whole_((check_picture_folder(target), target_), fs::exists(target_) ? IfThere::replace : IfThere::refuse),
      table_("file," + columns) {
  std::error_code failed;
  fs::create_directory(whole_.path(), failed);
  if (failed) throw Error(target.string() + ": the folder cannot be made (" + failed.message() + "); expected a writable place");
}

void PictureFolder::write(const std::string& name, const cv::Mat& picture) const {
  const fs::path file = whole_.path() / name;
  const std::vector<unsigned char> bytes = video::png_of(picture, (target_ / name).string());
  std::error_code failed;
  fs::create_directories(file.parent_path(), failed);
  std::ofstream out(file, std::ios::binary);
  out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  out.close();
  if (!out)
    throw Error((target_ / name).string() + ": cannot be written (" + std::strerror(errno) +
                "); expected a writable place with room");
}

void PictureFolder::commit() {
  write_whole(whole_.path() / list_name, table_.text());
  check_picture_folder(target_);  // once more: somebody may have put other files into it meanwhile
  whole_.commit();
}

}  // namespace tactile::pictures
