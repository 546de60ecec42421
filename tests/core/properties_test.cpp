#include "kinome/properties.h"

#include <gtest/gtest.h>

#include "kinome/texture.h"
#include "support/render.h"

namespace kinome::properties_test {
namespace {

constexpr const char* kWords[] = {"beckmann", "ggx"};
constexpr Parameter kTable[] = {
    choice_of("word", kWords, "ggx", ""),
    {"flag", ParameterType::kBoolean, "true", ""},
    {"count", ParameterType::kInteger, "-3", ""},
    {"size", ParameterType::kFloat, "2.5", ""},
    {"name", ParameterType::kString, "nobody", ""},
    {"file", ParameterType::kFile, nullptr, ""},
    {"axis", ParameterType::kVector, "0 0 1", ""},
    {"light", ParameterType::kEmission, "0.5", ""},
    {"albedo", ParameterType::kReflectanceTexture, "0.1 0.2 0.3", ""},
    {"alpha", ParameterType::kUnitlessTexture, "3", ""},
    {"map", ParameterType::kReflectanceTexture, nullptr, ""},
    {"to_world", ParameterType::kTransform, nullptr, ""},
    {"moved", ParameterType::kTransform, "1 0 0 5  0 1 0 6  0 0 1 7  0 0 0 1", ""},
    {"bad", ParameterType::kFloat, "one", ""},
    named_object("mask", Category::kTexture, ""),
    named_object("inner", Category::kBsdf, "", true),
};
const Location kWhere{"f.xml", 2, 5};

Properties make() {
  Properties props(Category::kBsdf, "thing", {"f.xml", 1, 1});
  props.set_table(kTable);
  return props;
}

template <class Function>
std::string error_of(const Function& function) {
  try {
    function();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(Properties, GettersFallBackOnTheTable) {
  const Properties props = make();
  EXPECT_TRUE(props.boolean("flag"));
  EXPECT_EQ(props.integer("count"), -3);
  EXPECT_EQ(props.real("size"), 2.5f);
  EXPECT_EQ(props.real("count"), -3.f);
  EXPECT_EQ(props.string("name"), "nobody");
  EXPECT_EQ(props.vector("axis"), Vec3(0, 0, 1));
  EXPECT_EQ(props.color("light"), Rgb(0.5f));
  EXPECT_EQ(props.texture("albedo")->mean(), Rgb(0.1f, 0.2f, 0.3f));
  EXPECT_EQ(props.texture("alpha")->mean(), Rgb(3.f));
  EXPECT_EQ(props.texture("map"), nullptr);
  EXPECT_TRUE(props.transform("to_world").is_identity());
  EXPECT_EQ(props.transform("moved").point(Vec3(1, 1, 1)), Vec3(6, 7, 8));
  EXPECT_FALSE(props.has("flag"));
}

TEST(Properties, WrongTableEntriesAreLogicErrors) {
  const Properties props = make();
  EXPECT_THROW(props.real("bad"), std::logic_error);
  EXPECT_THROW(props.real("unlisted"), std::logic_error);
}

TEST(Properties, MissingParametersWithoutDefaultAreErrors) {
  EXPECT_EQ(error_of([] { make().file("file"); }),
            "f.xml:1:1: bsdf 'thing' needs parameter 'file', a string (a file name)");
}

TEST(Properties, ValuesConvertAsMitsubasDo) {
  Properties props = make();
  props.set("size", int64_t{4}, kWhere);
  props.set("light", Vec3(1, 2, 3), kWhere);
  props.set("albedo", 0.25, kWhere);
  props.set("alpha", UniformColor{Rgb(5, 6, 7), false, false}, kWhere);
  EXPECT_EQ(props.real("size"), 4.f);
  EXPECT_EQ(props.color("light"), Rgb(1, 2, 3));
  EXPECT_EQ(props.texture("albedo")->mean(), Rgb(0.25f));
  EXPECT_EQ(props.texture("alpha")->mean(), Rgb(5, 6, 7));
}

TEST(Properties, ASpectrumIsEqualEnergyWhiteToLightAndWhiteToReflectance) {
  Properties props = make();
  props.set("light", UniformColor{Rgb(2.f), true, false}, kWhere);
  props.set("albedo", UniformColor{Rgb(0.5f), true, false}, kWhere);
  EXPECT_FLOAT_EQ(props.color("light").x, 2 * 1.204794f);
  EXPECT_FLOAT_EQ(props.color("light").y, 2 * 0.948291f);
  EXPECT_FLOAT_EQ(props.color("light").z, 2 * 0.908916f);
  EXPECT_EQ(props.texture("albedo")->mean(), Rgb(0.5f));
}

TEST(Properties, TypeErrorsNameBothTypes) {
  Properties props = make();
  props.set("count", 1.5, kWhere);
  props.set("name", true, kWhere);
  props.set("size", std::string("x"), kWhere);
  EXPECT_EQ(error_of([&] { props.integer("count"); }),
            "f.xml:2:5: 'count' must be an integer, got a float");
  EXPECT_EQ(error_of([&] { props.string("name"); }),
            "f.xml:2:5: 'name' must be a string, got a boolean");
  EXPECT_EQ(error_of([&] { props.real("size"); }),
            "f.xml:2:5: 'size' must be a float, got a string");
  EXPECT_EQ(error_of([&] { props.color("name"); }),
            "f.xml:2:5: 'name' must be a color, got a boolean");
}

TEST(Properties, ReflectancesOutsideTheUnitIntervalAreErrors) {
  Properties props = make();
  props.set("albedo", 1.5, kWhere);
  props.set("map", UniformColor{Rgb(0.5f, -0.25f, 0.f), false, false}, kWhere);
  props.set("alpha", 1e6, kWhere);
  EXPECT_EQ(error_of([&] { props.texture("albedo"); }),
            "f.xml:2:5: 'albedo' is outside [0,1]: 1.5");
  EXPECT_EQ(error_of([&] { props.texture("map"); }),
            "f.xml:2:5: 'map' is outside [0,1]: 0.5 -0.25 0");
  EXPECT_EQ(props.texture("alpha")->max(), 1e6f);
}

TEST(Properties, BordersOfTheUnitIntervalAreInside) {
  Properties props = make();
  props.set("albedo", int64_t{1}, kWhere);
  props.set("map", 0.0, kWhere);
  EXPECT_EQ(props.texture("albedo")->mean(), Rgb(1.f));
  EXPECT_EQ(props.texture("map")->mean(), Rgb(0.f));
}

TEST(Properties, ChoicesSuggestTheNearest) {
  Properties props = make();
  EXPECT_EQ(props.choice("word"), 1);
  props.set("word", std::string("beckmann"), kWhere);
  EXPECT_EQ(props.choice("word"), 0);
  Properties wrong = make();
  wrong.set("word", std::string("bekman"), kWhere);
  EXPECT_EQ(error_of([&] { wrong.choice("word"); }),
            "f.xml:2:5: 'word' must be one of 'beckmann', 'ggx', got 'bekman' (did you mean "
            "'beckmann'?)");
}

TEST(Properties, ParametersGivenTwiceAreErrors) {
  Properties props = make();
  props.set("size", 1.0, {"f.xml", 2, 5});
  EXPECT_EQ(error_of([&] {
              props.set("size", 2.0, {"f.xml", 3, 5});
            }),
            "f.xml:3:5: 'size' is given twice (first at f.xml:2:5)");
}

TEST(Properties, ListsUnreadParameters) {
  Properties props = make();
  props.set("size", 1.0, kWhere);
  props.set("count", int64_t{1}, kWhere);
  EXPECT_TRUE(props.has("size"));  // has() doesn't count as a read
  props.integer("count");
  EXPECT_FALSE(props.entries()[0].second.read);
  EXPECT_TRUE(props.entries()[1].second.read);
}

TEST(Properties, ObjectsAreFoundByName) {
  Properties props = make();
  EXPECT_EQ(props.object<Texture>("mask"), nullptr);
  EXPECT_EQ(error_of([&] { props.object<Bsdf>("inner"); }),
            "f.xml:1:1: bsdf 'thing' needs parameter 'inner', a bsdf");
  const std::shared_ptr<Texture> texture = make_uniform_texture(Rgb(1.f));
  props.set("other", std::shared_ptr<Object>(make_uniform_texture(Rgb(0.f))), kWhere);
  props.set("mask", std::shared_ptr<Object>(texture), kWhere);
  EXPECT_EQ(props.object<Texture>("mask"), texture);
  EXPECT_TRUE(props.has_object("mask"));
  EXPECT_FALSE(props.has_object("inner"));
  EXPECT_FALSE(props.entries()[0].second.read);
  EXPECT_TRUE(props.entries()[1].second.read);
  const auto nested = props.nested<Texture>();
  ASSERT_EQ(nested.size(), 2u);
  EXPECT_EQ(nested[0].name, "other");
  EXPECT_EQ(nested[0].where.line, 2);
  EXPECT_EQ(nested[1].object, texture);
}

TEST(Properties, ObjectsOfTheWrongKindAreRefused) {
  Properties props = make();
  props.set("inner", std::shared_ptr<Object>(make_uniform_texture(Rgb(1.f))), kWhere);
  props.set("mask", 1.0, kWhere);
  EXPECT_EQ(error_of([&] { props.object<Bsdf>("inner"); }),
            "f.xml:2:5: 'inner' must be a bsdf, got a texture");
  EXPECT_EQ(error_of([&] { props.object<Texture>("mask"); }),
            "f.xml:2:5: 'mask' must be a texture, got a float");
  EXPECT_FALSE(props.has_object("mask"));
}

TEST(Properties, IntegersOutsideARangeAreErrors) {
  Properties props = make();
  props.set("count", int64_t{7}, kWhere);
  EXPECT_EQ(props.integer("count", 7, 7), 7u);
  for (const auto& [low, high] : {std::pair(0u, 6u), std::pair(8u, 4000000000u)}) {
    const std::string message =
        error_of([&, low = low, high = high] { props.integer("count", low, high); });
    EXPECT_NE(message.find("must be from " + std::to_string(low) + " to " + std::to_string(high) +
                           ", got 7"),
              std::string::npos)
        << message;
  }
}

TEST(Properties, FilesAreSearchedInOrder) {
  const test::TemporaryFolder folder;
  const std::string first = folder.folder() + "/a", second = folder.folder() + "/b";
  folder.write("a/one.txt", "");
  folder.write("b/one.txt", "");
  folder.write("b/two.txt", "");
  const auto find = [&](const std::string& name) {
    Properties props = make();
    props.set_search_paths(
        std::make_shared<const std::vector<std::string>>(std::vector{first, second}));
    props.set("file", name, kWhere);
    return props.file("file");
  };
  EXPECT_EQ(find("one.txt"), first + "/one.txt");
  EXPECT_EQ(find("two.txt"), second + "/two.txt");
  EXPECT_EQ(find(second + "/one.txt"), second + "/one.txt");
  EXPECT_EQ(error_of([&] { find("three.txt"); }),
            "f.xml:2:5: 'file' can't be found: there is no file 'three.txt'; looked in " + first +
                ", " + second);
  EXPECT_EQ(error_of([&] { find(first); }),
            "f.xml:2:5: 'file' can't be found: '" + first + "' is a folder, not a file");
  EXPECT_EQ(error_of([&] { find(""); }), "f.xml:2:5: 'file' can't be found: a file name is empty");
}

TEST(Properties, ErrorsHaveThePositionOfTheParameterOrObject) {
  Properties props = make();
  props.set("size", 1.0, kWhere);
  EXPECT_STREQ(props.error("size", "must be odd").what(), "f.xml:2:5: 'size' must be odd");
  EXPECT_STREQ(props.error("count", "must be odd").what(),
               "f.xml:1:1: bsdf 'thing': 'count' must be odd");
}

}  // namespace
}  // namespace kinome::properties_test
