// Converts an edited mesh to a PLY file.

#include "editor/saving/saved_mesh.h"

#include <bit>
#include <cmath>

#include <fmt/format.h>

#include "kinome/wide/mesh.h"

namespace kinome::loader {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are written without conversion");

/// Returns true if the triangles' normals are opposite to their winding.
bool is_inside_out(const MeshShape& shape) {
  const TriangleMesh& mesh = *shape.mesh();
  for (uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    const glm::uvec3& t = mesh.triangles[i];
    const Vec3 by_winding = glm::cross(mesh.positions[t.y] - mesh.positions[t.x],
                                       mesh.positions[t.z] - mesh.positions[t.x]);
    if (!(glm::dot(by_winding, by_winding) > 0)) continue;
    Hit hit;
    hit.primitive = i;
    hit.u = hit.v = 1 / 3.f;
    return glm::dot(shape.interaction(Ray{}, hit).n, by_winding) < 0;
  }
  return false;
}

Vec3 normalized(const Vec3& v) {
  return wide::formulas::safe_normalize(v, Vec3(0.f));
}

/// Returns a vector that becomes the unit vector n, bit by bit, when the PLY reader normalises it:
/// usually n itself, otherwise a nearby vector.
Vec3 inverse_normalized(const Vec3& n) {
  constexpr int kMaxSteps = 2;
  if (normalized(n) == n) return n;
  const auto moved = [](float x, int steps) {
    for (; steps > 0; --steps) x = std::nextafter(x, kInfinity);
    for (; steps < 0; ++steps) x = std::nextafter(x, -kInfinity);
    return x;
  };
  for (int i = -kMaxSteps; i <= kMaxSteps; ++i) {
    for (int j = -kMaxSteps; j <= kMaxSteps; ++j) {
      for (int k = -kMaxSteps; k <= kMaxSteps; ++k) {
        const Vec3 near(moved(n.x, i), moved(n.y, j), moved(n.z, k));
        if (normalized(near) == n) return near;
      }
    }
  }
  return n;
}

class PlyText {
 public:
  void line(const std::string& text) { bytes_ += text + "\n"; }
  template <class T>
  void put(const T& value) {
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof(T));
  }
  void put(const MeshAttribute& attribute, size_t item) {
    for (uint32_t k = 0; k < attribute.size; ++k) put(attribute.values[item * attribute.size + k]);
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

/// Declares the properties heat_0, heat_1, … from which "vertex_heat" is read.
void add_properties(const MeshAttribute& attribute, PlyText& ply) {
  const std::string name = attribute.name.substr(attribute.name.find('_') + 1);
  for (uint32_t k = 0; k < attribute.size; ++k)
    ply.line(fmt::format("property float {}_{}", name, k));
}

std::string ply_of(const TriangleMesh& mesh, const std::vector<Vec3>& normals) {
  PlyText ply;
  ply.line("ply\nformat binary_little_endian 1.0");
  ply.line(fmt::format("element vertex {}", mesh.positions.size()));
  ply.line("property float x\nproperty float y\nproperty float z");
  if (!normals.empty()) ply.line("property float nx\nproperty float ny\nproperty float nz");
  if (!mesh.uvs.empty()) ply.line("property float u\nproperty float v");
  for (const auto& a : mesh.attributes) {
    if (!a.is_of_faces()) add_properties(a, ply);
  }
  ply.line(fmt::format("element face {}", mesh.triangles.size()));
  ply.line("property list uchar uint vertex_indices");
  for (const auto& a : mesh.attributes) {
    if (a.is_of_faces()) add_properties(a, ply);
  }
  ply.line("end_header");
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    ply.put(mesh.positions[i]);
    if (!normals.empty()) ply.put(normals[i]);
    if (!mesh.uvs.empty()) ply.put(mesh.uvs[i]);
    for (const auto& a : mesh.attributes) {
      if (!a.is_of_faces()) ply.put(a, i);
    }
  }
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    ply.put(static_cast<uint8_t>(3));
    ply.put(mesh.triangles[i]);
    for (const auto& a : mesh.attributes) {
      if (a.is_of_faces()) ply.put(a, i);
    }
  }
  return ply.bytes();
}

}  // namespace

SavedMesh saved_mesh(const MeshShape& shape, const EditedMesh& edited, const std::string& name) {
  const TriangleMesh& mesh = *shape.mesh();
  const bool flips = is_inside_out(shape);
  // Computed normals aren't written, because the reader computes them again.
  const bool is_computed = edited.has_computed_normals && !edited.normals;
  std::vector<Vec3> normals;
  if (!is_computed) {
    normals = edited.normals ? *edited.normals : mesh.normals;
    for (Vec3& n : normals) {
      if (!edited.normals) n = inverse_normalized(n);
      if (flips) n = -n;  // flip_normals reverts this
    }
  }
  std::vector<ObjectDescription::Value> values{{"filename", name, {}}};
  if (mesh.normals.empty()) values.push_back({"face_normals", true, {}});
  if (flips) values.push_back({"flip_normals", true, {}});
  return {std::move(values), ply_of(mesh, normals)};
}

}  // namespace kinome::loader
