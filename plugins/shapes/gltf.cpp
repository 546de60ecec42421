/// Triangles from a glTF 2.0 file, as text (.gltf) or binary (.glb).
///
/// All triangle primitives of the default scene's nodes become one mesh, with the nodes' transforms
/// applied; POSITION, NORMAL and TEXCOORD_0 are read, and where a mesh_attribute texture asks for
/// `vertex_color`, the red, green and blue of COLOR_0 (white where a primitive has none).
/// Materials, cameras, lights, skins, morph targets, points and lines are not. Buffers may be
/// embedded or files beside the glTF file. Normals are used where every primitive has them;
/// otherwise they are averaged from the faces. Format: Khronos, "glTF 2.0 Specification", 2021.
///
///     <shape type="gltf"><string name="filename" value="helmet.glb"/></shape>

#include <array>
#include <cmath>
#include <filesystem>
#include <set>

#include "gltf_accessor.h"
#include "kinome/log.h"
#include "kinome/plugin.h"
#include "kinome/wide/mesh.h"
#include "mesh_file.h"
#include "shape_parameters.h"

namespace kinome {
namespace {

constexpr Parameter kTable[] = {
    {"filename", ParameterType::kFile, nullptr, "The glTF file.", true},
    kFaceNormals,
    kFlipNormals,
    {"flip_tex_coords", ParameterType::kBoolean, "false", "Turns v into 1 - v."},
    kToWorld,
    kNestedBsdf,
    kNestedEmitter,
    kNestedSensor,
};

/// Of what the reader of the format says, which may quote megabytes of the file.
std::string first_line(const std::string& text) {
  constexpr size_t kLongest = 200;
  const size_t start = text.find_first_not_of(" \t\r\n");
  if (start == std::string::npos) return "the file is broken";
  const std::string line = text.substr(start, text.find_first_of("\r\n", start) - start);
  return line.size() > kLongest ? line.substr(0, kLongest) + "…" : line;
}

tinygltf::Model parse_gltf(const std::string& file) {
  const std::string bytes = read_mesh_file(file);
  const auto fail = [&](const std::string& message) {
    throw Error(Location{file, 0, 0}, "not a glTF file that can be read: " + message);
  };
  if (bytes.size() > std::numeric_limits<unsigned>::max()) fail("it is larger than 4 GB");
  const auto size = static_cast<unsigned>(bytes.size());
  const std::string folder = std::filesystem::path(file).parent_path().string();
  tinygltf::TinyGLTF reader;
  // Pictures are of no use to a shape.
  reader.SetImageLoader([](tinygltf::Image*, const int, std::string*, std::string*, int, int,
                           const unsigned char*, int, void*) { return true; },
                        nullptr);
  // Pipes and devices, which may have no end, are no buffers.
  const auto exists = [](const std::string& path, void*) {
    std::error_code failed;
    return std::filesystem::is_regular_file(path, failed);
  };
  reader.SetFsCallbacks({exists, tinygltf::ExpandFilePath, tinygltf::ReadWholeFile,
                         tinygltf::WriteWholeFile, nullptr});
  tinygltf::Model model;
  std::string error;
  std::string warning;
  bool ok = false;
  try {
    ok = bytes.starts_with("glTF")
             ? reader.LoadBinaryFromMemory(&model, &error, &warning,
                                           reinterpret_cast<const unsigned char*>(bytes.data()),
                                           size, folder)
             : reader.LoadASCIIFromString(&model, &error, &warning, bytes.data(), size, folder);
  } catch (const std::exception& e) {
    fail(first_line(e.what()));
  }
  if (!ok) fail(first_line(error));
  if (!model.asset.version.starts_with("2.")) {
    fail("its version is '" + model.asset.version.substr(0, 20) + "', expected 2.0");
  }
  return model;
}

class GltfReader {
 public:
  GltfReader(const std::string& file, const tinygltf::Model& model, bool flip_v, bool wants_colors)
      : model_(model),
        accessors_(file, model),
        flip_v_(flip_v),
        wants_colors_(wants_colors),
        visited_(model.nodes.size()) {}

