/// Alpha of the background and of transparent surfaces, and colours in front of a hidden
/// background, for every integrator. Alpha is that of Mitsuba 3.9.1's `path`. Its colours lack the
/// direct light of samples that go straight through, see docs/limits.md; expected colours are
/// closed forms.
#include <gtest/gtest.h>

#include <cmath>

#include "support/render.h"

namespace kinome::test::alpha_test {
namespace {

constexpr int kSide = 16;
constexpr uint32_t kSamples = 16;
constexpr int kRenders = 16;
/// Maximum standard deviations of a mean. The first is for known standard deviations, the second
/// for those estimated from the renders (Student's t with 15 degrees of freedom). Each has a false
/// alarm rate of 4e-7, which makes 1e-4 for the 250 means of this file.
constexpr double kMaxDeviations = 5.1, kMaxMeasuredDeviations = 8.3;
const double kIor = 1.5046 / 1.000277;
const double kReflectance = std::pow((kIor - 1) / (kIor + 1), 2);
/// Reflectance of a pane, with all reflections between its faces.
const double kPaneReflectance = 2 * kReflectance / (1 + kReflectance);

/// An orthographic camera that looks straight down the z axis at [-1, 1]². All rays therefore meet
/// horizontal surfaces at the same angle.
std::string scene_xml(const std::string& integrator, const std::string& body) {
  const auto integer = [](const char* name, uint32_t value) {
    return std::string("<integer name=\"") + name + "\" value=\"" + std::to_string(value) + "\"/>";
  };
  return integrator +
         "<sensor type=\"orthographic\"><transform name=\"to_world\">"
         "<lookat origin=\"0,0,4\" target=\"0,0,0\" up=\"0,1,0\"/></transform>"
         "<sampler type=\"independent\">" +
         integer("sample_count", kSamples) + "</sampler><film type=\"hdrfilm\">" +
         integer("width", kSide) + integer("height", kSide) +
         "<string name=\"pixel_format\" value=\"rgba\"/>"
         "<string name=\"component_format\" value=\"float32\"/><rfilter type=\"box\"/>"
         "</film></sensor>" +
         body;
}

const std::string kSky = "<emitter type=\"constant\"/>";
const std::string kLamp =
    "<emitter type=\"point\"><point name=\"position\" value=\"0 0 9\"/></emitter>";
const std::string kDiffuse = "<bsdf type=\"diffuse\"/>";
const std::string kGlass = "<bsdf type=\"dielectric\"/>";
const std::string kNull = "<bsdf type=\"null\"/>";
const std::string kPane = "<bsdf type=\"thindielectric\"/>";

std::string card(const std::string& bsdf, const char* z = "0") {
  return std::string("<shape type=\"rectangle\"><transform name=\"to_world\"><scale value=\"9\"/>"
                     "<translate z=\"") +
         z + "\"/></transform>" + bsdf + "</shape>";
}
std::string mask(const char* opacity, const std::string& nested = kDiffuse) {
  return std::string("<bsdf type=\"mask\"><float name=\"opacity\" value=\"") + opacity + "\"/>" +
         nested + "</bsdf>";
}
std::string blend(const char* weight, const std::string& first, const std::string& second) {
  return std::string("<bsdf type=\"blendbsdf\"><float name=\"weight\" value=\"") + weight +
         "\"/>" + first + second + "</bsdf>";
}

struct Method {
  const char* type;
  const char* parameters;
  double tolerance = 0;  ///< for the colours of light points; negative: colours aren't compared
};
const Method kMethods[] = {
    {"path", ""},
    {"direct", ""},
    {"direct", "<integer name=\"emitter_samples\" value=\"0\"/>"
               "<integer name=\"bsdf_samples\" value=\"3\"/>"},
    {"clustered", ""},
    {"clustered", "<boolean name=\"trial\" value=\"false\"/>"},
    {"clustered", "<integer name=\"max_depth\" value=\"2\"/>"},
    {"clustered", "<string name=\"importance\" value=\"joint\"/>"
                  "<integer name=\"max_depth\" value=\"2\"/>"
                  "<integer name=\"emitter_samples\" value=\"4\"/>"
                  "<integer name=\"light_samples\" value=\"512\"/>",
     0.01},
    {"groundtruth", "<integer name=\"max_depth\" value=\"2\"/>"
                    "<integer name=\"light_samples\" value=\"512\"/>",
     0.01},
    // Shows neither the sky nor surfaces behind masks and panes.
    {"ptracer", "", -1},
};

std::string integrator_xml(const Method& method, bool hide_emitters) {
  return std::string("<integrator type=\"") + method.type + "\">" + method.parameters +
         "<boolean name=\"hide_emitters\" value=\"" + (hide_emitters ? "true" : "false") +
         "\"/></integrator>";
}

double mean_of(const Image& image, int channel) {
  double sum = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) sum += static_cast<double>(image.at(x, y, channel));
  }
  return sum / (image.width * image.height);
}
Image render(const std::string& integrator, const std::string& body, unsigned threads = 0) {
  return render_scene(*scene_from(scene_xml(integrator, body)), 3, threads);
}

struct Case {
  const char* name;
  std::string body;
  bool hide_emitters;
  double alpha;
  double color;  ///< negative: not compared
};

