/// A grid of voxels from a file of Mitsuba (.vol) or OpenVDB (.vdb): the density of a cloud, the
/// colours of smoke. It fills the unit cube, which `to_world` transforms.
///
///     <volume type="gridvolume" name="sigma_t">
///       <string name="filename" value="cloud.vol"/>
///       <transform name="to_world"><scale value="2"/><translate x="-1" y="-1" z="-1"/></transform>
///     </volume>

#include <dlfcn.h>

#include "kinome/image.h"
#include "kinome/instruction_set.h"
#include "kinome/plugin.h"
#include "kinome/value_source.h"
#include "vdb_reader.h"
#include "voxels.h"

namespace kinome {
namespace {

constexpr int kMaxSlices = 1 << 30;
constexpr const char* kFilters[] = {"trilinear", "nearest"};
constexpr const char* kWraps[] = {"clamp", "repeat", "mirror"};

constexpr Parameter kParameters[] = {
    {"filename", ParameterType::kFile, nullptr,
     "grid of 1, 3 or 6 channels: Mitsuba's .vol, or OpenVDB", true},
    {"data", ParameterType::kImage, nullptr,
     "values from a program, instead of the file: an image of the rows of all slices, from the "
     "lowest z and y on"},
    {"slices", ParameterType::kInteger, "1",
     "number of slices along z in `data`; ignored for files"},
    {"grid", ParameterType::kString, "",
     "name of the grid in an OpenVDB file; default: 'density', or else the first by name"},
    {"to_world", ParameterType::kTransform, "identity",
     "transform of the unit cube, or of the file's box"},
    choice_of("filter_type", kFilters, "trilinear",
              "interpolation between voxels: trilinear or nearest"),
    choice_of("wrap_mode", kWraps, "clamp", "values outside of the grid: clamp, repeat or mirror"),
    {"use_grid_bbox", ParameterType::kBoolean, "false",
     "the grid fills the box in its file, not the unit cube"},
    ignored_row("raw", ParameterType::kBoolean, "values are never converted to spectra"),
    ignored_row("accel", ParameterType::kBoolean, "only GPUs have hardware for it"),
    ignored_row("max_value", ParameterType::kFloat, "the maximum of the values is used"),
};

/// Returns the function that reads OpenVDB files. Its library is loaded on demand, because few
/// scenes need it and it has large dependencies.
ReadVdbFunction vdb_reader(const Properties& props) {
  Dl_info info{};
  static const char anchor = 0;
  dladdr(&anchor, &info);
  auto folder = std::filesystem::path(info.dli_fname ? info.dli_fname : "").parent_path();
  if (instruction_set_named(folder.filename().string())) folder = folder.parent_path();
  const std::filesystem::path library = (folder / kReadVdbLibrary).lexically_normal();
  if (!std::filesystem::exists(library)) {
    throw props.error("filename", "is an OpenVDB file, but Kinome was built without OpenVDB");
  }
  void* const handle = dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL);
  void* const symbol = handle ? dlsym(handle, kReadVdbSymbol) : nullptr;
  if (symbol) return reinterpret_cast<ReadVdbFunction>(symbol);
  const char* const reason = dlerror();
  throw props.error("filename", std::string("requires a library that can't be loaded: ") +
                                    (reason ? reason : library.c_str()));
}

/// Converts `data` to a grid.
VoxelGrid grid_of(const Image& image, int slices, const Properties& props) {
  if (image.height % slices != 0) {
    throw props.error("slices",
                      "must divide the number of rows of `data`, " + std::to_string(image.height));
  }
  VoxelGrid grid;
  grid.size = {image.width, image.height / slices, slices};
  grid.channels = static_cast<uint32_t>(image.channel_count());
  if (grid.channels != 1 && grid.channels != 3 && grid.channels != 6) {
    throw props.error("data", "must have 1, 3 or 6 channels, got " + std::to_string(grid.channels));
  }
  if (image.data.empty() || image.data.size() >= kMaxVoxelValues) {
    throw props.error("data",
                      "must have 1 to 2147483647 values, got " + std::to_string(image.data.size()));
  }
  grid.values = image.data;
  find_range(grid, props.error("data", "").where());
  return grid;
}

VoxelGrid read_grid(const Properties& props) {
  props.exclude("data", "filename");
  const auto slices = static_cast<int>(props.integer("slices", 1, kMaxSlices));
  if (const auto pixels = props.image("data")) return grid_of(*pixels, slices, props);
  const std::string file = props.file("filename");
  if (!is_vdb_file(file)) {
    if (!props.string("grid").empty()) throw props.error("grid", "is only for OpenVDB files");
    return read_vol_file(file);
  }
  VoxelGrid grid;
  std::string error;
  if (!vdb_reader(props)(file, props.string("grid"), grid, error)) {
    throw Error(Location{file, 0, 0}, error);
  }
  find_range(grid, Location{file, 0, 0});
  return grid;
}

/// Transform from the unit cube to world space.
Transform cube_to_world(const Properties& props, const VoxelGrid& grid) {
  const Transform to_world = props.transform("to_world");
  if (!to_world.is_invertible()) throw props.error("to_world", "must be invertible");
  if (!props.boolean("use_grid_bbox")) return to_world;
  const Vec3 size = grid.box.extent();
  if (!(size.x > 0 && size.y > 0 && size.z > 0 && is_finite(size) && is_finite(grid.box.lo))) {
    throw props.error("use_grid_bbox",
                      "requires a file whose box isn't empty and is aligned with the axes");
  }
  Mat4 m(1.f);
  for (int a = 0; a < 3; ++a) m[a][a] = size[a];
  m[3] = glm::vec4(grid.box.lo, 1.f);
  return to_world * Transform(m);
}

class GridVolume final : public Volume, public ValueSource {
 public:
  explicit GridVolume(const Properties& props) : GridVolume(props, read_grid(props)) {}