  TriangleMesh read() {
    for (const std::string& extension : model_.extensionsRequired) {
      if (extension == "KHR_draco_mesh_compression" || extension == "EXT_meshopt_compression") {
        accessors_.fail("the file's meshes are compressed (" + extension +
                        "), which is not supported");
      }
    }
    for (const int root : roots()) read_node(root, glm::dmat4(1.), "the scene");
    if (mesh_.triangles.empty()) accessors_.fail("the file has no faces");
    if (any_normals_ && !all_normals_) unused_.insert("normals, which some primitives lack");
    if (!all_normals_) mesh_.normals.clear();
    if (!any_uvs_) mesh_.uvs.clear();
    if (any_colors_) mesh_.attributes.push_back({"vertex_color", 3, std::move(colors_)});
    note_unused();
    return std::move(mesh_);
  }

  /// What the file holds and a mesh has no use for.
  std::vector<std::string> unused() const { return {unused_.begin(), unused_.end()}; }

 private:
  /// Of the file as a whole.
  void note_unused() {
    if (model_.scenes.size() > 1) unused_.insert("scenes other than the default one");
    if (!model_.animations.empty()) unused_.insert("animations");
    for (const std::string& extension : model_.extensionsUsed) {
      unused_.insert("extension " + TextCursor::shorten(extension));
    }
  }

  std::vector<int> roots() const {
    if (!model_.scenes.empty()) {
      const int scene = std::max(model_.defaultScene, 0);
      return accessors_.at(model_.scenes, scene, "scene", "the file").nodes;
    }
    // Without a scene: every node that is nobody's child.
    std::vector<bool> is_child(model_.nodes.size());
    for (const tinygltf::Node& node : model_.nodes) {
      for (const int child : node.children) {
        accessors_.at(model_.nodes, child, "node", "a node");
        is_child[static_cast<size_t>(child)] = true;
      }
    }
    std::vector<int> roots;
    for (size_t i = 0; i < is_child.size(); ++i) {
      if (!is_child[i]) roots.push_back(static_cast<int>(i));
    }
    return roots;
  }

  /// Depth first, without recursion: a file may chain a million nodes.
  void read_node(int root, const glm::dmat4& to_world, const std::string& user) {
    struct Pending {
      int node;
      glm::dmat4 parent;
    };
    std::vector<Pending> pending = {{root, to_world}};
    while (!pending.empty()) {
      const Pending next = pending.back();
      pending.pop_back();
      const tinygltf::Node& node = accessors_.at(model_.nodes, next.node, "node", user);
      const std::string name = "node " + std::to_string(next.node);
      // Nodes form trees (glTF 2.0, 3.5.2).
      if (visited_[static_cast<size_t>(next.node)]) {
        accessors_.fail(name + " has two parents, or is its own ancestor");
      }
      visited_[static_cast<size_t>(next.node)] = true;
      const glm::dmat4 matrix = next.parent * local_matrix(node, name);
      if (node.camera >= 0) unused_.insert("cameras");
      if (node.skin >= 0) unused_.insert("skins");
      if (node.mesh >= 0) {
        const tinygltf::Mesh& mesh = accessors_.at(model_.meshes, node.mesh, "mesh", name);
        for (size_t i = 0; i < mesh.primitives.size(); ++i) {
          read_primitive(mesh.primitives[i], matrix,
                         "mesh " + std::to_string(node.mesh) + ", primitive " + std::to_string(i));
          check_size();
        }
      }
      for (auto child = node.children.rbegin(); child != node.children.rend(); ++child) {
        accessors_.at(model_.nodes, *child, "node", name);
        pending.push_back({*child, matrix});
      }
    }
  }

  void check_size() const {
    const size_t most = accessors_.most_elements();
    if (std::max(mesh_.positions.size(), mesh_.triangles.size()) <= most) return;
    accessors_.fail("the file uses its data too many times: that makes more than " +
                    std::to_string(most) + " vertices or faces");
  }

