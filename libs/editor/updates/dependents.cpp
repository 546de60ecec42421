// Finds the objects to make again after an edit, and sets another BSDF, emitter or medium of a
// shape.

#include <algorithm>

#include "editor/updates/edits.h"
#include "kinome/bsdf_medium.h"
#include "kinome/shape_group.h"

namespace kinome::loader {

Dependents::Dependents(const Builder& builder) : builder_(builder), holders_(builder.holders()) {}

/// Returns false for shapes that consist of several ones with BSDFs of their own.
bool Dependents::can_be_refitted(const Node& node) const {
  const auto shape = std::dynamic_pointer_cast<const Shape>(builder_.made_of(node));
  return shape && shape->parts().empty() && !std::dynamic_pointer_cast<const ShapeGroup>(shape);
}

void Dependents::add(const Node& node) {
  if (node.tag == "scene" || !to_make_.insert(&node).second) return;
  if (node.tag == "shape") {
    // Emitters and sensors store a pointer to their shape.
    for (const Node& child : node.children) {
      const Node* const part = is_object(child) ? builder_.resolved(child) : nullptr;
      if (part && (part->tag == "emitter" || part->tag == "sensor")) add(*part);
    }
  }
  for (const Node* const holder : holders_[&node]) {
    const bool is_fitting = node.tag == "bsdf" || node.tag == "emitter" || node.tag == "medium";
    if (holder->tag == "shape" && is_fitting && can_be_refitted(*holder)) {
      add_refitted(*holder);
    } else {
      add(*holder);
    }
  }
}

void Dependents::add_refitted(const Node& shape) {
  if (!to_refit_.insert(&shape).second) return;
  // Shape groups, and shapes built from them, have copied its former state.
  for (const Node* const holder : holders_[&shape]) {
    if (holder->tag == "shape") add(*holder);
  }
}

namespace {

/// Returns the pointer to a medium of a shape, or nullptr if `medium` isn't nested in it.
std::shared_ptr<const Medium> nested_medium(const Shape& shape, const Medium* medium) {
  for (const auto& object : shape.nested()) {
    if (object.get() == medium) return std::dynamic_pointer_cast<const Medium>(object);
  }
  return nullptr;
}

}  // namespace

std::function<void()> refit(Shape& shape, const Node& node, Builder& builder) {
  auto interior = nested_medium(shape, shape.interior());
  auto exterior = nested_medium(shape, shape.exterior());
  const auto put_back = [&shape, bsdf = shape.bsdf_pointer(), emitter = shape.emitter_pointer(),
                         interior = interior ? interior : interior_of(shape.bsdf()), exterior,
                         plugin = shape.plugin(), nested = shape.nested()] {
    shape.set_bsdf(bsdf);
    shape.set_emitter(emitter);
    shape.set_media(interior, exterior);
    shape.set_origin(plugin, nested);
  };
  std::vector<std::shared_ptr<const Object>> nested;
  for (const Node& child : node.children) {
    const Node* const part = is_object(child) ? builder.resolved(child) : nullptr;
    const auto object = part ? builder.object(*part) : nullptr;
    if (!object) continue;
    nested.push_back(object);
    if (const auto bsdf = std::dynamic_pointer_cast<Bsdf>(object)) shape.set_bsdf(bsdf);
    if (const auto emitter = std::dynamic_pointer_cast<Emitter>(object)) shape.set_emitter(emitter);
    if (const auto medium = std::dynamic_pointer_cast<Medium>(object)) {
      (child.value("name") == "interior" ? interior : exterior) = medium;
    }
  }
  std::shared_ptr<const Medium> of_bsdf;
  try {
    of_bsdf = interior_of(shape.bsdf());
  } catch (const Error&) {
    // The scene is built anew, which reports the error with its position.
    put_back();
    return nullptr;
  }
  shape.set_media(of_bsdf ? of_bsdf : interior, exterior);
  shape.set_origin(shape.plugin(), std::move(nested));
  const bool is_allowed = shape.curves() ? !shape.interior() : !of_bsdf || !interior;
  const std::vector<std::string> wanted = shape.requested_attributes();
  if (is_allowed && std::all_of(wanted.begin(), wanted.end(), [&](const std::string& name) {
        return shape.attribute(name).has_value();
      })) {
    return put_back;
  }
  put_back();
  return nullptr;
}

}  // namespace kinome::loader
