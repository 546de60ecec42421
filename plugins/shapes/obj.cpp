/// Triangles from a Wavefront OBJ file.
///
/// The reader uses the statements v, vt, vn and f; indices may be negative (relative). Polygons are
/// split into fans. Groups and materials are ignored: the file is one mesh. Points, lines,
/// free-form surfaces, faces with fewer than three vertices and unknown statements are skipped with
/// a warning. Corners without a normal get the average of the adjacent faces' normals, weighted by
/// angle.
///
///     <shape type="obj"><string name="filename" value="teapot.obj"/></shape>

#include <array>
#include <cmath>
#include <cstdint>
#include <map>

#include "kinome/log.h"
#include "kinome/plugin.h"
#include "kinome/wide/mesh.h"
#include "mesh_file.h"
#include "shape_parameters.h"

namespace kinome {
namespace {

constexpr Parameter kTable[] = {
    {"filename", ParameterType::kFile, nullptr, "OBJ file.", true},
    kFaceNormals,
    kFlipNormals,
    {"flip_tex_coords", ParameterType::kBoolean, "true",
     "Replace v by 1 - v: v starts at the bottom of the image in OBJ, and at the top in textures."},
    kToWorld,
    KINOME_NESTED_IN_SHAPES,
};

constexpr int64_t kAbsent = -1;

/// Corner of a face. Indices start at 0; missing ones are kAbsent.
struct Corner {
  int64_t position = kAbsent;
  int64_t uv = kAbsent;
  int64_t normal = kAbsent;
};

struct Face {
  size_t first_corner;
  size_t corner_count;
  int line;
};

struct ObjFile {
  std::vector<Vec3> positions;
  std::vector<Vec2> uvs;
  std::vector<Vec3> normals;
  std::vector<Corner> corners;
  std::vector<Face> faces;
};

class ObjReader {
 public:
  ObjReader(const std::string& file, std::string_view text) : cursor_(file, text, 1, true) {}

  ObjFile read() {
    for (; cursor_.skip_blank_lines(); cursor_.next_line()) {
      const std::string_view keyword = cursor_.word();
      if (keyword == "v") {
        obj_.positions.push_back(read_vector("a coordinate"));
        if (!cursor_.at_line_end()) note_unused("vertex colours or weights");
        if (!is_finite(obj_.positions.back())) {
          cursor_.fail("a vertex has a position that is not finite");
        }
      } else if (keyword == "vt") {
        const auto u = static_cast<float>(cursor_.number("a texture coordinate"));
        const bool has_v = !cursor_.at_line_end();
        obj_.uvs.emplace_back(
            u, has_v ? static_cast<float>(cursor_.number("a texture coordinate")) : 0.f);
        if (!cursor_.at_line_end()) note_unused("third texture coordinates");
      } else if (keyword == "vn") {
        obj_.normals.push_back(read_vector("a component of a normal"));
      } else if (keyword == "f") {
        read_face();
      } else if (const char* const geometry = unsupported_geometry(keyword)) {
        skip(geometry);
      } else if (is_known(keyword)) {
        note_unused(keyword);
      } else {
        skip("unknown statements '" + TextCursor::shorten(keyword) + "'");
        if (first_unknown_.empty()) {
          first_unknown_ = TextCursor::shorten(keyword);
          first_unknown_line_ = cursor_.line();
        }
      }
    }
    // Mitsuba ignores unknown statements. A file that has no others isn't an OBJ file.
    if (obj_.positions.empty() && !first_unknown_.empty()) {
      cursor_.fail_at(first_unknown_line_,
                      "not an OBJ file: unknown keyword '" + first_unknown_ + "'");
    }
    if (obj_.positions.empty()) cursor_.fail("the file has no vertices");
    check_indices();
    return std::move(obj_);
  }

  /// Ignored parts of the file, in the file's order.
  const std::vector<std::string>& unused() const { return unused_; }
  /// Warns about skipped geometry and unknown statements.
  void warn_of_skipped() const {
    for (const Skipped& kind : skipped_) {
      const std::string count = " (" + std::to_string(kind.count) + " of them)";
      log_warn(cursor_.error_at(kind.line, kind.what + " are skipped" + count).what());
    }
  }

 private:
  void note_unused(std::string_view what) {
    // A linear search suffices: a file has at most tens of kinds of statements.
    if (std::find(unused_.begin(), unused_.end(), what) == unused_.end())
      unused_.emplace_back(what);
  }

  Vec3 read_vector(const char* what) {
    const double x = cursor_.number(what);
    const double y = cursor_.number(what);
    const double z = cursor_.number(what);
    return {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)};
  }

