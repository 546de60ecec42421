// `kinome new`: starts a plugin as a renamed copy of its category's example.

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <regex>

#include <fmt/format.h>

#include "commands.h"
#include "crash.h"
#include "kinome/error.h"
#include "kinome/object.h"
#include "kinome/plugin_registry.h"
#include "kinome/read_files.h"
#include "shell.h"

namespace kinome::app {
namespace {

namespace fs = std::filesystem;

/// Returns share/kinome/templates in the program's prefix.
fs::path templates() {
  std::error_code failed;
  const fs::path program = fs::canonical("/proc/self/exe", failed).parent_path();
  return program.parent_path() / "share/kinome/templates";
}

void write(const fs::path& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file << text;
  if (!file.flush()) throw Error(fmt::format("'{}': can't be written", path.string()));
}

std::string replaced(const std::string& text, const std::string& pattern, const std::string& by) {
  return std::regex_replace(text, std::regex(pattern), by);
}

/// Returns "MySkyEmitter" for "my_sky" and "emitter". No class of the core has such a name.
std::string class_name(const std::string& name, const std::string& category) {
  std::string result;
  bool is_first = true;
  for (const char c : name + '_' + category) {
    if (c == '_') {
      is_first = true;
      continue;
    }
    result += is_first ? static_cast<char>(std::toupper(static_cast<unsigned char>(c))) : c;
    is_first = false;
  }
  return result;
}

/// Replaces the plugin's name only where it identifies the plugin, because the same word may be the
/// name of a parameter or a term in the text.
std::string renamed(const std::string& text, const std::string& name, const std::string& by) {
  // The last place is KINOME_PLUGIN(CLASS, Category::kEmitter, "NAME".
  return replaced(text, "(type=\"|plugins |<!-- |Category::k[^\"]*\")" + name + "\\b", "$1" + by);
}

Category known_category(const std::string& name) {
  if (const auto category = category_named(name)) return *category;
  std::vector<std::string> all;
  for (const Category category : kCategories) all.emplace_back(to_string(category));
  const std::string near = nearest_name(name, all);
  throw Error(fmt::format("unknown category '{}' ({})", name,
                          near.empty() ? fmt::format("must be one of {}", fmt::join(all, ", "))
                                       : fmt::format("did you mean '{}'?", near)));
}

void check_name(const std::string& name, Category category) {
  constexpr const char* kAllowed = "abcdefghijklmnopqrstuvwxyz0123456789_";
  if (name.empty() || !std::islower(static_cast<unsigned char>(name[0])) ||
      name.find_first_not_of(kAllowed) != std::string::npos) {
    throw Error(
        fmt::format("'{}': a plugin's name must consist of lower-case letters, digits and _, and "
                    "begin with a letter",
                    name));
  }
  constexpr size_t kMaxNameLength = 64;  // names of files and libraries add to it
  if (name.size() > kMaxNameLength) {
    throw Error(fmt::format("a plugin's name must have at most {} characters, got {}",
                            kMaxNameLength, name.size()));
  }
  // The order of folders decides which of two plugins with the same name a scene gets.
  const auto taken = PluginRegistry(PluginRegistry::default_folders()).names(category);
  if (std::find(taken.begin(), taken.end(), name) != taken.end()) {
    throw Error(
        fmt::format("plugin {}/{} already exists: choose another name", to_string(category), name));
  }
}

/// Returns the only source file among a category's templates.
fs::path example_of(const fs::path& folder) {
  std::error_code failed;
  for (const auto& entry : fs::directory_iterator(folder, failed)) {
    if (entry.path().extension() == ".cpp") return entry.path();
  }
  throw Error(fmt::format("'{}': missing templates, which are installed with the program",
                          folder.string()));
}

}  // namespace

int new_plugin_command(const Options& options) {
  set_activity("creating a plugin");
  check_name(options.plugin_name, known_category(options.category));
  const std::string& name = options.plugin_name;
  const fs::path from = templates() / options.category;
  const fs::path example = example_of(from);
  const fs::path to = options.folder.empty() ? name : options.folder;
  if (fs::exists(to)) throw Error(fmt::format("'{}' already exists", to.string()));

  std::string source = file_contents(example);
  const std::string registration = "KINOME_PLUGIN(";
  const size_t begin = source.find(registration) + registration.size();
  const std::string old_class = source.substr(begin, source.find(',', begin) - begin);
  const std::string old_name = example.stem().string();
  source = replaced(source, "\\b" + old_class + "\\b", class_name(name, options.category));
  source = renamed(source, old_name, name);
  std::string build = file_contents(templates() / "CMakeLists.txt");
  const bool is_wide = source.find("<kinome/wide/") != std::string::npos;
  if (is_wide) build = replaced(build, "@NAME@.cpp\\)", "@NAME@.cpp WIDE)");
  build = replaced(replaced(build, "@NAME@", name), "@CATEGORY@", options.category);
  std::error_code failed;
  fs::create_directories(to, failed);
  if (failed) throw Error(fmt::format("'{}': {}", to.string(), failed.message()));
  write(to / (name + ".cpp"), source);
  write(to / "CMakeLists.txt", build);
  write(to / "scene.xml", renamed(file_contents(from / "scene.xml"), old_name, name));
  fmt::print("{}: {}.cpp (as the example {}), CMakeLists.txt, scene.xml\n", to.string(), name,
             old_name);
  fs::path prefix = templates().parent_path().parent_path().parent_path();
  // A build folder has no CMake package for other projects.
  if (fs::exists(prefix / "CMakeCache.txt")) {
    const fs::path sdk = fs::absolute(to) / "kinome";
    fmt::print("  cmake --install {} --prefix {}\n", quoted(prefix.string()), quoted(sdk.string()));
    prefix = sdk;
  }
  fmt::print(
      "  cmake -S {0} -B {0}/build -DCMAKE_PREFIX_PATH={1}\n"
      "  cmake --build {0}/build\n"
      "  ctest --test-dir {0}/build\n",
      quoted(to.string()), quoted(prefix.string()));
  return 0;
}

}  // namespace kinome::app
