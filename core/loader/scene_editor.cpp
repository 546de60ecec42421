#include "kinome/scene_editor.h"

#include <algorithm>
#include <functional>

#include "base/clock.h"
#include "loader/edits.h"
#include "loader/object_paths.h"
#include "plugin/property_types.h"

namespace kinome {
namespace {

using loader::Node;

/// What an edit is to the object that it is of; arrays are none of these.
std::optional<Properties::Value> as_property(const EditedValue& edited) {
  return std::visit(
      [](const auto& value) -> std::optional<Properties::Value> {
        if constexpr (std::is_constructible_v<Properties::Value, decltype(value)>) {
          return Properties::Value(value);
        } else {
          return std::nullopt;
        }
      },
      edited);
}

EditedValue as_edited(const Properties::Value& property) {
  return std::visit(
      [](const auto& value) -> EditedValue {
        if constexpr (std::is_constructible_v<EditedValue, decltype(value)>) {
          return value;
        } else {
          throw Error("an object is no value");
        }
      },
      property);
}

/// What can't be, as far as it can be told without the plugin.
void check_value(const Properties& object, std::span<const Parameter> table, const Parameter& row,
                 const EditedValue& edited, const Location& where) {
  const auto value = as_property(edited);
  if (!value || !accepts(row.type, *value)) {
    throw Error(where, std::string("'") + row.name + "' must be " + describe(row.type) + ", got " +
                           (value ? describe(*value) : "an array"));
  }
  Properties alone(object.category(), object.plugin_name(), where);
  alone.set_table(table);
  alone.set(row.name, *value, where);
  if (takes_texture(row.type)) alone.texture(row.name);
  if (row.type == ParameterType::kTransform) alone.transform(row.name);
}

bool is_shown_as_value(const Parameter& row) {
  return takes_texture(row.type);
}

}  // namespace

class SceneEditor::State {
 public:
  State(const LoadOptions& options, PluginRegistry& registry)
      : options_(options), registry_(registry) {}