  /// Counts a statement of the current line that is skipped with a warning.
  void skip(const std::string& what) {
    constexpr size_t kMaxKinds = 8;  // a damaged file may have any number of unknown statements
    const auto known = std::find_if(skipped_.begin(), skipped_.end(),
                                    [&](const Skipped& kind) { return kind.what == what; });
    if (known != skipped_.end()) {
      ++known->count;
    } else if (skipped_.size() < kMaxKinds) {
      skipped_.push_back({what, cursor_.line(), 1});
    }
  }

  /// Returns the kind of geometry that a statement describes if it is unsupported, otherwise
  /// nullptr.
  static const char* unsupported_geometry(std::string_view keyword) {
    if (keyword == "p") return "points";
    if (keyword == "l") return "lines";
    if (keyword == "curv" || keyword == "curv2") return "free-form curves";
    if (keyword == "surf") return "free-form surfaces";
    return nullptr;
  }

  /// True for statements of the format that don't affect meshes.
  static bool is_known(std::string_view keyword) {
    constexpr std::string_view kOthers[] = {
        "g",          "s",         "o",     "mg",       "usemtl",   "mtllib", "vp",  "usemap",
        "maplib",     "bevel",     "lod",   "c_interp", "d_interp", "cstype", "deg", "bmat",
        "step",       "parm",      "trim",  "hole",     "scrv",     "sp",     "end", "con",
        "shadow_obj", "trace_obj", "ctech", "stech",    "call",     "csh"};
    return std::find(std::begin(kOthers), std::end(kOthers), keyword) != std::end(kOthers);
  }

  void read_face() {
    Face face{obj_.corners.size(), 0, cursor_.line()};
    while (!cursor_.at_line_end()) {
      const std::string_view word = cursor_.word();
      // As in Mitsuba, a face ends at the first word that isn't a corner.
      if (face.corner_count >= 3 && std::isalpha(static_cast<unsigned char>(word.front()))) {
        skip("words after the corners of a face");
        break;
      }
      obj_.corners.push_back(read_corner(word));
      ++face.corner_count;
    }
    if (face.corner_count < 3) {
      skip("faces of fewer than three vertices");
      obj_.corners.resize(face.first_corner);
      return;
    }
    obj_.faces.push_back(face);
  }

  /// Reads position, position/uv, position//normal or position/uv/normal. Slashes may follow the
  /// last index, as in "1/" and "1//".
  Corner read_corner(std::string_view word) const {
    const std::string_view whole = word;
    std::array<int64_t, 3> index = {kAbsent, kAbsent, kAbsent};
    const std::array<size_t, 3> sizes = {obj_.positions.size(), obj_.uvs.size(),
                                         obj_.normals.size()};
    for (size_t i = 0;; ++i) {
      const size_t slash = std::min(word.find('/'), word.size());
      if (slash > 0) {
        if (i == 3) cursor_.fail("expected v/vt/vn, got '" + TextCursor::shorten(whole) + "'");
        index[i] = read_index(word.substr(0, slash), sizes[i], whole);
      } else if (i == 0 || (i == 3 && !word.empty())) {
        cursor_.fail("expected an index, got '" + TextCursor::shorten(whole) + "'");
      }
      if (slash == word.size()) break;
      word.remove_prefix(slash + 1);
    }
    return {index[0], index[1], index[2]};
  }

  /// Indices start at 1; negative ones are relative to the current end.
  int64_t read_index(std::string_view text, size_t size, std::string_view whole) const {
    int64_t index = 0;
    if (text.front() == '+') text.remove_prefix(1);
    const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), index);
    if (error == std::errc::invalid_argument || rest != text.data() + text.size()) {
      cursor_.fail("expected an index, got '" + TextCursor::shorten(whole) + "'");
    }
    const auto count = static_cast<int64_t>(size);
    // Positive indices may refer to later parts of the file; see check_indices.
    if (error == std::errc::result_out_of_range || index == 0 || index < -count) {
      cursor_.fail("index out of range in '" + TextCursor::shorten(whole) + "': there are " +
                   std::to_string(size) + " so far");
    }
    return index > 0 ? index - 1 : count + index;
  }

  void check_indices() const {
    const auto check = [&](const Face& face, int64_t index, size_t size, const char* what) {
      if (index >= static_cast<int64_t>(size)) {
        cursor_.fail_at(face.line, "a face refers to " + std::string(what) + " " +
                                       std::to_string(index + 1) + ", but there are only " +
                                       std::to_string(size));
      }
    };
    for (const Face& face : obj_.faces) {
      for (size_t i = 0; i < face.corner_count; ++i) {
        const Corner& corner = obj_.corners[face.first_corner + i];
        check(face, corner.position, obj_.positions.size(), "vertex");
        check(face, corner.uv, obj_.uvs.size(), "texture coordinate");
        check(face, corner.normal, obj_.normals.size(), "normal");
      }
    }
  }

  struct Skipped {
    std::string what;
    int line;  ///< line of the first one
    size_t count;
  };
  TextCursor cursor_;
  ObjFile obj_;
  std::vector<std::string> unused_;
  std::vector<Skipped> skipped_;
  std::string first_unknown_;
  int first_unknown_line_ = 0;
};

