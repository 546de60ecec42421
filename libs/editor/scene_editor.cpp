#include "kinome/scene_editor.h"

#include <algorithm>
#include <functional>
#include <set>

#include "base/clock.h"
#include "base/log_once.h"
#include "base/read_files.h"
#include "editor/saving/placed_transform.h"
#include "editor/saving/scene_writer.h"
#include "editor/updates/scene_parameters.h"
#include "editor/updates/scene_update.h"
#include "plugin/property_types.h"
#include "scene_xml/values/convert.h"

namespace kinome {
namespace {

using loader::Node;

/// Throws Error for an invalid value, as far as that can be decided without the plugin.
void check_value(const PluginDescriptor& plugin, const Parameter& row, const EditedValue& edited,
                 const Location& where) {
  const auto value = loader::as_property(edited);
  if (!value || !accepts(row.type, *value)) {
    throw Error(where, std::string("'") + row.name + "' must be " + describe(row.type) + ", got " +
                           (value ? describe(*value) : "an array"));
  }
  Properties alone(plugin.category, plugin.name, where);
  alone.set_table(plugin.parameters);
  alone.set(row.name, *value, where);
  if (row.type == ParameterType::kVolume) {
    alone.volume(row.name);
  } else if (takes_texture(row.type)) {
    alone.texture(row.name);
  }
  if (row.type == ParameterType::kTransform) alone.transform(row.name);
}

}  // namespace

/// The scene's nodes, the objects built from them, and edits that wait for update().
struct SceneEditor::State {
  State(const LoadOptions& load_options, PluginRegistry& plugins)
      : options(load_options), registry(plugins) {}

  /// `expand` returns the nodes.
  void load(const std::string& scene_name,
            const std::function<loader::Expansion(loader::Faults&)>& expand, RenderStats* stats) {
    const ReadFiles::Recording recording(read_files);
    const WarningsOnce once(&warnings);  // a file may be read for several plugins
    const Clock::time_point start = Clock::now();
    const double plugin_seconds_before = registry.seconds();
    name = scene_name;
    Scene::Contents contents;
    loader::run_or_throw(faults, [&] {
      expansion = expand(faults);
      builder = std::make_unique<loader::Builder>(expansion, loader::base_folders(name, options),
                                                  registry, faults, options.threads);
      builder->set_denoising(options.denoising);
      contents = contents_of_scene();
    });
    parameters = std::make_unique<loader::ParameterList>(expansion.root, *builder, registry, name);
    const double load_seconds = seconds_since(start);
    const Clock::time_point build_start = Clock::now();
    scene = std::make_shared<const Scene>(std::move(contents), options.threads);
    builder->take_made();
    if (!stats) return;
    stats->load_seconds = load_seconds;
    stats->plugin_seconds = registry.seconds() - plugin_seconds_before;
    stats->build_seconds = seconds_since(build_start);
    stats->plugins = builder->plugins();
    const auto& skipped = builder->skipped();
    stats->skipped.insert(stats->skipped.end(), skipped.begin(), skipped.end());
  }

  void set(const std::string& path, EditedValue value) {
    const ReadFiles::Recording recording(read_files);
    if (!loader::is_value(value)) return set_other(path, std::move(value));
    loader::ParameterList::Target target = parameters->find(path);
    const Location where = loader::ParameterList::where(target);
    if (target.row) {
      check_value(parameters->plugin_of(*target.node), *target.row, value, where);
    } else {
      loader::check_mesh_array(target.name, value, where);
    }
    // Computes the inverse as for a file's matrix, so that a saved scene renders the same bits.
    if (auto* const transform = std::get_if<Transform>(&value)) {
      *transform = Transform(transform->matrix());
    }
    pending.push_back({std::move(target), std::move(value), where});
  }

  const EditedValue* pending_edit(const loader::ParameterList::Target& target) const {
    const auto edit = std::find_if(pending.rbegin(), pending.rend(),
                                   [&](const loader::Edit& one) { return one.target == target; });
    return edit == pending.rend() ? nullptr : &edit->value;
  }

