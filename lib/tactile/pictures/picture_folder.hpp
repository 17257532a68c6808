#pragma once

#include <cstddef>
#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "tactile/core/csv_table.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::pictures {

/// A folder of pictures with a list of them, `pictures.csv`, that appears under its name only once all are in it. An existing
/// folder is replaced as a whole, but only if it is empty or contains only pictures that its list names. So no other files are
/// lost.
class PictureFolder {
 public:
  /// @param columns  of the list, separated by commas, after `file`
  /// @throws Error   if a file, or a folder with anything else in it, is in the way, or the place cannot be written
  PictureFolder(const std::filesystem::path& target, const std::string& columns);

  /// Writes a picture as PNG. May be called from several threads at a time.
  /// @param name  below the folder, such as "fan/01/a.png"
  /// @throws Error if it cannot be written
  void write(const std::string& name, const cv::Mat& picture) const;

  /// Puts a picture into the list. @param values  those of `columns`, as cells of `csv_row`
  template <class... Values>
  void list(const std::string& name, const Values&... values) {
    table_.add_row(name, values...);
    ++listed_;
  }

  std::size_t listed() const { return listed_; }

  void commit();  ///< @throws Error if it cannot be put in place; what was there then still is

 private:
  std::filesystem::path target_;
  WholeFile whole_;
  CsvTable table_;
  std::size_t listed_ = 0;
};

/// @throws Error  as making a `PictureFolder` there would: to be asked before long work
void check_picture_folder(const std::filesystem::path& target);

}  // namespace tactile::pictures
