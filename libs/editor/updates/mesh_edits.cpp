// Edits of a mesh's arrays.

#include "editor/updates/edits.h"
#include "kinome/mesh_shape.h"

namespace kinome::loader {
namespace {

constexpr const char* kPositions = "vertex_positions";
constexpr const char* kNormals = "vertex_normals";
constexpr const char* kUvs = "vertex_texcoords";
constexpr const char* kFaces = "faces";

template <class Number, class Item>
std::vector<Number> flat(const std::vector<Item>& items) {
  std::vector<Number> numbers;
  numbers.reserve(items.size() * Item::length());
  for (const Item& item : items) {
    for (glm::length_t i = 0; i < Item::length(); ++i) numbers.push_back(item[i]);
  }
  return numbers;
}

template <class Item, class Number>
std::vector<Item> unflattened(const std::vector<Number>& numbers) {
  std::vector<Item> items(numbers.size() / Item::length());
  for (size_t i = 0; i < items.size() * Item::length(); ++i) {
    items[i / Item::length()][static_cast<glm::length_t>(i % Item::length())] = numbers[i];
  }
  return items;
}

}  // namespace

std::vector<const char*> mesh_arrays(const Object* shape) {
  if (!dynamic_cast<const MeshShape*>(shape)) return {};
  return {kPositions, kNormals, kUvs, kFaces};
}

EditedValue mesh_array(const Object& shape, const std::string& name) {
  const TriangleMesh& mesh = *dynamic_cast<const MeshShape&>(shape).mesh();
  if (name == kFaces) return flat<uint32_t>(mesh.triangles);
  return name == kPositions ? flat<float>(mesh.positions)
         : name == kNormals ? flat<float>(mesh.normals)
                            : flat<float>(mesh.uvs);
}

void check_mesh_array(const std::string& name, const EditedValue& value, const Location& where) {
  const bool is_of_faces = name == kFaces;
  const size_t each = name == kUvs ? 2 : 3;
  const auto* const floats = std::get_if<std::vector<float>>(&value);
  const auto* const integers = std::get_if<std::vector<uint32_t>>(&value);
  if (is_of_faces ? !integers : !floats) {
    throw Error(where,
                "'" + name + "' must be an array of " + (is_of_faces ? "indices" : "floats"));
  }
  const size_t size = floats ? floats->size() : integers->size();
  if (size % each == 0) return;
  throw Error(where, "'" + name + "' must have " + std::to_string(each) + " numbers for each " +
                         (is_of_faces ? "face" : "vertex") + ", got " + std::to_string(size));
}

std::function<void()> edit_mesh(Object& shape, const MeshEdits& edits, EditedMesh& edited,
                                const Location& where) {
  auto& mesh_shape = dynamic_cast<MeshShape&>(shape);
  TriangleMesh mesh = *mesh_shape.mesh();
  EditedMesh after = edited;
  bool has_normals = false;
  for (const auto& [name, value] : edits) {
    if (name == kFaces) {
      mesh.triangles = unflattened<glm::uvec3>(std::get<std::vector<uint32_t>>(value));
      after.has_faces = true;
      continue;
    }
    const auto& floats = std::get<std::vector<float>>(value);
    if (name == kPositions) {
      mesh.positions = unflattened<Vec3>(floats);
      after.has_positions = true;
    } else if (name == kUvs) {
      mesh.uvs = unflattened<Vec2>(floats);
      after.has_uvs = true;
    } else {
      mesh.normals = unflattened<Vec3>(floats);
      after.normals = std::make_shared<const std::vector<Vec3>>(mesh.normals);
      has_normals = true;
    }
  }
  // Edits of texture coordinates alone don't change the normals. Computed normals are computed
  // again, and normals that were set are set again in their original form, because normalising them
  // twice could change a bit.
  const bool is_same_shape = !edits.count(kPositions) && !edits.count(kFaces);
  const bool were_computed = after.has_computed_normals && !after.normals;
  const bool computes = !has_normals && (!is_same_shape || were_computed) && !mesh.normals.empty();
  if (!has_normals && is_same_shape && after.normals) mesh.normals = *after.normals;
  if (computes) {
    mesh.normals.resize(mesh.positions.size(), Vec3(0.f));
    after.has_computed_normals = true;
    after.normals = nullptr;
  }
  auto undo = mesh_shape.replace_mesh(std::move(mesh), !computes, where);
  edited = std::move(after);
  return undo;
}

std::function<void()> carry_over(const Object& former, const EditedMesh& edited, Object& shape,
                                 const Location& where) {
  auto& mesh_shape = dynamic_cast<MeshShape&>(shape);
  const TriangleMesh& before = *dynamic_cast<const MeshShape&>(former).mesh();
  TriangleMesh mesh = *mesh_shape.mesh();
  if (edited.has_positions) mesh.positions = before.positions;
  if (edited.has_uvs) mesh.uvs = before.uvs;
  if (edited.has_faces) mesh.triangles = before.triangles;
  const bool computes = edited.has_computed_normals;
  // The values don't matter if normals are computed or replaced below.
  if (computes) mesh.normals.assign(mesh.positions.size(), Vec3(0.f));
  if (edited.normals && !computes) mesh.normals = *edited.normals;
  auto undo = mesh_shape.replace_mesh(std::move(mesh), !computes, where);
  if (!edited.normals || !computes) return undo;
  // Computing normals first determines which side is outside: see MeshShape::replace_mesh().
  mesh = *mesh_shape.mesh();
  mesh.normals = *edited.normals;
  const auto undo_normals = mesh_shape.replace_mesh(std::move(mesh), true, where);
  return [undo, undo_normals] {
    undo_normals();
    undo();
  };
}

}  // namespace kinome::loader
