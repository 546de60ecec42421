#include "kinome/scene_loader.h"

#include <chrono>

#include "scene_loader_build.h"

namespace kinome {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

std::unique_ptr<Scene> load(const std::string& text, const std::string& name,
                            const LoadOptions& options, PluginRegistry& registry,
                            RenderStats* stats, Clock::time_point start) {
  const double plugin_seconds_before = registry.seconds();
  const loader::Expansion expansion = loader::expand(text, name, options, true);
  loader::Builder builder(expansion, loader::base_folders(name, options), registry);
  Scene::Contents contents = builder.scene(expansion.root);
  contents.file = name;
  contents.hash = expansion.hash;
  const double load_seconds = seconds_since(start);
  const auto build_start = Clock::now();
  auto scene = std::make_unique<Scene>(std::move(contents), options.threads);
  if (stats) {
    stats->load_seconds = load_seconds;
    stats->plugin_seconds = registry.seconds() - plugin_seconds_before;
    stats->build_seconds = seconds_since(build_start);
    stats->plugins = builder.plugins();
    stats->skipped.insert(stats->skipped.end(), builder.skipped().begin(), builder.skipped().end());
  }
  return scene;
}

}  // namespace

std::unique_ptr<Scene> load_scene(const std::string& path, const LoadOptions& options,
                                  PluginRegistry& registry, RenderStats* stats) {
  const auto start = Clock::now();
  return load(loader::read_text(path, {}), path, options, registry, stats, start);
}

std::unique_ptr<Scene> load_scene_from_string(const std::string& xml, const std::string& name,
                                              const LoadOptions& options, PluginRegistry& registry,
                                              RenderStats* stats) {
  return load(xml, name, options, registry, stats, Clock::now());
}

std::shared_ptr<Object> load_object_from_string(const std::string& xml, const std::string& name,
                                                const LoadOptions& options,
                                                PluginRegistry& registry) {
  const loader::Expansion expansion = loader::expand(xml, name, options, false);
  loader::Builder builder(expansion, loader::base_folders(name, options), registry);
  return builder.object(expansion.root);
}

}  // namespace kinome
