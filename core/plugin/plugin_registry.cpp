#include "kinome/plugin_registry.h"

#include <dlfcn.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <set>

#include "plugin/abi_key.h"
#include "plugin/library_sites.h"
#include "plugin/plugin_check.h"

namespace kinome {
namespace {

namespace fs = std::filesystem;

struct Library {
  InstructionSet instruction_set;
  std::string path;
};

/// Returns DIR/CATEGORY/NAME.so of the first folder that contains it, followed by the existing
/// DIR/CATEGORY/SET/NAME.so of the same folder, the best instruction set last.
std::vector<Library> find_libraries(const std::vector<std::string>& folders, Category category,
                                    const std::string& name) {
  if (name.empty() || name.find('/') != std::string::npos || name[0] == '.') return {};
  const std::string file = name + ".so";
  std::error_code failed;
  for (const std::string& folder : folders) {
    const fs::path plugins = fs::path(folder) / to_string(category);
    if (!fs::exists(plugins / file, failed)) continue;
    std::vector<Library> libraries = {{InstructionSet::kBaseline, (plugins / file).string()}};
    for (int i = 1; i < kInstructionSetCount; ++i) {
      const auto set = static_cast<InstructionSet>(i);
      const fs::path path = plugins / to_string(set) / file;
      if (fs::exists(path, failed)) libraries.push_back({set, path.string()});
    }
    return libraries;
  }
  return {};
}

Error no_such_plugin(const PluginRegistry& registry, const std::vector<std::string>& folders,
                     Category category, const std::string& name, const Location& where) {
  const std::string title =
      std::string("unknown ") + to_string(category) + " plugin '" + name + "'";
  const std::vector<std::string> known = registry.names(category);
  const std::string nearest = nearest_name(name, known);
  if (!nearest.empty()) return Error(where, title + did_you_mean(nearest));
  std::string list;
  for (const std::string& other : known) list += (list.empty() ? "" : ", ") + other;
  if (!list.empty()) return Error(where, title + " (available: " + list + ")");
  for (const std::string& folder : folders) list += (list.empty() ? "" : ", ") + folder;
  return Error(where, title + " (no plugins of this category in " +
                          (list.empty() ? "an empty search path" : list) + ")");
}

/// Fields of the ABI key. `common` must be identical; the others have messages of their own.
struct AbiKey {
  explicit AbiKey(std::string key)
      : instruction_set(take(key, ";isa=")), math(take(key, ";math=")), common(std::move(key)) {}

  std::string instruction_set, math, common;

