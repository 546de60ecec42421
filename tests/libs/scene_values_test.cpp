#include <gtest/gtest.h>

#include <algorithm>
#include <clocale>

#include "kinome/sensor.h"
#include "support/plugins/probe_registry.h"

/// Tests the values that a plugin gets from XML snippets.
namespace kinome::test::scene_values_test {
namespace {

constexpr float kRounding = 1e-5f;

void expect_near(const Vec3& a, const Vec3& b, float tolerance = kRounding) {
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(a[i], b[i], tolerance) << "component " << i;
}

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

TEST(Values, WavelengthSpectraGoByWhatTheyMeasure) {
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

TEST(Values, ConstantSpectraGoByWhatTheyMeasure) {
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
TEST(Values, PluginsSayWhatTheirColoursMeasure) {
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

Transform transform_of(const std::string& operations) {
  return probe("<transform name='transform'>" + operations + "</transform>")->transform;
}

TEST(Transforms, SingleOperations) {
  EXPECT_TRUE(transform_of("").is_identity());
  EXPECT_EQ(transform_of("<translate value='1 2 3'/>").point(Vec3(1)), Vec3(2, 3, 4));
  EXPECT_EQ(transform_of("<translate y='2'/>").point(Vec3(1)), Vec3(1, 3, 1));
  EXPECT_EQ(transform_of("<scale value='2'/>").point(Vec3(1, 2, 3)), Vec3(2, 4, 6));
  EXPECT_EQ(transform_of("<scale value='2 3 4'/>").point(Vec3(1)), Vec3(2, 3, 4));
  EXPECT_EQ(transform_of("<scale y='3'/>").point(Vec3(1)), Vec3(1, 3, 1));
  expect_near(transform_of("<rotate z='1' angle='90'/>").vector(Vec3(1, 0, 0)), Vec3(0, 1, 0));
  expect_near(transform_of("<rotate value='0 5 0' angle='90'/>").vector(Vec3(1, 0, 0)),
              Vec3(0, 0, -1));
  EXPECT_EQ(transform_of("<matrix value='1 0 0 5 0 1 0 6 0 0 1 7 0 0 0 1'/>").point(Vec3(1)),
            Vec3(6, 7, 8));
  EXPECT_EQ(transform_of("<matrix value='0 -1 0 1 0 0 0 0 1'/>").vector(Vec3(1, 0, 0)),
            Vec3(0, 1, 0));
}

/// Kinome normalises such axes, unlike Mitsuba. Hence the warning.
TEST(Transforms, AxesOfAnotherLengthAreWarnedOf) {
  const auto warning_of = [](const std::string& axis) {
    testing::internal::CaptureStderr();
    const Transform t = transform_of("\n<rotate " + axis + " angle='35'/>");
    EXPECT_FALSE(t.has_scale());
    return testing::internal::GetCapturedStderr();
  };
  EXPECT_EQ(warning_of("x='1'"), "");
  EXPECT_EQ(warning_of("x='.5774' y='.5774' z='-.5774'"), "");
  for (const char* axis : {"x='1' y='1'", "z='.9'", "value='0 -2 0'"}) {
    const std::string warning = warning_of(axis);
    EXPECT_NE(warning.find("warning: probe.xml:2:1: "), std::string::npos) << warning;
    EXPECT_NE(warning.find("axis of this rotation has length"), std::string::npos) << warning;
    EXPECT_EQ(std::count(warning.begin(), warning.end(), '\n'), 1) << warning;
  }
}

TEST(Transforms, LaterOperationsAreAppliedLater) {
  expect_near(
      transform_of("<translate x='1'/><rotate z='1' angle='90'/><scale value='2'/>").point(Vec3(0)),
      Vec3(0, 2, 0));
  expect_near(transform_of("<scale value='2'/><rotate z='1' angle='90'/><translate x='1'/>")
                  .point(Vec3(1, 0, 0)),
              Vec3(1, 2, 0));
}

TEST(Transforms, LookatHasTheViewAlongZAndLeftAlongX) {
  const Transform t = transform_of("<lookat origin='0 0 -5' target='0 0 0' up='0 1 0'/>");
  expect_near(t.point(Vec3(0)), Vec3(0, 0, -5));
  expect_near(t.vector(Vec3(0, 0, 1)), Vec3(0, 0, 1));
  expect_near(t.vector(Vec3(0, 1, 0)), Vec3(0, 1, 0));
  expect_near(t.vector(Vec3(1, 0, 0)), Vec3(1, 0, 0));
  EXPECT_FALSE(t.flips_handedness());
}

TEST(Transforms, LookatAsMitsubaWithoutUp) {
  // to_world of Mitsuba 3.9.1 for the same line, to the digits that it prints.
  const Transform t = transform_of("<lookat origin='1,2,3' target='0,0,0'/>");
  expect_near(t.vector(Vec3(1, 0, 0)), Vec3(-0.0792865f, 0.841427f, -0.534522f));
  expect_near(t.vector(Vec3(0, 1, 0)), Vec3(0.960357f, -0.0792865f, -0.267261f));
  expect_near(t.vector(Vec3(0, 0, 1)), Vec3(-0.267261f, -0.534522f, -0.801784f));
}

TEST(Upgrade, CamelCaseNamesBeforeVersion2) {
  const auto p = probe(
      "<transform name='Transform'><translate x='1'/></transform>"
      "<texture type='checkerboard' name='texture'><rgb name='color0' value='.1'/></texture>",
      {}, "0.6.0");
  EXPECT_EQ(p->transform.point(Vec3(0)), Vec3(1, 0, 0));
}

/// Reads a renamed parameter from a BSDF of an old file.
TEST(Upgrade, DiffuseReflectanceOfDiffuse) {
  const auto load = [](const std::string& version) {
    return load_object_from_string("<bsdf version='" + version +
                                       "' type='diffuse'><rgb name='diffuseReflectance' "
                                       "value='.1 .2 .3'/></bsdf>",
                                   "old.xml", {}, probe_registry());
  };
  const auto bsdf = std::dynamic_pointer_cast<Bsdf>(load("0.5.0"));
  EXPECT_EQ(bsdf->reflectance(SurfaceInteraction()).diffuse, Rgb(.1f, .2f, .3f));
  EXPECT_EQ(error_of([&] { load("2.0.0"); }),
            "old.xml:1:38: bsdf 'diffuse' has no parameter 'diffuseReflectance' (it has "
            "reflectance)");
}

/// Mitsuba 3.9.1 gives [[3, 0, .75], [0, 5, 2.5]] for this texture: it translates, then scales.
TEST(Upgrade, OffsetsAndScalesBecomeToUv) {
  const std::string old =
      "<float name='uoffset' value='.25'/><float name='voffset' value='.5'/>"
      "<float name='uscale' value='3'/><float name='vscale' value='5'/>";
  const auto p = std::dynamic_pointer_cast<Probe>(
      load_object_from_string("<texture version='0.6.0' type='uv_probe'>" + old + "</texture>",
                              "old.xml", {}, probe_registry()));
  expect_near(p->transform.point(Vec3(0)), Vec3(.75f, 2.5f, 0));
  expect_near(p->transform.vector(Vec3(1, 1, 0)), Vec3(3, 5, 0));
}

/// Colours in the notations of Mitsuba 0.6, and their values.
TEST(Upgrade, OldColours) {
  const auto color = [](const std::string& xml) { return probe(xml, {}, "0.6.0")->color; };
  expect_near(color("<rgb name='color' value='#ff8000'/>"), Rgb(1, 128 / 255.f, 0));
  expect_near(color("<srgb name='color' value='#Ff8000'/>"), Rgb(1, .2158605f, 0));
  expect_near(color("<srgb name='color' value='1, .5, 0'/>"), Rgb(1, .2140411f, 0));
  expect_near(color("<spectrum name='color' value='.5, .4, .3'/>"), Rgb(.5f, .4f, .3f));
  expect_near(color("<spectrum name='color' intent='illuminant' value='#ff0000'/>"), Rgb(1, 0, 0));
  const Rgb light = color("<blackbody name='color' temperature='5000K' scale='2'/>");
  EXPECT_NEAR(light.x / (2 * 15282.1f), 1, 0.01);
  EXPECT_EQ(error_of([&] { color("<srgb name='color' value='#ff80'/>"); }),
            "probe.xml:1:58: '#ff80' is not a colour such as '#ff8000'");
  EXPECT_NE(error_of([&] { probe("<srgb name='color' value='#ff8000'/>"); }), "no error");
}

TEST(Upgrade, OldNamesOfTagsAndParameters) {
  const auto load = [](const std::string& xml) {
    return load_object_from_string(xml, "old.xml", {}, probe_registry());
  };
  const auto sensor = std::dynamic_pointer_cast<Sensor>(
      load("<camera version='0.4.0' type='perspective'><transform name='toWorld'>"
           "<lookAt origin='0,0,1' target='0,0,0' up='0,1,0'/></transform>"
           "<sampler type='hammersley'><integer name='sampleCount' value='16'/>"
           "<integer name='scramble' value='-1'/></sampler>"
           "<film type='ldrfilm'><integer name='width' value='12'/>"
           "<string name='fileFormat' value='png'/><boolean name='banner' value='false'/>"
           "<boolean name='highQualityEdges' value='true'/></film></camera>"));
  EXPECT_EQ(sensor->film().width(), 12);
  EXPECT_TRUE(sensor->film().sample_border());
  EXPECT_EQ(sensor->sampler().sample_count(), 16u);
  EXPECT_EQ(sensor->sample_ray(Vec2(6, 288), Vec2(.5f)).o, Vec3(0, 0, 1));
  const auto integrator =
      load("<integrator version='0.6.0' type='bdpt'><integer name='maxDepth' value='5'/>"
           "<boolean name='lightImage' value='true'/></integrator>");
  EXPECT_EQ(integrator->plugin(), "integrator/path");
  load("<integrator version='0.6.0' type='path'><boolean name='strictNormals' value='true'/>"
       "</integrator>");
  // 0.2 + 0.3 + 0.5 of three colours.
  const auto mixture = std::dynamic_pointer_cast<Bsdf>(
      load("<bsdf version='0.6.0' type='mixturebsdf'><string name='weights' value='.2, .3, .5'/>"
           "<bsdf type='diffuse'><rgb name='reflectance' value='1 0 0'/></bsdf>"
           "<bsdf type='diffuse'><rgb name='reflectance' value='0 1 0'/></bsdf>"
           "<bsdf type='lambertian'><rgb name='reflectance' value='0 0 1'/></bsdf></bsdf>"));
  expect_near(mixture->reflectance(SurfaceInteraction()).diffuse, Rgb(.2f, .3f, .5f));
  EXPECT_NE(error_of([&] {
              load("<bsdf version='0.6.0' type='mixturebsdf'>"
                   "<string name='weights' value='.2, .3'/><bsdf type='diffuse'/></bsdf>");
            }).find("as many weights as BSDFs"),
            std::string::npos);
}

TEST(Expansion, SubstitutesTheLongestName) {
  LoadOptions options;
  options.defines = {{"a", "1"}, {"ab", "2"}, {"abc", "3"}};
  EXPECT_EQ(probe("<string name='string' value='$ab-$abc$a$abd'/>", options)->string, "2-312d");
}

TEST(Expansion, DefinesBeatDefaultsAndTheFirstDefaultStays) {
  const std::string xml =
      "<default name='x' value='first'/><default name='x' value='second'/>"
      "<string name='string' value='$x'/>";
  EXPECT_EQ(probe(xml)->string, "first");
  LoadOptions options;
  options.defines["x"] = "defined";
  EXPECT_EQ(probe(xml, options)->string, "defined");
}

TEST(Expansion, DefaultsMayUseOthers) {
  EXPECT_EQ(probe("<default name='x' value='1'/><default name='y' value='$x$x'/>"
                  "<string name='string' value='$y'/>")
                ->string,
            "11");
}

TEST(Expansion, DefaultsWorkInAnyAttribute) {
  EXPECT_EQ(probe("<default name='n' value='string'/><default name='t' value='probe'/>"
                  "<texture type='$t' name='texture'/><string name='$n' value='x'/>")
                ->string,
            "x");
}

TEST(Expansion, DollarsInADefineAreText) {
  LoadOptions options;
  options.defines["x"] = "a$b";
  EXPECT_EQ(probe("<string name='string' value='$x'/>", options)->string, "a$b");
}

TEST(References, ShareOneObject) {
  const auto p = probe(
      "<texture type='probe' name='texture' id='shared'/><ref id='shared' name='unbounded'/>");
  EXPECT_EQ(p->texture, p->unbounded);
}

TEST(References, MayPointForwardAndThroughAliases) {
  const auto p = probe(
      "<ref id='later' name='texture'/><texture type='probe' name='unbounded' id='later'/>"
      "<alias id='later' as='other'/><alias id='other' as='third'/>"
      "<ref id='third' name='optional'/>");
  EXPECT_EQ(p->texture, p->unbounded);
  EXPECT_EQ(p->optional, p->unbounded);
}

TEST(References, UnnamedOnesAreNumbered) {
  const auto p = probe("<bsdf type='diffuse' id='a'/><ref id='a'/>");
  ASSERT_EQ(p->objects.size(), 2u);
  EXPECT_EQ(p->objects[0], p->objects[1]);
}

}  // namespace
}  // namespace kinome::test::scene_values_test
