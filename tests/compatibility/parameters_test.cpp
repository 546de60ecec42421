/// Tests all parameters of all plugins, and parameters that Mitsuba 3.9.1 accepts without effect.
#include <gtest/gtest.h>

#include <map>

#include "kinome/log_listener.h"
#include "kit/checks/read_checks.h"
#include "support/render.h"
#include "support/volume_files.h"

namespace kinome::test::parameters_test {
namespace {

using Names = std::vector<std::string>;

constexpr const char* kOnePixel =
    "<film type='hdrfilm'><integer name='width' value='1'/><integer name='height' value='1'/></film>";

/// A triangle whose positions and indices are in the file.
constexpr const char* kGltf = R"({"asset": {"version": "2.0"}, "scene": 0,
  "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
  "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
  "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                 "min": [0, 0, 0], "max": [1, 1, 0]}],
  "bufferViews": [{"buffer": 0, "byteLength": 36}],
  "buffers": [{"byteLength": 36, "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]})";

/// A triangle in version 4 of the format, in a zlib stream without compression.
std::string serialized_triangle() {
  std::string body;
  const auto add = [](std::string& to, const auto& value) {
    to.append(reinterpret_cast<const char*>(&value), sizeof(value));
  };
  add(body, uint32_t{0x1000});  // single precision
  body += '\0';                 // no name
  add(body, uint64_t{3}), add(body, uint64_t{1});
  for (const float x : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f}) add(body, x);
  for (const uint32_t vertex : {0, 1, 2}) add(body, vertex);
  uint32_t a = 1, b = 0;  // Adler-32 checksum
  for (const char c : body) {
    a = (a + static_cast<unsigned char>(c)) % 65521;
    b = (b + a) % 65521;
  }
  const auto length = static_cast<uint16_t>(body.size());
  std::string file("\x1c\x04\x04\x00\x78\x01\x01", 7);
  add(file, length), add(file, static_cast<uint16_t>(~length));
  file += body;
  for (const uint32_t sum : {b >> 8, b, a >> 8, a}) file += static_cast<char>(sum);
  add(file, uint64_t{0});
  add(file, uint32_t{1});
  return file;
}

/// Parameters without which plugins can't be built, by "category/name".
std::map<std::string, std::map<std::string, std::string>> needed(const TemporaryFolder& folder) {
  const std::string curve = folder.write("curves.txt", "-1 0 0 1\n0 0 0 1\n1 0 0 1\n2 0 0 1\n");
  const std::string map =
      folder.write("map.pfm", "Pf\n1 1\n-1.0\n" + std::string("\0\0\x80\x3f", 4));
  return {
      {"emitter/envmap", {{"filename", map}}},
      {"integrator/aov", {{"aovs", "depth:depth"}}},
      {"sensor/distant", {{"film", kOnePixel}}},
      {"sensor/radiancemeter", {{"film", kOnePixel}}},
      {"shape/bsplinecurve", {{"filename", curve}}},
      {"shape/gltf", {{"filename", folder.write("mesh.gltf", kGltf)}}},
      {"shape/instance",
       {{"group", "<shape type='shapegroup'><shape type='cube'/></shape>"}}},
      {"shape/linearcurve", {{"filename", curve}}},
      {"shape/obj",
       {{"filename", folder.write("mesh.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")}}},
      {"shape/ply",
       {{"filename", folder.write("mesh.ply",
                                  "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
                                  "property float y\nproperty float z\nelement face 1\nproperty "
                                  "list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n"
                                  "3 0 1 2\n")}}},
      {"shape/serialized", {{"filename", folder.write("mesh.serialized", serialized_triangle())}}},
      {"phase/sggx",
       {{"S", "<volume name='S' type='gridvolume'><string name='filename' value='" +
                  folder.write("flakes.vol", VolFile{1, 1, 1, 6}.bytes(mixed_value)) +
                  "'/></volume>"}}},
      {"phase/tabphase", {{"values", "1, 2"}}},
      {"texture/bitmap", {{"filename", map}}},
      {"texture/blackbody", {{"temperature", "5000"}}},
      {"texture/irregular", {{"wavelengths", "400 700"}, {"values", "0.1 0.5"}}},
      {"texture/mesh_attribute", {{"name", "vertex_color"}}},
      {"texture/regular",
       {{"wavelength_min", "400"}, {"wavelength_max", "700"}, {"values", "0.1 0.5"}}},
      {"volume/gridvolume",
       {{"filename", folder.write("grid.vol", VolFile().bytes(mixed_value))}}},
  };
}

/// Parameters that a plugin accepts with none of the values that are tried.
Names unknown_of(Category category, const std::string& name) {
  // Programs pass pixels, scene files don't.
  if (name == "envmap" || name == "bitmap" || name == "gridvolume") return {"data"};
  if (name == "bsplinecurve" || name == "linearcurve") return {"interior"};
  // Needs a nested integrator and the ids of emitters.
  if (name == "aov") return {"light_groups"};
  // Only a BSDF that defines a medium.
  return category == Category::kSensor ? Names{"bsdf"} : Names();
}

TEST(Parameters, OfAllTablesAreReadOrIgnored) {
  const TemporaryFolder folder;
  const auto given = needed(folder);
  int plugins = 0;
  for (const Category category : kCategories) {
    for (const std::string& name : registry().names(category)) {
      if (name != registry().find(category, name).name) continue;  // an alias
      const std::string title = std::string(to_string(category)) + "/" + name;
      check::Request request;
      request.plugin = title;
      request.plugin_paths = {KINOME_TEST_PLUGINS};
      if (const auto found = given.find(title); found != given.end()) {
        request.parameters = found->second;
      }
      const check::ParameterUse use = check::parameter_use(request);
      EXPECT_EQ(use.unread, Names()) << title;
      EXPECT_EQ(use.unknown, unknown_of(category, name)) << title;
      ++plugins;
    }
  }
  EXPECT_GT(plugins, 60);
}

/// Returns the warnings from loading a scene with these elements.
Names warnings_of(const std::string& xml) {
  Names warnings;
  const LogListener listener([&](const std::string& warning) { warnings.push_back(warning); });
  scene_from("<integrator type='path'/>" + xml);
  return warnings;
}

TEST(Parameters, WithoutEffectGiveOneWarning) {
  const std::string sensor = "<sensor type='perspective'><float name='focus_distance' value='5'/>"
                             "</sensor>";
  const Names warnings = warnings_of(sensor + "<emitter type='constant'/>");
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("'focus_distance' is ignored: a pinhole camera is sharp everywhere"),
            std::string::npos)
      << warnings[0];
  const std::string sphere =
      "<shape type='sphere'><float name='silhouette_sampling_weight' value='1'/></shape>";
  EXPECT_EQ(warnings_of(sphere + sphere + sphere).size(), 1u);
}

/// Each loads in Mitsuba 3.9.1, without effect on the image to which renders converge.
TEST(Parameters, ThatMitsubaAcceptsWithoutEffectLoad) {
  const std::string transform = "<transform name='to_world'><translate x='1'/></transform>";
  const Names accepted = {
      "<emitter type='constant'>" + transform + "</emitter>",
      "<emitter type='constant'><float name='sampling_weight' value='2'/></emitter>",
      "<sensor type='orthographic'><float name='focus_distance' value='2'/></sensor>",
      "<sensor type='perspective'><float name='focus_distance' value='2'/></sensor>",
      "<sensor type='perspective'><float name='shutter_open' value='1'/>"
      "<float name='shutter_close' value='2'/></sensor>",
      "<sensor type='batch'><sensor type='perspective'/>" + transform + "</sensor>",
      "<sensor type='perspective'><film type='hdrfilm'><boolean name='banner' value='false'/>"
      "<boolean name='compensate' value='true'/></film></sensor>",
      "<sensor type='perspective'><sampler type='orthogonal'><integer name='sample_count' value='4'/>"
      "<integer name='strength' value='2'/></sampler></sensor>",
      "<shape type='sphere'><float name='silhouette_sampling_weight' value='1'/></shape>",
      "<shape type='sphere'><texture type='checkerboard' name='vertex_weight'/></shape>",
      "<shape type='cube'><boolean name='face_normals' value='true'/></shape>",
      "<shape type='rectangle'><boolean name='face_normals' value='true'/></shape>",
      "<shape type='shapegroup' id='group'><shape type='cube'/>" + transform + "</shape>"
      "<shape type='instance'><ref id='group'/></shape>",
      "<integrator type='depth'><boolean name='hide_emitters' value='true'/></integrator>",
      "<integrator type='aov'><string name='aovs' value='d:depth'/>"
      "<boolean name='hide_emitters' value='true'/></integrator>",
      "<integrator type='moment'><integrator type='path'/>"
      "<boolean name='hide_emitters' value='true'/></integrator>",
      "<integrator type='path'><integer name='block_size' value='32'/>"
      "<integer name='samples_per_pass' value='1'/><float name='timeout' value='-1'/></integrator>",
      "<shape type='sphere'><bsdf type='diffuse'><texture type='uniform' name='reflectance'>"
      "<float name='value' value='0.5'/><float name='wavelength_min' value='400'/></texture></bsdf>"
      "</shape>",
      "<shape type='sphere'><bsdf type='twosided'><boolean name='allow_transmission' value='true'/>"
      "<bsdf type='mask'><bsdf type='diffuse'/></bsdf></bsdf></shape>",
  };
  for (const std::string& xml : accepted) {
    const bool has_sensor = xml.starts_with("<sensor");
    EXPECT_NO_THROW(scene_from(xml + (has_sensor ? "" : "<sensor type='perspective'/>"))) << xml;
  }
}

}  // namespace
}  // namespace kinome::test::parameters_test