  /// Sets what is_value() excludes.
  void set_other(const std::string& path, EditedValue edited) {
    loader::ParameterList::Target target = parameters->find_with_bsdfs(path);
    const Location where = loader::ParameterList::where(target);
    if (!target.row && !target.is_object())
      throw Error(where, "an array can only be set to an array");
    std::shared_ptr<Node> inserted;
    if (const auto* const placed = std::get_if<Placed>(&edited)) {
      if (!target.row || target.row->type != ParameterType::kTransform) {
        throw Error(where, "'" + path + "' is not a transform");
      }
      inserted = loader::placed_transform(loader::written_transform(target), target.name,
                                          placed->transform.matrix(), where);
      if (!inserted) return set(path, placed->transform);
      edited = loader::convert_transform(*inserted);
    } else if (const auto* const description = std::get_if<ObjectDescription>(&edited)) {
      if (target.row && !takes_texture(target.row->type)) {
        throw Error(where, "'" + target.name + "' must be " + describe(target.row->type) +
                               ", and can't be a texture");
      }
      inserted = loader::node_to_insert(*description, target, *builder, faults);
    }
    pending.push_back({std::move(target), std::move(edited), where, std::move(inserted)});
  }

  SceneObject object_of(const std::string& path, const Node& node) const {
    return {path, node.tag + "/" + node.value("type"), node.inner != nullptr,
            builder->made_of(node).get()};
  }

  Scene::Contents contents_of_scene() {
    Scene::Contents contents = builder->scene(expansion.root);
    contents.hash = expansion.hash;
    contents.file = name;
    return contents;
  }

