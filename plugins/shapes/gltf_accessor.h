#pragma once

#include <tiny_gltf.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <vector>

#include "kinome/error.h"

/// Reader of glTF accessors. Checks all indices, offsets and counts against the available bytes.
namespace kinome {

class GltfAccessors {
 public:
  GltfAccessors(const std::string& file, const tinygltf::Model& model)
      : file_(file), model_(model) {
    for (const tinygltf::Buffer& buffer : model.buffers) total_bytes_ += buffer.data.size();
  }

  /// Returns all components of all elements of an accessor. Normalised integers are mapped to [0,
  /// 1] or [-1, 1] (glTF 2.0, 3.6.2.2).
  std::vector<double> read(int index, int type, const std::string& what) const {
    const tinygltf::Accessor& accessor = at(model_.accessors, index, "accessor", what);
    if (accessor.type != type) fail(what + " has an accessor of the wrong type");
    const int components = tinygltf::GetNumComponentsInType(static_cast<uint32_t>(type));
    // Sparse accessors may need no bytes for zeros, so the count is bounded by the size of all
    // data.
    if (accessor.count > total_bytes_) {
      fail(what + " claims " + std::to_string(accessor.count) + " elements, but the file has " +
           std::to_string(total_bytes_) + " bytes of data");
    }
    const auto width = static_cast<size_t>(components);
    std::vector<double> values(accessor.count * width, 0.);
    if (accessor.bufferView >= 0) {
      const View view = find(accessor.bufferView, accessor.byteOffset, accessor.count,
                             element_size(accessor.componentType, width, what), true, what);
      for (size_t i = 0; i < accessor.count; ++i) {
        read_element(view.data + i * view.stride, accessor, width, &values[i * width]);
      }
    } else if (!accessor.sparse.isSparse) {
      fail(what + " has an accessor without data");
    }
    if (accessor.sparse.isSparse) read_sparse(accessor, width, what, values);
    return values;
  }

  /// Number of bytes in the file's buffers.
  size_t total_bytes() const { return total_bytes_; }

  /// Maximum number of elements of the mesh. Nodes may repeat meshes, but a file that exceeds this
  /// limit is probably meant to exhaust memory.
  size_t max_elements() const {
    return (size_t{1} << 20) + std::max(kMaxRepeated * total_bytes_,
                                        std::min(kMaxInstanced * total_bytes_, kMaxElements));
  }

  template <class T>
  const T& at(const std::vector<T>& list, int index, const char* kind,
              const std::string& user) const {
    if (index < 0 || static_cast<size_t>(index) >= list.size()) {
      fail(user + " refers to " + kind + " " + std::to_string(index) + ", but there are " +
           std::to_string(list.size()));
    }
    return list[static_cast<size_t>(index)];
  }

  [[noreturn]] void fail(const std::string& message) const {
    throw Error(Location{file_, 0, 0}, message);
  }

 private:
  /// Maximum number of elements per byte of data.
  static constexpr size_t kMaxRepeated = 16;
  /// The same for small files with many instances, up to kMaxElements, which need a gigabyte.
  static constexpr size_t kMaxInstanced = 1024, kMaxElements = size_t{1} << 25;
  struct View {
    const unsigned char* data;
    size_t stride;
  };

  size_t element_size(int component_type, size_t width, const std::string& what) const {
    const int32_t size = tinygltf::GetComponentSizeInBytes(static_cast<uint32_t>(component_type));
    if (size <= 0) fail(what + " has numbers of an unknown type");
    return static_cast<size_t>(size) * width;
  }

