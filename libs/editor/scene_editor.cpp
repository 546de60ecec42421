#include "kinome/scene_editor.h"

#include <algorithm>
#include <functional>
#include <set>

#include "base/clock.h"
#include "base/log_once.h"
#include "base/read_files.h"
#include "scene_xml/convert.h"
#include "editor/placed_transform.h"
#include "editor/scene_parameters.h"
#include "editor/scene_update.h"
#include "editor/scene_writer.h"
#include "plugin/property_types.h"

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
  if (takes_texture(row.type)) alone.texture(row.name);
  if (row.type == ParameterType::kTransform) alone.transform(row.name);
}

}  // namespace

/// The scene's nodes, the objects built from them, and edits that wait for update().
class SceneEditor::State {
 public:
  State(const LoadOptions& options, PluginRegistry& registry)
      : options_(options), registry_(registry) {}

  /// `expand` returns the nodes.
  void load(const std::string& name,
            const std::function<loader::Expansion(loader::Faults&)>& expand, RenderStats* stats) {
    const ReadFiles::Recording recording(read_files_);
    const WarningsOnce once(&warnings_);  // a file may be read for several plugins
    const Clock::time_point start = Clock::now();
    const double plugin_seconds_before = registry_.seconds();
    name_ = name;
    Scene::Contents contents;
    loader::run_or_throw(faults_, [&] {
      expansion_ = expand(faults_);
      builder_ = std::make_unique<loader::Builder>(expansion_, loader::base_folders(name, options_),
                                                   registry_, faults_);
      contents = contents_of_scene();
    });
    parameters_ =
        std::make_unique<loader::ParameterList>(expansion_.root, *builder_, registry_, name);
    const double load_seconds = seconds_since(start);
    const Clock::time_point build_start = Clock::now();
    scene_ = std::make_shared<const Scene>(std::move(contents), options_.threads);
    builder_->take_made();
    if (!stats) return;
    stats->load_seconds = load_seconds;
    stats->plugin_seconds = registry_.seconds() - plugin_seconds_before;
    stats->build_seconds = seconds_since(build_start);
    stats->plugins = builder_->plugins();
    const auto& skipped = builder_->skipped();
    stats->skipped.insert(stats->skipped.end(), skipped.begin(), skipped.end());
  }

  std::shared_ptr<const Scene> scene() const { return scene_; }

  void note_scene_file() {
    const ReadFiles::Recording recording(read_files_);
    note_read_file(name_);
  }

  std::shared_ptr<const Scene> scene_with(const ObjectDescription& integrator) {
    const ReadFiles::Recording recording(read_files_);
    const auto objects = builder_->objects();
    Scene::Contents contents;
    Node node;
    const auto go_back = [&] {
      builder_->set_integrator(nullptr);
      builder_->set_objects(objects);
      builder_->take_made();
    };
    try {
      loader::run_or_throw(faults_, [&] {
        node = loader::node_of(integrator, faults_);
        if (node.tag != "integrator") throw Error(node.where, "must be an integrator");
        faults_.check();
        builder_->set_integrator(&node);
        contents = contents_of_scene();
      });
    } catch (...) {
      go_back();
      throw;
    }
    go_back();
    return std::make_shared<const Scene>(std::move(contents), options_.threads, scene_.get());
  }

  const loader::ParameterList& parameters() const { return *parameters_; }

  std::string path_of(const Object& object) const {
    for (const auto& [path, node] : parameters_->objects()) {
      if (builder_->made_of(*node).get() == &object) return path;
    }
    return "";
  }

  std::optional<EditedValue> get(const std::string& path) const {
    const loader::ParameterList::Target target = parameters_->find(path);
    const EditedValue* const edit = pending_edit(target);
    if (!edit) return parameters_->value(target);
    if (loader::is_value(*edit)) return *edit;
    return std::nullopt;
  }

  EditedValue edit_of(const std::string& path) const {
    const loader::ParameterList::Target target = parameters_->find_with_bsdfs(path);
    const EditedValue* const edit = pending_edit(target);
    return edit ? *edit : parameters_->edit_of(target);
  }

  void set(const std::string& path, EditedValue value) {
    const ReadFiles::Recording recording(read_files_);
    if (!loader::is_value(value)) return set_other(path, std::move(value));
    loader::ParameterList::Target target = parameters_->find(path);
    const Location where = loader::ParameterList::where(target);
    if (target.row) {
      check_value(parameters_->plugin_of(*target.node), *target.row, value, where);
    } else {
      loader::check_mesh_array(target.name, value, where);
    }
    // Computes the inverse as for a file's matrix, so that a saved scene renders the same bits.
    if (auto* const transform = std::get_if<Transform>(&value)) {
      *transform = Transform(transform->matrix());
    }
    pending_.push_back({std::move(target), std::move(value), where});
  }