/// Creates one vertex for each distinct (position, uv, normal).
class VertexMerger {
 public:
  VertexMerger(const ObjFile& obj, bool flip_v, TriangleMesh& mesh)
      : obj_(obj), flip_v_(flip_v), mesh_(mesh), newest_(obj.positions.size(), kNone) {
    for (const Corner& corner : obj.corners) {
      any_normals_ = any_normals_ || corner.normal != kAbsent;
      any_uvs_ = any_uvs_ || corner.uv != kAbsent;
    }
  }

  uint32_t index_of(const Corner& corner) {
    uint32_t& newest = newest_[static_cast<size_t>(corner.position)];
    int steps = 0;
    for (uint32_t i = newest; i != kNone; i = vertices_[i].next, ++steps) {
      if (vertices_[i].uv == corner.uv && vertices_[i].normal == corner.normal) return i;
    }
    const auto index = static_cast<uint32_t>(vertices_.size());
    if (steps < kMaxChain) {
      vertices_.push_back({corner.uv, corner.normal, newest});
      newest = index;
    } else {
      const auto [found, is_new] =
          overflow_.try_emplace({corner.position, corner.uv, corner.normal}, index);
      if (!is_new) return found->second;
      vertices_.push_back({corner.uv, corner.normal, kNone});
    }
    mesh_.positions.push_back(obj_.positions[static_cast<size_t>(corner.position)]);
    if (any_uvs_) {
      Vec2 uv(0.f);
      if (corner.uv != kAbsent) uv = obj_.uvs[static_cast<size_t>(corner.uv)];
      mesh_.uvs.emplace_back(uv.x, flip_v_ ? 1 - uv.y : uv.y);
    }
    if (any_normals_) {
      // MeshShape::finish() replaces normals that are zero.
      mesh_.normals.push_back(
          corner.normal == kAbsent ? Vec3(0.f) : obj_.normals[static_cast<size_t>(corner.normal)]);
    }
    return index;
  }

 private:
  static constexpr uint32_t kNone = ~0u;
  /// Maximum length of the list of vertices at a position. Typical meshes rarely exceed it.
  static constexpr int kMaxChain = 16;
  struct Vertex {
    int64_t uv, normal;
    uint32_t next;  ///< another vertex at the same position
  };
  const ObjFile& obj_;
  bool flip_v_;
  TriangleMesh& mesh_;
  std::vector<uint32_t> newest_;
  std::vector<Vertex> vertices_;
  /// Vertices beyond kMaxChain, by (position, uv, normal). A sorted map, because no choice of
  /// indices can make it slow, unlike a hash table.
  std::map<std::array<int64_t, 3>, uint32_t> overflow_;
  bool any_normals_ = false;
  bool any_uvs_ = false;
};

class Obj final : public wide::Mesh {
 public:
  explicit Obj(const Properties& props) : Mesh(props) {
    const std::string file = props.file("filename");
    const std::string text = with_newlines(file_contents(file));
    std::string_view lines = text;
    if (lines.starts_with("\xEF\xBB\xBF")) lines.remove_prefix(3);  // a byte order mark
    ObjReader reader(file, lines);
    const ObjFile obj = reader.read();
    VertexMerger merger(obj, props.boolean("flip_tex_coords"), mesh_);
    reader.warn_of_skipped();
    log_unused(file, reader.unused());
    if (obj.faces.empty()) warn_of_no_faces(file);
    for (const Face& face : obj.faces) {
      const Corner* corner = &obj.corners[face.first_corner];
      const uint32_t first = merger.index_of(corner[0]);
      uint32_t previous = merger.index_of(corner[1]);
      for (size_t i = 2; i < face.corner_count; ++i) {
        const uint32_t next = merger.index_of(corner[i]);
        mesh_.triangles.emplace_back(first, previous, next);
        previous = next;
      }
    }
    finish(props, to_world_of(props), props.boolean("face_normals"), props.boolean("flip_normals"));
  }
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Obj, kinome::Category::kShape, "obj", "Triangles from a Wavefront OBJ file.",
              kinome::kTable);
