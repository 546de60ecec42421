/// Triangles from a PLY file: ascii, or binary with either byte order.
///
/// The reader uses x, y, z, nx, ny, nz and u, v (or texture_u, texture_v, or s, t) of the vertices,
/// with any numeric type, and vertex_indices (or vertex_index) of faces or triangle strips
/// (tristrips). Polygons are split into fans. If the vertices have no texture coordinates, a list
/// 'texcoord' of each face gives those of its corners. Faces with fewer than three vertices are
/// skipped with a warning. Other properties and elements are ignored, except attributes that a
/// mesh_attribute texture reads. If the file has no normals, they are averaged from the faces,
/// weighted by angle. Format: Turk 1994, "The PLY Polygon File Format".
///
///     <shape type="ply"><string name="filename" value="bunny.ply"/></shape>

#include "ply_source.h"

#include <cmath>

#include "kinome/log.h"
#include "kinome/plugin.h"
#include "kinome/wide/mesh.h"
#include "mesh_file.h"
#include "ply_attributes.h"
#include "ply_header.h"
#include "ply_wedges.h"
#include "shape_parameters.h"

namespace kinome {
namespace {

constexpr Parameter kTable[] = {
    {"filename", ParameterType::kFile, nullptr, "PLY file.", true},
    kFaceNormals,
    kFlipNormals,
    {"flip_tex_coords", ParameterType::kBoolean, "false", "Replace v by 1 - v."},
    kToWorld,
    KINOME_NESTED_IN_SHAPES,
};

/// Meaning of a vertex property.
enum class Role { kX, kY, kZ, kNormalX, kNormalY, kNormalZ, kU, kV, kNone };

struct Roles {
  std::vector<Role> of_property;
  bool positions = false, normals = false, uvs = false;
};

Roles find_roles(const PlyElement& element) {
  const auto index = [&](const char* name) { return element.find_scalar(name); };
  Roles roles;
  roles.of_property.assign(element.properties.size(), Role::kNone);
  const auto assign = [&](std::initializer_list<int> properties, Role first) {
    for (const int i : properties) {
      if (i < 0) return false;
    }
    int role = static_cast<int>(first);
    for (const int i : properties) roles.of_property[i] = static_cast<Role>(role++);
    return true;
  };
  roles.positions = assign({index("x"), index("y"), index("z")}, Role::kX);
  roles.normals = assign({index("nx"), index("ny"), index("nz")}, Role::kNormalX);
  // The first existing pair, as in Mitsuba 3.
  roles.uvs = assign({index("u"), index("v")}, Role::kU) ||
              assign({index("texture_u"), index("texture_v")}, Role::kU) ||
              assign({index("s"), index("t")}, Role::kU);
  return roles;
}

template <class Source>
void check_count(const Source& source, const PlyElement& element) {
  size_t min_size = 0;
  for (const PlyProperty& property : element.properties) {
    min_size += Source::min_size(property.is_list ? property.count_type : property.type);
  }
  if (min_size > 0 && element.count > source.bytes_left() / min_size) {
    source.fail("the header promises " + std::to_string(element.count) + " of '" + element.name +
                "', but only " + std::to_string(source.bytes_left()) + " bytes follow");
  }
}

template <class Source>
size_t read_list_size(Source& source, const PlyProperty& property) {
  const double size = source.next(property.count_type);
  if (!(size >= 0) || size != std::floor(size)) {
    source.fail("a list of '" + property.name + "' has a length of " + std::to_string(size));
  }
  const size_t min_size = Source::min_size(property.type);
  if (size > static_cast<double>(source.bytes_left() / min_size)) {
    source.fail("a list of '" + property.name + "' is longer than the rest of the file");
  }
  return static_cast<size_t>(size);
}

template <class Source>
void skip_property(Source& source, const PlyProperty& property) {
  const size_t count = property.is_list ? read_list_size(source, property) : 1;
  for (size_t i = 0; i < count; ++i) source.next(property.type);
}

template <class Source>
void skip_element(Source& source, const PlyElement& element) {
  if (element.properties.empty()) return;
  for (uint64_t i = 0; i < element.count; ++i) {
    for (const PlyProperty& property : element.properties) skip_property(source, property);
    source.end_item();
  }
}

/// Returns the index of the property that lists the corners of faces or strips, or -1.
int find_indices(const PlyElement& faces) {
  const int indices = faces.find_list("vertex_indices");
  return indices < 0 ? faces.find_list("vertex_index") : indices;
}

template <class Source>
float read_attribute(Source& source, const PlyProperty& property) {
  const auto value = static_cast<float>(source.next(property.type));
  if (!std::isfinite(value)) source.fail("'" + property.name + "' has a value that is not finite");
  return value;
}

template <class Source>
void read_vertices(Source& source, const PlyElement& element, bool flip_v,
                   const std::vector<std::string>& requested, TriangleMesh& mesh) {
  AttributeReader attributes(element, "vertex_", requested);
  const Roles roles = find_roles(element);
  if (!roles.positions) source.fail("the vertices lack x, y or z");
  mesh.positions.reserve(element.count + 1);
  if (roles.normals) mesh.normals.reserve(element.count);
  if (roles.uvs) mesh.uvs.reserve(element.count);
  for (uint64_t i = 0; i < element.count; ++i) {
    float values[9] = {};  // by role; the last entry is for properties without one
    attributes.begin_item();
    for (size_t k = 0; k < element.properties.size(); ++k) {
      const PlyProperty& property = element.properties[k];
      if (property.is_list) {
        skip_property(source, property);
      } else if (attributes.is_used(k)) {
        attributes.put(k, read_attribute(source, property));
      } else {
        values[static_cast<int>(roles.of_property[k])] =
            static_cast<float>(source.next(property.type));
      }
    }
    const Vec3 position(values[0], values[1], values[2]);
    if (!is_finite(position)) {
      source.fail("vertex " + std::to_string(i) + " has a position that is not finite");
    }
    mesh.positions.push_back(position);
    if (roles.normals) mesh.normals.emplace_back(values[3], values[4], values[5]);
    if (roles.uvs) mesh.uvs.emplace_back(values[6], flip_v ? 1 - values[7] : values[7]);
    source.end_item();
  }
  attributes.move_to(mesh);
}

/// Throws unless `index` is the index of a vertex.
template <class Source>
uint32_t checked_vertex(const Source& source, double index, const char* what, uint64_t item,
                        uint64_t vertex_count) {
  if (vertex_count == 0) source.fail("the file has no vertices");
  if (!(index >= 0) || !(index < static_cast<double>(vertex_count)) || index != std::floor(index)) {
    source.fail(what + (' ' + std::to_string(item)) + " refers to vertex " + format_index(index) +
                ", expected 0 to " + std::to_string(vertex_count - 1));
  }
  return static_cast<uint32_t>(index);
}

/// Reads one polygon as a fan around its first vertex. Returns false, and adds no triangle, if it
/// has fewer than three vertices.
template <class Source>
bool read_polygon(Source& source, const PlyProperty& property, uint64_t face, uint64_t vertex_count,
                  TriangleMesh& mesh) {
  const size_t size = read_list_size(source, property);
  glm::uvec3 triangle(0);
  for (size_t i = 0; i < size; ++i) {
    const uint32_t vertex =
        checked_vertex(source, source.next(property.type), "face", face, vertex_count);
    if (i < 3) {
      triangle[static_cast<int>(i)] = vertex;
    } else {
      triangle = {triangle.x, triangle.z, vertex};
    }
    if (i >= 2) mesh.triangles.push_back(triangle);
  }
  return size >= 3;
}

/// Reads triangle strips; -1 ends a strip. Every other triangle of a strip is flipped, so that all
/// face the same way.
template <class Source>
void read_strips(Source& source, const PlyElement& element, uint64_t vertex_count,
                 TriangleMesh& mesh) {
  const int indices = find_indices(element);
  if (indices < 0) source.fail("the tristrips lack a list 'vertex_indices' or 'vertex_index'");
  for (uint64_t i = 0; i < element.count; ++i) {
    for (size_t k = 0; k < element.properties.size(); ++k) {
      const PlyProperty& property = element.properties[k];
      if (static_cast<int>(k) != indices) {
        skip_property(source, property);
        continue;
      }
      glm::uvec3 latest(0);
      size_t length = 0;
      for (size_t left = read_list_size(source, property); left > 0; --left) {
        const double index = source.next(property.type);
        if (index == -1) {
          length = 0;
          continue;
        }
        latest = {latest.y, latest.z, checked_vertex(source, index, "tristrips", i, vertex_count)};
        if (++length < 3) continue;
        mesh.triangles.push_back(length % 2 == 1 ? latest
                                                 : glm::uvec3(latest.y, latest.x, latest.z));
      }
    }
    source.end_item();
  }
}

/// Returns the parts of the file that are ignored.
std::vector<std::string> unused_parts(const PlyHeader& header,
                                      const std::vector<std::string>& requested) {
  std::vector<std::string> unused;
  const PlyElement* const vertices = header.find("vertex");
  const bool has_wedges = vertices && !find_roles(*vertices).uvs;
  for (const PlyElement& element : header.elements) {
    const std::string title = TextCursor::shorten(element.name);
    const bool is_vertex = element.name == "vertex";
    if (!is_vertex && element.name != "face" && element.name != "tristrips") {
      unused.push_back("element '" + title + "'");
      continue;
    }
    const Roles roles = find_roles(element);
    const AttributeReader attributes({element.name, 0, element.properties},
                                     is_vertex ? "vertex_" : "face_", requested);
    const int indices = find_indices(element);
    const int uvs = has_wedges && element.name == "face" ? PlyWedges::find(element) : -1;
    for (size_t i = 0; i < element.properties.size(); ++i) {
      const PlyProperty& property = element.properties[i];
      const int index = static_cast<int>(i);
      const bool is_used = attributes.is_used(i) || (is_vertex ? roles.of_property[i] != Role::kNone
                                                               : index == indices || index == uvs);
      if (!is_used) unused.push_back(title + " '" + TextCursor::shorten(property.name) + "'");
    }
  }
  return unused;
}

/// Returns the number of faces that were skipped because they have fewer than three vertices.
template <class Source>
uint64_t read_faces(Source& source, const PlyElement& element, uint64_t vertex_count,
                    const std::vector<std::string>& requested, PlyWedges* wedges,
                    TriangleMesh& mesh) {
  AttributeReader attributes(element, "face_", requested);
  const int uvs = wedges ? PlyWedges::find(element) : -1;
  if (wedges) wedges->begin(mesh.triangles.size());
  const int indices = find_indices(element);
  if (indices < 0) source.fail("the faces lack a list 'vertex_indices' or 'vertex_index'");
  mesh.triangles.reserve(element.count);
  uint64_t skipped = 0;
  for (uint64_t i = 0; i < element.count; ++i) {
    attributes.begin_item();
    const size_t before = mesh.triangles.size();
    for (size_t k = 0; k < element.properties.size(); ++k) {
      if (static_cast<int>(k) == indices) {
        if (!read_polygon(source, element.properties[k], i, vertex_count, mesh)) ++skipped;
      } else if (static_cast<int>(k) == uvs) {
        const PlyProperty& property = element.properties[k];
        for (size_t left = read_list_size(source, property); left > 0; --left) {
          wedges->put(static_cast<float>(source.next(property.type)));
        }
      } else if (attributes.is_used(k)) {
        attributes.put(k, read_attribute(source, element.properties[k]));
      } else {
        skip_property(source, element.properties[k]);
      }
    }
    attributes.repeat(mesh.triangles.size() - before);
    if (uvs >= 0) wedges->end_face(mesh.triangles.size() - before);
    source.end_item();
  }
  attributes.move_to(mesh);
  return skipped;
}

template <class Source>
TriangleMesh read_body(Source& source, const std::string& file, const PlyHeader& header,
                       bool flip_v, const std::vector<std::string>& requested) {
  const PlyElement* vertices = header.find("vertex");
  if (!vertices) source.fail("the file has no vertices");
  TriangleMesh mesh;
  PlyWedges wedges(flip_v);
  const bool has_wedges = !find_roles(*vertices).uvs;
  uint64_t skipped = 0;
  for (const PlyElement& element : header.elements) {
    check_count(source, element);
    if (&element == vertices) {
      read_vertices(source, element, flip_v, requested, mesh);
    } else if (element.count > 0 && element.name == "face") {
      skipped = read_faces(source, element, vertices->count, requested,
                           has_wedges ? &wedges : nullptr, mesh);
    } else if (element.count > 0 && element.name == "tristrips") {
      read_strips(source, element, vertices->count, mesh);
    } else {
      skip_element(source, element);
    }
  }
  source.finish();
  for (const MeshAttribute& attribute : mesh.attributes) {
    if (!attribute.is_of_faces()) continue;
    if (attribute.values.size() == mesh.triangles.size() * attribute.size) continue;
    throw Error(Location{file, 0, 0},
                "'" + attribute.name + "' has values for the faces, but not for the tristrips");
  }
  wedges.move_to(mesh);
  if (skipped > 0) {
    log_warn(Error(Location{file, 0, 0}, "faces of fewer than three vertices are skipped (" +
                                             std::to_string(skipped) + " of them)")
                 .what());
  }
  if (mesh.triangles.empty()) warn_of_no_faces(file);
  return mesh;
}

/// Like read_body(), but if the file is damaged, throws the likely cause instead of the first
/// symptom.
template <class Source>
TriangleMesh read_from(Source source, const std::string& file, const PlyHeader& header, bool flip_v,
                       const std::vector<std::string>& requested) {
  try {
    return read_body(source, file, header, flip_v, requested);
  } catch (const Error&) {
    source.throw_cause();
    throw;
  }
}

class Ply final : public wide::Mesh {
 public:
  explicit Ply(const Properties& props) : Mesh(props) {
    const std::string file = props.file("filename");
    const std::string bytes = file_contents(file);
    const PlyHeader header = read_ply_header(file, bytes);
    const std::string_view body = std::string_view(bytes).substr(header.bytes);
    const bool flip_v = props.boolean("flip_tex_coords");
    const std::vector<std::string> requested = requested_attributes();
    constexpr bool kBigEndianHost = std::endian::native == std::endian::big;
    if (header.format == PlyFormat::kAscii) {
      mesh_ = read_from(AsciiSource(file, header, body), file, header, flip_v, requested);
    } else if ((header.format == PlyFormat::kBigEndian) == kBigEndianHost) {
      mesh_ = read_from(BinarySource<false>(file, header, body), file, header, flip_v, requested);
    } else {
      mesh_ = read_from(BinarySource<true>(file, header, body), file, header, flip_v, requested);
    }
    log_unused(file, unused_parts(header, requested));
    finish(props, to_world_of(props), props.boolean("face_normals"), props.boolean("flip_normals"));
  }
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Ply, kinome::Category::kShape, "ply",
              "Triangles from a PLY file: ascii or binary.", kinome::kTable);
