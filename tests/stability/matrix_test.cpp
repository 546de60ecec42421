// Tests that the stability matrix finds black images and small deviations.
#include "matrix.h"

#include <gtest/gtest.h>

#include "xml.h"

namespace kinome::test {
namespace {

/// One edge, with emitters hidden: the image is black.
Method black_method(const char* name, int max_depth) {
  return {name, xml::integrator("path", xml::integer("max_depth", 1)), "", max_depth};
}

Case case_of_number(std::vector<Case> cases, int number) {
  for (Case& c : cases) {
    if (c.number == number) return c;
  }
  throw std::out_of_range("case " + std::to_string(number));
}

class Matrix : public testing::Test {
 protected:
  TemporaryFolder folder_;
};

/// An estimator that loses every sample has a variance of 0, which isn't chance.
TEST_F(Matrix, FindsBlackImages) {
  std::vector<Trial> trials;
  for (const int number : {6, 10}) {
    for (const Trial& t : case_of_number(light_cases(folder_.folder()), number).trials) {
      trials.push_back(t);
    }
  }
  for (const Trial& t : case_of_number(surface_cases(folder_.folder()), 17).trials) {
    trials.push_back(t);
  }
  for (const Trial& trial : trials) {
    const Cell cell =
        run_cell(trial, black_method("product", trial.max_depth), ordinary_materials().front());
    EXPECT_FALSE(passed(cell)) << trial.name << ": " << cell.text;
  }
  const Case corners = case_of_number(lamp_cases(folder_.folder()), 8);
  for (const Trial& trial : corners.trials) {
    const Cell cell =
        run_cell(trial, black_method("product, local", 3), ordinary_materials().front());
    EXPECT_FALSE(passed(cell)) << trial.name << ": " << cell.text;
  }
}

/// Floor and objects reflect 50 % too much, in 48 noisy renders.
TEST_F(Matrix, FindsHalfTooMuch) {
  const auto grey = [](float reflectance) {
    return xml::bsdf("diffuse", xml::color("reflectance", Rgb(reflectance)));
  };
  const Case scales = case_of_number(surface_cases(folder_.folder()), 17);
  for (Trial trial : scales.trials) {
    const auto scene = trial.expectation.scene;
    const std::string name = trial.name;
    for (const float expected : {.6f, .4f}) {
      trial.name = name + ", " + std::to_string(expected);  // expectations are stored by name
      trial.expectation.scene = [&](const std::string&) { return scene(grey(expected)); };
      const Cell cell = run_cell(trial, methods().front(), {"grey", grey(.6f)});
      EXPECT_EQ(passed(cell), expected == .6f) << trial.name << ": " << cell.text;
    }
  }
}

/// An undecided image is accepted for methods that are named, and for no others.
TEST_F(Matrix, OnlyListedImagesMayBeInconclusive) {
  Trial trial = case_of_number(light_cases(folder_.folder()), 10).trials.front();
  trial.expectation.integrator = trial.expectation.integrator.empty()
                                     ? xml::integrator("path", xml::integer("max_depth", 2))
                                     : trial.expectation.integrator;
  const Method black = black_method("direct", 2);
  trial.rarely_lit = {"direct"};
  EXPECT_TRUE(passed(run_cell(trial, black, ordinary_materials().front())));
  trial.rarely_lit = {"direct/ward"};
  EXPECT_FALSE(passed(run_cell(trial, black, ordinary_materials().front())));
}

}  // namespace
}  // namespace kinome::test

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  setenv("KINOME_PLUGIN_PATH", KINOME_STABILITY_PLUGINS, 1);
  return RUN_ALL_TESTS();
}
