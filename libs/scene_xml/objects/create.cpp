// Creates objects from their properties, adds defaults, and checks what only the created object
// knows.

#include <algorithm>

#include "kinome/log.h"
#include "kinome/texture.h"
#include "plugin/property_types.h"
#include "scene_xml/objects/build.h"

namespace kinome::loader {
namespace {

bool takes(const PluginDescriptor& plugin, Category category) {
  return std::any_of(plugin.parameters.begin(), plugin.parameters.end(), [&](const auto& row) {
    return row.type == ParameterType::kObject && row.category == category;
  });
}

bool has_object(const Properties& props, Category category) {
  return std::any_of(props.entries().begin(), props.entries().end(), [&](const auto& entry) {
    const auto* object = std::get_if<std::shared_ptr<Object>>(&entry.second.value);
    return object && category_of(**object) == category;
  });
}

/// Returns why an area emitter emits no light although its parameters are valid; "" if it does.
const char* why_dark(const Shape& shape) {
  constexpr float kMinSize = 0x1p-22f;  // at most four rounding errors, relative to the distance
  if (!(shape.area() > 0)) return "this emitter has no area and emits no light";
  const Aabb box = shape.bounds();
  const float distance = max_component(glm::max(glm::abs(box.lo), glm::abs(box.hi)));
  if (max_component(box.extent()) > kMinSize * distance) return "";
  return "this emitter is so small for its distance from the origin that rounding errors determine "
         "whether it emits any light";
}

/// Checks the mesh attributes that the shape's textures read.
void check_attributes(const Shape& shape, const Location& where) {
  for (const std::string& name : shape.requested_attributes()) {
    const auto found = shape.attribute(name);
    const std::string reads = "a texture of this shape reads the attribute '" + name + "', which ";
    if (!found) throw Error(where, reads + "the shape doesn't have");
    const uint32_t size = found->attribute->size;
    if (size != 1 && size != 3) {
      throw Error(where, reads + "has " + std::to_string(size) + " numbers, expected 1 or 3");
    }
  }
}

/// Throws Error if a texture of an emitter without a surface reads a mesh attribute.
void check_no_attribute(const Object& object, const Location& where) {
  for (const auto& part : object.nested()) {
    const auto* const texture = dynamic_cast<const Texture*>(part.get());
    if (texture && !texture->attribute().empty()) {
      throw Error(where, "a texture of this emitter reads the mesh attribute '" +
                             texture->attribute() + "', but the emitter isn't part of a mesh");
    }
  }
}

}  // namespace

/// Warns of the parameters that the scene gives but the plugin ignores.
void Builder::warn_of_ignored(const Properties& props, const PluginDescriptor& plugin) {
  for (const IgnoredEntry& ignored : take_ignored(props, plugin)) {
    warn_once_of_ignored(props, ignored.row->name, ignored.row->doc, ignored.entry->where);
  }
}

/// Logs one warning per plugin and parameter, because many shapes may have the same parameter.
void Builder::warn_once_of_ignored(const Properties& props, const std::string& parameter,
                                   const std::string& why, const Location& where) {
  const std::string plugin =
      std::string(to_string(props.category())) + " '" + props.plugin_name() + "'";
  if (!ignored_.insert(plugin + ": " + parameter).second) return;
  log_warn(Error(where, plugin + ": '" + parameter + "' is ignored: " + why).what());
}

void Builder::warn_of_dark_emitter(const Shape& shape, const Location& where) {
  constexpr int kMaxWarnings = 5;
  const std::string why = why_dark(shape);
  if (why.empty() || ++dark_emitters_ > kMaxWarnings + 1) return;
  const bool is_last = dark_emitters_ > kMaxWarnings;
  log_warn(Error(where, is_last ? why + " (no further ones are reported)" : why).what());
}

/// Creates an object, or takes the one that was `begun` with the same properties.
std::shared_ptr<Object> Builder::create(Properties& props, const Location& type_where,
                                        ReadAhead::Pending* begun) {
  const PluginDescriptor& plugin =
      registry_.find(props.category(), props.plugin_name(), type_where);
  const std::string name = std::string(to_string(props.category())) + "/" + props.plugin_name();
  if (std::find(plugins_.begin(), plugins_.end(), name) == plugins_.end()) plugins_.push_back(name);
  add_default_children(props, plugin);
  const bool is_changed = denoising_ && props.category() == Category::kFilm;
  auto object = begun        ? begun->take()
                : is_changed ? create_film_for_denoising(props)
                             : registry_.create(props);
  warn_of_ignored(props, plugin);
  made_.push_back(name);
  if (const auto* const emitter = dynamic_cast<const Emitter*>(object.get())) {
    if (!emitter->is_surface()) check_no_attribute(*object, props.where());
  }
  if (props.category() != Category::kShape) return object;

  auto& shape = dynamic_cast<Shape&>(*object);
  // The shapes in a group, and the parts of a shape, have their own BSDFs and emitters.
  if (dynamic_cast<const ShapeGroup*>(&shape) || !shape.parts().empty()) return object;
  check_attributes(shape, props.where());
  if (shape.emitter()) warn_of_dark_emitter(shape, props.where());
  if (shape.bsdf_pointer()) return object;
  if (shape.emitter()) {
    shape.set_bsdf(make_black_bsdf());
  } else {
    Properties diffuse(Category::kBsdf, "diffuse", props.where());
    shape.set_bsdf(std::dynamic_pointer_cast<Bsdf>(create(diffuse, props.where())));
  }
  return object;
}

/// Adds Mitsuba's default film, sampler and reconstruction filter, as if they were in the scene.
void Builder::add_default_children(Properties& props, const PluginDescriptor& plugin) {
  struct Default {
    Category parent;
    Category child;
    const char* plugin;
  };
  constexpr Default kDefaults[] = {
      {Category::kSensor, Category::kFilm, "hdrfilm"},
      {Category::kSensor, Category::kSampler, "independent"},
      {Category::kFilm, Category::kReconstructionFilter, "gaussian"},
      {Category::kMedium, Category::kPhase, "isotropic"},
  };
  for (const Default& missing : kDefaults) {
    if (missing.parent != props.category() || !takes(plugin, missing.child) ||
        has_object(props, missing.child)) {
      continue;
    }
    Properties child(missing.child, missing.plugin, props.where());
    props.set("_default_" + std::string(to_string(missing.child)), create(child, props.where()),
              props.where());
  }
}

/// Creates a film with a box filter in place of its own, which is recorded. Replaces `props` by the
/// film's properties.
std::shared_ptr<Object> Builder::create_film_for_denoising(Properties& props) {
  Properties boxed(Category::kFilm, props.plugin_name(), props.where());
  boxed.set_id(props.id());
  std::shared_ptr<const ReconstructionFilter> filter;
  for (const auto& [name, entry] : props.entries()) {
    const auto* const object = std::get_if<std::shared_ptr<Object>>(&entry.value);
    auto own = object ? std::dynamic_pointer_cast<ReconstructionFilter>(*object) : nullptr;
    if (own) {
      filter = std::move(own);
      Properties box(Category::kReconstructionFilter, "box", entry.where);
      boxed.set(name, create(box, entry.where), entry.where);
    } else {
      boxed.set(name, entry.value, entry.where);
    }
  }
  props = std::move(boxed);
  auto object = registry_.create(props);
  if (filter) denoising_->filters[dynamic_cast<const Film*>(object.get())] = std::move(filter);
  return object;
}

/// Returns an `aov` integrator that nests the given one and adds the images that guide a denoiser.
std::shared_ptr<Integrator> Builder::with_guides(std::shared_ptr<Integrator> integrator,
                                                 const Location& where) {
  Properties props(Category::kIntegrator, "aov", where);
  props.set("aovs",
            std::string(DenoisingSetup::kAlbedo) + ":guide_albedo," + DenoisingSetup::kNormal +
                ":guide_normal",
            where);
  props.set(DenoisingSetup::kNested, std::shared_ptr<Object>(std::move(integrator)), where);
  return std::dynamic_pointer_cast<Integrator>(create(props, where));
}

}  // namespace kinome::loader
