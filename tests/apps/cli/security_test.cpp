// Tests with untrusted scenes and files: they write nothing and load only the program's own
// plugins. Whatever they contain, the program takes at most a second and a gigabyte to refuse them.

#include <sys/stat.h>

#include <cstring>

#include "cli.h"
#include "kinome/image_files.h"
#include "kinome/image.h"

namespace kinome::test::security_test {
namespace {

namespace fs = std::filesystem;

class Security : public Cli {
 protected:
  /// Runs the program with limits of a second of processor time and a gigabyte of memory, beyond
  /// which it is killed.
  static ProcessResult bounded(std::vector<std::string> arguments) {
#ifdef KINOME_HAS_SANITIZER
    const std::string limits;  // sanitizers are slow, and reserve terabytes
#else
    const std::string limits = "ulimit -t 10; ulimit -v 1048576; ";
#endif
    arguments.insert(arguments.begin(),
                     {"sh", "-c", limits + "exec \"$@\"", "sh", KINOME_TEST_PROGRAM, "-t", "1"});
    return run_process(arguments);
  }
  void expect_refused(const std::string& xml, const std::vector<std::string>& parts,
                      const std::vector<std::string>& options = {}) {
    std::vector<std::string> own = other_files({});
    const std::string scene = folder_.write("scene.xml", xml);
    own.push_back(scene);
    std::vector<std::string> arguments = {scene};
    arguments.insert(arguments.end(), options.begin(), options.end());
    const ProcessResult result = bounded(arguments);
    SCOPED_TRACE(xml.substr(0, 300));
    EXPECT_EQ(result.status, 1) << result.err;
    EXPECT_EQ(lines(result.err), 1u) << result.err;
    EXPECT_LT(result.err.size(), 1000u);
    EXPECT_EQ(result.err.find("out of memory"), std::string::npos) << result.err;
    for (const std::string& part : parts) {
      EXPECT_NE(result.err.find(part), std::string::npos) << part << " in " << result.err;
    }
    EXPECT_EQ(other_files(own), std::vector<std::string>{});
  }
  static std::string in_scene(const std::string& inner) {
    return "<scene version=\"3.0.0\">\n" + inner + "\n</scene>\n";
  }
  static std::string with_file(const std::string& tag, const std::string& type,
                               const std::string& file) {
    return in_scene("<" + tag + " type=\"" + type + "\"><string name=\"filename\" value=\"" + file +
                    "\"/></" + tag + ">");
  }
};

TEST_F(Security, ScenesDontSelectOutputFiles) {
  for (const char* name : {"filename", "output", "path", "checkpoint"}) {
    expect_refused(
        in_scene("<sensor type=\"perspective\"><film type=\"hdrfilm\">"
                 "<string name=\"" +
                 std::string(name) + "\" value=\"../../elsewhere.exr\"/></film></sensor>"),
        {"'" + std::string(name) + "'"});
  }
  // Names of sensors and other objects don't write files, either.
  std::string xml = small_scene();
  xml.replace(xml.find("id=\"front\""), 10, "id=\"../../front\"");
  const std::string scene = folder_.write("scene.xml", xml);
  EXPECT_EQ(kinome({"-q", scene, "-s", "../../front", "-D", "width=8"}).status, 0);
  EXPECT_EQ(other_files({scene}), std::vector<std::string>{folder_.path("scene.exr")});
}

/// A plugin beside the scene, or anywhere the scene points to.
TEST_F(Security, ScenesDontBringPlugins) {
  for (const char* folder : {"", "bsdf", "plugins/bsdf", "lib/kinome/plugins/bsdf"}) {
    fs::create_directories(folder_.path(folder));
    fs::copy_file(KINOME_TEST_FAULTY "/bsdf/faulty.so",
                  folder_.path(std::string(folder) + "/faulty.so"));
  }
  const auto refused = [&](const std::string& type) {
    expect_refused(in_scene("<path value=\"bsdf\"/><bsdf type=\"" + type + "\" id=\"a\"/>"),
                   {"unknown bsdf plugin"}, {"-a", folder_.folder()});
  };
  for (const char* type : {"faulty", "./faulty", "bsdf/faulty", "../bsdf/faulty", "faulty.so"}) {
    refused(type);
  }
  refused(folder_.path("bsdf/faulty"));
  // The program runs in the scene's folder.
  const std::string scene = folder_.write("scene.xml", in_scene("<bsdf type=\"faulty\"/>"));
  const ProcessResult result = run_process({"sh", "-c", "cd \"$1\" && exec \"$2\" scene.xml", "sh",
                                            folder_.folder(), KINOME_TEST_PROGRAM});
  expect_one_error(result, "", {"unknown bsdf plugin 'faulty'"});
}

TEST_F(Security, XmlThatGrows) {
  std::string entities = "<?xml version=\"1.0\"?><!DOCTYPE scene [<!ENTITY a0 \"aaaaaaaaaa\">";
  for (int i = 1; i < 20; ++i) {
    entities += "<!ENTITY a" + std::to_string(i) + " \"";
    for (int k = 0; k < 10; ++k) entities += "&a" + std::to_string(i - 1) + ";";
    entities += "\">";
  }
  // Entities aren't expanded, so that this one is unknown.
  expect_refused(entities + "]><scene version=\"3.0.0\"><shape type=\"&a19;\"/></scene>", {"&a19;"});

  // Defaults of defaults, one value or many.
  std::string defaults = "<default name=\"x0\" value=\"xxxxxxxxxx\"/>";
  const auto doubled = [&](int last) {
    for (int i = 1; i <= last; ++i) {
      const std::string before = "$x" + std::to_string(i - 1) + " ";
      defaults +=
          "<default name=\"x" + std::to_string(i) + "\" value=\"" + before + before + "\"/>\n";
    }
    return defaults;
  };
  expect_refused(in_scene(doubled(40)), {"too long by substitution"});
  defaults = "<default name=\"x0\" value=\"xxxxxxxxxx\"/>";
  std::string floats = doubled(15);
  for (int i = 0; i < 5000; ++i) {
    floats += "<bsdf type=\"diffuse\"><string name=\"id\" value=\"$x15 \"/></bsdf>";
  }
  expect_refused(in_scene(floats), {"too large by substitution"});

  expect_refused(in_scene("<include filename=\"scene.xml\"/>"), {"includes itself"});
  folder_.write("a.xml", in_scene("<include filename=\"b.xml\"/>"));
  folder_.write("b.xml", in_scene("<include filename=\"a.xml\"/>"));
  expect_refused(in_scene("<include filename=\"a.xml\"/>"), {"includes itself"});
  for (int i = 0; i < 15; ++i) {
    const std::string next = "<include filename=\"n" + std::to_string(i + 1) + ".xml\"/>";
    folder_.write("n" + std::to_string(i) + ".xml", in_scene(next + next));
  }
  folder_.write("n15.xml", in_scene(""));
  expect_refused(in_scene("<include filename=\"n1.xml\"/>"), {"too many includes"});
  // A value of a megabyte, a thousand times.
  std::string large;
  for (int i = 0; i < 20000; ++i) large += "<default name=\"a\" value=\"some text, not much\"/>\n";
  folder_.write("large.xml", in_scene(large));
  std::string includes;
  for (int i = 0; i < 1000; ++i) includes += "<include filename=\"large.xml\"/>";
  expect_refused(in_scene(includes), {"large.xml", "too many times"});
}

TEST_F(Security, ObjectsThatReferTwiceToTheNext) {
  std::string scene = "<bsdf type=\"diffuse\" id=\"b0\"/>";
  for (int i = 1; i < 100; ++i) {
    const std::string next = "<ref id=\"b" + std::to_string(i - 1) + "\"/>";
    scene += "<bsdf type=\"twosided\" id=\"b" + std::to_string(i) + "\">" + next + next + "</bsdf>";
  }
  scene +=
      "<integrator type=\"direct\"/><shape type=\"sphere\"><ref id=\"b99\"/></shape>"
      "<emitter type=\"constant\"/><sensor type=\"perspective\"><transform name=\"to_world\">"
      "<lookat origin=\"0,0,5\" target=\"0,0,0\" up=\"0,1,0\"/></transform>"
      "<film type=\"hdrfilm\"><integer name=\"width\" value=\"4\"/>"
      "<integer name=\"height\" value=\"4\"/></film></sensor>";
  const ProcessResult result = bounded({folder_.write("scene.xml", in_scene(scene))});
  EXPECT_EQ(result.status, 0) << result.err;
}

TEST_F(Security, FilesWithoutAnEnd) {
  expect_refused(in_scene("<include filename=\"/dev/zero\"/>"),
                 {"/dev/zero", "not a regular file"});
  expect_refused(with_file("shape", "ply", "/dev/zero"), {"/dev/zero", "not a regular file"});
  expect_refused(with_file("emitter", "envmap", "/dev/urandom"), {"not a regular file"});
  expect_refused(in_scene("<bsdf type=\"diffuse\"><spectrum name=\"reflectance\" "
                          "filename=\"/dev/zero\"/></bsdf>"),
                 {"/dev/zero", "not a regular file"});
}

/// Kernel files that are regular files of any size, or that block for ever.
TEST_F(Security, FilesThatTheKernelMakes) {
  // Links to these files are refused, too.
  const std::string link = folder_.path("link");
  fs::create_symlink("/proc/self/maps", link);
  const std::string relative = fs::relative("/proc/self/maps", folder_.folder());
  const std::string of_sys = "/sys/kernel/uevent_seqnum";
  for (const std::string& file :
       {std::string("/proc/self/mem"), std::string("/proc/self/pagemap"), of_sys, link, relative}) {
    SCOPED_TRACE(file);
    if (file == of_sys && !fs::exists(file)) continue;  // missing in some containers
    expect_refused(in_scene("<include filename=\"" + file + "\"/>"), {file, "kernel"});
    for (const char* type : {"obj", "ply", "gltf"}) {
      expect_refused(with_file("shape", type, file), {file, "kernel"});
    }
    expect_refused(with_file("emitter", "envmap", file), {file, "kernel"});
    const ProcessResult result =
        kinome({fs::path(folder_.folder()) / file, "-o", folder_.path("a")});
    EXPECT_EQ(result.status, 1);
    EXPECT_NE(result.err.find("kernel"), std::string::npos) << result.err;
  }
}

TEST_F(Security, PipesInsteadOfFiles) {
  const std::string pipe = folder_.path("pipe");
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  expect_refused(with_file("shape", "ply", pipe), {"not a regular file"});
  folder_.write("a.gltf", R"({"asset": {"version": "2.0"}, "buffers":
                              [{"byteLength": 42, "uri": "pipe"}]})");
  expect_refused(with_file("shape", "gltf", "a.gltf"), {"a.gltf", "pipe"});
  const ProcessResult result = kinome({pipe}, 200);
  EXPECT_EQ(result.status, 1);
  EXPECT_NE(result.err.find("not a regular file"), std::string::npos) << result.err;
}

TEST_F(Security, NamesOfMegabytesAreCut) {
  const std::string name(5'000'000, 'x');
  for (const std::string& inside :
       {"<shape type=\"" + name + "\"/>", "<" + name + "/>", "<ref id=\"" + name + "\"/>",
        "<shape type=\"ply\"><string name=\"filename\" value=\"" + name + "\"/></shape>"}) {
    const ProcessResult result = kinome({folder_.write("scene.xml", in_scene(inside))});
    EXPECT_EQ(result.status, 1);
    EXPECT_LT(result.err.size(), 1500u);
  }
}

TEST_F(Security, NumbersThatAreTooLarge) {
  const auto film = [](const std::string& name, const std::string& value) {
    return in_scene("<sensor type=\"perspective\"><film type=\"hdrfilm\"><integer name=\"" + name +
                    "\" value=\"" + value + "\"/></film></sensor>");
  };
  for (const char* value : {"1000000000", "-1", "99999999999999999999"}) {
    for (const char* name : {"width", "height", "crop_width"})
      expect_refused(film(name, value), {});
  }
  const auto integrator = [](const std::string& type, const std::string& name) {
    return in_scene("<integrator type=\"" + type + "\"><integer name=\"" + name +
                    "\" value=\"1000000000000\"/></integrator>");
  };
  for (const char* name : {"light_samples", "cut_size", "emitter_samples", "brdf_samples"}) {
    expect_refused(integrator("clustered", name), {name, "1000000000000"});
  }
  expect_refused(integrator("direct", "shading_samples"), {"shading_samples", "1000000000000"});
  expect_refused(in_scene("<sensor type=\"perspective\"><sampler type=\"independent\">"
                          "<integer name=\"sample_count\" value=\"1000000000000\"/></sampler>"
                          "</sensor>"),
                 {"sample_count", "1000000000000"});
  expect_refused(in_scene("<emitter type=\"vpl\"><integer name=\"light_samples\" "
                          "value=\"1000000000000\"/></emitter>"),
                 {"light_samples", "1000000000000"});
}

/// A PNG that claims a size, with a header whose checksum is correct.
std::string png_of(uint32_t side) {
  std::string header = "IHDR";
  const auto put = [](std::string& to, uint32_t number) {
    for (int shift = 24; shift >= 0; shift -= 8) to += static_cast<char>(number >> shift & 255);
  };
  put(header, side);
  put(header, side);
  header += std::string("\x08\x02\x00\x00\x00", 5);
  uint32_t crc = 0xffffffff;
  for (const char c : header) {
    crc ^= static_cast<unsigned char>(c);
    for (int bit = 0; bit < 8; ++bit) crc = crc & 1 ? crc >> 1 ^ 0xedb88320 : crc >> 1;
  }
  std::string png("\x89PNG\r\n\x1a\n\0\0\0\x0d", 12);
  png += header;
  put(png, ~crc);
  return png + std::string("\0\0\0\0IEND\xae\x42\x60\x82", 12);
}

TEST_F(Security, ImagesThatClaimToBeHuge) {
  const auto in_both = [&](const std::string& name, const std::string& contents) {
    folder_.write(name, contents);
    expect_refused(with_file("emitter", "envmap", name), {name});
    expect_refused(
        in_scene("<shape type=\"sphere\"><bsdf type=\"diffuse\"><texture type=\"bitmap\" "
                 "name=\"reflectance\">"
                 "<string name=\"filename\" value=\"" +
                 name + "\"/></texture></bsdf></shape>"),
        {name});
    fs::remove(folder_.path(name));
  };
  for (const char* size : {"1000000 1000000", "131072 131072", "100000 100000"}) {
    in_both("a.pfm", "PF\n" + std::string(size) + "\n-1.0\n0123456789");
  }
  Image map{8, 8, {"R", "G", "B"}, std::vector<float>(8 * 8 * 3, 0.5f)};
  write_exr(folder_.path("map.exr"), map, ExrSampleType::kFloat, {});
  const std::string exr = read_text(folder_.path("map.exr"));
  for (const int32_t last : {999999, 131071, 100000}) {
    std::string huge = exr;
    for (const char* window : {"dataWindow", "displayWindow"}) {
      // Its name, "box2i", the size of 16; then x0, y0, x1, y1.
      const size_t at = huge.find(window) + std::strlen(window) + 1 + 6 + 4;
      for (const size_t corner : {at + 8, at + 12}) std::memcpy(&huge[corner], &last, 4);
    }
    in_both("b.exr", huge);
  }
  // An attribute of an unknown type, and its size.
  std::string attribute = exr;
  const size_t type = attribute.find("screenWindowCenter") + 19;
  attribute.replace(type, 3, "xyz");
  const int32_t gigabytes = 2000000000;
  std::memcpy(&attribute[type + 4], &gigabytes, sizeof gigabytes);
  in_both("c.exr", attribute);
  for (const uint32_t side : {1000000u, 100000u}) in_both("a.png", png_of(side));
  in_both("a.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1000000 +X 1000000\n0123456789");
}

TEST_F(Security, MeshesThatClaimToBeHuge) {
  const std::string ply =
      "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float "
      "y\nproperty float z\nelement face 1000000000000\nproperty list uchar int "
      "vertex_indices\nend_header\n" +
      std::string(36, '\0');
  folder_.write("a.ply", ply);
  expect_refused(with_file("shape", "ply", "a.ply"), {"a.ply", "1000000000000"});
  // Counts of an accessor and of a buffer, and a mesh in a hundred thousand nodes.
  const auto gltf = [](const std::string& count, const std::string& bytes, int nodes) {
    std::string list, indices;
    for (int i = 0; i < nodes; ++i) {
      list += std::string(i > 0 ? "," : "") + "{\"mesh\": 0}";
      indices += (i > 0 ? "," : "") + std::to_string(i);
    }
    return R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [)" + indices +
           R"(]}], "nodes": [)" + list +
           R"(], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
  "accessors": [{"bufferView": 0, "componentType": 5126, "count": )" +
           count + R"(, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}],
  "bufferViews": [{"buffer": 0, "byteLength": 36000}],
  "buffers": [{"byteLength": )" +
           bytes + R"(, "uri": "data:application/octet-stream;base64,)" + std::string(48000, 'A') +
           "\"}]}";
  };
  folder_.write("a.gltf", gltf("1000000000000", "36000", 1));
  expect_refused(with_file("shape", "gltf", "a.gltf"), {"a.gltf"});
  folder_.write("a.gltf", gltf("3000", "1000000000000", 1));
  expect_refused(with_file("shape", "gltf", "a.gltf"), {"a.gltf"});
  folder_.write("a.gltf", gltf("3000", "36000", 30000));
  expect_refused(with_file("shape", "gltf", "a.gltf"), {"a.gltf", "repeats its data too often"});
}

}  // namespace
}  // namespace kinome::test::security_test
