#include <gtest/gtest.h>

#include <algorithm>
#include <clocale>

#include "kinome/sensor.h"
#include "libs/scene_values.h"
#include "support/plugins/probe_registry.h"

/// Tests the values that a plugin gets from XML snippets.
namespace kinome::test::scene_values_test {
namespace {

using namespace scene_values;

TEST(Values, DefaultsOfTheTable) {
  const auto p = probe("");
  EXPECT_TRUE(p->boolean);
  EXPECT_EQ(p->integer, 7);
  EXPECT_EQ(p->real, 0.25f);
  EXPECT_EQ(p->string, "text");
  EXPECT_EQ(p->vector, Vec3(1, 2, 3));
  EXPECT_EQ(p->color, Rgb(4, 5, 6));
  EXPECT_EQ(p->texture->mean(), Rgb(0.5f));
  EXPECT_EQ(p->unbounded->mean(), Rgb(2.f));
  EXPECT_EQ(p->optional, nullptr);
  EXPECT_TRUE(p->transform.is_identity());
  EXPECT_EQ(p->choice, 0);
}

TEST(Values, Booleans) {
  for (const char* text : {"true", "True", "TRUE", " tRuE "}) {
    EXPECT_TRUE(probe(std::string("<boolean name='boolean' value='") + text + "'/>")->boolean);
  }
  for (const char* text : {"false", "False", "FALSE"}) {
    EXPECT_FALSE(probe(std::string("<boolean name='boolean' value='") + text + "'/>")->boolean);
  }
}

TEST(Values, Numbers) {
  const auto real = [](const std::string& text) {
    return probe("<float name='real' value='" + text + "'/>")->real;
  };
  EXPECT_EQ(real("1.5"), 1.5f);
  EXPECT_EQ(real("-.5"), -0.5f);
  EXPECT_EQ(real("+2"), 2.f);
  EXPECT_EQ(real("1e-3"), 1e-3f);
  EXPECT_EQ(real(" 7 "), 7.f);
  EXPECT_EQ(real("16777217.0"), 16777216.f);
  EXPECT_EQ(probe("<integer name='real' value='3'/>")->real, 3.f);
  const auto integer = [](const std::string& text) {
    return probe("<integer name='integer' value='" + text + "'/>")->integer;
  };
  EXPECT_EQ(integer("-12"), -12);
  EXPECT_EQ(integer("+12"), 12);
  EXPECT_EQ(integer("9223372036854775807"), INT64_MAX);
}

TEST(Values, NumbersDoNotDependOnTheLocale) {
  const std::string before = std::setlocale(LC_ALL, nullptr);
  std::setlocale(LC_ALL, "de_DE.UTF-8");
  EXPECT_EQ(probe("<float name='real' value='1.5'/>")->real, 1.5f);
  std::setlocale(LC_ALL, before.c_str());
}

TEST(Values, Strings) {
  EXPECT_EQ(probe("<string name='string' value=' a &lt;b&gt; &quot;c&quot; '/>")->string,
            " a <b> \"c\" ");
  EXPECT_EQ(probe("<string name='choice' value='ggx'/>")->choice, 1);
}

TEST(Values, Vectors) {
  EXPECT_EQ(probe("<point name='vector' value='1 2.5 -3'/>")->vector, Vec3(1, 2.5f, -3));
  EXPECT_EQ(probe("<vector name='vector' value='1, 2,3'/>")->vector, Vec3(1, 2, 3));
  EXPECT_EQ(probe("<vector name='vector' value='4'/>")->vector, Vec3(4));
  EXPECT_EQ(probe("<point name='vector' x='1' z='3' y='2'/>")->vector, Vec3(1, 2, 3));
}

TEST(Values, Colors) {
  EXPECT_EQ(probe("<rgb name='color' value='1 2 3'/>")->color, Rgb(1, 2, 3));
  EXPECT_EQ(probe("<rgb name='color' value='2'/>")->color, Rgb(2.f));
  EXPECT_EQ(probe("<float name='color' value='2'/>")->color, Rgb(2.f));
  EXPECT_EQ(probe("<integer name='color' value='2'/>")->color, Rgb(2.f));
  EXPECT_EQ(probe("<vector name='color' value='1 2 3'/>")->color, Rgb(1, 2, 3));
  expect_near(probe("<spectrum name='color' value='2'/>")->color,
              2.f * Rgb(1.204794f, 0.948291f, 0.908916f));
}

TEST(Values, UniformTextures) {
  EXPECT_EQ(probe("<rgb name='texture' value='.1 .2 .3'/>")->texture->mean(), Rgb(.1f, .2f, .3f));
  EXPECT_EQ(probe("<float name='texture' value='1'/>")->texture->mean(), Rgb(1.f));
  EXPECT_EQ(probe("<spectrum name='texture' value='.7'/>")->texture->mean(), Rgb(.7f));
  EXPECT_EQ(probe("<vector name='texture' value='.1 .2 .3'/>")->texture->mean(),
            Rgb(.1f, .2f, .3f));
  EXPECT_EQ(probe("<rgb name='unbounded' value='-1 2 30'/>")->unbounded->mean(), Rgb(-1, 2, 30));
}

TEST(Values, NestedTextures) {
  const auto p = probe("<texture type='probe' name='texture' id='inner'/>");
  EXPECT_EQ(p->texture->id(), "inner");
  EXPECT_EQ(p->id(), "");
}

/// Values of spectra in Mitsuba 3.9.1, scalar_rgb, for each quantity. Kinome's white of daylight is
/// exact to float precision. Mitsuba's is 0.1 % lower, because it sums its own tables. Hence the
/// tolerance, relative to the largest channel.
struct SpectrumColors {
  const char* value;
  Rgb emission;
  Rgb unitless;
  bool is_reflectance = true;
};
constexpr float kDaylightError = 2e-3f;

const SpectrumColors kSpectra[] = {
    {"400:.2, 500:.5, 600:.8, 700:.3", Rgb(0.886932f, 0.614419f, 0.285147f),
     Rgb(0.75503f, 0.641415f, 0.323239f)},
    // The light of the Cornell box.
    {"400:0, 500:8, 600:15.6, 700:18.4", Rgb(20.710836f, 10.854634f, 2.771152f),
     Rgb(17.714712f, 11.354429f, 3.304508f), false},
    {"360:1 830:1", Rgb(1.204884f, 0.948228f, 0.909267f), Rgb(1.f)},
    // Saturated colours: negative components are clamped to 0.
    {"440:0, 450:1, 460:0", Rgb(0.013305f, 0, 0.175353f), Rgb(0.015372f, 0, 0.203877f)},
    {"503.3:0, 511.7:1, 520.1:0", Rgb(0, 0.078657f, 0.003416f), Rgb(0, 0.085082f, 0.003731f)},
    {"360:0, 519:0, 520:1, 530:1, 531:0, 830:0", Rgb(0, 0.141431f, 0), Rgb(0, 0.15183f, 0)},
    {"640:0, 650:1, 660:0", Rgb(0.071752f, 0, 0), Rgb(0.058576f, 0, 0)},
};

void expect_color(const Rgb& color, const Rgb& mitsuba, const char* what) {
  SCOPED_TRACE(what);
  expect_near(color, mitsuba, kDaylightError * max_component(mitsuba));
}

TEST(Values, SpectraByWavelengthDependOnTheirQuantity) {
  for (const SpectrumColors& spectrum : kSpectra) {
    SCOPED_TRACE(spectrum.value);
    const auto named = [&](const std::string& name) {
      return "<spectrum name='" + name + "' value='" + spectrum.value + "'/>";
    };
    expect_color(probe(named("color"))->color, spectrum.emission, "emission");
    expect_color(probe(named("lamp"))->lamp->mean(), spectrum.emission, "emission texture");
    expect_color(probe(named("unbounded"))->unbounded->mean(), spectrum.unitless, "unitless");
    const Rgb reflectance = spectrum.is_reflectance ? spectrum.unitless : Rgb(1.f);
    expect_color(probe(named("texture"))->texture->mean(), reflectance, "reflectance");
    // The colours of a texture are always reflectances in Mitsuba, even inside an emitter.
    const auto board = probe("<texture type='checkerboard' name='lamp'>" + named("color0") +
                             named("color1") + "</texture>");
    expect_color(board->lamp->mean(), reflectance, "checkerboard of a light");
  }
}

/// Values of Mitsuba 3.9.1, scalar_rgb, for its spectrum plugins, for any quantity.
TEST(Values, SpectraOfAType) {
  struct Case {
    const char* type;
    const char* children;
    Rgb value;
  };
  const Case cases[] = {
      {"uniform", "<float name='value' value='.3'/>", Rgb(.3f)},
      {"uniform", "<integer name='value' value='1'/><float name='wavelength_min' value='400'/>",
       Rgb(1.f)},
      {"d65", "", Rgb(1.f)},
      {"d65", "<float name='scale' value='.5'/>", Rgb(.5f)},
      {"d65", "<rgb name='color' value='.2 .5 .8'/><float name='scale' value='.5'/>",
       Rgb(.1f, .25f, .4f)},
      {"d65", "<spectrum type='uniform'><float name='value' value='.3'/></spectrum>", Rgb(.3f)},
      {"srgb", "<rgb name='color' value='.2 .5 .8'/>", Rgb(.2f, .5f, .8f)},
      {"srgb", "<rgb name='color' value='2 5 8'/><boolean name='unbounded' value='true'/>",
       Rgb(2, 5, 8)},
      {"rawconstant", "<float name='value' value='.3'/>", Rgb(.3f)},
      {"rawconstant", "<vector name='value' value='.2 .5 .8'/>", Rgb(.2f, .5f, .8f)},
  };
  for (const Case& one : cases) {
    for (const char* tag : {"spectrum", "texture"}) {
      SCOPED_TRACE(std::string(one.type) + one.children);
      const auto named = [&](const std::string& name) {
        return std::string("<") + tag + " type='" + one.type + "' name='" + name + "'>" +
               one.children + "</" + tag + ">";
      };
      expect_near(probe(named("color"))->color, one.value);
      expect_near(probe(named("lamp"))->lamp->mean(), one.value);
      expect_near(probe(named("unbounded"))->unbounded->eval(Vec2(.3f)), one.value);
    }
  }
  // A texture inside daylight is used unchanged.
  const auto board = probe("<spectrum type='d65' name='lamp'><texture type='checkerboard'/>"
                           "</spectrum>");
  EXPECT_FALSE(board->lamp->is_uniform());
  expect_near(board->lamp->mean(), Rgb(.3f));
}

/// Spectrum plugins with wavelengths equal <spectrum> with wavelengths; Mitsuba's RGB variants
/// don't support them. References share one object for emission and reflectance.
TEST(Values, SpectraOfATypeByWavelengths) {
  for (const std::string text :
       {"type='irregular'><string name='wavelengths' value='400, 550 700'/>"
        "<string name='values' value='.1, .5, .3'/>",
        "type='regular'><float name='wavelength_min' value='400'/>"
        "<float name='wavelength_max' value='700'/><string name='values' value='.1 .5 .3'/>"}) {
    SCOPED_TRACE(text);
    const auto p = probe("<spectrum id='s' name='lamp' " + text + "</spectrum>" +
                         "<ref id='s' name='unbounded'/><ref id='s' name='color'/>");
    expect_color(p->lamp->mean(), Rgb(0.496383f, 0.445673f, 0.190482f), "emission texture");
    expect_color(p->color, Rgb(0.496383f, 0.445673f, 0.190482f), "emission");
    expect_color(p->unbounded->mean(), Rgb(0.414422f, 0.466529f, 0.216741f), "unitless");
  }
  // Mitsuba's scalar_spectral renders this colour for a black body of 5000 K, with 1 % of noise.
  const Rgb light = probe("<spectrum type='blackbody' name='color'>"
                          "<float name='temperature' value='5000'/></spectrum>")
                        ->color;
  const Rgb shown(15282.1f, 12094.6f, 9594.1f);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(light[c] / shown[c], 1, 0.01) << c;
}

TEST(Values, ConstantSpectraDependOnTheirQuantity) {
  const auto named = [&](const std::string& name) {
    return "<spectrum name='" + name + "' value='2'/>";
  };
  const Rgb light = 2.f * Rgb(1.204794f, 0.948291f, 0.908916f);
  expect_near(probe(named("color"))->color, light);
  expect_near(probe(named("lamp"))->lamp->mean(), light);
  expect_near(probe(named("unbounded"))->unbounded->mean(), Rgb(2.f));
  expect_near(probe("<texture type='checkerboard' name='lamp'>" + named("color0") +
                    named("color1") + "</texture>")
                  ->lamp->mean(),
              Rgb(2.f));
}

/// Tests the parameter tables of all plugins, by common parameter names.
TEST(Values, PluginsDeclareTheQuantityOfTheirColours) {
  const std::map<std::string, Quantity> known{{"radiance", Quantity::kEmission},
                                              {"irradiance", Quantity::kEmission},
                                              {"intensity", Quantity::kEmission},
                                              {"reflectance", Quantity::kReflectance},
                                              {"scale", Quantity::kUnitless},
                                              {"alpha", Quantity::kUnitless},
                                              {"alpha_u", Quantity::kUnitless},
                                              {"alpha_v", Quantity::kUnitless},
                                              {"eta", Quantity::kUnitless},
                                              {"opacity", Quantity::kUnitless},
                                              {"weight", Quantity::kUnitless},
                                              {"specular_transmittance", Quantity::kReflectance},
                                              {"k", Quantity::kUnitless},
                                              {"exponent", Quantity::kUnitless},
                                              {"normalmap", Quantity::kUnitless},
                                              {"texture", Quantity::kUnitless},
                                              {"color", Quantity::kColor},
                                              {"subsurface.color", Quantity::kReflectance},
                                              {"radius", Quantity::kUnitless},
                                              {"value", Quantity::kColor},
                                              {"volume", Quantity::kReflectance},
                                              {"anisotropic", Quantity::kUnitless},
                                              {"base_color", Quantity::kReflectance},
                                              {"clearcoat", Quantity::kUnitless},
                                              {"clearcoat_gloss", Quantity::kUnitless},
                                              {"diff_trans", Quantity::kUnitless},
                                              {"flatness", Quantity::kUnitless},
                                              {"metallic", Quantity::kUnitless},
                                              {"roughness", Quantity::kUnitless},
                                              {"albedo", Quantity::kReflectance},
                                              {"sheen", Quantity::kUnitless},
                                              {"sigma_a", Quantity::kUnitless},
                                              {"sheen_tint", Quantity::kUnitless},
                                              {"spec_tint", Quantity::kUnitless},
                                              {"spec_trans", Quantity::kUnitless},
                                              {"color0", Quantity::kColor},
                                              {"color1", Quantity::kColor},
                                              {"diffuse_reflectance", Quantity::kReflectance},
                                              {"specular_reflectance", Quantity::kReflectance}};
  PluginRegistry registry({KINOME_TEST_PLUGINS});
  int rows = 0;
  for (const Category category : {Category::kBsdf, Category::kEmitter, Category::kTexture}) {
    for (const std::string& name : registry.names(category)) {
      for (const Parameter& row : registry.find(category, name).parameters) {
        const Quantity quantity = quantity_of(row.type);
        if (quantity == Quantity::kNone) continue;
        auto found = known.find(name + "." + row.name);
        if (found == known.end()) found = known.find(row.name);
        ASSERT_NE(found, known.end()) << name << ": " << row.name;
        EXPECT_EQ(quantity, found->second) << name << ": " << row.name;
        ++rows;
      }
    }
  }
  EXPECT_GE(rows, 25);
}

TEST(Values, AnRgbOrFloatIsItself) {
  for (const char* name : {"color", "lamp", "unbounded"}) {
    const auto p = probe("<rgb name='" + std::string(name) + "' value='3 2 1'/>");
    const Rgb value = name == std::string("color")  ? p->color
                      : name == std::string("lamp") ? p->lamp->mean()
                                                    : p->unbounded->mean();
    EXPECT_EQ(value, Rgb(3, 2, 1)) << name;
  }
  EXPECT_EQ(probe("<float name='lamp' value='3'/>")->lamp->mean(), Rgb(3.f));
}

TEST(Values, ASpectrumClampedAsAReflectanceIsWarnedOf) {
  testing::internal::CaptureStderr();
  probe("<spectrum name='texture' value='400:0, 500:8, 600:15.6, 700:18.4'/>");
  probe("<spectrum name='lamp' value='400:0, 500:8, 600:15.6, 700:18.4'/>");
  probe("<spectrum name='texture' value='360:1 830:1'/>");
  const std::string text = testing::internal::GetCapturedStderr();
  EXPECT_NE(text.find("probe.xml:1:64: this spectrum is a reflectance"), std::string::npos) << text;
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1) << text;
}

}  // namespace
}  // namespace kinome::test::scene_values_test