  glm::dmat4 local_matrix(const tinygltf::Node& node, const std::string& name) const {
    const auto check = [&](const std::vector<double>& v, size_t size, const char* what) {
      if (!v.empty() && v.size() != size) {
        accessors_.fail(name + " has a " + what + " of " + std::to_string(v.size()) +
                        " numbers, expected " + std::to_string(size));
      }
      return !v.empty();
    };
    glm::dmat4 m(1.);
    if (check(node.matrix, 16, "matrix")) {
      for (int i = 0; i < 16; ++i) m[i / 4][i % 4] = node.matrix[static_cast<size_t>(i)];
      return m;
    }
    if (check(node.rotation, 4, "rotation")) {
      const double x = node.rotation[0], y = node.rotation[1], z = node.rotation[2];
      const double w = node.rotation[3];
      m[0] = {1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y), 0};
      m[1] = {2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x), 0};
      m[2] = {2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y), 0};
    }
    if (check(node.scale, 3, "scale")) {
      for (int i = 0; i < 3; ++i) m[i] *= node.scale[static_cast<size_t>(i)];
    }
    if (check(node.translation, 3, "translation")) {
      m[3] = {node.translation[0], node.translation[1], node.translation[2], 1};
    }
    return m;
  }

  void read_primitive(const tinygltf::Primitive& primitive, const glm::dmat4& matrix,
                      const std::string& name) {
    const bool is_list = primitive.mode == TINYGLTF_MODE_TRIANGLES || primitive.mode == -1;
    const bool is_strip = primitive.mode == TINYGLTF_MODE_TRIANGLE_STRIP;
    if (!is_list && !is_strip && primitive.mode != TINYGLTF_MODE_TRIANGLE_FAN) {
      unused_.insert("points and lines");
      return;
    }
    if (primitive.extensions.contains("KHR_draco_mesh_compression")) {
      accessors_.fail(name + " is compressed (KHR_draco_mesh_compression), which is not supported");
    }
    if (primitive.material >= 0) unused_.insert("materials");
    if (!primitive.targets.empty()) unused_.insert("morph targets");
    for (const auto& [attribute, accessor] : primitive.attributes) {
      if (attribute == "POSITION" || attribute == "NORMAL" || attribute == "TEXCOORD_0") continue;
      if (attribute == "COLOR_0" && wants_colors_) continue;
      unused_.insert("attribute " + TextCursor::shorten(attribute));
    }
    const size_t first = mesh_.positions.size();
    const size_t count = read_vertices(primitive, matrix, name);
    if (mesh_.positions.size() > kNoHit) accessors_.fail("the file has too many vertices");
    const std::vector<uint32_t> indices = read_indices(primitive, first, count, name);
    if (is_list && indices.size() % 3 != 0) {
      accessors_.fail(name + " has " + std::to_string(indices.size()) +
                      " indices, expected a multiple of 3");
    }
    const bool mirrored = glm::determinant(glm::dmat3(matrix)) < 0;
    const size_t step = is_list ? 3 : 1;
    for (size_t i = 0; i + 2 < indices.size(); i += step) {
      glm::uvec3 triangle(indices[i], indices[i + 1], indices[i + 2]);
      if (is_strip && i % 2 == 1) std::swap(triangle.y, triangle.z);
      if (!is_list && !is_strip) triangle.x = indices[0];
      // A mirroring node keeps its faces' outside (glTF 2.0, 3.7.4).
      if (mirrored) std::swap(triangle.y, triangle.z);
      mesh_.triangles.push_back(triangle);
    }
  }

  /// Appends the vertices and returns their number.
  size_t read_vertices(const tinygltf::Primitive& primitive, const glm::dmat4& matrix,
                       const std::string& name) {
    const auto read = [&](const char* attribute, int type) {
      const auto found = primitive.attributes.find(attribute);
      if (found == primitive.attributes.end()) return std::vector<double>();
      return accessors_.read(found->second, type, name + ", " + attribute);
    };
    const std::vector<double> positions = read("POSITION", TINYGLTF_TYPE_VEC3);
    const std::vector<double> normals = read("NORMAL", TINYGLTF_TYPE_VEC3);
    const std::vector<double> uvs = read("TEXCOORD_0", TINYGLTF_TYPE_VEC2);
    const size_t count = positions.size() / 3;
    if (count == 0) accessors_.fail(name + " has no positions");
    if ((!normals.empty() && normals.size() != count * 3) ||
        (!uvs.empty() && uvs.size() != count * 2)) {
      accessors_.fail(name + " has attributes of different lengths");
    }
    all_normals_ = all_normals_ && !normals.empty();
    any_normals_ = any_normals_ || !normals.empty();
    any_uvs_ = any_uvs_ || !uvs.empty();
    // Normals go by the cofactors, which are the inverse transpose times the determinant, and
    // exist for a flattening node, too.
    const glm::dmat3 m(matrix);
    const glm::dmat3 cofactors(glm::cross(m[1], m[2]), glm::cross(m[2], m[0]),
                               glm::cross(m[0], m[1]));
    const double sign = glm::determinant(m) < 0 ? -1 : 1;
    for (size_t i = 0; i < count; ++i) {
      const glm::dvec4 p(positions[3 * i], positions[3 * i + 1], positions[3 * i + 2], 1);
      mesh_.positions.emplace_back(matrix * p);
      Vec3 n(0.f);
      if (!normals.empty()) {
        const glm::dvec3 stored(normals[3 * i], normals[3 * i + 1], normals[3 * i + 2]);
        const glm::dvec3 turned = cofactors * stored * sign;
        const double length = glm::length(turned);
        n = Vec3(length > 0 ? turned / length : turned);
      }
      mesh_.normals.push_back(n);
      Vec2 uv(0.f);
      if (!uvs.empty()) {
        uv = Vec2(uvs[2 * i], flip_v_ ? 1 - uvs[2 * i + 1] : uvs[2 * i + 1]);
      }
      mesh_.uvs.push_back(uv);
    }
    if (wants_colors_) read_colors(primitive, count, name);
    return count;
  }

  /// COLOR_0 has three numbers or four, of which the last is an opacity.
  void read_colors(const tinygltf::Primitive& primitive, size_t count, const std::string& name) {
    const size_t before = colors_.size();
    colors_.resize(before + 3 * count, 1.f);
    const auto found = primitive.attributes.find("COLOR_0");
    if (found == primitive.attributes.end()) return;
    any_colors_ = true;
    const std::string what = name + ", COLOR_0";
    const bool has_alpha =
        accessors_.at(model_.accessors, found->second, "accessor", what).type == TINYGLTF_TYPE_VEC4;
    const std::vector<double> values =
        accessors_.read(found->second, has_alpha ? TINYGLTF_TYPE_VEC4 : TINYGLTF_TYPE_VEC3, what);
    const size_t size = has_alpha ? 4 : 3;
    if (values.size() != size * count) {
      accessors_.fail(name + " has attributes of different lengths");
    }
    for (size_t i = 0; i < count; ++i) {
      for (size_t k = 0; k < 3; ++k) {
        if (!std::isfinite(values[size * i + k])) accessors_.fail(what + " is not finite");
        colors_[before + 3 * i + k] = static_cast<float>(values[size * i + k]);
      }
    }
  }

  /// Into the merged mesh, whose vertices of this primitive start at `first`.
  std::vector<uint32_t> read_indices(const tinygltf::Primitive& primitive, size_t first,
                                     size_t count, const std::string& name) const {
    std::vector<uint32_t> indices;
    if (primitive.indices < 0) {
      for (size_t i = 0; i < count; ++i) indices.push_back(static_cast<uint32_t>(first + i));
      return indices;
    }
    const std::vector<double> stored =
        accessors_.read(primitive.indices, TINYGLTF_TYPE_SCALAR, name + ", indices");
    indices.reserve(stored.size());
    for (const double index : stored) {
      if (!(index >= 0) || !(index < static_cast<double>(count)) || index != std::floor(index)) {
        accessors_.fail(name + " refers to vertex " + format_index(index) + ", expected 0 to " +
                        std::to_string(count - 1));
      }
      indices.push_back(static_cast<uint32_t>(first + static_cast<size_t>(index)));
    }
    return indices;
  }

  const tinygltf::Model& model_;
  GltfAccessors accessors_;
  bool flip_v_;
  bool wants_colors_;
  std::vector<bool> visited_;
  TriangleMesh mesh_;
  std::vector<float> colors_;  ///< where they are wanted
  bool any_colors_ = false;
  bool all_normals_ = true;
  bool any_normals_ = false;
  bool any_uvs_ = false;
  std::set<std::string> unused_;
};

class Gltf final : public wide::Mesh {
 public:
  explicit Gltf(const Properties& props) : Mesh(props) {
    const std::string file = props.file("filename");
    const tinygltf::Model model = parse_gltf(file);
    const std::vector<std::string> wanted = wanted_attributes();
    GltfReader reader(file, model, props.boolean("flip_tex_coords"),
                      std::find(wanted.begin(), wanted.end(), "vertex_color") != wanted.end());
    mesh_ = reader.read();
    log_unused(file, reader.unused());
    finish(props, to_world_of(props), props.boolean("face_normals"), props.boolean("flip_normals"));
  }
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Gltf, kinome::Category::kShape, "gltf",
              "Triangles from a glTF 2.0 file: text or binary (glb).", kinome::kTable);
