#include <gtest/gtest.h>

#include <algorithm>
#include <ctime>
#include <random>
#include <string_view>

#include "support/plugins/probe_registry.h"
#include "support/sanitizer.h"

/// Tests damaged scenes. Each must load or throw an Error; a crash, a hang or another exception is
/// a failure. Sanitizers detect other errors.
namespace kinome::test::scene_fuzz_test {
namespace {

using std::string_view_literals::operator""sv;

const std::string kScene = R"(<?xml version="1.0"?>
<!-- every tag once --><scene version="3.0.0">
  <default name="size" value="1.5"/><path value="."/>
  <bsdf type="diffuse" id="red"><rgb name="reflectance" value=".1, .2 .3"/></bsdf>
  <alias id="red" as="rot"/>
  <texture type="probe" id="t"><float name="real" value="$size"/>
    <integer name="integer" value="3"/><boolean name="boolean" value="true"/>
    <string name="string" value="&lt;&#65;&gt;"/><point name="vector" x="1" y="2" z="3"/>
    <spectrum name="color" value="400:1, 700:2"/><spectrum name="unbounded" value="3"/>
    <transform name="transform"><translate x="1"/><scale value="2"/>
      <rotate z="1" angle="30"/><lookat origin="1 2 3" target="0" up="0 1 0"/>
      <matrix value="1 0 0 0 1 0 0 0 1"/></transform>
    <ref id="rot"/>
  </texture>
</scene>)";

void load(const std::string& xml) {
  try {
    load_scene_from_string(xml, "fuzz.xml", {}, probe_registry());
  } catch (const Error& error) {
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    EXPECT_EQ(std::string(error.what()).substr(0, 8), "fuzz.xml");
  }
}

TEST(Fuzz, TheSceneItselfIsGood) {
  EXPECT_NO_THROW(load_scene_from_string(kScene, "fuzz.xml", {}, probe_registry()));
}

TEST(Fuzz, TruncatedAnywhere) {
  for (size_t size = 0; size < kScene.size(); ++size) load(kScene.substr(0, size));
}

TEST(Fuzz, BytesReplacedRemovedAndRepeated) {
  std::mt19937 random(1);
  const std::string_view alphabet = "<>/=\"'$&;:#!-. \n\0\xff\x80x1e"sv;
  for (int i = 0; i < 5000; ++i) {
    std::string xml = kScene;
    for (int change = 0; change < 1 + i % 3; ++change) {
      const size_t at = random() % xml.size();
      const size_t length = 1 + random() % 8;
      switch (random() % 3) {
        case 0:
          xml[at] = alphabet[random() % alphabet.size()];
          break;
        case 1:
          xml.erase(at, length);
          break;
        default:
          xml.insert(random() % xml.size(), xml.substr(at, length * 4));
      }
    }
    load(xml);
  }
}

TEST(Fuzz, DeepNesting) {
  std::string nested;
  for (int i = 0; i < 100000; ++i) nested += "<bsdf type='diffuse'>";
  EXPECT_NE(error_of([&] { load_scene_from_string(nested, "f", {}, probe_registry()); }),
            "no error");
  for (int i = 0; i < 100000; ++i) nested += "</bsdf>";
  const auto errors = errors_of([&] {
    load_scene_from_string("<scene version='3.0.0'>" + nested + "</scene>", "f", {},
                           probe_registry());
  });
  // The levels above report another error: a diffuse BSDF has no BSDF parameters.
  EXPECT_EQ(std::count_if(errors.begin(), errors.end(),
                          [](const std::string& error) {
                            return error.find("elements are nested too deeply") !=
                                   std::string::npos;
                          }),
            1);
}

TEST(Fuzz, LongChainsOfReferences) {
  std::string xml = "<scene version='3.0.0'>";
  constexpr int kLength = 20000;
  for (int i = 0; i < kLength; ++i) {
    xml += "<texture type='probe' id='t" + std::to_string(i) + "'><ref name='texture' id='t" +
           std::to_string(i + 1) + "'/></texture>\n";
  }
  xml += "<texture type='probe' id='t" + std::to_string(kLength) + "'/></scene>";
  EXPECT_NE(error_of([&] {
              load_scene_from_string(xml, "f", {}, probe_registry());
            }).find("objects are nested too deeply"),
            std::string::npos);
}

/// Each error is reported, up to a maximum. The time must not grow with the square of their number.
TEST(Fuzz, ThousandsOfErrors) {
  std::string xml = "<scene version='3.0.0'>";
  for (int i = 0; i < 6000; ++i) {
    const std::string n = std::to_string(i);
    xml += "<bsdf type='diffuse' id='material" + n + "'/><shape type='sphere'><ref id='matter" + n +
           "'/></shape><shape type='serialised'/>\n";
  }
  const std::clock_t start = std::clock();
  const auto errors =
      errors_of([&] { load_scene_from_string(xml + "</scene>", "f", {}, probe_registry()); });
  // A search of all names for each error would take minutes. An exception takes 1 to 2 ms with a
  // sanitizer.
  EXPECT_LT(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC, kHasSanitizer ? 100 : 20);
  ASSERT_EQ(errors.size(), 10001u);
  EXPECT_EQ(errors.back(), "f: too many errors: stopped looking for more");
}

TEST(Fuzz, HostileHundredBytes) {
  for (const char* xml : {
           "<!DOCTYPE a [<!ENTITY b \"bbbbbbbbbb\"><!ENTITY c "
           "\"&b;&b;&b;&b;&b;\">]><scene>&c;</scene>",
           "<scene version='99999999999999999999.0.0'/>",
           "<scene version='3.0.0'><include filename='/dev/stdin/..'/></scene>",
           "<scene version='3.0.0'><include filename='/'/></scene>",
           "<scene version='3.0.0'><default name='$' value='$'/></scene>",
           "<scene version='3.0.0'><shape type='../../../etc/passwd'/></scene>",
           "<scene version='-1.0.0'><float name='uoffset' value='1'/></scene>",
           "<scene version='0.0.0'><texture type='probe'><float name='uoffset'/></texture></scene>",
       }) {
    EXPECT_NE(error_of([&] { load_scene_from_string(xml, "f", {}, probe_registry()); }), "no error")
        << xml;
  }
}

}  // namespace
}  // namespace kinome::test::scene_fuzz_test
