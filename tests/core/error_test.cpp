#include "kinome/error.h"

#include <gtest/gtest.h>

#include "kinome/log.h"
#include "kinome/object.h"
#include "kinome/texture.h"
#include "support/render.h"

namespace kinome::error_test {
namespace {

TEST(Error, GivesTheKnownPartsOfTheLocation) {
  EXPECT_STREQ(Error({"a.xml", 3, 7}, "wrong").what(), "a.xml:3:7: wrong");
  EXPECT_STREQ(Error({"a.xml", 0, 0}, "wrong").what(), "a.xml: wrong");
  EXPECT_STREQ(Error("wrong").what(), "wrong");
  EXPECT_EQ(Error({"a.xml", 3, 7}, "wrong").message(), "wrong");
  EXPECT_EQ(Error({"a.xml", 3, 7}, "wrong").where().column, 7);
}

TEST(Error, NumbersAreShort) {
  EXPECT_EQ(format_number(0.1f), "0.1");
  EXPECT_EQ(format_number(-1), "-1");
  EXPECT_EQ(format_number(1e-9f), "1e-09");
}

TEST(Error, IsOneLine) {
  EXPECT_STREQ(Error({"a\nb", 1, 2}, "two\nlines\r\tin one").what(), "a b:1:2: two lines  in one");
}

TEST(Error, AbbreviatesLongQuotes) {
  // Characters of two bytes, none of which may be cut in two.
  std::string text;
  for (int i = 0; i < 100000; ++i) text += "ä";
  for (const char* const before : {"", "x"}) {
    const std::string message = Error({"a.xml", 1, 2}, before + text + "the end").message();
    EXPECT_LT(message.size(), 1000u);
    EXPECT_TRUE(message.starts_with(before + std::string("ää"))) << message;
    EXPECT_TRUE(message.ends_with("äthe end")) << message;
    EXPECT_NE(message.find("ä … ä"), std::string::npos) << message;
  }
  const std::string plain(800, 'x');
  EXPECT_EQ(Error(plain).message(), plain);
}

TEST(EditDistance, CountsInsertionsDeletionsAndReplacements) {
  EXPECT_EQ(edit_distance("", ""), 0);
  EXPECT_EQ(edit_distance("abc", "abc"), 0);
  EXPECT_EQ(edit_distance("", "abc"), 3);
  EXPECT_EQ(edit_distance("abc", ""), 3);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3);
  EXPECT_EQ(edit_distance("sitting", "kitten"), 3);
  EXPECT_EQ(edit_distance("flaw", "lawn"), 2);
  EXPECT_EQ(edit_distance("abcdef", "azced"), 3);
}

TEST(NearestName, IsTheNearestOrNone) {
  const std::vector<std::string> names{"roughplastic", "plastic", "diffuse", "phong"};
  EXPECT_EQ(nearest_name("plastik", names), "plastic");
  EXPECT_EQ(nearest_name("Phong", names), "phong");
  EXPECT_EQ(nearest_name("difuse", names), "diffuse");
  EXPECT_EQ(nearest_name("xyz", names), "");
  EXPECT_EQ(nearest_name("", names), "");
  const char* const choices[] = {"beckmann", "ggx"};
  EXPECT_EQ(nearest_name("gx", choices), "ggx");
}

TEST(Category, HasMitsubasNames) {
  std::string all;
  for (const Category category : kCategories) all += to_string(category) + std::string(" ");
  EXPECT_EQ(all, "bsdf emitter film integrator medium phase rfilter sampler sensor shape texture volume ");
}

TEST(UniformTexture, IsItsValueEverywhere) {
  const auto texture = make_uniform_texture(Rgb(0.1f, 0.7f, 0.3f));
  EXPECT_EQ(texture->eval(Vec2(0.3f, 9.f)), Rgb(0.1f, 0.7f, 0.3f));
  EXPECT_EQ(texture->mean(), Rgb(0.1f, 0.7f, 0.3f));
  EXPECT_EQ(texture->max(), 0.7f);
  EXPECT_EQ(texture->min(), 0.1f);
  EXPECT_TRUE(texture->is_uniform());
  EXPECT_FLOAT_EQ(texture->eval_1(Vec2(0.f)), luminance(Rgb(0.1f, 0.7f, 0.3f)));
  EXPECT_EQ(make_uniform_texture(Rgb(0.3f))->eval_1(Vec2(0.f)), 0.3f);
}

TEST(Log, NamesTheProgramAndObeysItsLevel) {
  testing::internal::CaptureStderr();
  const LogLevel before = log_level();
  set_log_level(LogLevel::kWarn);
  log_warn("careful with {}");
  log_info("unheard");
  set_log_level(LogLevel::kInfo);
  log_info("heard");
  log_debug("unheard");
  set_log_level(LogLevel::kQuiet);
  log_warn("unheard");
  EXPECT_EQ(log_level(), LogLevel::kQuiet);
  set_log_level(before);
  EXPECT_EQ(testing::internal::GetCapturedStderr(),
            "kinome: warning: careful with {}\nkinome: heard\n");
}

TEST(RunProcess, ReportsStatusAndBothStreams) {
  const auto done = test::run_process({"/bin/sh", "-c", "echo out; echo err >&2; exit 3"});
  EXPECT_EQ(done.status, 3);
  EXPECT_EQ(done.out, "out\n");
  EXPECT_EQ(done.err, "err\n");
  EXPECT_EQ(test::run_process({"/bin/sh", "-c", "kill -TERM $$"}).status, 128 + 15);
  EXPECT_EQ(test::run_process({"/no/such/program"}).status, 127);
  EXPECT_EQ(test::run_process({"/bin/sh", "-c", "head -c 1000000 /dev/zero"}).out.size(), 1000000u);
}

TEST(RunProcess, EndsProcessesThatTakeTooLong) {
  EXPECT_EQ(test::run_process({"/bin/sh", "-c", "sleep 60 & wait"}, 0.2).status, 128 + 9);
}

}  // namespace
}  // namespace kinome::error_test
