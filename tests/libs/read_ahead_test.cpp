#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "kinome/image_files.h"
#include "kinome/log.h"
#include "kinome/log_listener.h"
#include "kinome/scene_loader.h"
#include "scene_xml/objects/memory_in_use.h"
#include "support/image_helpers.h"
#include "support/render.h"

/// Tests that scenes whose files are read by several threads are those of one thread.
namespace kinome::test {
namespace {

std::string scene(const std::string& children) {
  return "<scene version='3.0.0'>" + children + "</scene>";
}

std::string from_file(const std::string& tag, const std::string& name, const std::string& child) {
  return "<" + tag + "><string name='filename' value='" + name + "'/>" + child + "</" +
         tag.substr(0, tag.find(' ')) + ">";
}

/// Loads a scene, and returns its warnings and errors, or the names of its plugins.
std::vector<std::string> messages_of(const std::string& path, unsigned threads) {
  std::vector<std::string> messages;
  const LogListener listener([&](const std::string& warning) { messages.push_back(warning); });
  LoadOptions options;
  options.threads = threads;
  RenderStats stats;
  try {
    load_scene(path, options, registry(), &stats);
    messages.insert(messages.end(), stats.plugins.begin(), stats.plugins.end());
  } catch (const Errors& errors) {
    for (const Error& error : errors.all()) messages.emplace_back(error.what());
  }
  return messages;
}

void expect_same_at_any_number_of_threads(const std::string& path,
                                          const std::vector<std::string>& parts) {
  const std::vector<std::string> messages = messages_of(path, 1);
  ASSERT_EQ(messages.size(), parts.size()) << testing::PrintToString(messages);
  for (size_t i = 0; i < parts.size(); ++i) {
    EXPECT_NE(messages[i].find(parts[i]), std::string::npos) << messages[i];
  }
  for (const unsigned threads : {2u, 3u, 8u}) EXPECT_EQ(messages_of(path, threads), messages);
}

TEST(ReadAhead, MessagesDontDependOnThreads) {
  const TemporaryFolder folder;
  const std::string vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  folder.write("a.obj", vertices + "f 1 2 3\n");
  for (const char* const empty : {"b.obj", "c.obj"}) folder.write(empty, vertices);
  folder.write("d.obj", vertices + "f 1 2 4\n");
  folder.write("map.pfm", "Pf\n1 1\n-1\nabc");
  const auto mesh = [](const std::string& name, const std::string& child) {
    return from_file("shape type='obj'", name, child);
  };
  const std::string map = "<bsdf type='diffuse'>" +
                          from_file("texture type='bitmap' name='reflectance'", "map.pfm", "") +
                          "</bsdf>";
  const std::string used = mesh("b.obj", "") + mesh("a.obj", "") +
                           mesh("c.obj", "<emitter type='area'/>") +
                           "<bsdf type='diffuse' id='shared'/>" + mesh("a.obj", "<ref id='shared'/>") +
                           "<integrator type='path'/>";
  expect_same_at_any_number_of_threads(
      folder.write("good.xml", scene(used)),
      {"b.obj: the file has no faces", "c.obj: the file has no faces", "has no area",
       "bsdf/diffuse", "shape/obj", "emitter/area", "integrator/path", "sensor/perspective",
       "film/hdrfilm", "rfilter/gaussian", "sampler/independent"});
  expect_same_at_any_number_of_threads(
      folder.write("bad.xml",
                   scene(used + mesh("d.obj", map) + mesh("none.obj", "") + mesh("d.obj", "<odd/>"))),
      {"b.obj: the file has no faces", "c.obj: the file has no faces", "has no area",
       "refers to vertex 4", "map.pfm: can't be read", "no file 'none.obj'", "unknown tag <odd>"});
}

/// Unused data of a file are reported once, in the order of the scene.
TEST(ReadAhead, UnusedDataAreReportedInTheOrderOfTheScene) {
  const TemporaryFolder folder;
  std::string children;
  for (const char* const name : {"z.ply", "x.ply", "y.ply", "x.ply", "z.ply", "y.ply"}) {
    folder.write(name,
                 "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
                 "property float z\nproperty float quality\nelement face 1\nproperty list uchar "
                 "int vertex_indices\nend_header\n0 0 0 1\n1 0 0 1\n0 1 0 1\n3 0 1 2\n");
    children += from_file("shape type='ply'", name, "");
  }
  const std::string path = folder.write("s.xml", scene(children + "<integrator type='path'/>"));
  const LogLevel level = log_level();
  set_log_level(LogLevel::kInfo);
  testing::internal::CaptureStderr();
  messages_of(path, 8);
  const std::string log = testing::internal::GetCapturedStderr();
  set_log_level(level);
  const size_t z = log.find("z.ply: not used"), x = log.find("x.ply: not used"),
               y = log.find("y.ply: not used");
  EXPECT_LT(z, x) << log;
  EXPECT_LT(x, y) << log;
  EXPECT_NE(y, std::string::npos) << log;
  EXPECT_EQ(log.rfind("z.ply: not used"), z) << log;
}

TEST(ReadAhead, MemoryOfObjectsBeingMadeIsBounded) {
  constexpr uint64_t kMax = loader::MemoryInUse::kMaxOtherBytes;
  loader::MemoryInUse memory;
  EXPECT_TRUE(memory.admits(10 * kMax));
  memory.begin(10 * kMax);
  EXPECT_FALSE(memory.admits(kMax + 1));
  memory.begin(kMax / 2);
  memory.begin(kMax / 2);
  EXPECT_FALSE(memory.admits(1));
  EXPECT_TRUE(memory.admits(0));
  memory.end(10 * kMax);
  EXPECT_TRUE(memory.admits(kMax / 2));
  EXPECT_TRUE(memory.admits(10 * kMax));
  memory.begin(10 * kMax);
  EXPECT_FALSE(memory.admits(1));
}

/// Files that are large enough for OpenEXR's threads.
TEST(ReadAhead, ReadsLargeImagesTogether) {
#if defined(__SANITIZE_THREAD__)
  set_image_file_threads(1);  // the sanitizer doesn't see how OpenEXR's own threads synchronise
#endif
  const TemporaryFolder folder;
  const Image image = make_image(600, 300, {"R", "G", "B"});
  for (const char* const name : {"a.exr", "b.exr", "c.exr"}) {
    write_exr(folder.path(name), image, ExrSampleType::kFloat, {});
  }
  std::string children = from_file("emitter type='envmap'", "a.exr", "");
  for (const char* const name : {"b.exr", "c.exr"}) {
    children += "<shape type='sphere'><bsdf type='diffuse'>" +
                from_file("texture type='bitmap' name='reflectance'", name,
                          "<string name='wrap_mode' value='clamp'/>") +
                "</bsdf></shape>";
  }
  const std::vector<std::string> messages = messages_of(folder.write("s.xml", scene(children)), 1);
  EXPECT_EQ(messages_of(folder.path("s.xml"), 4), messages);
}

}  // namespace
}  // namespace kinome::test