  void set(std::vector<std::pair<std::string, EditedValue>> values) {
    const auto before = static_cast<std::ptrdiff_t>(pending_.size());
    try {
      for (auto& [path, value] : values) set(path, std::move(value));
    } catch (...) {
      pending_.erase(pending_.begin() + before, pending_.end());
      throw;
    }
  }

  SceneChanges update() {
    const std::vector<loader::Edit> edits = std::exchange(pending_, {});
    if (edits.empty()) return {};
    const ReadFiles::Recording recording(read_files_);
    const WarningsOnce once(&warnings_);
    loader::SceneUpdate update(*builder_, meshes_, faults_);
    for (const loader::Edit& edit : edits) {
      update.add(edit, parameters_->plugin_of(*edit.target.node).parameters);
    }
    Scene::Contents contents = update.make([&] { return contents_of_scene(); });
    const Scene* const before = update.has_mesh_edits() ? nullptr : scene_.get();
    auto scene = std::make_shared<const Scene>(std::move(contents), options_.threads, before);
    SceneChanges changes;
    changes.made = builder_->take_made();
    changes.refitted = update.refitted();
    changes.has_new_structure = !scene->shares_structure_with(*scene_);
    scene_ = std::move(scene);
    parameters_->forget();
    update.commit();
    return changes;
  }

  void save(const std::string& path) const {
    const ReadFiles::Recording recording(read_files_);
    loader::SavedScene saved(expansion_.root, *builder_, *parameters_, meshes_, path);
    loader::save_scene(expansion_, name_, options_.defines, saved, path);
  }

 private:
  const EditedValue* pending_edit(const loader::ParameterList::Target& target) const {
    const auto edit = std::find_if(pending_.rbegin(), pending_.rend(),
                                   [&](const loader::Edit& one) { return one.target == target; });
    return edit == pending_.rend() ? nullptr : &edit->value;
  }

  /// Sets what is_value() excludes.
  void set_other(const std::string& path, EditedValue edited) {
    loader::ParameterList::Target target = parameters_->find_with_bsdfs(path);
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
      inserted = loader::node_to_insert(*description, target, *builder_, faults_);
    }
    pending_.push_back({std::move(target), std::move(edited), where, std::move(inserted)});
  }

  Scene::Contents contents_of_scene() {
    Scene::Contents contents = builder_->scene(expansion_.root);
    contents.hash = expansion_.hash;
    contents.file = name_;
    return contents;
  }

  LoadOptions options_;
  PluginRegistry& registry_;
  mutable ReadFiles read_files_;
  std::string name_;
  loader::Faults faults_;
  loader::Expansion expansion_;
  std::unique_ptr<loader::Builder> builder_;
  std::unique_ptr<loader::ParameterList> parameters_;
  loader::EditedMeshes meshes_;
  std::shared_ptr<const Scene> scene_;
  std::vector<loader::Edit> pending_;
  std::set<std::string> warnings_;  ///< logged by the load and by updates; never repeated
};

SceneEditor::SceneEditor(const std::string& path, const LoadOptions& options,
                         PluginRegistry& registry, RenderStats* stats)
    : SceneEditor(loader::read_text(path, {}), path, options, registry, stats) {
  state_->note_scene_file();
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
  return state_->scene();
}
std::shared_ptr<const Scene> SceneEditor::scene_with(const ObjectDescription& integrator) {
  return state_->scene_with(integrator);
}
std::vector<SceneParameter> SceneEditor::parameters() const {
  return state_->parameters().all();
}
std::vector<SceneParameter> SceneEditor::textured_parameters() const {
  return state_->parameters().textured();
}
std::vector<SceneObject> SceneEditor::objects() const {
  std::vector<SceneObject> all;
  for (const auto& [path, node] : state_->parameters().objects()) {
    all.push_back({path, node->tag + "/" + node->value("type"), node->inner != nullptr});
  }
  return all;
}
EditedValue SceneEditor::edit_of(const std::string& path) const {
  return state_->edit_of(path);
}
std::string SceneEditor::path_of(const Object& object) const {
  return state_->path_of(object);
}
std::optional<EditedValue> SceneEditor::get(const std::string& path) const {
  return state_->get(path);
}
void SceneEditor::set(const std::string& path, EditedValue value) {
  state_->set(path, std::move(value));
}
void SceneEditor::set(std::vector<std::pair<std::string, EditedValue>> values) {
  state_->set(std::move(values));
}
SceneChanges SceneEditor::update() {
  return state_->update();
}
void SceneEditor::save(const std::string& path) const {
  state_->save(path);
}

}  // namespace kinome
