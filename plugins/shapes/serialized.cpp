/// Triangles from a serialized file of Mitsuba 0.5 or 0.6. The file contains one or more compressed
/// meshes and ends with a list of their offsets. `shape_index` selects a mesh.
///
/// Positions, normals and texture coordinates are read, in single or double precision. Vertex
/// colours are ignored. If the file has no normals, they are averaged from the faces, weighted by
/// angle. Format: Jakob 2014, "Mitsuba Documentation", section 8.2.1.
///
///     <shape type="serialized">
///       <string name="filename" value="bunny.serialized"/>
///       <integer name="shape_index" value="0"/>
///     </shape>

#include <bit>
#include <cmath>
#include <cstring>

#include "inflated_bytes.h"
#include "kinome/log.h"
#include "kinome/plugin.h"
#include "kinome/wide/mesh.h"
#include "mesh_file.h"
#include "shape_parameters.h"

namespace kinome {
namespace {

constexpr Parameter kTable[] = {
    {"filename", ParameterType::kFile, nullptr, "Serialized file.", true},
    {"shape_index", ParameterType::kInteger, "0", "Index of the mesh in the file, from 0."},
    kFaceNormals,
    kFlipNormals,
    kToWorld,
    KINOME_NESTED_IN_SHAPES,
};

constexpr uint16_t kMagic = 0x041c;
constexpr uint16_t kWithoutNames = 3, kWithNames = 4;  // file versions
constexpr size_t kHeader = 4;                          // size of magic and version, in bytes
enum Flag : uint32_t {
  kHasNormals = 0x1,
  kHasUvs = 0x2,
  kHasColors = 0x8,
  kHasFaceNormals = 0x10,
  kIsDouble = 0x2000  // otherwise single precision
};
/// Maximum length of a name. Names end with a zero byte, which a damaged file may lack.
constexpr size_t kMaxNameLength = 4096;

/// Reads a little-endian number.
template <class T>
T number_at(const std::string& bytes, size_t at) {
  char raw[sizeof(T)];
  std::memcpy(raw, bytes.data() + at, sizeof(T));
  if constexpr (std::endian::native == std::endian::big) std::reverse(raw, raw + sizeof(T));
  T value;
  std::memcpy(&value, raw, sizeof(T));
  return value;
}

/// Reader of one compressed mesh.
class MeshSource {
 public:
  MeshSource(const std::string& file, std::string_view compressed, uint16_t version)
      : file_(file), bytes_(compressed) {
    flags_ = number<uint32_t>();
    if (version == kWithNames) skip_name();
    vertices_ = number<uint64_t>();
    triangles_ = number<uint64_t>();
    if (vertices_ == 0) fail("the mesh has no vertices");
    if (vertices_ > kMaxCount || triangles_ > kMaxCount) {
      fail("the mesh claims " + std::to_string(vertices_) + " vertices and " +
           std::to_string(triangles_) + " triangles: expected fewer than 2^32 of either");
    }
    check_size();
  }

  TriangleMesh read() {
    TriangleMesh mesh;
    mesh.positions.reserve(vertices_ + 1);  // Embree reads 4 bytes past the last vertex
    vectors<3>(mesh.positions);
    if (flags_ & kHasNormals) vectors<3>(mesh.normals);
    if (flags_ & kHasUvs) vectors<2>(mesh.uvs);
    if (flags_ & kHasColors) {
      std::vector<Vec3> unused;
      vectors<3>(unused);
    }
    read_triangles(mesh);
    return mesh;
  }
  bool has_colors() const { return (flags_ & kHasColors) != 0; }
  bool is_flat() const { return (flags_ & kHasFaceNormals) != 0; }

 private:
  static constexpr uint64_t kMaxCount = (uint64_t{1} << 32) - 1;

  [[noreturn]] void fail(const std::string& message) const {
    throw Error(Location{file_, 0, 0}, message);
  }
  template <class T>
  T number() {
    std::string raw(sizeof(T), '\0');
    take(raw.data(), raw.size());
    return number_at<T>(raw, 0);
  }
  void take(void* out, size_t size) {
    if (!bytes_.read(out, size)) fail(bytes_.why());
  }
  void skip_name() {
    char c = 1;
    for (size_t length = 0; c != 0; ++length) {
      if (length > kMaxNameLength) fail("the mesh's name has no end");
      take(&c, 1);
    }
  }
  /// Throws Error if the file is too small for the counts in its header. Called before memory is
  /// allocated for them.
  void check_size() const {
    const uint64_t bytes_per_number = flags_ & kIsDouble ? 8 : 4;
    uint64_t numbers_per_vertex = 3;
    if (flags_ & kHasNormals) numbers_per_vertex += 3;
    if (flags_ & kHasUvs) numbers_per_vertex += 2;
    if (flags_ & kHasColors) numbers_per_vertex += 3;
    const uint64_t needed = vertices_ * numbers_per_vertex * bytes_per_number + triangles_ * 12;
    if (needed > bytes_.max_bytes_left()) {
      fail("the mesh claims " + std::to_string(vertices_) + " vertices and " +
           std::to_string(triangles_) + " triangles, more than the file can contain");
    }
  }