  View find(int view_index, size_t offset, size_t count, size_t size, bool strided,
            const std::string& what) const {
    const tinygltf::BufferView& view = at(model_.bufferViews, view_index, "buffer view", what);
    const tinygltf::Buffer& buffer = at(model_.buffers, view.buffer, "buffer", what);
    if (strided && view.byteStride > 0 && view.byteStride < size) {
      fail(what + " has elements of " + std::to_string(size) + " bytes, but a stride of " +
           std::to_string(view.byteStride));
    }
    const size_t stride = strided && view.byteStride > 0 ? view.byteStride : size;
    const size_t available = buffer.data.size();
    const bool view_fits =
        view.byteOffset <= available && view.byteLength <= available - view.byteOffset;
    const bool fits = view_fits && offset <= view.byteLength &&
                      (count == 0 || (size <= view.byteLength - offset &&
                                      count - 1 <= (view.byteLength - offset - size) / stride));
    if (!fits) {
      fail(what + " reaches beyond its data: " + std::to_string(count) + " elements from byte " +
           std::to_string(offset) + " of a view of " + std::to_string(view.byteLength) +
           " bytes at " + std::to_string(view.byteOffset) + " in a buffer of " +
           std::to_string(available));
    }
    return {buffer.data.data() + view.byteOffset + offset, stride};
  }

  template <class T>
  static double read_number(const unsigned char* bytes, double scale) {
    T value;  // unaligned in the file
    std::memcpy(&value, bytes, sizeof(T));
    return std::max(static_cast<double>(value) * scale, scale == 1 ? -HUGE_VAL : -1.);
  }

  static void read_element(const unsigned char* bytes, const tinygltf::Accessor& accessor,
                           size_t width, double* out) {
    struct Type {
      double (*read)(const unsigned char* bytes, double scale);
      double max;  ///< value to which 1 is normalised
    };
    constexpr Type kTypes[] = {{read_number<int8_t>, 127},    {read_number<uint8_t>, 255},
                               {read_number<int16_t>, 32767}, {read_number<uint16_t>, 65535},
                               {read_number<int32_t>, 1},     {read_number<uint32_t>, 1},
                               {read_number<float>, 1}};
    const auto index = static_cast<size_t>(accessor.componentType - TINYGLTF_COMPONENT_TYPE_BYTE);
    const Type type = index < std::size(kTypes) ? kTypes[index] : Type{read_number<double>, 1};
    const auto size = static_cast<size_t>(
        tinygltf::GetComponentSizeInBytes(static_cast<uint32_t>(accessor.componentType)));
    for (size_t i = 0; i < width; ++i) {
      out[i] = type.read(bytes + i * size, accessor.normalized ? 1 / type.max : 1);
    }
  }

  /// Replaces some elements (glTF 2.0, 3.6.2.3).
  void read_sparse(const tinygltf::Accessor& accessor, size_t width, const std::string& what,
                   std::vector<double>& values) const {
    const auto& sparse = accessor.sparse;
    if (sparse.count < 0 || sparse.indices.byteOffset < 0 || sparse.values.byteOffset < 0) {
      fail(what + " has a sparse accessor with a negative count or offset");
    }
    const auto count = static_cast<size_t>(sparse.count);
    tinygltf::Accessor index_type;
    index_type.componentType = sparse.indices.componentType;
    const View indices =
        find(sparse.indices.bufferView, static_cast<size_t>(sparse.indices.byteOffset), count,
             element_size(index_type.componentType, 1, what), false, what + " (sparse indices)");
    const View replacements =
        find(sparse.values.bufferView, static_cast<size_t>(sparse.values.byteOffset), count,
             element_size(accessor.componentType, width, what), false, what + " (sparse values)");
    for (size_t i = 0; i < count; ++i) {
      double index = 0;
      read_element(indices.data + i * indices.stride, index_type, 1, &index);
      if (!(index >= 0) || !(index < static_cast<double>(accessor.count))) {
        fail(what + " has a sparse index out of range");
      }
      read_element(replacements.data + i * replacements.stride, accessor, width,
                   &values[static_cast<size_t>(index) * width]);
    }
  }

  std::string file_;
  const tinygltf::Model& model_;
  size_t total_bytes_ = 0;
};

}  // namespace kinome
