#include "kinome/shape.h"

#include <algorithm>
#include <set>

#include "kinome/bsdf_medium.h"
#include "kinome/texture.h"
#include "kinome/wide/surface_point.h"

namespace kinome {
namespace {

/// Reads a medium. Shapes of other projects may have no such parameter.
std::shared_ptr<const Medium> medium_of(const Properties& props, const char* name) {
  return props.has(name) ? props.object<Medium>(name) : nullptr;
}

std::shared_ptr<const Medium> medium_behind(const Bsdf& bsdf, const Properties& props) {
  try {
    return interior_of(bsdf);
  } catch (const Error& error) {
    throw Error(props.where(), error.what());
  }
}

}  // namespace

Shape::Shape(const Properties& props)
    : bsdf_(props.object<Bsdf>()),
      emitter_(props.object<Emitter>()),
      sensor_(props.object<Sensor>()),
      interior_(medium_of(props, "interior")),
      exterior_(medium_of(props, "exterior")) {
  if (auto medium = bsdf_ ? medium_behind(*bsdf_, props) : nullptr) {
    if (interior_) {
      throw Error(props.where(),
                  "the shape has an interior medium, but its BSDF defines another one: remove one "
                  "of them");
    }
    interior_ = std::move(medium);
  }
  if (sensor_) {
    if (!sensor_->is_surface()) {
      throw Error(props.where(),
                  "this sensor has a position of its own: move it out of the shape into the scene");
    }
    try {
      sensor_->attach(*this);
    } catch (const Error& error) {
      throw Error(props.where(), error.what());
    }
  }
  if (!emitter_) return;
  if (!emitter_->is_surface()) {
    throw Error(props.where(),
                "this emitter has a position or direction of its own: use 'area' for a shape, or "
                "move the emitter out of the shape into the scene");
  }
  try {
    emitter_->attach(*this);
  } catch (const Error& error) {
    throw Error(props.where(), error.what());
  }
}

void Shape::set_emitter(std::shared_ptr<Emitter> emitter) {
  if (emitter && emitter->shape() != this) emitter->attach(*this);
  emitter_ = std::move(emitter);
}

std::vector<std::string> Shape::requested_attributes() const {
  std::vector<std::string> names;
  std::set<const Object*> known;  // a BSDF may be nested in several others
  std::vector<const Object*> left{bsdf_.get(), emitter_.get()};
  while (!left.empty()) {
    const Object* const object = left.back();
    left.pop_back();
    if (!object || !known.insert(object).second) continue;
    for (const auto& part : object->nested()) left.push_back(part.get());
    const auto* const texture = dynamic_cast<const Texture*>(object);
    if (!texture || texture->attribute().empty()) continue;
    if (std::find(names.begin(), names.end(), texture->attribute()) == names.end()) {
      names.push_back(texture->attribute());
    }
  }
  return names;
}

std::optional<SurfaceSample> Shape::sample_solid_angle(const Vec3& p, const Vec2& u) const {
  SurfaceSample sample{sample_surface(u), 0};
  sample.pdf = pdf_solid_angle(p, sample.si);
  if (!(sample.pdf > 0)) return std::nullopt;
  return sample;
}

float Shape::pdf_solid_angle(const Vec3& p, const SurfaceInteraction& si) const {
  return wide::formulas::solid_angle_density(si.p - p, si.n, area());
}

}  // namespace kinome