  /// `expand` gives the nodes.
  void load(const std::string& name,
            const std::function<loader::Expansion(loader::Faults&)>& expand, RenderStats* stats) {
    const Clock::time_point start = Clock::now();
    const double plugin_seconds_before = registry_.seconds();
    name_ = name;
    Scene::Contents contents;
    attempt([&] {
      expansion_ = expand(faults_);
      builder_ = std::make_unique<loader::Builder>(expansion_, loader::base_folders(name, options_),
                                                   registry_, faults_);
      contents = contents_of_scene();
    });
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

  std::shared_ptr<const Scene> scene_with(const ObjectDescription& integrator) {
    const auto objects = builder_->objects();
    Scene::Contents contents;
    Node node;
    const auto go_back = [&] {
      builder_->set_integrator(nullptr);
      builder_->set_objects(objects);
      builder_->take_made();
    };
    try {
      attempt([&] {
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

  std::vector<SceneParameter> parameters() const {
    std::vector<SceneParameter> all;
    for (const auto& [path, node] : paths().all()) {
      const PluginDescriptor& plugin = plugin_of(*node);
      const std::string name = node->tag + "/" + plugin.name;
      for (const Parameter& row : plugin.parameters) {
        if (!has_value(*node, row)) continue;
        all.push_back({path + "." + row.name + (is_shown_as_value(row) ? ".value" : ""),
                       to_string(row.type), name, row.doc});
      }
      for (const char* const array : loader::mesh_arrays(builder_->made_of(*node).get())) {
        all.push_back({path + "." + array, "array", name,
                       std::string(array) == "faces" ? "three vertices of each face, from 0"
                                                     : "of each vertex, in world space"});
      }
    }
    return all;
  }

  EditedValue get(const std::string& path) const {
    const Place place = find(path);
    for (auto edit = pending_.rbegin(); edit != pending_.rend(); ++edit) {
      if (edit->place.node == place.node && edit->place.name == place.name) return edit->value;
    }
    if (!place.row) return loader::mesh_array(*builder_->made_of(*place.node), place.name);
    for (const auto& [name, value, where] : place.node->given) {
      if (name == place.name) return as_edited(value);
    }
    if (const auto value = builder_->written(*place.node, *place.row)) return as_edited(*value);
    if (holds_object(*place.node, place.name)) {
      throw Error(place.node->where, "'" + path + "' is a texture");
    }
    if (place.row->default_value) return as_edited(parse_default(*place.row));
    if (place.row->type == ParameterType::kTransform) return Transform();
    throw Error(place.node->where, "'" + path + "' has no value");
  }

  void set(const std::string& path, EditedValue value) {
    Place place = find(path);
    const Location where = where_of(place);
    if (place.row) {
      const PluginDescriptor& plugin = plugin_of(*place.node);
      check_value(Properties(plugin.category, plugin.name, where), plugin.parameters, *place.row,
                  value, where);
    } else {
      loader::check_mesh_array(place.name, value, where);
    }
    pending_.push_back({std::move(place), std::move(value), where});
  }

  SceneChanges update() {
    const std::vector<Edit> edits = std::exchange(pending_, {});
    if (edits.empty()) return {};
    Undo undo(*this);
    std::set<const Node*> to_make;
    std::map<Node*, loader::MeshEdits> meshes;
    for (const Edit& edit : edits) {
      if (edit.place.row) {
        undo.keep_given(*edit.place.node);
        give(*edit.place.node, edit);
        to_make.insert(edit.place.node);
      } else {
        meshes[edit.place.node][edit.place.name] = edit.value;
      }
    }
    SceneChanges changes;
    // Once more where a shape must read its file again, for attributes that it had no use for.
    while (!make(to_make, meshes, edits, undo, changes)) undo.undo_shapes();
    changes.made = builder_->take_made();
    undo.commit();
    return changes;
  }

 private:
  struct Place {
    Node* node = nullptr;
    const Parameter* row = nullptr;  ///< nullptr: an array of a mesh
    std::string name;
  };
  struct Edit {
    Place place;
    EditedValue value;
    Location where;
  };

  /// Goes back to what was before an update, unless that is through.
  class Undo {
   public:
    explicit Undo(State& state) : state_(state), objects_(state.builder_->objects()) {}
    ~Undo() {
      if (is_through_) return;
      undo_shapes();
      for (auto& [node, given] : given_) node->given = std::move(given);
      state_.builder_->take_made();
    }
    Undo(const Undo&) = delete;
    Undo& operator=(const Undo&) = delete;
    void keep_given(Node& node) { given_.emplace(&node, node.given); }
    void add(std::function<void()> undo) { shapes_.push_back(std::move(undo)); }
    void undo_shapes() {
      for (auto undo = shapes_.rbegin(); undo != shapes_.rend(); ++undo) (*undo)();
      shapes_.clear();
      state_.builder_->set_objects(objects_);
    }
    void commit() { is_through_ = true; }

   private:
    State& state_;
    loader::Builder::Objects objects_;
    std::map<Node*, std::vector<ObjectDescription::Value>> given_;
    std::vector<std::function<void()>> shapes_;
    bool is_through_ = false;
  };

  template <class Function>
  void attempt(const Function& function) {
    faults_ = {};
    try {
      faults_.attempt(function);
    } catch (const loader::Faults::Stop&) {
    }
    faults_.check();
  }

  Scene::Contents contents_of_scene() {
    Scene::Contents contents = builder_->scene(expansion_.root);
    contents.hash = expansion_.hash;
    contents.file = name_;
    return contents;
  }

  /// False where shapes were added to `to_make`, and all is to be done again.
  bool make(std::set<const Node*>& to_make, const std::map<Node*, loader::MeshEdits>& meshes,
            const std::vector<Edit>& edits, Undo& undo, SceneChanges& changes) {
    loader::Dependents dependents(*builder_);
    for (const Node* const node : to_make) dependents.add(*node);
    for (const auto& [node, edited] : meshes) dependents.add_refitted(*node);
    auto objects = builder_->objects();
    for (const Node* const node : dependents.to_make()) objects.erase(node);
    builder_->set_objects(std::move(objects));
    builder_->take_made();
    changes.refitted = 0;
    const size_t before = to_make.size();
    Scene::Contents contents;
    attempt([&] {
      for (const Node* const node : dependents.to_refit()) {
        if (dependents.to_make().count(node)) continue;
        const auto shape = std::dynamic_pointer_cast<Shape>(builder_->made_of(*node));
        auto put_back = loader::refit(*shape, *node, *builder_);
        if (!put_back) to_make.insert(node);
        if (put_back) undo.add(std::move(put_back));
        ++changes.refitted;
      }
      faults_.check();
      if (to_make.size() != before) return;
      for (const auto& [node, edited] : meshes) {
        const auto shape = builder_->object(*node);
        faults_.check();
        const auto edit = std::find_if(
            edits.begin(), edits.end(),
            [edited_node = node](const Edit& e) { return e.place.node == edited_node; });
        undo.add(loader::edit_mesh(*shape, edited, edit->where));
      }
      contents = contents_of_scene();
    });
    if (to_make.size() != before) return false;
    auto scene = std::make_shared<const Scene>(std::move(contents), options_.threads,
                                               meshes.empty() ? scene_.get() : nullptr);
    changes.has_new_structure = !scene->shares_structure_with(*scene_);
    scene_ = std::move(scene);
    return true;
  }

  static void give(Node& node, const Edit& edit) {
    std::erase_if(node.given, [&](const auto& other) { return other.name == edit.place.name; });
    node.given.push_back({edit.place.name, *as_property(edit.value), edit.where});
  }

  loader::ObjectPaths paths() const { return {expansion_.root, *builder_}; }

  const PluginDescriptor& plugin_of(const Node& node) const {
    return registry_.find(*loader::category_of_tag(node.tag), node.value("type"));
  }

  Place find(const std::string& path) const {
    for (const auto& [found, rest] : paths().candidates(path)) {
      if (!builder_->made_of(*found)) continue;
      const size_t dot = rest.rfind(".value");
      const bool has_suffix = dot != std::string::npos && dot + 6 == rest.size();
      const std::string name = has_suffix ? rest.substr(0, dot) : rest;
      Node* const node = const_cast<Node*>(found);
      const Parameter* const row = find_row(plugin_of(*node), name);
      if (row && row->type != ParameterType::kObject && has_suffix <= is_shown_as_value(*row)) {
        return {node, row, name};
      }
      for (const char* const array : loader::mesh_arrays(builder_->made_of(*node).get())) {
        if (rest == array) return {node, nullptr, array};
      }
    }
    std::vector<std::string> known;
    for (const SceneParameter& parameter : parameters()) known.push_back(parameter.path);
    throw Error(Location{name_}, "there is no parameter '" + path + "'" +
                                     loader::did_you_mean(nearest_name(path, known)));
  }

  bool holds_object(const Node& node, const std::string& name) const {
    return !node.is_given(name) &&
           std::any_of(node.children.begin(), node.children.end(), [&](const Node& child) {
             return loader::is_object(child) && child.value("name") == name;
           });
  }

  bool has_value(const Node& node, const Parameter& row) const {
    if (row.type == ParameterType::kObject || holds_object(node, row.name)) return false;
    return row.default_value || row.type == ParameterType::kTransform || node.is_given(row.name) ||
           std::any_of(node.children.begin(), node.children.end(),
                       [&](const Node& child) { return child.value("name") == row.name; });
  }

  /// Where the scene says what is set, or would say it.
  static Location where_of(const Place& place) {
    for (const Node& child : place.node->children) {
      if (child.value("name") == place.name) return child.where;
    }
    for (const auto& given : place.node->given) {
      if (given.name == place.name) return given.where;
    }
    return place.node->where;
  }

  LoadOptions options_;
  PluginRegistry& registry_;
  std::string name_;
  loader::Faults faults_;
  loader::Expansion expansion_;
  std::unique_ptr<loader::Builder> builder_;
  std::shared_ptr<const Scene> scene_;
  std::vector<Edit> pending_;
};

SceneEditor::SceneEditor(const std::string& path, const LoadOptions& options,
                         PluginRegistry& registry, RenderStats* stats)
    : SceneEditor(loader::read_text(path, {}), path, options, registry, stats) {}

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
  return state_->parameters();
}
EditedValue SceneEditor::get(const std::string& path) const {
  return state_->get(path);
}
void SceneEditor::set(const std::string& path, EditedValue value) {
  state_->set(path, std::move(value));
}
SceneChanges SceneEditor::update() {
  return state_->update();
}

}  // namespace kinome