  template <int size, class Vector>
  void vectors(std::vector<Vector>& out) {
    static_assert(sizeof(Vector) == size * sizeof(float));
    out.resize(vertices_);
    if (!(flags_ & kIsDouble)) {
      take(out.data(), out.size() * sizeof(Vector));
      if constexpr (std::endian::native == std::endian::big) swap_words(out);
      return;
    }
    constexpr size_t kStep = 1024;
    std::string raw(kStep * size * sizeof(double), '\0');
    for (size_t first = 0; first < out.size(); first += kStep) {
      const size_t count = std::min(kStep, out.size() - first);
      take(raw.data(), count * size * sizeof(double));
      for (size_t i = 0; i < count; ++i) {
        for (int k = 0; k < size; ++k) {
          out[first + i][k] =
              static_cast<float>(number_at<double>(raw, (i * size + k) * sizeof(double)));
        }
      }
    }
  }
  void read_triangles(TriangleMesh& mesh) {
    mesh.triangles.resize(triangles_);
    take(mesh.triangles.data(), triangles_ * sizeof(glm::uvec3));
    if constexpr (std::endian::native == std::endian::big) swap_words(mesh.triangles);
    for (size_t i = 0; i < mesh.triangles.size(); ++i) {
      for (int k = 0; k < 3; ++k) {
        const uint32_t vertex = mesh.triangles[i][k];
        if (vertex >= vertices_) {
          fail("triangle " + std::to_string(i) + " refers to vertex " + std::to_string(vertex) +
               ", expected 0 to " + std::to_string(vertices_ - 1));
        }
      }
    }
  }
  template <class T>
  static void swap_words(std::vector<T>& values) {
    auto* const bytes = reinterpret_cast<char*>(values.data());
    for (size_t i = 0; i < values.size() * sizeof(T); i += 4)
      std::reverse(bytes + i, bytes + i + 4);
  }

  std::string file_;
  InflatedBytes bytes_;
  uint32_t flags_ = 0;
  uint64_t vertices_ = 0, triangles_ = 0;
};

/// Returns the version in the header at offset `at`. Throws Error if no mesh begins there, or if
/// the version is neither 3 nor 4.
uint16_t read_version(const std::string& file, const std::string& bytes, size_t at) {
  const Location where{file, 0, 0};
  if (bytes.size() < at + kHeader || number_at<uint16_t>(bytes, at) != kMagic) {
    throw Error(where, at == 0 ? "is not a file of serialized meshes"
                               : "its list of meshes has a wrong offset");
  }
  const auto version = number_at<uint16_t>(bytes, at + 2);
  if (version != kWithoutNames && version != kWithNames) {
    throw Error(where, "has version " + std::to_string(version) + ", expected 3 or 4");
  }
  return version;
}

/// Returns the compressed bytes of a mesh. The file ends with the offsets of all meshes, followed
/// by their number.
std::string_view find_mesh(const std::string& file, const std::string& bytes, uint16_t version,
                           int64_t index, const Properties& props) {
  const Location where{file, 0, 0};
  // The first mesh can be found without the list, which some files lack.
  const std::string_view from_first = std::string_view(bytes).substr(kHeader);
  const size_t offset_size = version == kWithNames ? 8 : 4, count_size = 4;
  const size_t count = bytes.size() < kHeader + count_size
                           ? 0
                           : number_at<uint32_t>(bytes, bytes.size() - count_size);
  if (count == 0 || count > (bytes.size() - kHeader - count_size) / offset_size) {
    if (index == 0) return from_first;
    throw Error(where, "ends without a list of its meshes");
  }
  if (index < 0 || static_cast<uint64_t>(index) >= count) {
    throw props.error("shape_index", "must be between 0 and " + std::to_string(count - 1) +
                                         ", because the file has " + std::to_string(count) +
                                         " meshes, got " + std::to_string(index));
  }
  const size_t list = bytes.size() - count_size - count * offset_size;
  const auto offset = [&](size_t i) -> uint64_t {
    if (i == count) return list;
    const size_t at = list + i * offset_size;
    return version == kWithNames ? number_at<uint64_t>(bytes, at) : number_at<uint32_t>(bytes, at);
  };
  const auto i = static_cast<size_t>(index);
  const uint64_t begin = offset(i), end = offset(i + 1);
  if (begin >= list || end > list || end < begin + kHeader) {
    if (index == 0) return from_first;
    throw Error(where, "its list of meshes has an offset outside the file");
  }
  read_version(file, bytes, begin);
  return std::string_view(bytes).substr(begin + kHeader, end - begin - kHeader);
}

class Serialized final : public wide::Mesh {
 public:
  explicit Serialized(const Properties& props) : Mesh(props) {
    const std::string file = props.file("filename");
    const std::string bytes = file_contents(file);
    const uint16_t version = read_version(file, bytes, 0);
    MeshSource source(file, find_mesh(file, bytes, version, props.integer("shape_index"), props),
                      version);
    mesh_ = source.read();
    if (source.has_colors()) log_unused(file, {"vertex colours"});
    if (source.is_flat() && !props.boolean("face_normals")) {
      log_warn(Error(Location{file, 0, 0},
                     "the mesh is marked as flat, which is ignored as in Mitsuba 3: set "
                     "face_normals for flat shading")
                   .what());
    }
    if (mesh_.triangles.empty()) warn_of_no_faces(file);
    finish(props, to_world_of(props), props.boolean("face_normals"), props.boolean("flip_normals"));
  }
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Serialized, kinome::Category::kShape, "serialized",
              "Triangles from a serialized file of Mitsuba 0.5 or 0.6.", kinome::kTable);