  LoadOptions options;
  PluginRegistry& registry;
  ReadFiles read_files;
  std::string name;
  loader::Faults faults;
  loader::Expansion expansion;
  std::unique_ptr<loader::Builder> builder;
  std::unique_ptr<loader::ParameterList> parameters;
  loader::EditedMeshes meshes;
  std::shared_ptr<const Scene> scene;
  std::vector<loader::Edit> pending;
  std::set<std::string> warnings;  ///< logged by the load and by updates; never repeated
};

SceneEditor::SceneEditor(const std::string& path, const LoadOptions& options,
                         PluginRegistry& registry, RenderStats* stats)
    : SceneEditor(loader::read_text(path, {}), path, options, registry, stats) {
  const ReadFiles::Recording recording(state_->read_files);
  record_read_file(path);
}

SceneEditor::SceneEditor(const std::string& xml, const std::string& name,
                         const LoadOptions& options, PluginRegistry& registry, RenderStats* stats)
    : state_(std::make_unique<State>(options, registry)) {
  state_->load(
      name,
      [&](loader::Faults& faults) {
        return loader::expand_scene(xml, name, options, true, registry, stats, faults);
      },
      stats);
}

SceneEditor::SceneEditor(const ObjectDescription& scene, const LoadOptions& options,
                         PluginRegistry& registry, RenderStats* stats)
    : state_(std::make_unique<State>(options, registry)) {
  const auto expand = [&](loader::Faults& faults) {
    if (scene.tag != "scene") throw Error(scene.where, "must be a scene");
    loader::Expansion expansion;
    expansion.root = loader::node_of(scene, faults);
    loader::replace_differentiable(expansion.root);
    return expansion;
  };
  state_->load(scene.where.file, expand, stats);
}

SceneEditor::~SceneEditor() = default;

std::shared_ptr<const Scene> SceneEditor::scene() const {
  return state_->scene;
}

std::shared_ptr<const Scene> SceneEditor::scene_with(const ObjectDescription& integrator) {
  const ReadFiles::Recording recording(state_->read_files);
  const auto objects = state_->builder->objects();
  Scene::Contents contents;
  Node node;
  const auto go_back = [&] {
    state_->builder->set_integrator(nullptr);
    state_->builder->set_objects(objects);
    state_->builder->take_made();
  };
  try {
    loader::run_or_throw(state_->faults, [&] {
      node = loader::node_of(integrator, state_->faults);
      if (node.tag != "integrator") throw Error(node.where, "must be an integrator");
      state_->faults.check();
      state_->builder->set_integrator(&node);
      contents = state_->contents_of_scene();
    });
  } catch (...) {
    go_back();
    throw;
  }
  go_back();
  return std::make_shared<const Scene>(std::move(contents), state_->options.threads,
                                       state_->scene.get());
}

std::vector<SceneParameter> SceneEditor::parameters() const {
  return state_->parameters->all();
}
std::vector<SceneParameter> SceneEditor::textured_parameters() const {
  return state_->parameters->textured();
}
std::vector<SceneObject> SceneEditor::objects() const {
  std::vector<SceneObject> all;
  for (const auto& [path, node] : state_->parameters->objects()) {
    all.push_back(state_->object_of(path, *node));
  }
  return all;
}

std::optional<SceneObject> SceneEditor::object_at(const std::string& path) const {
  const Node* const node = state_->parameters->listed_object(path);
  return node ? std::optional(state_->object_of(path, *node)) : std::nullopt;
}

std::string SceneEditor::path_of(const Object& object) const {
  return state_->parameters->path_of(object);
}

std::optional<EditedValue> SceneEditor::get(const std::string& path) const {
  const loader::ParameterList::Target target = state_->parameters->find(path);
  const EditedValue* const edit = state_->pending_edit(target);
  if (!edit) return state_->parameters->value(target);
  if (loader::is_value(*edit)) return *edit;
  return std::nullopt;
}

EditedValue SceneEditor::edit_of(const std::string& path) const {
  const loader::ParameterList::Target target = state_->parameters->find_with_bsdfs(path);
  const EditedValue* const edit = state_->pending_edit(target);
  return edit ? *edit : state_->parameters->edit_of(target);
}

void SceneEditor::set(const std::string& path, EditedValue value) {
  state_->set(path, std::move(value));
}

void SceneEditor::set(std::vector<std::pair<std::string, EditedValue>> values) {
  const auto before = static_cast<std::ptrdiff_t>(state_->pending.size());
  try {
    for (auto& [path, value] : values) set(path, std::move(value));
  } catch (...) {
    state_->pending.erase(state_->pending.begin() + before, state_->pending.end());
    throw;
  }
}

SceneChanges SceneEditor::update() {
  const std::vector<loader::Edit> edits = std::exchange(state_->pending, {});
  if (edits.empty()) return {};
  const ReadFiles::Recording recording(state_->read_files);
  const WarningsOnce once(&state_->warnings);
  loader::SceneUpdate update(*state_->builder, state_->meshes, state_->faults);
  for (const loader::Edit& edit : edits) {
    update.add(edit, state_->parameters->plugin_of(*edit.target.node).parameters);
  }
  Scene::Contents contents = update.make([&] { return state_->contents_of_scene(); });
  const Scene* const before = update.has_mesh_edits() ? nullptr : state_->scene.get();
  auto scene = std::make_shared<const Scene>(std::move(contents), state_->options.threads, before);
  SceneChanges changes;
  changes.made = state_->builder->take_made();
  changes.refitted = update.refitted();
  changes.has_new_structure = !scene->shares_structure_with(*state_->scene);
  state_->scene = std::move(scene);
  state_->parameters->forget();
  update.commit();
  return changes;
}

void SceneEditor::save(const std::string& path) const {
  const ReadFiles::Recording recording(state_->read_files);
  loader::SavedScene saved(state_->expansion.root, *state_->builder, *state_->parameters,
                           state_->meshes, path);
  loader::save_scene(state_->expansion, state_->name, state_->options.defines, saved, path);
}

}  // namespace kinome
