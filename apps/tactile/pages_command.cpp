#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <string>

#include "command.hpp"
#include "commands.hpp"
#include "completion_scripts.hpp"
#include "help_text.hpp"
#include "manual_page.hpp"
#include "tactile/core/make_folders.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::cli {
namespace {

namespace fs = std::filesystem;

void write_pages(CLI::App& program, const fs::path& folder) {
  const fs::path manual = folder / "man1";
  for (const fs::path& made : {manual, folder / "bash", folder / "zsh", folder / "fish"}) make_folders(made);
  write_whole(manual / (page_name(program) + ".1"), manual_page(program));
  for (const CLI::App* command : listed_commands(program))
    write_whole(manual / (page_name(*command) + ".1"), manual_page(*command));
  // Each shell finds a script by its name.
  write_whole(folder / "bash" / "tactile", bash_completion(program));
  write_whole(folder / "zsh" / "_tactile", zsh_completion(program));
  write_whole(folder / "fish" / "tactile.fish", fish_completion(program));
}

}  // namespace

void add_pages_command(CLI::App& app) {
  auto folder = std::make_shared<std::string>();
  Command command = add_command(app, "pages", "Write man pages, and completions of bash, zsh and fish, for an installation",
                                [folder, &app](const CommonArguments&) { write_pages(app, *folder); });
  command.add_option("folder", *folder, "Folder to write them into").type_name("DIR").required();
  command.hide();  // it is for those who install tactile
}

}  // namespace tactile::cli
