/// Triangles from a glTF 2.0 file, as text (.gltf) or binary (.glb).
///
/// All triangle primitives of the default scene's nodes become one mesh. The nodes' transforms,
/// skins and morph targets are applied as set in the file. The reader uses POSITION, NORMAL and
/// TEXCOORD_0. If a mesh_attribute texture reads `vertex_color`, it also uses the red, green and
/// blue of COLOR_0 (white for primitives without it). Primitives without normals are flat.
///
/// Instances of EXT_mesh_gpu_instancing become copies in the mesh. KHR_mesh_quantization and
/// KHR_node_visibility are supported; compression is not. Animations, materials, cameras, lights,
/// points and lines are ignored. Buffers may be embedded, or files relative to the glTF file.
/// Format: Khronos, "glTF 2.0 Specification", 2021.
///
///     <shape type="gltf"><string name="filename" value="helmet.glb"/></shape>

#include <array>
#include <cmath>
#include <set>

#include "gltf_extensions.h"
#include "gltf_file.h"
#include "gltf_node.h"
#include "gltf_primitive.h"
#include "gltf_skin.h"
#include "kinome/log.h"
#include "kinome/plugin.h"
#include "kinome/wide/mesh.h"
#include "mesh_file.h"
#include "shape_parameters.h"

namespace kinome {
namespace {

constexpr Parameter kTable[] = {
    {"filename", ParameterType::kFile, nullptr, "glTF file (.gltf or .glb).", true},
    kFaceNormals,
    kFlipNormals,
    {"flip_tex_coords", ParameterType::kBoolean, "false", "Replace v by 1 - v."},
    kToWorld,
    KINOME_NESTED_IN_SHAPES,
};

class GltfReader {
 public:
  GltfReader(const std::string& file, const tinygltf::Model& model, bool flip_v, bool reads_colors)
      : model_(model),
        accessors_(file, model),
        skins_(accessors_, model),
        flip_v_(flip_v),
        reads_colors_(reads_colors),
        visited_(model.nodes.size()) {}

  TriangleMesh read() {
    for (const std::string& extension : model_.extensionsRequired) {
      if (!is_supported(extension)) accessors_.fail(unsupported(extension));
    }
    for (const tinygltf::Mesh& mesh : model_.meshes) {
      for (const tinygltf::Primitive& primitive : mesh.primitives) {
        has_normals_ = has_normals_ || primitive.attributes.contains("NORMAL");
      }
    }
    std::vector<PlacedNode> nodes;
    for (const int root : roots()) collect_nodes(root, nodes);
    check_claims(nodes);
    for (const PlacedNode& node : nodes) read_node(node);
    if (!has_normals_) mesh_.normals.clear();
    if (!any_uvs_) mesh_.uvs.clear();
    if (any_colors_) mesh_.attributes.push_back({"vertex_color", 3, std::move(colors_)});
    note_unused();
    return std::move(mesh_);
  }

  /// True if no primitive has normals, so that all faces are flat (glTF 2.0, 3.7.2.1).
  bool is_flat() const { return !has_normals_; }
  bool has_materials() const { return has_materials_; }
  /// Number of primitives that were skipped because they have no triangles.
  size_t skipped_primitives() const { return skipped_primitives_; }
  /// Parts of the file that are ignored.
  std::vector<std::string> unused() const { return {unused_.begin(), unused_.end()}; }

 private:
  struct PlacedNode {
    int node;
    glm::dmat4 matrix;  ///< from the node's space to the scene's
  };

  /// Records ignored parts of the whole file.
  void note_unused() {
    if (model_.scenes.size() > 1) unused_.insert("scenes other than the default one");
    if (!model_.animations.empty()) unused_.insert("animations");
    for (const std::string& extension : model_.extensionsUsed) {
      if (extension == "EXT_mesh_gpu_instancing" || extension == "KHR_mesh_quantization" ||
          extension == "KHR_node_visibility") {
        continue;
      }
      unused_.insert("extension " + TextCursor::shorten(extension));
    }
  }

