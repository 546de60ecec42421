// Triangle meshes: checks them, transforms them to world space, computes vertex normals, and
// returns surface points.

#include <algorithm>
#include <cmath>

#include "kinome/error.h"
#include "kinome/log.h"
#include "kinome/wide/mesh.h"

namespace kinome {

namespace {

/// Returns the unit normal of a triangle, or `fallback` if it is degenerate.
Vec3 face_normal(const Vec3& p0, const Vec3& p1, const Vec3& p2, const Vec3& fallback) {
  return wide::formulas::face_normal(p1 - p0, p2 - p0, fallback);
}

double triangle_area(const TriangleMesh& mesh, const glm::uvec3& triangle) {
  const glm::dvec3 p0(mesh.positions[triangle.x]);
  const glm::dvec3 a = glm::dvec3(mesh.positions[triangle.y]) - p0;
  const glm::dvec3 b = glm::dvec3(mesh.positions[triangle.z]) - p0;
  return 0.5 * glm::length(glm::cross(a, b));
}

/// Returns atan2(sine, cosine) for sine >= 0 with an error of 4e-7 (Abramowitz and Stegun 1964,
/// 4.4.49). It is five times as fast as atan2, which would dominate the time for smooth normals.
float angle_from(float sine, float cosine) {
  const float c = std::abs(cosine);
  const float x = std::min(sine, c) / std::max(sine, c);
  const float y = x * x;
  float angle = 0.0028662257f;
  for (const float coefficient : {-0.0161657367f, 0.0429096138f, -0.0752896400f, 0.1065626393f,
                                  -0.1420889944f, 0.1999355085f, -0.3333314528f, 1.f}) {
    angle = angle * y + coefficient;
  }
  angle *= x;
  if (sine > c) angle = kPi / 2 - angle;
  return cosine < 0 ? kPi - angle : angle;
}

/// Replaces zero normals: by the normal of any face if the faces of a vertex cancel out (a sheet
/// folded flat), and by (0, 0, 1) if a vertex has no faces.
void fill_zero_normals(const TriangleMesh& mesh, std::vector<Vec3>& normals) {
  for (const glm::uvec3& triangle : mesh.triangles) {
    for (int i = 0; i < 3; ++i) {
      Vec3& n = normals[triangle[i]];
      if (n != Vec3(0.f)) continue;
      n = face_normal(mesh.positions[triangle.x], mesh.positions[triangle.y],
                      mesh.positions[triangle.z], Vec3(0.f));
    }
  }
  for (Vec3& n : normals) {
    if (n == Vec3(0.f)) n = Vec3(0, 0, 1);
  }
}

/// Returns smooth normals: the mean of face normals, weighted by the angle at the vertex (Thürmer
/// and Wüthrich 1998).
std::vector<Vec3> angle_weighted_normals(const TriangleMesh& mesh) {
  std::vector<Vec3> normals(mesh.positions.size(), Vec3(0.f));
  for (const glm::uvec3& triangle : mesh.triangles) {
    const Vec3 p0 = mesh.positions[triangle.x];
    Vec3 a = mesh.positions[triangle.y] - p0;
    Vec3 b = mesh.positions[triangle.z] - p0;
    const float scale = std::max(max_component(glm::abs(a)), max_component(glm::abs(b)));
    if (!(scale > 0)) continue;
    a /= scale;
    b /= scale;
    const Vec3 cross = glm::cross(a, b);
    const float twice_area = glm::length(cross);
    if (!(twice_area > 0)) continue;
    const Vec3 n = cross / twice_area;
    const float angle0 = angle_from(twice_area, glm::dot(a, b));
    const float angle1 = angle_from(twice_area, glm::dot(a, a - b));
    normals[triangle.x] += n * angle0;
    normals[triangle.y] += n * angle1;
    normals[triangle.z] += n * std::max(kPi - angle0 - angle1, 0.f);
  }
  bool is_any_zero = false;
  for (Vec3& n : normals) {
    const float length = glm::length(n);
    if (length > 0) n /= length;
    is_any_zero |= !(length > 0);
  }
  if (is_any_zero) fill_zero_normals(mesh, normals);
  return normals;
}

/// Gives vertices whose stored normal is zero the normal of their faces. If all are zero, the mesh
/// has no normals.
void fill_missing_normals(TriangleMesh& mesh) {
  auto& normals = mesh.normals;
  const auto zeros = std::count(normals.begin(), normals.end(), Vec3(0.f));
  if (zeros == 0) return;
  if (static_cast<size_t>(zeros) == normals.size()) {
    normals.clear();
    return;
  }
  const std::vector<Vec3> computed = angle_weighted_normals(mesh);
  for (size_t i = 0; i < normals.size(); ++i) {
    if (normals[i] == Vec3(0.f)) normals[i] = computed[i];
  }
}

/// Moves vertices that are not finite and not part of a triangle to 0. Returns their number.
size_t replace_unused_positions(TriangleMesh& mesh) {
  auto& positions = mesh.positions;
  if (std::all_of(positions.begin(), positions.end(), [](const Vec3& p) { return is_finite(p); })) {
    return 0;
  }
  std::vector<bool> is_used(positions.size());
  for (const glm::uvec3& triangle : mesh.triangles) {
    for (int i = 0; i < 3; ++i) {
      if (triangle[i] < positions.size()) is_used[triangle[i]] = true;
    }
  }
  size_t count = 0;
  for (size_t i = 0; i < positions.size(); ++i) {
    if (is_used[i] || is_finite(positions[i])) continue;
    positions[i] = Vec3(0.f);
    ++count;
  }
  return count;
}

/// Sets positions of unused vertices, normals and texture coordinates that are not finite to zero,
/// as if they were missing. Exporters write them for degenerate faces. Returns warnings about them.
std::vector<std::string> replace_non_finite(TriangleMesh& mesh) {
  std::vector<std::string> warnings;
  const auto warn = [&warnings](size_t count, const std::string& what) {
    if (count > 0) warnings.push_back(what + " (" + std::to_string(count) + " of them)");
  };
  warn(replace_unused_positions(mesh), "unused vertices that are not finite are moved to 0");
  size_t count = 0;
  for (Vec3& n : mesh.normals) {
    if (is_finite(n)) continue;
    n = Vec3(0.f);
    ++count;
  }
  warn(count, "normals that are not finite are replaced by those of the faces");
  count = 0;
  for (Vec2& uv : mesh.uvs) {
    if (std::isfinite(uv.x) && std::isfinite(uv.y)) continue;
    uv = Vec2(0.f);
    ++count;
  }
  warn(count, "texture coordinates that are not finite are replaced by 0");
  return warnings;
}

/// Makes at least four bytes past the end readable. They are written once, so that tools such as
/// MemorySanitizer report no uninitialized reads.
void make_readable_beyond(std::vector<Vec3>& values) {
  values.reserve(values.size() + 1);
  values.emplace_back(0.f);
  values.pop_back();
}

std::string number(size_t i) {
  return std::to_string(i);
}

/// Returns what is wrong with the mesh, or "".
std::string find_fault(const TriangleMesh& mesh) {
  const size_t vertices = mesh.positions.size();
  // The indices of coordinates and of triangle corners must fit int32_t.
  constexpr size_t kMaxCount = std::numeric_limits<int32_t>::max() / 3;
  if (vertices > kMaxCount || mesh.triangles.size() > kMaxCount) return "the mesh is too large";
  for (size_t i = 0; i < vertices; ++i) {
    if (!is_finite(mesh.positions[i])) {
      return "vertex " + number(i) + " has a position that is not finite";
    }
  }
  if (!mesh.normals.empty() && mesh.normals.size() != vertices) {
    return "there are " + number(mesh.normals.size()) + " normals for " + number(vertices) +
           " vertices";
  }
  for (size_t i = 0; i < mesh.normals.size(); ++i) {
    if (!is_finite(mesh.normals[i])) {
      return "vertex " + number(i) + " has a normal that is not finite";
    }
  }
  if (!mesh.uvs.empty() && mesh.uvs.size() != vertices) {
    return "there are " + number(mesh.uvs.size()) + " texture coordinates for " + number(vertices) +
           " vertices";
  }
  for (size_t i = 0; i < mesh.uvs.size(); ++i) {
    if (!std::isfinite(mesh.uvs[i].x) || !std::isfinite(mesh.uvs[i].y)) {
      return "vertex " + number(i) + " has a texture coordinate that is not finite";
    }
  }
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    const glm::uvec3& t = mesh.triangles[i];
    const size_t largest = std::max({t.x, t.y, t.z});
    if (largest >= vertices) {
      return "triangle " + number(i) + " refers to vertex " + number(largest) +
             ", but there are only " + number(vertices) + " (counted from 0)";
    }
  }
  return "";
}

}  // namespace

