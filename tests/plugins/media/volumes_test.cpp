/// Grids of voxels: look-up as in Mitsuba, bounds, integrals, damaged files.
#include <gtest/gtest.h>
#include <zlib.h>

#include <filesystem>
#include <limits>

#include "kinome/volume.h"
#include "support/render.h"
#include "support/volume_files.h"

namespace kinome::test::volumes_test {
namespace {

constexpr float kNanValue = std::numeric_limits<float>::quiet_NaN();

std::string grid_xml(const std::string& file, const std::string& more = "") {
  return "<volume type='gridvolume'><string name='filename' value='" + file + "'/>" + more +
         "</volume>";
}

const char* const kPlacement =
    "<transform name='to_world'><scale x='2' y='1' z='3'/><rotate z='1' angle='30'/>"
    "<translate x='0.5' y='-1' z='0'/></transform>";

std::string error_of(const std::string& xml) {
  try {
    make_object(xml);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

/// Values of Mitsuba 3.9.1 (scalar_rgb) for the file of VolFile with mixed_value().
TEST(GridVolume, HasMitsubasValues) {
  struct Row {
    const char *filter, *wrap, *use_box;
    Rgb values[3];
  };
  const Row rows[] = {
      {"trilinear",
       "clamp",
       "false",
       {Rgb(0.7923513f, 0.279265f, 0.6456016f), Rgb(0.1651555f, 0.4687986f, 0.8351353f),
        Rgb(0.08910892f, 0.4554456f, 0.8217822f)}},
      {"trilinear",
       "clamp",
       "true",
       {Rgb(0.1581615f, 0.5244982f, 0.5551438f), Rgb(0.4797949f, 0.4554581f, 0.6389968f),
        Rgb(0.3790666f, 0.3882602f, 0.7545968f)}},
      {"trilinear",
       "repeat",
       "false",
       {Rgb(0.4613666f, 0.7464725f, 0.3629641f), Rgb(0.3344624f, 0.6381056f, 0.1608664f),
        Rgb(0.5069501f, 0.4181473f, 0.583041f)}},
      {"trilinear",
       "repeat",
       "true",
       {Rgb(0.1743952f, 0.5407318f, 0.5281863f), Rgb(0.4797949f, 0.4554581f, 0.6389968f),
        Rgb(0.2914014f, 0.6406143f, 0.3116091f)}},
      {"trilinear",
       "mirror",
       "false",
       {Rgb(0.5685914f, 0.7698659f, 0.3238962f), Rgb(0.1651555f, 0.4687986f, 0.8351353f),
        Rgb(0.6145887f, 0.5780394f, 0.347262f)}},
      {"trilinear",
       "mirror",
       "true",
       {Rgb(0.1581615f, 0.5244982f, 0.5551438f), Rgb(0.4797949f, 0.4554581f, 0.6389968f),
        Rgb(0.3850589f, 0.3873159f, 0.7449817f)}},
      {"nearest",
       "clamp",
       "false",
       {Rgb(0.9009901f, 0.2673267f, 0.6336634f), Rgb(0.0990099f, 0.4653465f, 0.8316832f),
        Rgb(0.08910891f, 0.4554456f, 0.8217822f)}},
      {"nearest",
       "repeat",
       "true",
       {Rgb(0.0990099f, 0.4653465f, 0.8316832f), Rgb(0.1980198f, 0.5643564f, 0.9306931f),
        Rgb(0.2970297f, 0.6633663f, 0.02970297f)}},
      {"nearest",
       "mirror",
       "false",
       {Rgb(0.5049505f, 0.8712871f, 0.2376238f), Rgb(0.0990099f, 0.4653465f, 0.8316832f),
        Rgb(0.3861386f, 0.7524753f, 0.1188119f)}},
  };
  const Vec3 points[] = {{.05f, .4f, .6f}, {1.3f, .4f, -.6f}, {-2.3f, .5f, 3.f}};
  const TemporaryFolder folder;
  const std::string file = folder.write("a.vol", VolFile().bytes(mixed_value));
  for (const Row& row : rows) {
    const std::string options = kPlacement + std::string("<string name='filter_type' value='") +
                                row.filter + "'/><string name='wrap_mode' value='" + row.wrap +
                                "'/><boolean name='use_grid_bbox' value='" + row.use_box + "'/>";
    const auto volume = make<Volume>(grid_xml(file, options));
    ASSERT_EQ(volume->channels(), 3u);
    for (int i = 0; i < 3; ++i) {
      EXPECT_LT(glm::length(volume->color(points[i]) - row.values[i]), 1e-5f)
          << options << " point " << i;
    }
    if (row.use_box != std::string("true")) continue;
    EXPECT_LT(glm::length(volume->box().lo - Vec3(-2.23205f, -3.73205f, -9)), 1e-4f);
    EXPECT_LT(glm::length(volume->box().hi - Vec3(3.23205f, 1.73205f, 12)), 1e-4f);
  }
}

TEST(GridVolume, RefusesDamagedFiles) {
  const TemporaryFolder folder;
  const std::string good = VolFile().bytes(mixed_value);
  const auto with = [&](const auto& change) {
    VolFile file;
    change(file);
    return file.header();
  };
  const std::pair<std::string, std::string> cases[] = {
      {"", "is too short for a .vol file: 0 bytes"},
      {good.substr(0, 40), "is too short for a .vol file: 40 bytes"},
      {"PNG" + good.substr(3), "is not a .vol file"},
      {with([](VolFile& f) { f.version = 2; }), "has version 2"},
      {with([](VolFile& f) { f.type = 2; }), "values of type 2, expected 1 (float32)"},
      {with([](VolFile& f) { f.channels = 2; }), "has 2 channels, expected 1, 3 or 6"},
      {with([](VolFile& f) { f.channels = 0; }), "has 0 channels"},
      {with([](VolFile& f) { f.x = 0; }), "has 0 x 3 x 2 voxels"},
      {with([](VolFile& f) { f.z = -1; }), "has 4 x 3 x -1 voxels"},
      // Products that overflow 32 and 64 bits.
      {with([](VolFile& f) { f.x = 65536, f.y = 65536; }), "fewer than 2147483648 values"},
      {with([](VolFile& f) { f.x = f.y = f.z = 2147483647; }), "fewer than 2147483648 values"},
      {with([](VolFile& f) { f.x = 715827883, f.y = f.z = 1; }), "fewer than 2147483648 values"},
      {with([](VolFile& f) { f.x = 100000; }), "has 48 bytes, expected 7200048 for 100000 x 3"},
      {good.substr(0, good.size() - 1), "has 335 bytes, expected 336"},
      {good + "x", "has 337 bytes, expected 336"},
      {VolFile().bytes([](int i) { return i == 52 ? kNanValue : 0.f; }),
       "voxel (1, 1, 1) has the value nan"},
      {VolFile().bytes([](int i) { return i == 3 ? -kInfinity : 0.f; }),
       "voxel (1, 0, 0) has the value -inf"},
  };
  for (const auto& [bytes, message] : cases) {
    const std::string file = folder.write("bad.vol", bytes);
    try {
      make<Volume>(grid_xml(file));
      ADD_FAILURE() << "accepted: " << message;
    } catch (const Error& error) {
      EXPECT_NE(error.message().find(message), std::string::npos) << error.message();
      EXPECT_EQ(error.where().file, file);
      ASSERT_EQ(error.requesters().size(), 1u);
      EXPECT_EQ(error.requesters()[0].line, 1);
    }
  }
}

/// The file, written by OpenVDB 10.0.1, has the grid `density` of mixed_value() with voxels of size
/// 1/2 from (5, -1, 2) to (8, 1, 3), and the grid `colour` of two voxels.
TEST(GridVolume, ReadsOpenVdb) {
  const std::string packed = KINOME_TEST_SOURCE "/tests/plugins/media/two_grids.vdb.gz";
  std::string bytes(100000, '\0');
  gzFile stream = gzopen(packed.c_str(), "rb");
  bytes.resize(static_cast<size_t>(gzread(stream, bytes.data(), 100000)));
  gzclose(stream);
  const TemporaryFolder folder;
  const std::string file = folder.write("grids.vdb", bytes);
  if (!std::filesystem::exists(KINOME_TEST_PLUGINS "/support/openvdb_reader.so")) {
    EXPECT_NE(error_of(grid_xml(file)).find("but Kinome was built without OpenVDB"),
              std::string::npos);
    return;
  }
  const auto density = make<Volume>(grid_xml(file, "<boolean name='use_grid_bbox' value='true'/>"));
  EXPECT_EQ(density->channels(), 1u);
  EXPECT_EQ(density->box().lo, Vec3(2.25f, -0.75f, 0.75f));
  EXPECT_EQ(density->box().hi, Vec3(4.25f, 0.75f, 1.75f));
  for (int i = 0; i < 24; ++i) {
    const Vec3 voxel(5 + i % 4, -1 + i / 4 % 3, 2 + i / 12);
    EXPECT_NEAR(density->color(0.5f * voxel).x, mixed_value(i), 1e-6f) << i;
  }
  const auto colour = make<Volume>(grid_xml(file, "<string name='grid' value='colour'/>"));
  EXPECT_LT(glm::length(colour->color(Vec3(0.75f, 0.5f, 0.5f)) - Rgb(.4f, .5f, .6f)), 1e-6f);
  EXPECT_NE(error_of(grid_xml(file, "<string name='grid' value='colr'/>"))
                .find("has no grid 'colr' (available: 'colour', 'density')"),
            std::string::npos);
  const std::string cut = folder.write("cut.vdb", bytes.substr(0, bytes.size() / 2));
  EXPECT_NE(error_of(grid_xml(cut)), "no error");
}

TEST(GridVolume, RefusesBadPlacements) {
  const TemporaryFolder folder;
  VolFile flat;
  flat.box[3] = flat.box[0];
  const std::string file = folder.write("flat.vol", flat.bytes(mixed_value));
  EXPECT_EQ(error_of(grid_xml(file)), "no error");  // the box plays no part
  EXPECT_NE(error_of(grid_xml(file, "<boolean name='use_grid_bbox' value='true'/>"))
                .find("'use_grid_bbox' requires a file whose box isn't empty"),
            std::string::npos);
}

TEST(GridVolume, ASingleVoxelIsUniformAndItsIntegralExact) {
  const TemporaryFolder folder;
  VolFile one;
  one.x = one.y = one.z = one.channels = 1;
  const auto volume =
      make<Volume>(grid_xml(folder.write("one.vol", one.bytes([](int) { return 2.5f; }))));
  alignas(kColumnAlignment) float column[7][kBlockLanes] = {};
  column[3][0] = 1, column[6][0] = 0.5f;
  float length[kBlockLanes] = {0.75f};
  float* const values[] = {column[6]};
  volume->integral_block({column[0], column[1], column[2]}, {column[3], column[4], column[5]},
                         length, 1, values);
  EXPECT_FLOAT_EQ(column[6][0], 2.5f * 0.75f);
  float value = 0;
  volume->eval(Vec3(-7, 0.5f, 1e30f), &value);
  EXPECT_EQ(value, 2.5f);
  volume->eval(Vec3(kNanValue), &value);  // must not read outside of the grid
  EXPECT_FALSE(value < 2.5f);
}

/// Integral of a trilinear grid along its axis, by hand: values 1 and 3 with centres at 1/4 and
/// 3/4.
TEST(GridVolume, IntegralsBetweenCentresMatchLineIntegrals) {
  const TemporaryFolder folder;
  VolFile two;
  two.x = 2, two.y = two.z = two.channels = 1;
  const auto volume = make<Volume>(
      grid_xml(folder.write("two.vol", two.bytes([](int i) { return i == 0 ? 1.f : 3.f; }))));
  alignas(kColumnAlignment) float column[7][kBlockLanes] = {};
  float length[kBlockLanes] = {};
  for (int i = 0; i < 2; ++i) {  // there and back
    column[0][i] = i == 0 ? 0.f : 1.f;
    column[1][i] = column[2][i] = 0.5f;
    column[3][i] = i == 0 ? 1.f : -1.f;
    length[i] = 1;
  }
  column[0][2] = 0.25f, column[1][2] = column[2][2] = 0.3f, column[3][2] = 1, length[2] = 0.25f;
  float* const values[] = {column[6]};
  volume->integral_block({column[0], column[1], column[2]}, {column[3], column[4], column[5]},
                         length, 3, values);
  EXPECT_FLOAT_EQ(column[6][0], 2);
  EXPECT_FLOAT_EQ(column[6][1], 2);
  EXPECT_FLOAT_EQ(column[6][2], 0.375f);
}

TEST(Extremes, OfEmptyBlocksAreZero) {
  const TemporaryFolder folder;
  VolFile file;
  file.x = file.y = file.z = 16, file.channels = 1;
  const auto volume = make<Volume>(grid_xml(folder.write(
      "corner.vol", file.bytes([](int i) { return i == 16 * 16 * 16 - 1 ? 5.f : 0.f; }))));
  const BlockGrid blocks{volume->box(), {2, 2, 2}};
  float lo[8], hi[8];
  volume->extremes(blocks, lo, hi);
  for (int i = 0; i < 8; ++i) {
    EXPECT_EQ(lo[i], 0) << i;
    EXPECT_NEAR(hi[i], i == 7 ? 5 : 0, 1e-5) << i;
  }
  EXPECT_EQ(volume->resolution(), glm::uvec3(16));
}

}  // namespace
}  // namespace kinome::test::volumes_test
