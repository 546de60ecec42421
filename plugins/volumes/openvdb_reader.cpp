#include "vdb_reader.h"

#include <openvdb/openvdb.h>
#include <openvdb/tools/Dense.h>

#include "kinome/export.h"

namespace {

using kinome::VoxelGrid;

/// World-space box of the voxels, or an empty box if they aren't boxes along the axes.
kinome::Aabb box_of(const openvdb::GridBase& grid, const openvdb::CoordBBox& voxels) {
  if (!grid.transform().isLinear()) return {};
  const openvdb::Mat4d m = grid.transform().baseMap()->getAffineMap()->getMat4();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      if (row != column && m(row, column) != 0) return {};
    }
  }
  // A voxel's value is at its index.
  const openvdb::Vec3d half(0.5);
  const auto lo = grid.indexToWorld(voxels.min().asVec3d() - half);
  const auto hi = grid.indexToWorld(voxels.max().asVec3d() + half);
  kinome::Aabb box;
  for (int a = 0; a < 3; ++a) {
    box.lo[a] = static_cast<float>(lo[a]), box.hi[a] = static_cast<float>(hi[a]);
  }
  return box;
}

/// Copies the values of a grid if it has the type G. Returns false otherwise.
template <class G>
bool copy_as(const openvdb::GridBase& base, VoxelGrid& out) {
  const auto* const grid = dynamic_cast<const G*>(&base);
  if (!grid) return false;
  const openvdb::CoordBBox voxels = grid->evalActiveVoxelBoundingBox();
  if (voxels.empty()) throw std::runtime_error("has no active voxels");
  using Value = typename G::ValueType;
  out.channels = std::is_arithmetic_v<Value> ? 1 : 3;
  const openvdb::Coord size = voxels.dim();
  uint64_t count = uint64_t(size.x()) * uint64_t(size.y());
  if (count < kinome::kMaxVoxelValues) count *= uint64_t(size.z());
  if (count < kinome::kMaxVoxelValues) count *= out.channels;
  if (count >= kinome::kMaxVoxelValues) {
    throw std::runtime_error("has too many voxels: " + std::to_string(size.x()) + " x " +
                             std::to_string(size.y()) + " x " + std::to_string(size.z()));
  }
  out.size = {size.x(), size.y(), size.z()};
  out.box = box_of(base, voxels);
  // In this layout, x varies fastest.
  openvdb::tools::Dense<Value, openvdb::tools::LayoutXYZ> dense(voxels);
  openvdb::tools::copyToDense(*grid, dense);
  out.values.resize(count);
  for (uint64_t i = 0; i < count / out.channels; ++i) {
    if constexpr (std::is_arithmetic_v<Value>) {
      out.values[i] = static_cast<float>(dense.data()[i]);
    } else {
      for (int c = 0; c < 3; ++c) {
        out.values[3 * i + static_cast<uint64_t>(c)] = static_cast<float>(dense.data()[i][c]);
      }
    }
  }
  return true;
}

/// Reads the grid `requested`. If that is "", reads `density` or else the first grid by name.
void read(const std::string& path, const std::string& requested, VoxelGrid& out) {
  openvdb::initialize();
  openvdb::io::File file(path);
  file.open();
  const bool has_density = requested.empty() && file.hasGrid("density");
  const std::string name = has_density ? "density" : requested;
  std::string names;
  for (auto at = file.beginName(); at != file.endName(); ++at) {
    names += (names.empty() ? "'" : ", '") + at.gridName() + "'";
    if (!name.empty() && at.gridName() != name) continue;
    const openvdb::GridBase::Ptr grid = file.readGrid(at.gridName());
    if (copy_as<openvdb::FloatGrid>(*grid, out) || copy_as<openvdb::DoubleGrid>(*grid, out) ||
        copy_as<openvdb::Vec3fGrid>(*grid, out) || copy_as<openvdb::Vec3dGrid>(*grid, out)) {
      return;
    }
    if (name.empty()) continue;
    throw std::runtime_error("has values of type " + grid->valueType() + " in grid '" + name +
                             "', expected numbers or vectors");
  }
  throw std::runtime_error(name.empty() ? "has no grid of numbers or vectors"
                                        : "has no grid '" + name + "' (available: " + names + ")");
}

}  // namespace

extern "C" KINOME_EXPORT bool kinome_read_vdb(const std::string& path, const std::string& name,
                                              VoxelGrid& grid, std::string& error) {
  try {
    read(path, name, grid);
    return true;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& failure) {
    error = failure.what();
    return false;
  }
}