  std::vector<int> roots() const {
    if (!model_.scenes.empty()) {
      const int scene = std::max(model_.defaultScene, 0);
      return accessors_.at(model_.scenes, scene, "scene", "the file").nodes;
    }
    // Without a scene, every node without a parent.
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

  /// Appends the visible nodes of the tree below `root`, depth first. Not recursive, because a file
  /// may have a chain of a million nodes.
  void collect_nodes(int root, std::vector<PlacedNode>& nodes) {
    accessors_.at(model_.nodes, root, "node", "the scene");
    std::vector<PlacedNode> pending = {{root, glm::dmat4(1.)}};
    while (!pending.empty()) {
      PlacedNode next = pending.back();
      pending.pop_back();
      const tinygltf::Node& node = model_.nodes[static_cast<size_t>(next.node)];
      const std::string name = name_of(next);
      // Nodes form trees (glTF 2.0, 3.5.2).
      if (visited_[static_cast<size_t>(next.node)]) {
        accessors_.fail(name + " has two parents, or is its own ancestor");
      }
      visited_[static_cast<size_t>(next.node)] = true;
      if (is_hidden(node)) continue;
      next.matrix *= local_matrix(accessors_, node, name);
      nodes.push_back(next);
      for (auto child = node.children.rbegin(); child != node.children.rend(); ++child) {
        accessors_.at(model_.nodes, *child, "node", name);
        pending.push_back({*child, next.matrix});
      }
    }
  }

  static std::string name_of(const PlacedNode& placed) {
    return "node " + std::to_string(placed.node);
  }

  void read_node(const PlacedNode& placed) {
    const tinygltf::Node& node = model_.nodes[static_cast<size_t>(placed.node)];
    if (node.camera >= 0) unused_.insert("cameras");
    if (node.mesh >= 0) read_mesh(node, placed.matrix, name_of(placed));
  }

  /// Returns the number of elements that an accessor claims. Returns 0 if there is no such
  /// accessor, or if it claims more than the file can contain; reading it then reports the error.
  size_t claimed_count(int accessor) const {
    if (accessor < 0 || static_cast<size_t>(accessor) >= model_.accessors.size()) return 0;
    const size_t count = model_.accessors[static_cast<size_t>(accessor)].count;
    return count > accessors_.total_bytes() ? 0 : count;
  }

  /// Returns the number of vertices or of faces that a primitive adds, whichever is larger.
  size_t claimed_elements(const tinygltf::Primitive& primitive) const {
    const auto positions = primitive.attributes.find("POSITION");
    if (!is_of_triangles(primitive) || positions == primitive.attributes.end()) return 0;
    const size_t vertices = claimed_count(positions->second);
    const size_t corners = primitive.indices < 0 ? vertices : claimed_count(primitive.indices);
    const size_t faces = face_count(primitive, corners);
    const bool is_flat = has_normals_ && !primitive.attributes.contains("NORMAL");
    return std::max(is_flat ? 3 * faces : vertices, faces);
  }

  /// Throws, before any memory is allocated, if the nodes repeat meshes too often.
  void check_claims(const std::vector<PlacedNode>& nodes) const {
    std::vector<double> elements_of_mesh;
    for (const tinygltf::Mesh& mesh : model_.meshes) {
      double elements = 0;
      for (const auto& primitive : mesh.primitives) {
        elements += static_cast<double>(claimed_elements(primitive));
      }
      elements_of_mesh.push_back(elements);
    }
    double elements = 0;
    for (const PlacedNode& placed : nodes) {
      const tinygltf::Node& node = model_.nodes[static_cast<size_t>(placed.node)];
      if (node.mesh < 0 || static_cast<size_t>(node.mesh) >= elements_of_mesh.size()) continue;
      size_t copies = 1;
      // All copies of a skinned mesh are identical.
      for (const int accessor : node.skin < 0 ? instance_accessors(node) : std::vector<int>()) {
        copies = std::max(copies, claimed_count(accessor));
      }
      elements += static_cast<double>(copies) * elements_of_mesh[static_cast<size_t>(node.mesh)];
    }
    if (elements > static_cast<double>(accessors_.max_elements())) fail_by_size();
  }

  void check_size() const {
    if (mesh_.positions.size() > kNoHit) accessors_.fail("the file has too many vertices");
    const size_t elements = std::max(mesh_.positions.size(), mesh_.triangles.size());
    if (elements > accessors_.max_elements()) fail_by_size();
  }

  [[noreturn]] void fail_by_size() const {
    accessors_.fail("the file repeats its data too often: the mesh must have at most " +
                    std::to_string(accessors_.max_elements()) + " vertices and faces");
  }

  void read_mesh(const tinygltf::Node& node, const glm::dmat4& matrix, const std::string& user) {
    const tinygltf::Mesh& mesh = accessors_.at(model_.meshes, node.mesh, "mesh", user);
    const std::vector<double>& weights = node.weights.empty() ? mesh.weights : node.weights;
    std::vector<glm::dmat4> joints;
    if (node.skin >= 0) joints = skins_.joint_matrices(node.skin, user);
    std::vector<glm::dmat4> copies = instance_matrices(accessors_, node, user);
    for (glm::dmat4& copy : copies) copy = matrix * copy;
    for (size_t i = 0; i < mesh.primitives.size(); ++i) {
      read_primitive(mesh.primitives[i], weights, joints, copies,
                     "mesh " + std::to_string(node.mesh) + ", primitive " + std::to_string(i));
    }
  }

  void note_unused(const tinygltf::Primitive& primitive, bool is_skinned) {
    if (primitive.material >= 0) has_materials_ = true;
    for (const auto& [attribute, accessor] : primitive.attributes) {
      if (attribute == "POSITION" || attribute == "NORMAL" || attribute == "TEXCOORD_0") continue;
      if (attribute == "COLOR_0" && reads_colors_) continue;
      const bool is_of_skin = attribute.starts_with("JOINTS_") || attribute.starts_with("WEIGHTS_");
      if (is_skinned && is_of_skin) continue;
      unused_.insert("attribute " + TextCursor::shorten(attribute));
    }
  }

  /// Adds copies of a primitive. `joints` is empty if there is no skin.
  void read_primitive(const tinygltf::Primitive& primitive, const std::vector<double>& weights,
                      const std::vector<glm::dmat4>& joints, const std::vector<glm::dmat4>& copies,
                      const std::string& name) {
    if (!is_of_triangles(primitive)) {
      ++skipped_primitives_;
      return;
    }
    // A compressed primitive may also contain uncompressed data.
    const auto positions = primitive.attributes.find("POSITION");
    if (primitive.extensions.contains("KHR_draco_mesh_compression") &&
        (positions == primitive.attributes.end() ||
         accessors_.at(model_.accessors, positions->second, "accessor", name).bufferView < 0)) {
      accessors_.fail(name +
                      " is compressed by KHR_draco_mesh_compression, which is unsupported: "
                      "export it without compression");
    }
    const GltfVertices vertices = read_vertices(accessors_, primitive, weights, name);
    std::vector<float> colors;
    if (reads_colors_) {
      colors = read_colors(accessors_, model_, primitive, vertices.count, name);
      any_colors_ = any_colors_ || primitive.attributes.contains("COLOR_0");
    }
    const std::vector<glm::uvec3> triangles =
        read_triangles(accessors_, primitive, vertices.count, name);
    std::vector<glm::dmat4> skinned;
    if (!joints.empty()) {
      skinned = skinned_vertices(accessors_, primitive, joints, vertices.count, name);
    }
    note_unused(primitive, !skinned.empty());
    any_uvs_ = any_uvs_ || !vertices.uvs.empty();
    // The transform of a skinned mesh's node has no effect (glTF 2.0, 3.7.3.3).
    for (const glm::dmat4& copy : copies) {
      const auto matrix_of = [&](size_t i) -> const glm::dmat4& {
        return skinned.empty() ? copy : skinned[i];
      };
      if (vertices.normals.empty() && has_normals_) {
        add_flat(vertices, triangles, colors, matrix_of);
      } else {
        add(vertices, triangles, colors, matrix_of);
      }
      check_size();
      if (!skinned.empty()) break;  // all copies are identical
    }
  }

  template <class MatrixOf>
  void add(const GltfVertices& vertices, const std::vector<glm::uvec3>& triangles,
           const std::vector<float>& colors, const MatrixOf& matrix_of) {
    const auto first = static_cast<uint32_t>(mesh_.positions.size());
    for (size_t i = 0; i < vertices.count; ++i) add_vertex(vertices, i, matrix_of(i));
    colors_.insert(colors_.end(), colors.begin(), colors.end());
    for (glm::uvec3 triangle : triangles) {
      // Nodes that mirror keep the outside of faces (glTF 2.0, 3.7.4).
      if (mirrors(matrix_of(triangle.x))) std::swap(triangle.y, triangle.z);
      mesh_.triangles.push_back(triangle + first);
    }
  }

  /// Like add(), but with separate vertices for each triangle. Their normals are zero, which
  /// MeshShape::finish() replaces by the triangle's normal.
  template <class MatrixOf>
  void add_flat(const GltfVertices& vertices, const std::vector<glm::uvec3>& triangles,
                const std::vector<float>& colors, const MatrixOf& matrix_of) {
    for (glm::uvec3 triangle : triangles) {
      if (mirrors(matrix_of(triangle.x))) std::swap(triangle.y, triangle.z);
      const auto first = static_cast<uint32_t>(mesh_.positions.size());
      for (int k = 0; k < 3; ++k) {
        const size_t i = triangle[k];
        add_vertex(vertices, i, matrix_of(i));
        if (colors.empty()) continue;
        colors_.insert(colors_.end(), &colors[3 * i], &colors[3 * i] + 3);
      }
      mesh_.triangles.emplace_back(first, first + 1, first + 2);
    }
  }

  static bool mirrors(const glm::dmat4& matrix) { return glm::determinant(glm::dmat3(matrix)) < 0; }

  void add_vertex(const GltfVertices& vertices, size_t i, const glm::dmat4& matrix) {
    const double* const p = &vertices.positions[3 * i];
    mesh_.positions.emplace_back(matrix * glm::dvec4(p[0], p[1], p[2], 1));
    Vec3 n(0.f);
    if (!vertices.normals.empty()) {
      const double* const stored = &vertices.normals[3 * i];
      // Normals are transformed by the cofactor matrix, which is the inverse transpose times the
      // determinant. It exists even if the node flattens.
      const glm::dmat3 m(matrix);
      const glm::dmat3 cofactors(glm::cross(m[1], m[2]), glm::cross(m[2], m[0]),
                                 glm::cross(m[0], m[1]));
      const double sign = glm::determinant(m) < 0 ? -1 : 1;
      const glm::dvec3 turned = cofactors * glm::dvec3(stored[0], stored[1], stored[2]) * sign;
      const double length = glm::length(turned);
      n = Vec3(length > 0 ? turned / length : turned);
    }
    mesh_.normals.push_back(n);
    Vec2 uv(0.f);
    if (!vertices.uvs.empty()) {
      const double v = vertices.uvs[2 * i + 1];
      uv = Vec2(vertices.uvs[2 * i], flip_v_ ? 1 - v : v);
    }
    mesh_.uvs.push_back(uv);
  }

  const tinygltf::Model& model_;
  GltfAccessors accessors_;
  GltfSkins skins_;
  bool flip_v_;
  bool reads_colors_;
  std::vector<bool> visited_;
  TriangleMesh mesh_;
  std::vector<float> colors_;  ///< empty unless a texture reads them
  bool any_colors_ = false;
  bool has_normals_ = false;
  bool any_uvs_ = false;
  bool has_materials_ = false;
  size_t skipped_primitives_ = 0;
  std::set<std::string> unused_;
};

class Gltf final : public wide::Mesh {
 public:
  explicit Gltf(const Properties& props) : Mesh(props) {
    const std::string file = props.file("filename");
    const tinygltf::Model model = parse_gltf(file);
    const std::vector<std::string> requested = requested_attributes();
    GltfReader reader(
        file, model, props.boolean("flip_tex_coords"),
        std::find(requested.begin(), requested.end(), "vertex_color") != requested.end());
    mesh_ = reader.read();
    const auto warn = [&](const std::string& what) {
      log_warn(Error(Location{file, 0, 0}, what).what());
    };
    if (const size_t skipped = reader.skipped_primitives(); skipped > 0) {
      warn("primitives of points or lines are skipped (" + std::to_string(skipped) + " of them)");
    }
    if (reader.has_materials() && !bsdf_pointer()) {
      warn("its materials are ignored: give the shape a bsdf");
    }
    log_unused(file, reader.unused());
    if (mesh_.triangles.empty()) warn_of_no_faces(file);
    const bool face_normals = props.boolean("face_normals") || reader.is_flat();
    finish(props, to_world_of(props), face_normals, props.boolean("flip_normals"));
  }
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Gltf, kinome::Category::kShape, "gltf",
              "Triangles from a glTF 2.0 file: text or binary (glb).", kinome::kTable);