void MeshShape::finish(const Properties& props, const Transform& to_world, bool face_normals,
                       bool flip_normals) {
  const auto fail = [&](const std::string& fault) {
    throw props.has("filename") ? Error(Location{props.file("filename"), 0, 0}, fault)
                                : Error(props.where(), fault);
  };
  if (face_normals) mesh_.normals.clear();
  for (const std::string& repair : replace_non_finite(mesh_)) {
    log_warn(Error(props.has("filename") ? Location{props.file("filename"), 0, 0} : props.where(),
                   repair)
                 .what());
  }
  if (const std::string fault = find_fault(mesh_); !fault.empty()) fail(fault);
  fill_missing_normals(mesh_);
  if (!to_world.is_identity()) {
    for (Vec3& p : mesh_.positions) p = to_world.point(p);
    for (Vec3& n : mesh_.normals) n = to_world.normal(n);
  }
  // Stored normals still point outside after the transform, but the winding of a mirrored triangle
  // is reversed. Without stored normals, the winding decides, as in Mitsuba: a mirrored mesh is
  // then turned inside out.
  flip_normals_ = flip_normals;
  flip_geometric_normal_ = flip_normals;
  if (!mesh_.normals.empty() && to_world.flips_handedness()) {
    flip_geometric_normal_ = !flip_geometric_normal_;
  }
  // Keep normals that the transform makes zero: interaction() uses the face normal for them.
  for (Vec3& n : mesh_.normals) n = wide::formulas::safe_normalize(n, Vec3(0.f));
  if (mesh_.normals.empty() && !face_normals) mesh_.normals = angle_weighted_normals(mesh_);
  if (flip_normals) {
    for (Vec3& n : mesh_.normals) n = -n;
  }

  for (const Vec3& p : mesh_.positions) {
    if (!is_finite(p)) fail("to_world moves a vertex beyond the range of float");
  }
  measure();
}

