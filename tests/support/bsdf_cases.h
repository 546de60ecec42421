#pragma once

#include <cmath>
#include <memory>
#include <ostream>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "kinome/bsdf.h"
#include "kit/scenes/bsdf_points.h"
#include "support/render.h"

/// BSDFs for all tests of BSDFs.
namespace kinome::test {

struct BsdfCase {
  const char* name;
  const char* xml;
  bool reciprocal = true;
  bool conserves_energy = true;
  /// u1 makes a choice within a lobe, for example between reflection and transmission. The density
  /// of a sample then depends on u1 and u2.
  bool chooses_within_lobe = false;
  /// A lobe that is not a delta transmits light.
  bool has_rough_transmission = false;

  std::shared_ptr<Bsdf> make() const { return test::make<Bsdf>(xml); }
};
inline std::ostream& operator<<(std::ostream& out, const BsdfCase& c) {
  return out << c.name;
}

/// A normal map without a file: a checkerboard of two encoded normals, evaluated at one position.
#define KINOME_TEST_NORMAL(rgb)                                                  \
  "<texture type='checkerboard' name='normalmap'><rgb name='color0' value='" rgb \
  "'/><rgb name='color1' value='0.5 0.5 1'/></texture>"

/// Heights for a bump map.
#define KINOME_TEST_BUMPS                                                                          \
  "<texture type='bitmap'><string name='filename' value='" KINOME_TEST_SOURCE                      \
  "/tests/support/bumps.pfm'/><boolean name='raw' value='true'/></texture>"

inline const std::vector<BsdfCase>& bsdf_cases() {
  static const std::vector<BsdfCase> cases{
      {"diffuse", "<bsdf type='diffuse'><rgb name='reflectance' value='0.2 0.5 0.9'/></bsdf>"},
      {"roughdiffuse",
       "<bsdf type='roughdiffuse'><rgb name='reflectance' value='0.2 0.5 0.9'/>"
       "<float name='alpha' value='0.6'/></bsdf>"},
      {"coating_of_metal",
       "<bsdf type='coating'><rgb name='sigma_a' value='0.1 0.2 0.3'/>"
       "<bsdf type='roughconductor'><float name='alpha' value='0.3'/></bsdf></bsdf>"},
      {"roughcoating_of_diffuse",
       "<bsdf type='roughcoating'><string name='distribution' value='ggx'/>"
       "<float name='alpha' value='0.3'/><bsdf type='diffuse'/></bsdf>"},
      {"phong_1", "<bsdf type='phong'><float name='exponent' value='1'/></bsdf>"},
      {"phong_30",
       "<bsdf type='phong'><rgb name='diffuse_reflectance' value='0.1 0.4 0.6'/>"
       "<rgb name='specular_reflectance' value='0.6 0.3 0.1'/></bsdf>"},
      {"phong_1000", "<bsdf type='phong'><float name='exponent' value='1000'/></bsdf>"},
      {"phong_10000",
       "<bsdf type='phong'><float name='exponent' value='10000'/>"
       "<float name='diffuse_reflectance' value='0'/></bsdf>"},
      {"ward_balanced",
       "<bsdf type='ward'><float name='alpha_u' value='0.1'/>"
       "<float name='alpha_v' value='0.4'/></bsdf>"},
      {"ward_balanced_rough", "<bsdf type='ward'><float name='alpha' value='1'/></bsdf>"},
      {"ward_ward",
       "<bsdf type='ward'><string name='variant' value='ward'/>"
       "<float name='alpha' value='0.15'/></bsdf>",
       true, false},
      {"ward_duer",
       "<bsdf type='ward'><string name='variant' value='ward-duer'/>"
       "<float name='alpha_u' value='0.3'/><float name='alpha_v' value='0.05'/></bsdf>",
       true, false},
      {"conductor_beckmann_002",
       "<bsdf type='roughconductor'><string name='material' value='Au'/>"
       "<float name='alpha' value='0.02'/></bsdf>"},
      {"conductor_beckmann_03",
       "<bsdf type='roughconductor'><string name='material' value='Cu'/>"
       "<float name='alpha' value='0.3'/></bsdf>"},
      {"conductor_beckmann_1_all",
       "<bsdf type='roughconductor'><float name='alpha' value='1'/>"
       "<boolean name='sample_visible' value='false'/></bsdf>"},
      {"conductor_beckmann_aniso",
       "<bsdf type='roughconductor'><float name='alpha_u' value='0.05'/>"
       "<float name='alpha_v' value='0.5'/></bsdf>"},
      {"conductor_ggx_01",
       "<bsdf type='roughconductor'><string name='distribution' value='ggx'/>"
       "<string name='material' value='Ag'/></bsdf>"},
      {"conductor_ggx_aniso",
       "<bsdf type='roughconductor'><string name='distribution' value='ggx'/>"
       "<float name='alpha_u' value='0.8'/><float name='alpha_v' value='0.1'/></bsdf>"},
      {"conductor_ggx_aniso_all",
       "<bsdf type='roughconductor'><string name='distribution' value='ggx'/>"
       "<boolean name='sample_visible' value='false'/>"
       "<float name='alpha_u' value='0.2'/><float name='alpha_v' value='0.4'/></bsdf>"},
      {"conductor_ggx_1",
       "<bsdf type='roughconductor'><string name='distribution' value='ggx'/>"
       "<float name='alpha' value='1'/></bsdf>"},
      {"plastic",
       "<bsdf type='plastic'><rgb name='diffuse_reflectance' value='0.1 0.5 0.9'/>"
       "<boolean name='nonlinear' value='true'/></bsdf>"},
      {"roughplastic_beckmann",
       "<bsdf type='roughplastic'><rgb name='diffuse_reflectance' value='0.1 0.5 0.9'/></bsdf>"},
      {"roughplastic_ggx",
       "<bsdf type='roughplastic'><string name='distribution' value='ggx'/>"
       "<float name='alpha' value='0.4'/><string name='int_ior' value='diamond'/>"
       "<boolean name='nonlinear' value='true'/></bsdf>"},
      // Not reciprocal: radiance that leaves glass is divided by the squared index of refraction.
      {"roughdielectric_beckmann",
       "<bsdf type='roughdielectric'><rgb name='specular_transmittance' value='0.9 0.6 0.3'/>"
       "<float name='alpha' value='0.3'/></bsdf>",
       false, true, true, true},
      {"roughdielectric_ggx_aniso",
       "<bsdf type='roughdielectric'><string name='distribution' value='ggx'/>"
       "<float name='alpha_u' value='0.2'/><float name='alpha_v' value='0.5'/></bsdf>",
       false, true, true, true},
      {"roughdielectric_ggx_bubble_all",
       "<bsdf type='roughdielectric'><string name='distribution' value='ggx'/>"
       "<boolean name='sample_visible' value='false'/><float name='int_ior' value='1'/>"
       "<float name='ext_ior' value='1.33'/><float name='alpha' value='0.4'/></bsdf>",
       false, false, true, true},
      {"roughdielectric_beckmann_all",
       "<bsdf type='roughdielectric'><boolean name='sample_visible' value='false'/>"
       "<float name='alpha' value='0.5'/></bsdf>",
       false, true, true, true},
      {"principled_cloth",
       "<bsdf type='principled'><rgb name='base_color' value='0.1 0.5 0.9'/>"
       "<float name='roughness' value='0.7'/><float name='flatness' value='0.4'/>"
       "<float name='sheen' value='0.8'/><float name='sheen_tint' value='0.5'/>"
       "<float name='spec_tint' value='0.6'/></bsdf>",
       true, false},
      {"principled_brushed_metal",
       "<bsdf type='principled'><rgb name='base_color' value='0.9 0.6 0.2'/>"
       "<float name='metallic' value='1'/><float name='anisotropic' value='0.8'/></bsdf>"},
      {"principled_car_paint",
       "<bsdf type='principled'><rgb name='base_color' value='0.6 0.1 0.1'/>"
       "<float name='metallic' value='0.4'/><float name='clearcoat' value='1'/>"
       "<float name='clearcoat_gloss' value='0.3'/></bsdf>",
       true, false, true},
      {"principled_glass",
       "<bsdf type='principled'><rgb name='base_color' value='0.3 0.8 0.9'/>"
       "<float name='spec_trans' value='0.8'/><float name='eta' value='1.4'/></bsdf>",
       false, false, true, true},
      {"principled_bubble",
       "<bsdf type='principled'><float name='spec_trans' value='1'/><float name='eta' value='0.7'/>"
       "<float name='roughness' value='0.6'/><float name='spec_tint' value='0.5'/></bsdf>",
       false, false, true, true},
      {"principledthin_leaf",
       "<bsdf type='principledthin'><rgb name='base_color' value='0.2 0.7 0.1'/>"
       "<float name='diff_trans' value='0.8'/><float name='flatness' value='0.5'/>"
       "<float name='sheen' value='0.5'/></bsdf>",
       true, false, true, true},
      {"principledthin_pane",
       "<bsdf type='principledthin'><rgb name='base_color' value='0.5 0.8 0.9'/>"
       "<float name='spec_trans' value='0.7'/><float name='diff_trans' value='0.5'/>"
       "<float name='anisotropic' value='0.6'/><float name='spec_tint' value='0.3'/></bsdf>",
       true, true, true, true},
      // Not reciprocal: the scales tilt the frame.
      {"hair", "<bsdf type='hair'/>", false, true, true, true},
      {"hair_blond",
       "<bsdf type='hair'><rgb name='sigma_a' value='0.05 0.1 0.3'/>"
       "<float name='longitudinal_roughness' value='0.5'/>"
       "<float name='azimuthal_roughness' value='0.6'/><float name='scale_tilt' value='-4'/></bsdf>",
       false, true, true, true},
      {"twosided",
       "<bsdf type='twosided'><bsdf type='phong'/>"
       "<bsdf type='roughconductor'><float name='alpha' value='0.3'/></bsdf></bsdf>"},
      {"mask",
       "<bsdf type='mask'><float name='opacity' value='0.7'/>"
       "<bsdf type='twosided'><bsdf type='phong'/></bsdf></bsdf>"},
      {"blend",
       "<bsdf type='blendbsdf'><float name='weight' value='0.3'/><bsdf type='diffuse'/>"
       "<bsdf type='roughconductor'><float name='alpha' value='0.3'/></bsdf></bsdf>"},
      {"blend_of_blends",
       "<bsdf type='blendbsdf'><texture type='checkerboard' name='weight'>"
       "<float name='color0' value='0.3'/><float name='color1' value='0.6'/></texture>"
       "<bsdf type='blendbsdf'><float name='weight' value='0.4'/><bsdf type='diffuse'/>"
       "<bsdf type='phong'/></bsdf>"
       "<bsdf type='blendbsdf'><float name='weight' value='0.7'/><bsdf type='diffuse'/>"
       "<bsdf type='roughconductor'><float name='alpha' value='0.3'/></bsdf></bsdf></bsdf>",
       true, true, true},
      {"normalmap_diffuse",
       "<bsdf type='normalmap'>" KINOME_TEST_NORMAL(
           "0.75 0.6 0.9") "<bsdf type='diffuse'>"
                           "<float name='reflectance' value='0.8'/></bsdf></bsdf>",
       false, false},
      {"normalmap_steep",
       "<bsdf type='normalmap'>" KINOME_TEST_NORMAL("0.95 0.5 0.65") "<bsdf type='phong'/></bsdf>",
       false, false},
      {"normalmap_aniso",
       "<bsdf type='normalmap'>" KINOME_TEST_NORMAL(
           "0.4 0.3 0.9") "<boolean name='use_shadowing_function' value='false'/>"
                          "<bsdf type='roughconductor'><string name='distribution' value='ggx'/>"
                          "<float name='alpha_u' value='0.1'/><float name='alpha_v' "
                          "value='0.5'/></bsdf></bsdf>",
       false, false},
      {"bumpmap_diffuse",
       "<bsdf type='bumpmap'>" KINOME_TEST_BUMPS "<float name='scale' value='0.3'/>"
       "<bsdf type='diffuse'/></bsdf>",
       false, false},
      {"bumpmap_glass",
       "<bsdf type='bumpmap'>" KINOME_TEST_BUMPS "<float name='scale' value='0.3'/>"
       "<bsdf type='roughdielectric'><float name='alpha' value='0.3'/></bsdf></bsdf>",
       false, false, true, true},
      {"bumpmap_steep_aniso",
       "<bsdf type='bumpmap'>" KINOME_TEST_BUMPS "<float name='scale' value='-1.5'/>"
       "<boolean name='flip_invalid_normals' value='false'/>"
       "<bsdf type='twosided'><bsdf type='roughconductor'><float name='alpha_u' value='0.1'/>"
       "<float name='alpha_v' value='0.5'/></bsdf></bsdf></bsdf>",
       false, false},
  };
  return cases;
}

inline std::string case_name(const testing::TestParamInfo<BsdfCase>& c) {
  return c.param.name;
}

using check::masks_of;
using check::seen_at;
using check::seen_from;

class RandomDirections {
 public:
  explicit RandomDirections(unsigned seed) : bits_(seed) {}
  float unit() { return static_cast<float>(bits_() >> 8) * 0x1p-24f; }
  Vec2 unit2() {
    const float x = unit();
    return {x, unit()};
  }
  Vec3 sphere() {
    const float z = 2 * unit() - 1;
    const float phi = 2 * kPi * unit();
    const float r = safe_sqrt(1 - z * z);
    return {r * std::cos(phi), r * std::sin(phi), z};
  }

 private:
  std::mt19937 bits_;
};

}  // namespace kinome::test
