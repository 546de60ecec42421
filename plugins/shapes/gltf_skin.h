#pragma once

#include <optional>
#include <string>
#include <vector>

#include "gltf_node.h"

/// Skins of glTF files, in the pose given by the nodes (glTF 2.0, 3.7.3).
namespace kinome {

/// Transforms of the joints of a file's skins.
class GltfSkins {
 public:
  GltfSkins(const GltfAccessors& accessors, const tinygltf::Model& model)
      : accessors_(accessors),
        model_(model),
        parents_(model.nodes.size(), -1),
        known_(model.nodes.size()) {
    for (size_t i = 0; i < model.nodes.size(); ++i) {
      for (const int child : model.nodes[i].children) {
        accessors.at(model.nodes, child, "node", "a node");
        parents_[static_cast<size_t>(child)] = static_cast<int>(i);
      }
    }
  }

  /// Returns, for each joint of a skin, the matrix from the mesh's space in the bind pose to the
  /// scene's space.
  std::vector<glm::dmat4> joint_matrices(int skin_index, const std::string& user) {
    const tinygltf::Skin& skin = accessors_.at(model_.skins, skin_index, "skin", user);
    const std::string name = "skin " + std::to_string(skin_index);
    std::vector<double> inverse_bind;
    if (skin.inverseBindMatrices >= 0) {
      inverse_bind = accessors_.read(skin.inverseBindMatrices, TINYGLTF_TYPE_MAT4,
                                     name + ", inverseBindMatrices");
      if (inverse_bind.size() < 16 * skin.joints.size()) {
        accessors_.fail(name + " has fewer inverseBindMatrices than joints");
      }
    }
    std::vector<glm::dmat4> matrices;
    for (size_t i = 0; i < skin.joints.size(); ++i) {
      glm::dmat4 m = scene_matrix(skin.joints[i], name);
      if (!inverse_bind.empty()) {
        glm::dmat4 bind;
        for (int k = 0; k < 16; ++k) bind[k / 4][k % 4] = inverse_bind[16 * i + k];
        m *= bind;
      }
      matrices.push_back(m);
    }
    return matrices;
  }

 private:
  /// Returns the transform from a node's space to the scene's. Each is computed once, because
  /// joints share long chains of ancestors.
  const glm::dmat4& scene_matrix(int index, const std::string& user) {
    accessors_.at(model_.nodes, index, "node", user);
    std::vector<size_t> path;
    for (int i = index; i >= 0 && !known_[static_cast<size_t>(i)];
         i = parents_[static_cast<size_t>(i)]) {
      path.push_back(static_cast<size_t>(i));
      if (path.size() > parents_.size()) {
        accessors_.fail("node " + std::to_string(i) + " is its own ancestor");
      }
    }
    for (; !path.empty(); path.pop_back()) {
      const size_t i = path.back();
      const glm::dmat4 local =
          local_matrix(accessors_, model_.nodes[i], "node " + std::to_string(i));
      known_[i] = parents_[i] < 0 ? local : *known_[static_cast<size_t>(parents_[i])] * local;
    }
    return *known_[static_cast<size_t>(index)];
  }

  const GltfAccessors& accessors_;
  const tinygltf::Model& model_;
  std::vector<int> parents_;
  std::vector<std::optional<glm::dmat4>> known_;
};

/// Returns the matrix of each vertex of a skinned primitive, blended from the joints' matrices.
/// Empty if the primitive has no joints.
inline std::vector<glm::dmat4> skinned_vertices(const GltfAccessors& accessors,
                                                const tinygltf::Primitive& primitive,
                                                const std::vector<glm::dmat4>& joints, size_t count,
                                                const std::string& name) {
  std::vector<glm::dmat4> blended;
  std::vector<double> sums(count, 0.);
  for (int set = 0;; ++set) {
    const auto find = [&](const std::string& attribute) {
      const auto found = primitive.attributes.find(attribute + std::to_string(set));
      return found == primitive.attributes.end() ? -1 : found->second;
    };
    const int joints_accessor = find("JOINTS_"), weights_accessor = find("WEIGHTS_");
    if (joints_accessor < 0 || weights_accessor < 0) break;
    const auto indices =
        accessors.read(joints_accessor, TINYGLTF_TYPE_VEC4, name + ", joints of vertices");
    const auto weights =
        accessors.read(weights_accessor, TINYGLTF_TYPE_VEC4, name + ", weights of joints");
    if (indices.size() != 4 * count || weights.size() != 4 * count) {
      accessors.fail(name + " has attributes of different lengths");
    }
    blended.resize(count, glm::dmat4(0.));
    for (size_t i = 0; i < 4 * count; ++i) {
      if (weights[i] == 0) continue;
      if (!(indices[i] >= 0) || !(indices[i] < static_cast<double>(joints.size()))) {
        accessors.fail(name + " refers to joint " + format_index(indices[i]) +
                       " of a skin that has " + std::to_string(joints.size()));
      }
      blended[i / 4] += weights[i] * joints[static_cast<size_t>(indices[i])];
      sums[i / 4] += weights[i];
    }
  }
  for (size_t i = 0; i < blended.size(); ++i) {
    if (!(std::abs(sums[i]) > 0)) accessors.fail(name + " has a vertex without joint weights");
    blended[i] /= sums[i];
  }
  return blended;
}

}  // namespace kinome
