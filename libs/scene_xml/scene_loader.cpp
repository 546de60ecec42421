#include "kinome/scene_loader.h"

#include "base/clock.h"
#include "base/log_once.h"
#include "kinome/read_files.h"
#include "scene_xml/objects/build.h"

namespace kinome {
namespace {

/// Reads a scene's text, and calls `use` with the expansion and the builder. Throws Errors with all
/// errors.
template <class Use>
void read(const std::string& text, const std::string& name, const LoadOptions& options,
          PluginRegistry& registry, bool whole_scene, RenderStats* stats, const Use& use) {
  loader::Faults faults;
  try {
    faults.attempt([&] {
      const loader::Expansion expansion =
          loader::expand_scene(text, name, options, whole_scene, registry, stats, faults);
      loader::Builder builder(expansion, loader::base_folders(name, options), registry, faults,
                              options.threads);
      builder.set_denoising(options.denoising);
      use(expansion, builder);
    });
  } catch (const loader::Faults::Stop&) {
  }
  faults.check();
}

std::unique_ptr<Scene> load(const std::string& text, const std::string& name,
                            const LoadOptions& options, PluginRegistry& registry,
                            RenderStats* stats, Clock::time_point start) {
  const WarningsOnce once;  // a file may be read for several plugins
  const double plugin_seconds_before = registry.seconds();
  Scene::Contents contents;
  RenderStats own;
  read(text, name, options, registry, true, stats,
       [&](const auto& expansion, loader::Builder& builder) {
         contents = builder.scene(expansion.root);
         contents.hash = expansion.hash;
         own.plugins = builder.plugins();
         own.skipped = builder.skipped();
       });
  contents.file = name;
  const double load_seconds = seconds_since(start);
  const auto build_start = Clock::now();
  auto scene = std::make_unique<Scene>(std::move(contents), options.threads);
  if (stats) {
    stats->load_seconds = load_seconds;
    stats->plugin_seconds = registry.seconds() - plugin_seconds_before;
    stats->build_seconds = seconds_since(build_start);
    stats->plugins = own.plugins;
    stats->skipped.insert(stats->skipped.end(), own.skipped.begin(), own.skipped.end());
  }
  return scene;
}

}  // namespace

std::unique_ptr<Scene> load_scene(const std::string& path, const LoadOptions& options,
                                  PluginRegistry& registry, RenderStats* stats) {
  const auto start = Clock::now();
  record_read_file(path);
  return load(loader::read_text(path, {}), path, options, registry, stats, start);
}

std::unique_ptr<Scene> load_scene_from_string(const std::string& xml, const std::string& name,
                                              const LoadOptions& options, PluginRegistry& registry,
                                              RenderStats* stats) {
  return load(xml, name, options, registry, stats, Clock::now());
}

std::vector<Error> check_scene(const std::string& path, const LoadOptions& options,
                               PluginRegistry& registry) {
  const WarningsOnce once;
  try {
    read(loader::read_text(path, {}), path, options, registry, true, nullptr,
         [](const auto& expansion, loader::Builder& builder) { builder.scene(expansion.root); });
  } catch (const Errors& errors) {
    return errors.all();
  } catch (const Error& error) {
    return {error};
  }
  return {};
}

std::shared_ptr<Object> load_object_from_string(const std::string& xml, const std::string& name,
                                                const LoadOptions& options,
                                                PluginRegistry& registry) {
  const WarningsOnce once;
  std::shared_ptr<Object> object;
  read(xml, name, options, registry, false, nullptr,
       [&](const auto& expansion, loader::Builder& builder) {
         object = builder.object(expansion.root);
       });
  return object;
}

}  // namespace kinome