  uint32_t channels() const override { return voxels_.grid().channels; }
  void eval(const Vec3& p, float* values) const override {
    voxels_.eval<float>(p, [&](int32_t c, float v) { values[c] = v; });
  }
  void eval_block(const Columns3& p, size_t count, float* const* values) const override {
    wide::for_lanes(count, [&](size_t i) {
      voxels_.eval<wide::Float>(wide::Vec3::load(p, i),
                                [&](int32_t c, const wide::Float& v) { v.store(values[c] + i); });
    });
  }
  float min() const override { return min_; }
  float max() const override { return max_; }
  std::string describe_min() const override { return describe(voxels_.grid().min); }
  std::string describe_max() const override { return describe(voxels_.grid().max); }
  Aabb box() const override { return box_; }
  glm::uvec3 resolution() const override { return resolution_; }
  void extremes(const BlockGrid& blocks, float* lo, float* hi) const override {
    size_t i = 0;
    for (glm::uvec3 at(0); at.z < blocks.size.z; ++at.z) {
      for (at.y = 0; at.y < blocks.size.y; ++at.y) {
        for (at.x = 0; at.x < blocks.size.x; ++at.x, ++i) {
          std::tie(lo[i], hi[i]) = voxels_.range_in(blocks.block(at));
        }
      }
    }
  }
  bool has_integral() const override { return true; }
  void integral_block(const Columns3& o, const Columns3& d, const float* length, size_t count,
                      float* const* values) const override {
    for (size_t i = 0; i < count; ++i) {
      double sums[kMaxChannels] = {};
      voxels_.integrate(o.at(i), d.at(i), length[i], sums);
      for (uint32_t c = 0; c < channels(); ++c) values[c][i] = static_cast<float>(sums[c]);
    }
  }

 private:
  GridVolume(const Properties& props, VoxelGrid grid)
      : GridVolume(props, cube_to_world(props, grid), std::move(grid)) {}
  GridVolume(const Properties& props, const Transform& to_world, VoxelGrid grid)
      : voxels_(std::move(grid), to_world.inverse(),
                static_cast<VoxelFilter>(props.choice("filter_type")),
                static_cast<VoxelWrap>(props.choice("wrap_mode"))),
        source_(props.has("data") ? "'data'" : props.file("filename")) {
    for (unsigned i = 0; i < 8; ++i) {
      box_.expand(to_world.point(Aabb(Vec3(0.f), Vec3(1.f)).corner(i)));
    }
    std::tie(min_, max_) = widened(voxels_.grid());
    // The axes of the box are those of the grid, unless `to_world` rotates.
    const Mat4& m = to_world.matrix();
    for (int a = 0; a < 3; ++a) {
      const Vec3 along = glm::abs(Vec3(m[0][a], m[1][a], m[2][a]));
      const int main = along.x >= along.y && along.x >= along.z ? 0 : along.y >= along.z ? 1 : 2;
      resolution_[a] = voxels_.grid().size[main];
    }
  }

  std::string describe(float value) const {
    const std::vector<float>& values = voxels_.grid().values;
    const auto at = std::find(values.begin(), values.end(), value) - values.begin();
    return format_number(value) + " in " + voxel_of(voxels_.grid(), static_cast<size_t>(at)) +
           " of " + source_;
  }
  /// Range of the values, with the rounding errors of interpolation.
  static std::pair<float, float> widened(const VoxelGrid& grid) {
    constexpr float kRounding = 1e-6f;
    return {grid.min < 0 ? grid.min * (1 + kRounding) : grid.min * (1 - kRounding),
            grid.max > 0 ? grid.max * (1 + kRounding) : grid.max * (1 - kRounding)};
  }

  Voxels voxels_;
  std::string source_;  ///< file or parameter, for error messages
  Aabb box_;
  glm::uvec3 resolution_{1};
  float min_ = 0, max_ = 0;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::GridVolume, kinome::Category::kVolume, "gridvolume",
              "Values on a grid of voxels, from a file.", kinome::kParameters);
