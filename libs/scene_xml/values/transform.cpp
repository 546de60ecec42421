// <transform> and the operations in it.

#include <algorithm>
#include <cmath>
#include <functional>

#include <fmt/format.h>
#include <glm/gtc/matrix_transform.hpp>

#include "base/numbers.h"
#include "kinome/log.h"
#include "kinome/look_at.h"
#include "scene_xml/values/convert.h"

namespace kinome::loader {
namespace {

using DMat4 = glm::dmat4;
using DVec3 = glm::dvec3;

DMat4 rotation(const Node& node) {
  const Attribute& attribute = *node.find("angle");
  const auto degrees = parse_real(attribute.value);
  if (!degrees)
    throw Error(attribute.where, "'" + attribute.value + "' is not an angle in degrees");
  const auto is_axis = [](const Attribute& a) { return a.name != "angle"; };
  if (std::none_of(node.attributes.begin(), node.attributes.end(), is_axis)) {
    throw Error(node.where, "<rotate> needs an attribute 'value', or some of x, y, z");
  }
  const float zero = 0;
  const DVec3 axis(convert_vector(node, &zero));
  const double length = glm::length(axis);
  if (length == 0) throw Error(node.where, "the axis of a rotation can't be zero");
  if (std::abs(length - 1) > 1e-3) {
    log_warn(
        Error(node.where,
              fmt::format("the axis of this rotation has length {:.4g} and is normalised; Mitsuba "
                          "3 doesn't normalise it, which distorts objects: its image differs",
                          length))
            .what());
  }
  return glm::rotate(DMat4(1), glm::radians(*degrees), glm::normalize(axis));
}

DMat4 look_at(const Node& node) {
  const Vec3 origin = convert_triple(node, *node.find("origin"));
  const Vec3 target = convert_triple(node, *node.find("target"));
  if (origin == target) throw Error(node.where, "origin and target are the same point");
  const Attribute* const up_attribute = node.find("up");
  Vec3 up(0);
  if (up_attribute) up = convert_triple(node, *up_attribute);
  // Without 'up', any perpendicular axis will do.
  if (glm::length(up) == 0) {
    up = Frame::from_normal(Vec3(glm::normalize(DVec3(target) - DVec3(origin)))).s;
  }
  const auto to_world = kinome::look_at(origin, target, up);
  if (!to_world) throw Error(up_attribute->where, "'up' is parallel to the viewing direction");
  return *to_world;
}

DMat4 matrix(const Node& node) {
  const Attribute& attribute = *node.find("value");
  const auto numbers = parse_reals(attribute.value);
  const size_t count = numbers ? numbers->size() : 0;
  if (count != 9 && count != 16) {
    throw Error(attribute.where, "a <matrix> needs 9 or 16 numbers" +
                                     (count ? ", got " + std::to_string(count) : std::string()));
  }
  const int side = count == 9 ? 3 : 4;
  DMat4 m(1);
  for (int i = 0; i < side * side; ++i) m[i % side][i / side] = (*numbers)[static_cast<size_t>(i)];
  return m;
}

DMat4 operation(const Node& node) {
  const float zero = 0, one = 1;
  if (node.tag == "translate") return glm::translate(DMat4(1), DVec3(convert_vector(node, &zero)));
  if (node.tag == "scale") return glm::scale(DMat4(1), DVec3(convert_vector(node, &one)));
  if (node.tag == "rotate") return rotation(node);
  if (node.tag == "lookat") return look_at(node);
  return matrix(node);
}

}  // namespace

Transform convert_transform(const Node& node) {
  DMat4 total(1);
  std::vector<Error> faults;
  for (const Node& child : node.children) {
    if (child.is_broken) continue;
    try {
      const DMat4 next = operation(child) * total;
      if (!Transform(Mat4(next)).is_invertible()) {
        throw Error(child.where, quoted_tag(child) + " makes the transform singular");
      }
      total = next;
    } catch (const Error& error) {
      faults.push_back(error);
    }
  }
  if (!faults.empty()) throw Errors(std::move(faults));
  return Transform(Mat4(total));
}

}  // namespace kinome::loader
