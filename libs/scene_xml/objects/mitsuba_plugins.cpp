#include "kinome/mitsuba_plugins.h"

#include <algorithm>
#include <vector>

#include "base/numbers.h"

namespace kinome {
namespace {

/// Names of Mitsuba's plugins, separated by blanks, for each category.
constexpr std::pair<std::string_view, std::string_view> kNamesOfCategories[] = {
    {"bsdf",
     "blendbsdf bumpmap circular conductor dielectric diffuse hair mask measured "
     "measured_polarized normalmap null plastic polarizer pplastic principled "
     "principledthin retarder roughconductor roughdielectric roughplastic "
     "thindielectric twosided"},
    {"emitter",
     "area constant directional directionalarea envmap point projector spot sunsky "
     "timed_sunsky"},
    {"film", "hdrfilm specfilm"},
    {"integrator", "aov depth direct moment path ptracer stokes volpath volpathmis"},
    {"medium", "heterogeneous homogeneous"},
    {"phase", "blendphase hg isotropic rayleigh sggx tabphase"},
    {"rfilter", "box catmullrom gaussian lanczos mitchell tent"},
    {"sampler", "independent ldsampler multijitter orthogonal stratified"},
    {"sensor", "batch distant irradiancemeter orthographic perspective radiancemeter thinlens"},
    {"shape",
     "blender bsplinecurve cube cylinder disk ellipsoids ellipsoidsmesh instance "
     "linearcurve merge obj ply rectangle sdfgrid serialized shapegroup sphere"},
    {"spectrum", "blackbody d65 irregular rawconstant regular srgb uniform"},
    {"texture", "bitmap checkerboard mesh_attribute volume"},
    {"volume", "constvolume gridvolume"},
};

constexpr const char* kReflectionOnly = "not for BSDFs with specular transmission";
/// Plugins of which Kinome's have fewer features.
constexpr MitsubaPlugin kPartlySupported[] = {
    {"bsdf", "bumpmap", kReflectionOnly},
    {"bsdf", "normalmap", kReflectionOnly},
    {"emitter", "sunsky", "not complex_sun"},
    {"emitter", "timed_sunsky", "not complex_sun"},
    {"integrator", "moment", "not for ptracer (as in Mitsuba) and product sampling of clustered"},
};

std::vector<MitsubaPlugin> list_plugins() {
  std::vector<MitsubaPlugin> all;
  for (const auto& of : kNamesOfCategories) {
    for (const std::string_view name : split_list(of.second)) {
      const auto* const partly = std::find_if(
          std::begin(kPartlySupported), std::end(kPartlySupported),
          [&](const auto& one) { return one.category == of.first && one.name == name; });
      all.push_back(
          {of.first, name, partly == std::end(kPartlySupported) ? nullptr : partly->lacks});
    }
  }
  return all;
}

}  // namespace

std::span<const MitsubaPlugin> mitsuba_plugins() {
  static const std::vector<MitsubaPlugin> all = list_plugins();
  return all;
}

bool is_of_mitsuba(const std::string& tag, const std::string& name) {
  return std::ranges::any_of(mitsuba_plugins(), [&](const MitsubaPlugin& plugin) {
    // As in Mitsuba, spectra are textures.
    return name == plugin.name &&
           tag == (plugin.category == "spectrum" ? "texture" : plugin.category);
  });
}

}  // namespace kinome
