#pragma once

#include <nanobind/nanobind.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <numeric>
#include <span>
#include <string>
#include <vector>

#include "kinome/error.h"
#include "kinome/scene.h"
#include "kinome/scene_editor.h"
#include "query_blocks.h"
#include "scene_queries.h"

namespace kinome::python {

/// Surface points as numpy arrays with a row per point, which the caller keeps alive.
struct PointArrays {
  size_t count = 0;
  const Scene* scene = nullptr;                  ///< nullptr if no point is on a shape
  std::array<const float*, kTriples> triples{};  ///< in the order of kTripleColumns
  const float* uv = nullptr;
  const float* p_error = nullptr;
  const uint32_t* primitive = nullptr;
  const uint32_t* shape = nullptr;  ///< index into scene->shapes(), or kNoHit

  explicit PointArrays(const nb::tuple& arrays);
  /// Returns nullptr for a point that is on no shape.
  const Shape* shape_of(size_t i) const;
  /// Returns columns with the points first + rows[0], first + rows[1], ….
  SurfaceBlock gather(size_t first, std::span<const uint32_t> rows, Columns& memory) const;
};

/// Throws Error unless the shapes of all points have the mesh attributes that the object's textures
/// read.
void check_attributes(const Object& object, const PointArrays& points);

/// Returns the object of type T at a path of a scene, or nullptr for the empty path. Throws Error
/// if there is none, or if it can't be evaluated at the points.
template <class T>
const T* object_for(const SceneEditor& editor, const std::string& path, const PointArrays& points) {
  if (path.empty()) return nullptr;
  const auto* const found = dynamic_cast<const T*>(object_at(editor, path));
  if (!found) throw Error("'" + path + "' can't be evaluated at surface points");
  check_attributes(*found, points);
  return found;
}

/// Calls fn(*key, rows) for the rows from 0 to count of each key, except nullptr.
template <class KeyOf, class Function>
void for_each_group(size_t count, const KeyOf& key_of, const Function& fn) {
  using Key = decltype(key_of(0));
  std::vector<Key> keys(count);
  std::vector<uint32_t> rows(count);
  for (size_t i = 0; i < count; ++i) keys[i] = key_of(i);
  std::iota(rows.begin(), rows.end(), 0u);
  std::ranges::stable_sort(rows, std::less<Key>(), [&](uint32_t i) { return keys[i]; });
  for (size_t begin = 0; begin < count;) {
    const Key key = keys[rows[begin]];
    size_t end = begin + 1;
    while (end < count && keys[rows[end]] == key) ++end;
    if (key) fn(*key, std::span<const uint32_t>(rows).subspan(begin, end - begin));
    begin = end;
  }
}

}  // namespace kinome::python