 private:
  /// Removes a field from the key and returns its value.
  static std::string take(std::string& key, std::string_view field) {
    const size_t at = key.rfind(field);
    if (at == std::string::npos) return {};
    const size_t begin = at + field.size(), end = std::min(key.find(';', begin), key.size());
    const std::string value = key.substr(begin, end - begin);
    key.erase(at, end - at);
    return value;
  }
};

void check_abi(const std::string& path, InstructionSet best) {
  const std::string text = read_abi_key(path);
  const AbiKey key(text);
  if (key.math == "fast") {
    throw Error("it was built with -ffast-math or one of its options, which are unsupported");
  }
  const AbiKey own(KINOME_ABI_KEY);
  if (key.common != own.common || key.math != own.math || key.instruction_set.empty()) {
    throw Error("it was built for another ABI: its key is '" + text + "', this program's is '" +
                KINOME_ABI_KEY + "'");
  }
  if (key.instruction_set == "of-no-level") {
    if (own.instruction_set == key.instruction_set) return;  // both were built for this processor
    throw Error(
        "it was built for a specific processor, as with -march=native, which can't be "
        "checked: build it for an x86-64 level, such as -march=x86-64-v4");
  }
  const auto set = instruction_set_named(key.instruction_set);
  const std::string is_built = "it is built for the instruction set " + key.instruction_set;
  if (!set || *set > processor_instruction_set()) {
    throw Error(is_built + ", which this processor lacks");
  }
  if (*set > best) {
    throw Error(is_built + ", but the best one allowed is " + to_string(best));
  }
}

const PluginDescriptor* open_library(const std::string& path, Category category,
                                     const std::string& name, InstructionSet best) {
  check_abi(path, best);
  LibraryLoading loading(name);
  // RTLD_LOCAL, because two plugins may define the same names. Never closed; see the header.
  void* const library = dlopen(fs::absolute(path).c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!library) throw Error(std::string("it can't be loaded: ") + dlerror());
  const auto* plugin = static_cast<const PluginDescriptor*>(dlsym(library, "kinome_plugin"));
  if (!plugin) throw Error("it exports no kinome_plugin");
  loading.finish(plugin);
  if (plugin->category != category) {
    throw Error(std::string("its category is ") + to_string(plugin->category) + ", expected " +
                to_string(category));
  }
  return plugin;
}

/// Returns the folder of the library (or program) that contains this code.
fs::path folder_of_this_library() {
  Dl_info info{};
  if (!dladdr(reinterpret_cast<const void*>(&folder_of_this_library), &info)) return {};
  std::error_code failed;
  return fs::canonical(info.dli_fname, failed).parent_path();
}

}  // namespace

PluginRegistry::PluginRegistry(std::vector<std::string> folders, InstructionSet instruction_set)
    : folders_(std::move(folders)), instruction_set_(instruction_set) {}

std::vector<std::string> PluginRegistry::default_folders(const std::vector<std::string>& extra) {
  std::vector<std::string> folders = extra;
  if (const char* variable = std::getenv("KINOME_PLUGIN_PATH")) {
    const std::string_view list(variable);
    for (size_t begin = 0; begin <= list.size();) {
      const size_t end = std::min(list.find(':', begin), list.size());
      if (end > begin) folders.emplace_back(list.substr(begin, end - begin));
      begin = end + 1;
    }
  }
  std::error_code failed;
  const fs::path program = fs::canonical("/proc/self/exe", failed).parent_path();
  if (!program.empty()) {
    folders.push_back((program.parent_path() / "plugins").string());
    folders.push_back((program.parent_path() / "lib/kinome/plugins").string());
  }
  // Some systems don't install libraries in lib/.
  const fs::path library = folder_of_this_library();
  if (!library.empty()) folders.push_back((library / "kinome/plugins").string());
  return folders;
}

const PluginDescriptor& PluginRegistry::find(Category category, const std::string& name,
                                             const Location& where) {
  const auto known = loaded_.find({category, name});
  if (known != loaded_.end()) return *known->second;
  // Remember missing plugins: a scene may request one thousands of times.
  const auto missing = missing_.find({category, name});
  if (missing != missing_.end()) throw Error(where, missing->second);

  const auto start = std::chrono::steady_clock::now();
  const std::vector<Library> libraries = find_libraries(folders_, category, name);
  if (libraries.empty()) {
    const Error error = no_such_plugin(*this, folders_, category, name, where);
    missing_[{category, name}] = error.message();
    throw error;
  }
  // The first one is the baseline, which every processor supports.
  const auto best = std::find_if(libraries.rbegin(), libraries.rend() - 1, [&](const auto& library) {
    return library.instruction_set <= instruction_set_;
  });
  const std::string& path = best->path;
  const std::string full_name = std::string(to_string(category)) + "/" + name;
  const PluginDescriptor* plugin = nullptr;
  try {
    plugin = open_library(path, category, full_name, instruction_set_);
  } catch (const Error& error) {
    throw UnusablePlugin(where, "'" + path + "' is not a usable plugin: " + error.message());
  }
  loaded_[{category, name}] = plugin;
  loaded_names_.push_back(full_name);
  seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return *plugin;
}

namespace {

/// Returns true if `file` is the scene file with the object's description, rather than a file that
/// the object is loaded from.
bool is_scene_file(const std::string& file, const Properties& props) {
  return file == props.where().file ||
         std::any_of(props.entries().begin(), props.entries().end(),
                     [&](const auto& entry) { return file == entry.second.where.file; });
}

/// Returns the location in the scene of the name of the file that the object is loaded from.
const Location& file_requester(const PluginDescriptor& plugin, const Properties& props) {
  for (const auto& [name, entry] : props.entries()) {
    const Parameter* const row = find_row(plugin, name);
    if (row && row->type == ParameterType::kFile) return entry.where;
  }
  return props.where();
}

/// Runs a plugin's constructor. Converts its exceptions (except std::bad_alloc) to Errors with the
/// object's location.
std::shared_ptr<Object> construct(const PluginDescriptor& plugin, const Properties& props,
                                  const std::string& name) {
  try {
    return plugin.create(props);
  } catch (const Error& error) {
    // Code that a plugin calls (a mesh reader, say) doesn't always know the location.
    if (error.where().file.empty()) throw Error(props.where(), error.message());
    if (is_scene_file(error.where().file, props) || !error.requesters().empty()) throw;
    throw error.requested_by(file_requester(plugin, props));
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    throw Error(props.where(), "plugin '" + name + "' failed: " + error.what());
  } catch (...) {
    throw Error(props.where(), "plugin '" + name + "' failed with an unknown exception");
  }
}

std::vector<std::shared_ptr<const Object>> nested_objects(const Properties& props) {
  std::vector<std::shared_ptr<const Object>> nested;
  for (const auto& [name, entry] : props.entries()) {
    if (const auto* object = std::get_if<std::shared_ptr<Object>>(&entry.value)) {
      nested.push_back(*object);
    }
  }
  return nested;
}

}  // namespace

std::shared_ptr<Object> PluginRegistry::create(Properties& props) {
  return create(find(props.category(), props.plugin_name(), props.where()), props);
}

std::shared_ptr<Object> PluginRegistry::create(const PluginDescriptor& plugin, Properties& props) {
  if (auto faults = check_parameters(props, plugin); !faults.empty()) {
    throw Errors(std::move(faults));
  }
  props.set_table(plugin.parameters);
  const std::string name = std::string(to_string(props.category())) + "/" + props.plugin_name();
  std::shared_ptr<Object> object = construct(plugin, props, name);
  take_ignored(props, plugin);
  check_all_read(props);
  object->set_id(props.id());
  object->set_origin(name, nested_objects(props));
  return object;
}

std::vector<InstructionSet> PluginRegistry::instruction_sets(Category category,
                                                             const std::string& name) const {
  std::vector<InstructionSet> sets;
  for (const Library& library : find_libraries(folders_, category, name)) {
    sets.push_back(library.instruction_set);
  }
  return sets;
}

bool PluginRegistry::has(Category category, const std::string& name) const {
  return loaded_.contains({category, name}) || !find_libraries(folders_, category, name).empty();
}

std::vector<std::string> PluginRegistry::names(Category category) const {
  std::set<std::string> found;
  for (const std::string& folder : folders_) {
    std::error_code failed;
    fs::directory_iterator files(fs::path(folder) / to_string(category), failed);
    for (; !failed && files != fs::directory_iterator(); files.increment(failed)) {
      if (files->path().extension() == ".so") found.insert(files->path().stem().string());
    }
  }
  return {found.begin(), found.end()};
}

}  // namespace kinome