const Case kCases[] = {
    {"visible sky", kSky, false, 1, 1},
    {"hidden sky", kSky, true, 0, 0},
    {"nothing", kLamp, false, 0, 0},
    {"mask in front of a hidden sky", kSky + card(mask("0.4")), true, 0.4, 0.2},
    {"hole in front of a hidden sky", kSky + card(mask("0")), true, 0, 0},
    {"many holes", kLamp + card(kNull) + card(mask("0"), "-1") + card(kNull, "-2"), false, 0, 0},
    {"mask in front of a visible sky", kSky + card(mask("0.4")), false, 1, 0.8},
    {"mask in front of nothing", kLamp + card(mask("0.4")), false, 0.4, -1},
    {"pane in front of a hidden sky", kSky + card(kPane), true, kPaneReflectance,
     kPaneReflectance},
    // The ray goes straight through here, too, but is refracted.
    {"glass in front of a hidden sky", kSky + card(kGlass), true, 1,
     kReflectance + (1 - kReflectance) / (kIor * kIor)},
    {"masked glass in front of a hidden sky", kSky + card(mask("0.4", kGlass)), true, 0.4,
     0.4 * (kReflectance + (1 - kReflectance) / (kIor * kIor))},
    {"glass mixed with nothing", kSky + card(blend("0.3", kGlass, kNull)), true, 0.7,
     0.7 * (kReflectance + (1 - kReflectance) / (kIor * kIor))},
    {"back of a mask", kSky + "<shape type=\"rectangle\"><transform name=\"to_world\">"
                              "<rotate y=\"1\" angle=\"180\"/><scale value=\"9\"/></transform>" +
                           mask("0.4") + "</shape>",
     true, 0.4, 0},
};

/// Each of `rays` rays has an alpha of 1 or 0. Means of ones have rounding errors.
void expect_share(double mean, double expected, double rays, const std::string& what) {
  EXPECT_NEAR(mean, expected,
              kMaxDeviations * std::sqrt(expected * (1 - expected) / rays) + 2e-6)
      << what;
}

TEST(Alpha, EqualsMitsubasPathWithEveryIntegrator) {
  for (const Method& method : kMethods) {
    for (const Case& c : kCases) {
      const std::string what = std::string(c.name) + " by " + method.type + method.parameters;
      const auto scene = scene_from(scene_xml(integrator_xml(method, c.hide_emitters), c.body));
      Moments color, alpha;
      for (uint64_t seed = 1; seed <= kRenders; ++seed) {
        const Image image = render_scene(*scene, seed);
        ASSERT_EQ(image.channels, (std::vector<std::string>{"R", "G", "B", "A"}));
        color.add(mean_of(image, 0));
        alpha.add(mean_of(image, 3));
      }
      // Product sampling uses at least one camera ray per three samples.
      expect_share(alpha.mean(), c.alpha, kRenders * kSide * kSide * kSamples / 3., what);
      if (c.color < 0 || method.tolerance < 0) continue;
      EXPECT_NEAR(color.mean(), c.color,
                  kMaxMeasuredDeviations * std::sqrt(color.variance_of_mean()) +
                      method.tolerance * c.color + 2e-6)
          << what;
    }
  }
}

TEST(Alpha, OfLayeredMasksIsTheirTotalCoverage) {
  const std::string body = kSky + card(mask("0.4")) + card(mask("0.4"), "-1");
  for (const char* type : {"path", "clustered", "ptracer"}) {
    expect_share(mean_of(render(integrator_xml({type, ""}, true), body), 3), 1 - 0.6 * 0.6,
                 kSide * kSide * kSamples / 3., type);
  }
}

TEST(Alpha, IsOneBehindAMaskWherePathsFindASurface) {
  const std::string body = kSky + card(mask("0.4")) + card(kDiffuse, "-1");
  for (const char* type : {"path", "clustered"}) {
    EXPECT_EQ(mean_of(render(integrator_xml({type, ""}, true), body), 3), 1) << type;
  }
  // With depth 2, the surface behind isn't rendered, and has no alpha, either, as in Mitsuba.
  expect_share(mean_of(render(integrator_xml({"direct", ""}, true), body), 3), 0.4,
               kSide * kSide * kSamples, "direct");
}

TEST(Alpha, OfEmittersIsOneUnlessTheyAreHidden) {
  const std::string lamp =
      "<shape type=\"rectangle\"><transform name=\"to_world\"><scale value=\"9\"/></transform>"
      "<emitter type=\"area\"/></shape>";
  for (const Method& method : kMethods) {
    for (const bool hide : {false, true}) {
      EXPECT_EQ(mean_of(render(integrator_xml(method, hide), lamp), 3), hide ? 0 : 1)
          << method.type;
    }
  }
}

TEST(Alpha, OfNestedIntegratorsIsTheirs) {
  const std::string nested = integrator_xml({"path", ""}, true);
  const std::string body = kSky + card(mask("0.4"));
  const double alone = mean_of(render(nested, body), 3);
  for (const std::string& outer :
       {"<integrator type=\"moment\">" + nested + "</integrator>",
        "<integrator type=\"aov\"><string name=\"aovs\" value=\"d:depth\"/>" + nested +
            "</integrator>"}) {
    EXPECT_NEAR(mean_of(render(outer, body), 3), alone, 1e-6) << outer;
  }
}

/// As for Mitsuba's `depth`, which shows the first hit.
TEST(Alpha, OfDepthIsOneForAllHits) {
  const std::string depth = "<integrator type=\"depth\"/>";
  EXPECT_EQ(mean_of(render(depth, kSky + card(mask("0"))), 3), 1);
  EXPECT_EQ(mean_of(render(depth, kSky), 3), 0);
}

TEST(Alpha, IsTheSameBitsOnAnyNumberOfThreads) {
  const std::string body = kSky + card(mask("0.4")) + card(kPane, "-1");
  for (const Method& method : kMethods) {
    const std::string integrator = integrator_xml(method, true);
    EXPECT_EQ(render(integrator, body, 1).data, render(integrator, body, 2).data) << method.type;
  }
}

}  // namespace
}  // namespace kinome::test::alpha_test
