#include <algorithm>
#include <cmath>

#include "kinome/error.h"
#include "kinome/shape.h"

namespace kinome {

namespace {

/// v / |v| without under- or overflow of |v|²; `fallback` where v is zero or not finite. Edges of
/// a small mesh scaled by 1e-6 have cross products whose squares are below the smallest float.
Vec3 safe_normalize(const Vec3& v, const Vec3& fallback) {
  // Nearly always, and without the wait for a first division.
  const float length2 = glm::dot(v, v);
  if (length2 > 1e-20f && length2 < 1e20f) return v / std::sqrt(length2);
  const float scale = max_component(glm::abs(v));
  if (!(scale > 0) || !std::isfinite(scale)) return fallback;
  return glm::normalize(v / scale);
}

/// Not normalised, and scaled to edges of length about 1; zero for a degenerate triangle.
Vec3 face_direction(const Vec3& p0, const Vec3& p1, const Vec3& p2) {
  const Vec3 a = p1 - p0;
  const Vec3 b = p2 - p0;
  const float scale = std::max(max_component(glm::abs(a)), max_component(glm::abs(b)));
  if (!(scale > 0)) return Vec3(0.f);
  return glm::cross(a / scale, b / scale);
}

/// Unit normal of a triangle; `fallback` where it is degenerate.
Vec3 face_normal(const Vec3& p0, const Vec3& p1, const Vec3& p2, const Vec3& fallback) {
  const Vec3 cross = glm::cross(p1 - p0, p2 - p0);
  const float length2 = glm::dot(cross, cross);
  if (length2 > 1e-20f && length2 < 1e20f) return cross / std::sqrt(length2);
  return safe_normalize(face_direction(p0, p1, p2), fallback);
}

double triangle_area(const TriangleMesh& mesh, const glm::uvec3& triangle) {
  const glm::dvec3 p0(mesh.positions[triangle.x]);
  const glm::dvec3 a = glm::dvec3(mesh.positions[triangle.y]) - p0;
  const glm::dvec3 b = glm::dvec3(mesh.positions[triangle.z]) - p0;
  return 0.5 * glm::length(glm::cross(a, b));
}

/// The angle in [0, pi] whose sine and cosine are as `sine` >= 0 to `cosine`: atan2 to 4e-7
/// (Abramowitz and Stegun 1964, 4.4.49) in a fifth of its time, of which smooth normals would take
/// most.
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

/// Where faces cancel out (a sheet folded flat), any of them is as good as another; a vertex of
/// none needs no normal.
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

/// Smooth normals: faces weighted by their angle at the vertex (Thürmer and Wüthrich 1998).
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

std::string number(size_t i) {
  return std::to_string(i);
}

/// What is wrong with the mesh, or "".
std::string find_fault(const TriangleMesh& mesh) {
  const size_t vertices = mesh.positions.size();
  if (mesh.triangles.empty()) return "the mesh has no faces";
  if (vertices > kNoHit || mesh.triangles.size() > kNoHit) return "the mesh is too large";
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

struct PartialDerivatives {
  Vec3 du, dv;
};

/// Of the position by uv: solves du duv_i.x + dv duv_i.y = edge_i. A frame where uv is degenerate.
PartialDerivatives position_derivatives(const Vec3& e1, const Vec3& e2, const Vec2& duv1,
                                        const Vec2& duv2, const Vec3& n) {
  // In double, since texture coordinates of neighbours may differ in their last bits only.
  const double det = static_cast<double>(duv1.x) * duv2.y - static_cast<double>(duv1.y) * duv2.x;
  if (det != 0) {
    const glm::dvec3 a(e1);
    const glm::dvec3 b(e2);
    const double inverse = 1 / det;
    const Vec3 du((a * static_cast<double>(duv2.y) - b * static_cast<double>(duv1.y)) * inverse);
    const Vec3 dv((b * static_cast<double>(duv1.x) - a * static_cast<double>(duv2.x)) * inverse);
    if (is_finite(du) && is_finite(dv)) return {du, dv};
  }
  const Frame frame = Frame::from_normal(n);
  return {frame.s, frame.t};
}

/// Bound on the distance of a computed point, and of rays started near it, from the triangle's
/// plane. With u = 2^-24 and M the largest coordinate of the vertices: b0 = 1 - b1 - b2 is off by
/// at most 2u, the three products and two sums by gamma_3 M, the moved origin is rounded once (u),
/// so each coordinate is off by less than 7 u M, and the distance by sqrt(3) times that: < 13 u M.
/// Embree's own test subtracts the origin from the vertices and evaluates two dot products of three
/// terms on them: relative error below 8u of the distance to the vertices (the normal taken as it
/// is), which is at most sqrt(3) E, E being the largest side of the mesh's bounds, and 2 sqrt(3) M.
/// Twice the sum is safe against the third-order terms left out. At M = 1 it is 5e-6 at most,
/// twenty times smaller than a fixed 1e-4; of a small mesh far away, three times less than of one
/// that reaches from there to the origin. It is no bound for a triangle next to this one whose
/// coordinates are much larger.
float plane_error(const Vec3& p0, const Vec3& p1, const Vec3& p2, const Aabb& bounds) {
  const float largest = max_component(glm::max(glm::max(glm::abs(p0), glm::abs(p1)), glm::abs(p2)));
  const float side = max_component(bounds.extent());
  return 0x1p-24f * (26 * largest + std::min(56 * largest, 28 * side));
}

}  // namespace

void MeshShape::finish(const Properties& props, const Transform& to_world, bool face_normals,
                       bool flip_normals) {
  const auto fail = [&](const std::string& fault) {
    throw props.has("filename") ? Error(Location{props.file("filename"), 0, 0}, fault)
                                : Error(props.where(), fault);
  };
  if (const std::string fault = find_fault(mesh_); !fault.empty()) fail(fault);
  if (face_normals) mesh_.normals.clear();
  if (!to_world.is_identity()) {
    for (Vec3& p : mesh_.positions) p = to_world.point(p);
    for (Vec3& n : mesh_.normals) n = to_world.normal(n);
  }
  // Stored normals are transformed as they are and still point outside; a mirrored triangle's
  // winding doesn't. Without stored normals the winding is all there is, and decides, as in
  // Mitsuba: a mirrored mesh is then turned inside out.
  flip_geometric_normal_ = flip_normals;
  if (!mesh_.normals.empty() && to_world.flips_handedness()) {
    flip_geometric_normal_ = !flip_geometric_normal_;
  }
  // A zero normal stays zero: interaction() then takes the face's.
  for (Vec3& n : mesh_.normals) n = safe_normalize(n, Vec3(0.f));
  if (mesh_.normals.empty() && !face_normals) mesh_.normals = angle_weighted_normals(mesh_);
  if (flip_normals) {
    for (Vec3& n : mesh_.normals) n = -n;
  }

  for (const Vec3& p : mesh_.positions) {
    if (!is_finite(p)) fail("to_world moves a vertex beyond the range of float");
  }
  double area = 0;
  for (const glm::uvec3& triangle : mesh_.triangles) {
    area += triangle_area(mesh_, triangle);
    for (int i = 0; i < 3; ++i) bounds_.expand(mesh_.positions[triangle[i]]);
  }
  area_ = static_cast<float>(area);
  // Four readable bytes past the end, for Embree's 16-byte loads; written once, so that tools that
  // track initialised memory stay quiet.
  mesh_.positions.reserve(mesh_.positions.size() + 1);
  mesh_.positions.emplace_back(0.f);
  mesh_.positions.pop_back();
}

SurfaceInteraction MeshShape::sample_surface(const Vec2& u) const {
  std::call_once(by_area_made_, [this] {
    std::vector<float> areas;
    areas.reserve(mesh_.triangles.size());
    for (const glm::uvec3& triangle : mesh_.triangles) {
      areas.push_back(static_cast<float>(triangle_area(mesh_, triangle)));
    }
    const auto count = static_cast<uint32_t>(areas.size());
    by_area_ = GridDistribution(count, 1, std::move(areas));
  });
  const GridDistribution::Cell cell =
      by_area_.total() > 0 ? by_area_.sample(u) : GridDistribution::Cell{0, 0, u};
  // The square is folded along its diagonal, which keeps what is near, near (Heitz 2019, "A
  // low-distortion map between triangle and square").
  Hit hit;
  hit.primitive = cell.column;
  const float half = std::min(cell.u.x, cell.u.y) / 2;
  hit.u = cell.u.x > cell.u.y ? cell.u.x - half : half;
  hit.v = cell.u.x > cell.u.y ? half : cell.u.y - half;
  return sampled_at(hit);
}

SurfaceInteraction MeshShape::sampled_at(const Hit& hit) const {
  SurfaceInteraction si = interaction(Ray{}, hit);
  si.shape = this;
  return si;
}

SurfaceInteraction MeshShape::interaction(const Ray& ray, const Hit& hit) const {
  const glm::uvec3 triangle = mesh_.triangles[hit.primitive];
  const Vec3 p0 = mesh_.positions[triangle.x];
  const Vec3 p1 = mesh_.positions[triangle.y];
  const Vec3 p2 = mesh_.positions[triangle.z];
  const float b1 = hit.u;
  const float b2 = hit.v;
  const float b0 = 1 - b1 - b2;

  SurfaceInteraction si;
  si.t = ray.tmax;
  si.p = b0 * p0 + b1 * p1 + b2 * p2;
  si.p_error = plane_error(p0, p1, p2, bounds_);
  si.primitive = hit.primitive;
  const Vec3 backward = safe_normalize(-ray.d, Vec3(0, 0, 1));
  si.n = face_normal(p0, p1, p2, backward);
  if (flip_geometric_normal_) si.n = -si.n;

  if (mesh_.uvs.empty()) {
    si.uv = {b1, b2};
    si.dp_du = p1 - p0;
    si.dp_dv = p2 - p0;
  } else {
    const Vec2 uv0 = mesh_.uvs[triangle.x];
    const Vec2 uv1 = mesh_.uvs[triangle.y];
    const Vec2 uv2 = mesh_.uvs[triangle.z];
    si.uv = b0 * uv0 + b1 * uv1 + b2 * uv2;
    const auto [du, dv] = position_derivatives(p1 - p0, p2 - p0, uv1 - uv0, uv2 - uv0, si.n);
    si.dp_du = du;
    si.dp_dv = dv;
  }

  Vec3 shading_normal = si.n;
  if (!mesh_.normals.empty()) {
    shading_normal =
        safe_normalize(b0 * mesh_.normals[triangle.x] + b1 * mesh_.normals[triangle.y] +
                           b2 * mesh_.normals[triangle.z],
                       si.n);
  }
  si.frame = Frame::from_normal_and_tangent(shading_normal, si.dp_du);
  si.wi = si.frame.to_local(backward);
  return si;
}

}  // namespace kinome
