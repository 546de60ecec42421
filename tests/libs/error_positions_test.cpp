#include <gtest/gtest.h>

#include "support/plugins/probe_registry.h"

/// Tests the positions of errors in unusual files.
namespace kinome::test::error_positions_test {
namespace {

TEST(Places, CountCharactersNotBytes) {
  EXPECT_EQ(error_of([] {
              load_scene_from_string(
                  "\xEF\xBB\xBF<scene version='3.0.0'>\n"
                  "<!-- Zwölf Boxkämpfer --> <bsdf type='ä' x=''/></scene>",
                  "scene.xml", {}, probe_registry());
            }),
            "scene.xml:2:42: <bsdf> has no attribute 'x'");
}

TEST(Places, DoNotCountAByteOrderMark) {
  EXPECT_EQ(error_of([] {
              load_scene_from_string("\xEF\xBB\xBF<scene version='3.0.0' x=''/>", "scene.xml", {},
                                     probe_registry());
            }),
            "scene.xml:1:24: <scene> has no attribute 'x'");
}

TEST(Places, OfAttributesOnOtherLinesWithAnyText) {
  EXPECT_EQ(error_of([] {
              load_scene_from_string(
                  "<scene version='3.0.0'>\r\n<bsdf\r\n  type = \"a='/>\"\r\n"
                  "\tzzz='>'/>\r\n</scene>",
                  "scene.xml", {}, probe_registry());
            }),
            "scene.xml:4:2: <bsdf> has no attribute 'zzz'");
}

TEST(Objects, HaveRootsOfTheirOwn) {
  EXPECT_EQ(error_of([] { load_object_from_string("<scene/>", "a.xml", {}, probe_registry()); }),
            "a.xml:1:1: a <scene> is not an object of its own");
  EXPECT_EQ(error_of([] { load_object_from_string("<float/>", "a.xml", {}, probe_registry()); }),
            "a.xml:1:1: the root must be an object such as <scene>, not <float>");
}

}  // namespace
}  // namespace kinome::test::error_positions_test
