#include "editor/saving/placed_transform.h"

#include <algorithm>

#include "editor/saving/written_values.h"
#include "scene_xml/values/convert.h"

namespace kinome::loader {
namespace {

/// Tolerance for rounding in the file's numbers, relative to the largest component of each column.
constexpr float kTolerance = 1e-5f;

bool are_near(const Mat4& a, const Mat4& b) {
  for (int column = 0; column < 4; ++column) {
    const float size = max_component(glm::abs(Vec3(a[column])));
    const float off = max_component(glm::abs(Vec3(a[column]) - Vec3(b[column])));
    if (!(off <= kTolerance * size)) return false;
  }
  return true;
}

Node step(const char* tag, std::vector<std::pair<const char*, std::string>> attributes,
          const Location& where) {
  Node node;
  node.tag = tag;
  node.where = where;
  for (auto& [name, value] : attributes) node.attributes.push_back({name, std::move(value), where});
  return node;
}

/// Returns a <lookat> from the origin of `m` along its z axis.
Node lookat(const Mat4& m, float distance, const Location& where) {
  const Vec3 origin(m[3]), target = origin + distance * glm::normalize(Vec3(m[2]));
  return step("lookat",
              {{"origin", written_triple(origin)},
               {"target", written_triple(target)},
               {"up", written_triple(Vec3(m[1]))}},
              where);
}

Node translate(const Mat4& m, const Location& where) {
  const Vec3 way(m[3]);
  return step(
      "translate",
      {{"x", written_number(way.x)}, {"y", written_number(way.y)}, {"z", written_number(way.z)}},
      where);
}

/// Returns the distance from origin to target of a <lookat>.
float distance_of(const Node& lookat) {
  return glm::length(convert_triple(lookat, *lookat.find("target")) -
                     convert_triple(lookat, *lookat.find("origin")));
}

}  // namespace

std::shared_ptr<Node> placed_transform(const Node* written, const std::string& name,
                                       const Mat4& matrix, const Location& where) {
  auto result = std::make_shared<Node>(step("transform", {{"name", name}}, where));
  if (written) result->children = written->children;
  const std::string last = result->children.empty() ? "" : result->children.back().tag;
  float distance = 1;
  if (last == "lookat") distance = distance_of(result->children.back());
  if (last == "lookat" || last == "translate") result->children.pop_back();
  const Transform before = convert_transform(*result);
  if (!before.is_invertible()) return nullptr;
  const Mat4 rest = matrix * before.inverse().matrix();
  // A farther target represents the direction more precisely in rounded numbers.
  const float far = max_component(glm::abs(Vec3(rest[3])));
  for (const float length : {distance, 10 * far, 1000 * far}) {
    result->children.push_back(last == "lookat" ? lookat(rest, length, where)
                                                : translate(rest, where));
    const Node& added = result->children.back();
    const bool is_valid = last != "lookat" || added.value("origin") != added.value("target");
    if (is_valid && are_near(matrix, convert_transform(*result).matrix())) return result;
    result->children.pop_back();
  }
  return nullptr;
}

}  // namespace kinome::loader
