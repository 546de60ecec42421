#include "kinome/mitsuba_plugins.h"

#include <algorithm>
#include <string_view>

namespace kinome {
namespace {

constexpr const char* kReflectionOnly = "not for BSDFs with specular transmission";

constexpr MitsubaPlugin kPlugins[] = {
    {"bsdf", "blendbsdf", nullptr},
    {"bsdf", "bumpmap", kReflectionOnly},
    {"bsdf", "circular", nullptr},
    {"bsdf", "conductor", nullptr},
    {"bsdf", "dielectric", nullptr},
    {"bsdf", "diffuse", nullptr},
    {"bsdf", "hair", nullptr},
    {"bsdf", "mask", nullptr},
    {"bsdf", "measured", nullptr},
    {"bsdf", "measured_polarized", nullptr},
    {"bsdf", "normalmap", kReflectionOnly},
    {"bsdf", "null", nullptr},
    {"bsdf", "plastic", nullptr},
    {"bsdf", "polarizer", nullptr},
    {"bsdf", "pplastic", nullptr},
    {"bsdf", "principled", nullptr},
    {"bsdf", "principledthin", nullptr},
    {"bsdf", "retarder", nullptr},
    {"bsdf", "roughconductor", nullptr},
    {"bsdf", "roughdielectric", nullptr},
    {"bsdf", "roughplastic", nullptr},
    {"bsdf", "thindielectric", nullptr},
    {"bsdf", "twosided", nullptr},
    {"emitter", "area", nullptr},
    {"emitter", "constant", nullptr},
    {"emitter", "directional", nullptr},
    {"emitter", "directionalarea", nullptr},
    {"emitter", "envmap", nullptr},
    {"emitter", "point", nullptr},
    {"emitter", "projector", nullptr},
    {"emitter", "spot", nullptr},
    {"emitter", "sunsky", "not complex_sun"},
    {"emitter", "timed_sunsky", "not complex_sun"},
    {"film", "hdrfilm", nullptr},
    {"film", "specfilm", nullptr},
    {"integrator", "aov", nullptr},
    {"integrator", "depth", nullptr},
    {"integrator", "direct", nullptr},
    {"integrator", "moment", "not for ptracer (as in Mitsuba) and product sampling of clustered"},
    {"integrator", "path", nullptr},
    {"integrator", "ptracer", nullptr},
    {"integrator", "stokes", nullptr},
    {"integrator", "volpath", "only for scenes without media, rendered as by path"},
    {"integrator", "volpathmis", "only for scenes without media, rendered as by path"},
    {"medium", "heterogeneous", nullptr},
    {"medium", "homogeneous", nullptr},
    {"phase", "blendphase", nullptr},
    {"phase", "hg", nullptr},
    {"phase", "isotropic", nullptr},
    {"phase", "rayleigh", nullptr},
    {"phase", "sggx", nullptr},
    {"phase", "tabphase", nullptr},
    {"rfilter", "box", nullptr},
    {"rfilter", "catmullrom", nullptr},
    {"rfilter", "gaussian", nullptr},
    {"rfilter", "lanczos", nullptr},
    {"rfilter", "mitchell", nullptr},
    {"rfilter", "tent", nullptr},
    {"sampler", "independent", nullptr},
    {"sampler", "ldsampler", nullptr},
    {"sampler", "multijitter", nullptr},
    {"sampler", "orthogonal", nullptr},
    {"sampler", "stratified", nullptr},
    {"sensor", "batch", nullptr},
    {"sensor", "distant", nullptr},
    {"sensor", "irradiancemeter", nullptr},
    {"sensor", "orthographic", nullptr},
    {"sensor", "perspective", nullptr},
    {"sensor", "radiancemeter", nullptr},
    {"sensor", "thinlens", nullptr},
    {"shape", "blender", nullptr},
    {"shape", "bsplinecurve", nullptr},
    {"shape", "cube", nullptr},
    {"shape", "cylinder", nullptr},
    {"shape", "disk", nullptr},
    {"shape", "ellipsoids", nullptr},
    {"shape", "ellipsoidsmesh", nullptr},
    {"shape", "instance", nullptr},
    {"shape", "linearcurve", nullptr},
    {"shape", "merge", nullptr},
    {"shape", "obj", nullptr},
    {"shape", "ply", nullptr},
    {"shape", "rectangle", nullptr},
    {"shape", "sdfgrid", nullptr},
    {"shape", "serialized", nullptr},
    {"shape", "shapegroup", nullptr},
    {"shape", "sphere", nullptr},
    {"spectrum", "blackbody", nullptr},
    {"spectrum", "d65", nullptr},
    {"spectrum", "irregular", nullptr},
    {"spectrum", "rawconstant", nullptr},
    {"spectrum", "regular", nullptr},
    {"spectrum", "srgb", nullptr},
    {"spectrum", "uniform", nullptr},
    {"texture", "bitmap", nullptr},
    {"texture", "checkerboard", nullptr},
    {"texture", "mesh_attribute", nullptr},
    {"texture", "volume", nullptr},
    {"volume", "constvolume", nullptr},
    {"volume", "gridvolume", nullptr},
};

}  // namespace

std::span<const MitsubaPlugin> mitsuba_plugins() {
  return kPlugins;
}

bool is_of_mitsuba(const std::string& tag, const std::string& name) {
  return std::any_of(std::begin(kPlugins), std::end(kPlugins), [&](const MitsubaPlugin& plugin) {
    // As in Mitsuba, spectra are textures.
    const std::string_view category = plugin.category;
    return name == plugin.name && tag == (category == "spectrum" ? "texture" : category);
  });
}

}  // namespace kinome