std::function<void()> MeshShape::replace_mesh(TriangleMesh mesh, bool keep_normals,
                                              const Location& where) {
  if (const std::string fault = find_fault(mesh); !fault.empty()) throw Error(where, fault);
  if (mesh.triangles.empty()) throw Error(where, "the mesh has no faces");
  for (const MeshAttribute& attribute : mesh.attributes) {
    const size_t count = attribute.is_of_faces() ? mesh.triangles.size() : mesh.positions.size();
    if (attribute.values.size() == count * attribute.size) continue;
    throw Error(where, "the attribute '" + attribute.name +
                           "', which textures use, has the wrong number of " +
                           (attribute.is_of_faces() ? "faces" : "vertices"));
  }
  const auto former = std::make_shared<TriangleMesh>(std::move(mesh_));
  const auto put_back = [this, former, flips = flip_geometric_normal_, was = is_replaced_] {
    mesh_ = std::move(*former);
    is_replaced_ = was;
    flip_geometric_normal_ = flips;
    measure();
  };
  mesh_ = std::move(mesh);
  is_replaced_ = true;
  if (keep_normals) {
    for (Vec3& n : mesh_.normals) n = wide::formulas::safe_normalize(n, Vec3(0.f));
  } else if (!mesh_.normals.empty()) {
    mesh_.normals = angle_weighted_normals(mesh_);
    if (flip_normals_) {
      for (Vec3& n : mesh_.normals) n = -n;
    }
    flip_geometric_normal_ = flip_normals_;
  }
  measure();
  return put_back;
}

