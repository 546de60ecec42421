/// Triangles from a file of Mitsuba 0.5 and 0.6: meshes one after the other, each compressed, and
/// at the end a list of where they begin, of which `shape_index` takes one.
///
/// Read are positions, normals and texture coordinates, of single and of double precision. Without
/// normals in the file, they are averaged from the faces, weighted by angle. Format: Jakob 2014,
/// "Mitsuba Documentation", section 8.2.1.
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
    {"filename", ParameterType::kFile, nullptr, "The file.", true},
    {"shape_index", ParameterType::kInteger, "0", "Which of the file's meshes; from 0."},
    kFaceNormals,
    kFlipNormals,
    kToWorld,
    kNestedBsdf,
    kNestedEmitter,
    kNestedSensor,
};

constexpr uint16_t kMagic = 0x041c;
constexpr uint16_t kWithoutNames = 3, kWithNames = 4;  // versions
constexpr size_t kHeader = 4;                          // magic and version
enum Flag : uint32_t {
  kHasNormals = 0x1,
  kHasUvs = 0x2,
  kHasColors = 0x8,
  kHasFaceNormals = 0x10,
  kIsDouble = 0x2000  // else of single precision
};
/// Names are read to the first zero, of which a broken file may have none.
constexpr size_t kLongestName = 4096;

/// Numbers of a file are little-endian.
template <class T>
T number_at(const std::string& bytes, size_t at) {
  char raw[sizeof(T)];
  std::memcpy(raw, bytes.data() + at, sizeof(T));
  if constexpr (std::endian::native == std::endian::big) std::reverse(raw, raw + sizeof(T));
  T value;
  std::memcpy(&value, raw, sizeof(T));
  return value;
}

/// What lies in one compressed block.
class MeshSource {
 public:
  MeshSource(const std::string& file, std::string_view compressed, uint16_t version)
      : file_(file), bytes_(compressed) {
    flags_ = number<uint32_t>();
    if (version == kWithNames) skip_name();
    vertices_ = number<uint64_t>();
    triangles_ = number<uint64_t>();
    if (vertices_ == 0) fail("the mesh has no vertices");
    if (vertices_ > kMost || triangles_ > kMost) {
      fail("the mesh claims " + std::to_string(vertices_) + " vertices and " +
           std::to_string(triangles_) + " triangles: expected less than 2^32 of either");
    }
    check_size();
  }

  TriangleMesh read() {
    TriangleMesh mesh;
    mesh.positions.reserve(vertices_ + 1);
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
  static constexpr uint64_t kMost = (uint64_t{1} << 32) - 1;

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
      if (length > kLongestName) fail("the mesh's name has no end");
      take(&c, 1);
    }
  }
  /// Before memory is taken for what a broken file claims.
  void check_size() const {
    const uint64_t of_number = flags_ & kIsDouble ? 8 : 4;
    uint64_t of_vertex = 3;
    if (flags_ & kHasNormals) of_vertex += 3;
    if (flags_ & kHasUvs) of_vertex += 2;
    if (flags_ & kHasColors) of_vertex += 3;
    const uint64_t needed = vertices_ * of_vertex * of_number + triangles_ * 12;
    if (needed > bytes_.most_left()) {
      fail("the mesh claims " + std::to_string(vertices_) + " vertices and " +
           std::to_string(triangles_) + " triangles, more than the file can hold");
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

/// Version of the file. Error where it isn't one of Mitsuba's.
uint16_t read_version(const std::string& file, const std::string& bytes, size_t at) {
  const Location where{file, 0, 0};
  if (bytes.size() < at + kHeader || number_at<uint16_t>(bytes, at) != kMagic) {
    throw Error(where, at == 0 ? "is not a file of serialized meshes"
                               : "no mesh begins where the file's list says");
  }
  const auto version = number_at<uint16_t>(bytes, at + 2);
  if (version != kWithoutNames && version != kWithNames) {
    throw Error(where, "is of version " + std::to_string(version) + ", expected 3 or 4");
  }
  return version;
}

/// Where the mesh lies, by the list at the file's end: places of all meshes and their number.
std::string_view find_mesh(const std::string& file, const std::string& bytes, uint16_t version,
                           int64_t index, const Properties& props) {
  const Location where{file, 0, 0};
  // The first mesh can be found without the list, which some files lack.
  const std::string_view from_first = std::string_view(bytes).substr(kHeader);
  const size_t of_place = version == kWithNames ? 8 : 4, of_count = 4;
  const size_t count =
      bytes.size() < kHeader + of_count ? 0 : number_at<uint32_t>(bytes, bytes.size() - of_count);
  if (count == 0 || count > (bytes.size() - kHeader - of_count) / of_place) {
    if (index == 0) return from_first;
    throw Error(where, "ends without a list of its meshes");
  }
  if (index < 0 || static_cast<uint64_t>(index) >= count) {
    throw props.error("shape_index", "must be one of the file's " + std::to_string(count) +
                                         " meshes, from 0, got " + std::to_string(index));
  }
  const size_t list = bytes.size() - of_count - count * of_place;
  const auto place = [&](size_t i) -> uint64_t {
    if (i == count) return list;
    const size_t at = list + i * of_place;
    return version == kWithNames ? number_at<uint64_t>(bytes, at) : number_at<uint32_t>(bytes, at);
  };
  const auto i = static_cast<size_t>(index);
  const uint64_t begin = place(i), end = place(i + 1);
  if (begin >= list || end > list || end < begin + kHeader) {
    if (index == 0) return from_first;
    throw Error(where, "its list of meshes names a place outside of the file");
  }
  read_version(file, bytes, begin);
  return std::string_view(bytes).substr(begin + kHeader, end - begin - kHeader);
}

class Serialized final : public wide::Mesh {
 public:
  explicit Serialized(const Properties& props) : Mesh(props) {
    const std::string file = props.file("filename");
    const std::string bytes = read_mesh_file(file);
    const uint16_t version = read_version(file, bytes, 0);
    MeshSource source(file, find_mesh(file, bytes, version, props.integer("shape_index"), props),
                      version);
    mesh_ = source.read();
    if (source.has_colors()) log_unused(file, {"vertex colours"});
    if (source.is_flat() && !props.boolean("face_normals")) {
      log_warn(Error(Location{file, 0, 0},
                     "the mesh is marked as flat, which Mitsuba 3 ignores, too: set face_normals "
                     "to shade it so")
                   .what());
    }
    if (mesh_.triangles.empty()) warn_of_no_faces(file);
    finish(props, to_world_of(props), props.boolean("face_normals"), props.boolean("flip_normals"));
  }
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Serialized, kinome::Category::kShape, "serialized",
              "Triangles from a file of Mitsuba 0.5 or 0.6.", kinome::kTable);
