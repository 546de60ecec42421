#include <gtest/gtest.h>

#include "kinome/texture.h"
#include "support/bsdf_cases.h"

/// Tests which parameters BSDFs accept and reject.
namespace kinome::test::bsdf_parameters_test {
namespace {

struct BadBsdf {
  const char* xml;
  const char* message;  ///< part of the error
};

const BadBsdf kBadBsdfs[] = {
    {"<bsdf type='diffuse'><rgb name='reflectance' value='.2 1.2 0'/></bsdf>", "outside [0,1]"},
    {"<bsdf type='diffuse'><texture type='checkerboard' name='reflectance'><float name='color0' "
     "value='-.5'/></texture></bsdf>",
     "'color0' must not be negative, got -0.5"},
    {"<bsdf type='phong'><float name='exponent' value='-1'/></bsdf>", "must not be negative"},
    {"<bsdf type='phong'><float name='exponnent' value='3'/></bsdf>", "did you mean 'exponent'"},
    {"<bsdf type='ward'><string name='variant' value='wardd'/></bsdf>", "did you mean 'ward'"},
    {"<bsdf type='ward'><float name='alpha_v' value='-.1'/></bsdf>", "must not be negative"},
    {"<bsdf type='conductor'><string name='material' value='Aur'/></bsdf>", "did you mean 'Au'"},
    {"<bsdf type='conductor'><string name='material' value='Au'/><float name='k' "
     "value='3'/></bsdf>",
     "can't be combined with 'material'"},
    {"<bsdf type='roughconductor'><string name='distribution' value='gxx'/></bsdf>",
     "did you mean 'ggx'"},
    {"<bsdf type='roughconductor'><float name='alpha_u' value='.1'/></bsdf>",
     "set both alpha_u and alpha_v"},
    {"<bsdf type='roughconductor'><float name='alpha' value='.1'/><float name='alpha_u' "
     "value='.1'/>"
     "<float name='alpha_v' value='.1'/></bsdf>",
     "can't be combined with 'alpha_u'"},
    {"<bsdf type='roughplastic'><float name='alpha' value='-.1'/></bsdf>", "must not be negative"},
    {"<bsdf type='roughplastic'><float name='alpha' value='1e30'/></bsdf>", "must be at most 1e6"},
    {"<bsdf type='roughdielectric'><float name='alpha' value='1e10'/></bsdf>",
     "must be at most 1e6"},
    {"<bsdf type='principled'><float name='roughness' value='1e30'/></bsdf>",
     "must be at most 1e6"},
    {"<bsdf type='principledthin'><float name='roughness' value='1e30'/></bsdf>",
     "must be at most 1e6"},
    {"<bsdf type='ward'><float name='alpha_u' value='1e30'/></bsdf>", "must be at most 1e6"},
    {"<bsdf type='roughplastic'><float name='int_ior' value='0'/></bsdf>", "must be positive"},
    {"<bsdf type='roughplastic'><float name='int_ior' value='1e-45'/></bsdf>",
     "must be between 0.001 and 1000"},
    {"<bsdf type='roughdielectric'><float name='int_ior' value='0'/></bsdf>", "must be positive"},
    {"<bsdf type='roughdielectric'><float name='ext_ior' value='-1'/></bsdf>", "must be positive"},
    {"<bsdf type='roughdielectric'><float name='int_ior' value='inf'/></bsdf>", "not a number"},
    {"<bsdf type='roughdielectric'><string name='int_ior' value='air'/></bsdf>", "must differ"},
    {"<bsdf type='roughdielectric'><float name='alpha_v' value='.1'/></bsdf>",
     "set both alpha_u and alpha_v"},
    {"<bsdf type='roughdielectric'><string name='distribution' value='gxx'/></bsdf>",
     "did you mean 'ggx'"},
    {"<bsdf type='plastic'><string name='int_ior' value='watr'/></bsdf>", "did you mean 'water'"},
    {"<bsdf type='plastic'><float name='ext_ior' value='-1'/></bsdf>", "must be positive"},
    {"<bsdf type='twosided'/>", "needs a nested bsdf"},
    {"<bsdf type='twosided'><bsdf type='diffuse'/><bsdf type='diffuse'/><bsdf "
     "type='diffuse'/></bsdf>",
     "at most 2"},
    {"<bsdf type='principled'><float name='metallic' value='1.5'/></bsdf>",
     "must be between 0 and 1"},
    {"<bsdf type='principled'><float name='roughness' value='-.1'/></bsdf>",
     "must not be negative"},
    {"<bsdf type='principled'><float name='eta' value='0'/></bsdf>",
     "must be between 0.001 and 1000"},
    {"<bsdf type='principled'><float name='specular' value='-1'/></bsdf>",
     "must be between 0 and 12"},
    {"<bsdf type='principled'><float name='eta' value='1.5'/><float name='specular' "
     "value='.5'/></bsdf>",
     "can't be combined with 'eta'"},
    {"<bsdf type='principled'><float name='clearcoat_sampling_rate' value='-1'/></bsdf>",
     "must not be negative"},
    {"<bsdf type='principledthin'><float name='diff_trans' value='2.5'/></bsdf>",
     "must be between 0 and 2"},
    {"<bsdf type='principledthin'><float name='eta' value='-1'/></bsdf>",
     "must be between 0.001 and 1000"},
    {"<bsdf type='principledthin'><float name='metallic' value='1'/></bsdf>",
     "has no parameter 'metallic'"},
    {"<bsdf type='hair'><float name='longitudinal_roughness' value='1.5'/></bsdf>",
     "must be between 0 and 1"},
    {"<bsdf type='hair'><float name='azimuthal_roughness' value='-1'/></bsdf>",
     "must be between 0 and 1"},
    {"<bsdf type='hair'><rgb name='sigma_a' value='1 2 3'/><float name='eumelanin' "
     "value='1'/></bsdf>",
     "can't be combined with 'sigma_a'"},
    {"<bsdf type='hair'><float name='pheomelanin' value='-1'/></bsdf>", "must not be negative"},
    {"<bsdf type='hair'><string name='int_ior' value='air'/></bsdf>", "must differ"},
    {"<bsdf type='bumpmap'><bsdf type='diffuse'/></bsdf>", "needs parameter 'texture'"},
    {"<bsdf type='bumpmap'><texture type='checkerboard'/></bsdf>", "needs a nested bsdf"},
    {"<bsdf type='bumpmap'><texture type='checkerboard'/><texture type='checkerboard' "
     "name='second'/><bsdf type='diffuse'/></bsdf>",
     "takes at most 1 texture"},
    {"<bsdf type='bumpmap'><texture type='checkerboard'/><bsdf type='dielectric'/></bsdf>",
     "must not be smooth glass"},
    {"<bsdf type='normalmap'><bsdf type='diffuse'/></bsdf>", "normalmap"},
    {"<bsdf type='normalmap'><rgb name='normalmap' value='.5 .5 1'/></bsdf>",
     "needs a nested bsdf"},
};

TEST(BsdfParameters, ErrorsAreNamed) {
  for (const BadBsdf& bad : kBadBsdfs) {
    try {
      make_object(bad.xml);
      ADD_FAILURE() << "accepted: " << bad.xml;
    } catch (const Error& e) {
      EXPECT_NE(std::string(e.what()).find(bad.message), std::string::npos)
          << bad.xml << ": " << e.what();
      EXPECT_GT(e.where().line, 0) << e.what();
    }
  }
}

class InfiniteTexture final : public Texture {
 public:
  Rgb eval(const Vec2&) const override { return Rgb(kInfinity); }
  Rgb mean() const override { return Rgb(kInfinity); }
  float max() const override { return kInfinity; }
  float min() const override { return 1; }
};

TEST(BsdfParameters, InfiniteValuesAreNotCalledNegative) {
  Properties props(Category::kBsdf, "phong", {"scene.xml", 1, 1});
  props.set("exponent", std::make_shared<InfiniteTexture>(), {"scene.xml", 2, 3});
  try {
    registry().create(props);
    ADD_FAILURE() << "accepted";
  } catch (const Error& e) {
    EXPECT_STREQ(e.what(), "scene.xml:2:3: 'exponent' must be finite, got inf");
  }
}

Rgb value(const std::string& xml, const Vec3& wo = Vec3(0.3f, 0.1f, 0.9f), Vec2 uv = Vec2(0.25f)) {
  SurfaceInteraction si = seen_at(35, 20);
  si.uv = uv;
  return make<Bsdf>(xml)->eval_pdf(si, Lobe::kAll, glm::normalize(wo)).f;
}

TEST(BsdfParameters, NamesOfMaterialsAreIndices) {
  EXPECT_EQ(value("<bsdf type='roughplastic'><string name='int_ior' value='water'/></bsdf>"),
            value("<bsdf type='roughplastic'><float name='int_ior' value='1.333'/></bsdf>"));
  EXPECT_EQ(value("<bsdf type='plastic'/>"),
            value("<bsdf type='plastic'><float name='int_ior' value='1.49'/>"
                  "<float name='ext_ior' value='1.000277'/></bsdf>"));
  EXPECT_EQ(value("<bsdf type='roughconductor'><string name='material' value='none'/></bsdf>"),
            value("<bsdf type='roughconductor'><float name='eta' value='0'/>"
                  "<float name='k' value='1'/></bsdf>"));
}

TEST(BsdfParameters, DefaultsAreMitsubas) {
  EXPECT_EQ(value("<bsdf type='roughconductor'/>"),
            value("<bsdf type='roughconductor'><string name='distribution' value='beckmann'/>"
                  "<float name='alpha_u' value='.1'/><float name='alpha_v' value='.1'/></bsdf>"));
  EXPECT_EQ(value("<bsdf type='phong'/>"),
            value("<bsdf type='phong'><float name='exponent' value='30'/>"
                  "<float name='diffuse_reflectance' value='.5'/>"
                  "<float name='specular_reflectance' value='.2'/></bsdf>"));
  EXPECT_EQ(value("<bsdf type='ward'/>"),
            value("<bsdf type='ward'><string name='variant' value='balanced'/>"
                  "<float name='alpha_u' value='.1'/><float name='alpha_v' value='.1'/></bsdf>"));
  EXPECT_EQ(value("<bsdf type='diffuse'/>").x,
            value("<bsdf type='diffuse'><float name='reflectance' value='.5'/></bsdf>").x);
}

// Specular mapping: every weight, exponent and roughness may be a texture. A checkerboard has one
// value of each kind at (.25, .25) and the other at (.75, .25).
TEST(BsdfParameters, TexturesAreReadAtThePoint) {
  const auto checker = [](const std::string& name, const char* a, const char* b) {
    return "<texture type='checkerboard' name='" + name + "'><float name='color0' value='" + a +
           "'/><float name='color1' value='" + b + "'/></texture>";
  };
  const auto number = [](const std::string& name, const char* v) {
    return "<float name='" + name + "' value='" + v + "'/>";
  };
  struct Textured {
    const char* plugin;
    const char* parameter;
    bool is_number;  ///< read as a scalar: the checkerboard's colours swap
  };
  for (const Textured& t :
       {Textured{"diffuse", "reflectance", false}, Textured{"phong", "exponent", true},
        Textured{"roughconductor", "alpha", true}, Textured{"roughconductor", "eta", false},
        Textured{"ward", "alpha_u", true}, Textured{"ward", "alpha_v", true},
        Textured{"roughconductor", "specular_reflectance", false},
        Textured{"roughplastic", "diffuse_reflectance", false},
        Textured{"plastic", "diffuse_reflectance", false}}) {
    const auto bsdf = [&](const std::string& child) {
      return "<bsdf type='" + std::string(t.plugin) + "'>" + child + "</bsdf>";
    };
    const Vec3 wo(-0.5f, -0.1f, 0.8f);
    const Rgb first = value(bsdf(number(t.parameter, ".3")), wo);
    const Rgb second = value(bsdf(number(t.parameter, ".7")), wo);
    const std::string both = bsdf(checker(t.parameter, ".3", ".7"));
    EXPECT_NE(first, second) << t.plugin << ' ' << t.parameter;
    const Rgb matching = value(both, wo, Vec2(0.25f));
    const Rgb other = value(both, wo, Vec2(0.75f, 0.25f));
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(matching[c], (t.is_number ? second : first)[c], 1e-5f * first[c])
          << t.plugin << ' ' << t.parameter;
      EXPECT_NEAR(other[c], (t.is_number ? first : second)[c], 1e-5f * first[c])
          << t.plugin << ' ' << t.parameter;
    }
  }
}

TEST(BsdfParameters, LobesMatchTheParameters) {
  const auto lobes = [](const std::string& xml) { return make<Bsdf>(xml)->lobes(); };
  EXPECT_EQ(lobes("<bsdf type='diffuse'/>"), Lobe::kDiffuse);
  EXPECT_EQ(lobes("<bsdf type='phong'/>"), Lobe::kDiffuse | Lobe::kGlossy);
  EXPECT_EQ(lobes("<bsdf type='phong'><float name='specular_reflectance' value='0'/></bsdf>"),
            Lobe::kDiffuse);
  EXPECT_EQ(lobes("<bsdf type='ward'><float name='diffuse_reflectance' value='0'/></bsdf>"),
            Lobe::kGlossy);
  EXPECT_EQ(lobes("<bsdf type='conductor'/>"), Lobe::kDelta);
  EXPECT_EQ(lobes("<bsdf type='plastic'/>"), Lobe::kDiffuse | Lobe::kDelta);
  EXPECT_EQ(lobes("<bsdf type='twosided'><bsdf type='conductor'/><bsdf type='diffuse'/></bsdf>"),
            Lobe::kDiffuse | Lobe::kDelta);
}

}  // namespace
}  // namespace kinome::test::bsdf_parameters_test
