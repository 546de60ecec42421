#include <cmath>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "compatibility/old_formats.h"
#include "kinome/bsdf.h"
#include "kinome/emitter.h"
#include "kinome/log_listener.h"
#include "kinome/sensor.h"
#include "kinome/texture.h"
#include "support/render.h"

/// Files of Mitsuba 0.4 to 0.6: plugins that Mitsuba 3 lacks, or that have other parameters.
namespace kinome::test::old_plugins_test {
namespace {

using namespace old_formats;

TEST(OldFormats, MetalsAreCopper) {
  const auto metal = old<Bsdf>("<bsdf type='conductor'/>");
  const auto copper = old<Bsdf>(
      "<bsdf type='conductor'><string name='material' value='Cu'/></bsdf>");
  const auto weight = [](const Bsdf& bsdf) {
    return bsdf.sample(seen_from(Vec3(0, 0, 1)), Lobe::kAll, .5f, Vec2(.5f))->weight;
  };
  expect_near(weight(*metal), weight(*copper));
  EXPECT_LT(weight(*metal).z, .7f);
}

TEST(OldFormats, MixturesKeepTheirSum) {
  const auto reflectance = [](const std::string& weights) {
    const auto mixture = old<Bsdf>(
        "<bsdf type='mixturebsdf'><string name='weights' value='" + weights + "'/>"
        "<bsdf type='diffuse'><float name='reflectance' value='.8'/></bsdf>"
        "<bsdf type='diffuse'><float name='reflectance' value='.4'/></bsdf></bsdf>");
    return mixture->reflectance(seen_from(Vec3(0, 0, 1))).diffuse;
  };
  expect_near(reflectance("0.5, 0.3"), Rgb(.5f * .8f + .3f * .4f));
  expect_near(reflectance("0.75, 0.25"), Rgb(.75f * .8f + .25f * .4f));
  expect_near(reflectance("0.75; 0.25"), Rgb(.75f * .8f + .25f * .4f));
  expect_near(reflectance("3, 1"), Rgb(.75f * .8f + .25f * .4f));
}

/// Transmission by Lambert's law.
TEST(OldFormats, Difftrans) {
  const auto sheet = old<Bsdf>(
      "<bsdf type='difftrans'><rgb name='transmittance' value='.2 .4 .6'/></bsdf>");
  const SurfaceInteraction si = seen_from(Vec3(.3f, 0, .8f));
  const Vec3 through = glm::normalize(Vec3(.1f, .5f, -.7f));
  expect_near(sheet->eval_pdf(si, Lobe::kAll, through).f,
              Rgb(.2f, .4f, .6f) * (-through.z / kPi));
  EXPECT_EQ(sheet->eval_pdf(si, Lobe::kAll, Vec3(0, 0, 1)).f, Rgb(0.f));
}

/// Oren and Nayar 1994, equations 27 to 31, in double precision.
double oren_nayar(double rho, double sigma, const Vec3& wi, const Vec3& wo) {
  const double pi = 3.14159265358979323846, s2 = sigma * sigma;
  const double ti = std::acos(double{wi.z}), to = std::acos(double{wo.z});
  const double alpha = std::max(ti, to), beta = std::min(ti, to);
  const double cos_phi = std::cos(std::atan2(wo.y, wo.x) - std::atan2(wi.y, wi.x));
  const double c1 = 1 - .5 * s2 / (s2 + .33);
  const double behind = cos_phi < 0 ? std::pow(2 * beta / pi, 3) : 0;
  const double c2 = .45 * s2 / (s2 + .09) * (std::sin(alpha) - behind);
  const double c3 = .125 * s2 / (s2 + .09) * std::pow(4 * alpha * beta / (pi * pi), 2);
  const double first = c1 + cos_phi * c2 * std::tan(beta) +
                       (1 - std::abs(cos_phi)) * c3 * std::tan((alpha + beta) / 2);
  const double second =
      .17 * s2 / (s2 + .13) * (1 - cos_phi * std::pow(2 * beta / pi, 2));
  return rho / pi * first + rho * rho / pi * second;
}

TEST(OldFormats, Roughdiffuse) {
  const auto bsdf = old<Bsdf>(
      "<bsdf type='roughdiffuse'><float name='reflectance' value='.6'/>"
      "<float name='alpha' value='.5'/></bsdf>");
  const Vec3 places[] = {{.6f, 0, .8f}, {-.3f, .4f, .5f}, {.1f, -.9f, .2f}, {0, .1f, 1}};
  for (const Vec3& wi : places) {
    for (const Vec3& wo : places) {
      const Vec3 i = glm::normalize(wi), o = glm::normalize(wo);
      const auto value = bsdf->eval_pdf(seen_from(i), Lobe::kAll, o);
      const double expected = oren_nayar(.6, .5 / std::sqrt(2.), i, o) * o.z;
      EXPECT_NEAR(value.f.x, expected, 2e-4 * expected);
    }
  }
}

/// A black coat of index 1 has no effect. A glass coat reflects and transmits by Fresnel, and
/// spreads the transmitted light.
TEST(OldFormats, Coating) {
  const auto bsdf = old<Bsdf>(
      "<bsdf type='coating'><float name='intIOR' value='1.5'/><float name='extIOR' value='1'/>"
      "<bsdf type='diffuse'><float name='reflectance' value='.5'/></bsdf></bsdf>");
  // Fresnel reflectance at normal incidence is 0.04.
  const SurfaceInteraction si = seen_from(Vec3(0, 0, 1));
  const double expected = .96 * .96 * .5 / (1.5 * 1.5) / M_PI;
  EXPECT_NEAR(bsdf->eval_pdf(si, Lobe::kAll, Vec3(0, 0, 1)).f.x, expected, 1e-5);
  const auto mirror = bsdf->sample(si, Lobe::kDelta, .5f, Vec2(.5f));
  ASSERT_TRUE(mirror);
  EXPECT_NEAR(mirror->weight.x, .04, 1e-5);
  const auto dyed = old<Bsdf>(
      "<bsdf type='coating'><float name='intIOR' value='1.5'/><float name='extIOR' value='1'/>"
      "<float name='thickness' value='2'/><spectrum name='sigmaA' value='.1, .2, .3'/>"
      "<bsdf type='diffuse'/></bsdf>");
  expect_near(dyed->eval_pdf(si, Lobe::kAll, Vec3(0, 0, 1)).f,
              Rgb(std::exp(-.4f), std::exp(-.8f), std::exp(-1.2f)) * static_cast<float>(expected));
}

TEST(OldFormats, Roughcoating) {
  const auto bsdf = old<Bsdf>(
      "<bsdf type='roughcoating'><float name='alpha' value='.2'/><string name='distribution' "
      "value='phong'/><bsdf type='diffuse'><float name='reflectance' value='0'/></bsdf></bsdf>");
  const auto plastic = old<Bsdf>(
      "<bsdf type='roughplastic'><float name='alpha' value='.2'/><string name='intIOR' value='bk7'/>"
      "<float name='diffuseReflectance' value='0'/></bsdf>");
  const SurfaceInteraction si = seen_from(Vec3(.3f, 0, .8f));
  const Vec3 wo = glm::normalize(Vec3(-.3f, .1f, .7f));
  expect_near(bsdf->eval_pdf(si, Lobe::kAll, wo).f, plastic->eval_pdf(si, Lobe::kAll, wo).f);
}

TEST(OldFormats, RoughcoatingUsesTheMeanOfBothAxes) {
  const auto coating = [](const std::string& parameters) {
    return "<bsdf type='roughcoating'>" + parameters + "<bsdf type='diffuse'/></bsdf>";
  };
  const std::string both = coating("<float name='alphaU' value='.1'/><float name='alphaV' "
                                   "value='.3'/>");
  const SurfaceInteraction si = seen_from(Vec3(.3f, 0, .8f));
  const Vec3 wo = glm::normalize(Vec3(-.3f, .1f, .7f));
  const auto value = [&](const std::string& xml) {
    return old<Bsdf>(xml)->eval_pdf(si, Lobe::kAll, wo).f;
  };
  expect_near(value(both), value(coating("<float name='alpha' value='.2'/>")));
  EXPECT_NE(warnings_of(both).find("are replaced by their mean"), std::string::npos);
}

TEST(OldFormats, Textures) {
  const auto scaled = old<Texture>(
      "<texture type='scale'><float name='scale' value='.5'/><texture type='checkerboard'/>"
      "</texture>");
  expect_near(scaled->eval(Vec2(.1f)), Rgb(.2f));
  expect_near(scaled->mean(), Rgb(.15f));
  const auto by_name = old<Texture>(
      "<texture type='scale'><float name='scale' value='.5'/>"
      "<texture name='value' type='checkerboard'/></texture>");
  expect_near(by_name->mean(), Rgb(.15f));
  const auto coloured = old<Texture>(
      "<texture type='scale'><rgb name='scale' value='1 .5 2'/><rgb name='value' value='.1 .2 .3'/>"
      "</texture>");
  expect_near(coloured->mean(), Rgb(.1f, .1f, .6f));
  const auto grid = old<Texture>(
      "<texture type='gridtexture'><float name='lineWidth' value='.1'/></texture>");
  expect_near(grid->eval(Vec2(.5f, .5f)), Rgb(.2f));
  expect_near(grid->eval(Vec2(.95f, .5f)), Rgb(.4f));
  expect_near(grid->eval(Vec2(.5f, 3.05f)), Rgb(.4f));
  expect_near(grid->mean(), Rgb(.64f * .2f + .36f * .4f));
}

TEST(OldFormats, FilmsAndSensors) {
  const auto matlab = old<Film>("<film type='mfilm'/>");
  EXPECT_EQ(matlab->width(), 1);
  EXPECT_EQ(matlab->height(), 1);
  EXPECT_EQ(old<Sensor>("<sensor type='telecentric'><float name='apertureRadius' value='.1'/>"
                        "</sensor>")
                ->plugin(),
            "sensor/orthographic");
  // Before 0.4, x was mirrored.
  const std::string camera =
      "<camera type='perspective'><transform name='toWorld'><lookAt origin='0,0,1' target='0,0,0' "
      "up='0,1,0'/></transform></camera>";
  const auto direction = [&](const std::string& version) {
    return object_of<Sensor>(camera, version)->sample_ray(Vec2(0, 288), Vec2(.5f)).d;
  };
  EXPECT_GT(direction("0.4.0").x * -1, .1f);
  EXPECT_GT(direction("0.3.0").x, .1f);
}

TEST(OldFormats, Integrators) {
  const auto plugin = [](const std::string& xml) { return old<Object>(xml)->plugin(); };
  EXPECT_EQ(plugin("<integrator type='volpath_simple'><integer name='maxDepth' value='5'/>"
                   "</integrator>"),
            "integrator/volpath");
  EXPECT_EQ(plugin("<integrator type='irrcache'><integer name='resolution' value='14'/>"
                   "<integrator type='direct'/></integrator>"),
            "integrator/direct");
  EXPECT_EQ(plugin("<integrator type='adaptive'><integrator type='ppm'/></integrator>"),
            "integrator/path");
  EXPECT_EQ(plugin("<integrator type='multichannel'><integrator type='path'/>"
                   "<integrator type='field'><string name='field' value='shNormal'/></integrator>"
                   "</integrator>"),
            "integrator/aov");
}

/// Mitsuba 3's differentiable integrators render the same images as the others; `prb` stops at 6
/// edges.
TEST(Integrators, DifferentiableOnes) {
  const auto plugin_of = [](const std::string& type) {
    return object_of<Object>("<integrator type='" + type + "'><integer name='sppc' value='4'/>"
                             "<boolean name='hide_emitters' value='true'/></integrator>",
                             "3.0.0")
        ->plugin();
  };
  EXPECT_EQ(plugin_of("prb"), "integrator/path");
  EXPECT_EQ(plugin_of("prb_basic"), "integrator/path");
  EXPECT_EQ(plugin_of("direct_projective"), "integrator/path");
  EXPECT_EQ(plugin_of("prbvolpath"), "integrator/volpath");
  EXPECT_THROW(plugin_of("prb_unknown"), Error);
}

/// A wall that touches the floor hides half of the sky.
TEST(OldFormats, AmbientOcclusion) {
  const auto scene = old_scene(
      "<integrator type='ao'><integer name='shadingSamples' value='4'/></integrator>"
      "<emitter type='point'/>"
      "<shape type='rectangle'><transform name='toWorld'><scale value='1000'/></transform>"
      "<bsdf type='diffuse'><float name='reflectance' value='0'/></bsdf></shape>"
      "<shape type='rectangle'><transform name='toWorld'><scale value='1000'/>"
      "<rotate y='1' angle='90'/><translate x='.02'/></transform></shape>"
      "<sensor type='perspective'><float name='fov' value='.1'/><transform name='toWorld'>"
      "<lookat origin='0,0,10' target='0,0,0' up='0,1,0'/></transform>"
      "<sampler type='independent'><integer name='sampleCount' value='256'/></sampler>"
      "<film type='hdrfilm'><integer name='width' value='8'/><integer name='height' value='8'/>"
      "<rfilter type='box'/></film></sensor>");
  const Image image = render_scene(*scene);
  double mean = 0;
  for (const float v : image.data) mean += v / static_cast<double>(image.data.size());
  EXPECT_NEAR(mean, .5, .02);
}

TEST(OldFormats, VertexColorsOfShapesWithoutColoursAreBlack) {
  const auto scene = old_scene(
      "<texture type='vertexcolors' id='colours'/>"
      "<bsdf type='twosided' id='painted'><bsdf type='diffuse'><ref name='reflectance' "
      "id='colours'/></bsdf></bsdf>"
      "<shape type='sphere'><ref id='painted'/></shape>"
      "<shape type='cube'><bsdf type='diffuse'><texture type='vertexcolors' name='reflectance'/>"
      "</bsdf></shape>");
  ASSERT_EQ(scene->shapes().size(), 2u);
  for (const auto& shape : scene->shapes()) {
    expect_near(shape->bsdf().reflectance(seen_from(Vec3(0, 0, 1))).diffuse, Rgb(0.f));
  }
}

/// The same holds for PLY files. A file with colours keeps them, although both use the same BSDF.
TEST(OldFormats, VertexColorsOfPly) {
  const auto write = [](const std::string& name, const std::string& properties,
                        const std::string& values) {
    const std::string path = ::testing::TempDir() + name;
    std::ofstream file(path);
    file << "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
            "property float z\n" << properties
         << "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
    for (const char* const p : {"0 0 0", "1 0 0", "0 1 0"}) file << p << values << "\n";
    file << "3 0 1 2\n";
    return path;
  };
  const std::string plain = write("plain.ply", "", "");
  const std::string painted = write(
      "painted.ply", "property uchar red\nproperty uchar green\nproperty uchar blue\n",
      " 255 255 255");
  const auto shape = [](const std::string& path) {
    return "<shape type='ply'><string name='filename' value='" + path +
           "'/><ref id='paint'/></shape>";
  };
  const auto scene = old_scene(
      "<bsdf type='diffuse' id='paint'><texture type='vertexcolors' name='reflectance'/></bsdf>" +
      shape(plain) + shape(painted));
  ASSERT_EQ(scene->shapes().size(), 2u);
  EXPECT_TRUE(scene->shapes()[0]->requested_attributes().empty());
  EXPECT_EQ(scene->shapes()[1]->requested_attributes().size(), 1u);
}

TEST(OldFormats, MediaAreTranslated) {
  const auto scene = old_scene(
      "<shape type='sphere'><medium type='homogeneous' name='interior'><rgb name='sigmaA' "
      "value='1, 2, 0'/><rgb name='sigmaS' value='3, 2, 0'/><float name='scale' value='2'/>"
      "</medium></shape><shape type='sphere'><medium type='homogeneous' name='exterior'>"
      "<spectrum name='sigmaT' value='4'/><spectrum name='albedo' value='.5'/></medium>"
      "<bsdf type='dielectric'/></shape>");
  ASSERT_EQ(scene->media().size(), 2u);
  const auto at = [&](size_t i) { return scene->media()[i]->coefficients({}, Vec3(0, 0, 1)); };
  expect_near(at(0).extinction, Rgb(8, 8, 0));
  expect_near(at(0).scattering, Rgb(6, 4, 0));
  expect_near(at(1).extinction, Rgb(4.f));
  expect_near(at(1).scattering, Rgb(2.f));
  EXPECT_EQ(scene->shapes()[0]->bsdf().plugin(), "bsdf/null");
  EXPECT_EQ(scene->shapes()[1]->bsdf().plugin(), "bsdf/dielectric");
}

}  // namespace
}  // namespace kinome::test::old_plugins_test