/// Computes the area and the bounds, after the vertices have been set.
void MeshShape::measure() {
  double area = 0;
  bounds_ = {};
  for (const glm::uvec3& triangle : mesh_.triangles) {
    area += triangle_area(mesh_, triangle);
    for (int i = 0; i < 3; ++i) bounds_.expand(mesh_.positions[triangle[i]]);
  }
  area_ = static_cast<float>(area);
  // Embree and block functions load 16 bytes at a time.
  make_readable_beyond(mesh_.positions);
  make_readable_beyond(mesh_.normals);
  by_area_ = std::make_unique<AreaDistribution>();
}

const GridDistribution& MeshShape::area_distribution() const {
  std::call_once(by_area_->made, [this] {
    std::vector<float> areas;
    areas.reserve(mesh_.triangles.size());
    for (const glm::uvec3& triangle : mesh_.triangles) {
      areas.push_back(static_cast<float>(triangle_area(mesh_, triangle)));
    }
    const auto count = static_cast<uint32_t>(areas.size());
    by_area_->triangles = GridDistribution(count, 1, std::move(areas));
  });
  return by_area_->triangles;
}

SurfaceInteraction MeshShape::sample_surface(const Vec2& u) const {
  const GridDistribution& triangles = area_distribution();
  const GridDistribution::Cell cell =
      triangles.total() > 0 ? triangles.sample(u) : GridDistribution::Cell{0, 0, u};
  const Vec2 barycentric = wide::formulas::square_to_triangle(cell.u);
  Hit hit;
  hit.primitive = cell.column;
  hit.u = barycentric.x;
  hit.v = barycentric.y;
  return sampled_at(hit);
}

SurfaceInteraction MeshShape::sampled_at(const Hit& hit) const {
  SurfaceInteraction si = interaction(Ray{}, hit);
  si.shape = this;
  return si;
}

std::optional<AttributeArrays> MeshShape::attribute(const std::string& name) const {
  for (const MeshAttribute& attribute : mesh_.attributes) {
    if (attribute.name != name) continue;
    if (mesh_.triangles.empty()) return AttributeArrays{&attribute, nullptr, nullptr, Mat4(1.f)};
    return AttributeArrays{&attribute, &mesh_.positions[0].x, &mesh_.triangles[0].x, Mat4(1.f)};
  }
  return std::nullopt;
}

MeshArrays MeshShape::arrays() const {
  return {&mesh_.positions[0].x,
          mesh_.normals.empty() ? nullptr : &mesh_.normals[0].x,
          mesh_.uvs.empty() ? nullptr : &mesh_.uvs[0].x,
          &mesh_.triangles[0].x,
          max_component(bounds_.extent()),
          flip_geometric_normal_};
}

SurfaceInteraction MeshShape::interaction(const Ray& ray, const Hit& hit) const {
  const MeshArrays mesh = arrays();
  const Vec3 backward = wide::formulas::opposite_of(ray.d);
  const auto triangle =
      wide::formulas::triangle_of<float>(mesh, static_cast<int32_t>(3 * hit.primitive), backward);
  SurfaceInteraction si =
      wide::interaction_of(wide::formulas::point_of<float>(mesh, triangle, hit.u, hit.v, backward));
  si.t = ray.tmax;
  si.primitive = hit.primitive;
  return si;
}

}  // namespace kinome
