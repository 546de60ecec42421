#include "panels/parameters/parameter_order.h"

#include <algorithm>
#include <string_view>

#include "panels/parameters/parameter_widgets.h"

namespace kinome::viewer {
namespace {

/// Names that come first, in this order. All others follow in the order of the plugin.
constexpr std::string_view kFirst[] = {
    "material",     "reflectance", "base_color", "diffuse_reflectance", "filename", "radiance",
    "irradiance",   "intensity",   "scale",      "roughness",           "alpha",    "metallic",
    "alpha_u",      "alpha_v",     "int_ior",    "albedo",              "sigma_t",  "position",
    "center",       "radius",      "to_world",   "max_depth",           "rr_depth", "hide_emitters",
    "rays_per_pixel"};

/// Parameters that only experiments change: parts of methods that can be switched off, sampling
/// rates, and conventions.
constexpr std::string_view kAdvanced[] = {
    "adaptive",        "brdf_samples",       "checked_sigma",
    "control_variate", "cut_criterion",      "cut_size",
    "diagnostics",     "emitter_samples",    "ext_ior",
    "fewer_cells",     "flip_normals",       "horizon_terms",
    "importance",      "learned_sigma",      "light_guide",
    "light_samples",   "max_geometry_term",  "mis_compensation",
    "mode",            "nonlinear",          "sample_emitters",
    "sample_visible",  "shared_candidates",  "smooth_plan",
    "trial",           "has_spectral_extinction"};

std::string name_in(const std::string& path, const std::string& object) {
  std::string name = path.substr(object.empty() ? 0 : object.size() + 1);
  if (name.ends_with(".value")) name.resize(name.size() - 6);
  return name;
}

bool is_conductor_preset(const SceneParameter* material) {
  const auto* const name =
      material && material->value ? std::get_if<std::string>(&*material->value) : nullptr;
  return name && *name != "none";
}

}  // namespace

OrderedParameters ordered_parameters(const SceneInfo& info, const std::string& object) {
  const bool has_preset = is_conductor_preset(info.find(object + ".material"));
  std::vector<std::pair<size_t, const SceneParameter*>> ranked;
  OrderedParameters ordered;
  for (const SceneParameter& parameter : info.parameters) {
    if (object_of(parameter.path) != object) continue;
    const std::string name = name_in(parameter.path, object);
    if (has_preset && (name == "eta" || name == "k")) continue;
    if (std::ranges::find(kAdvanced, name) != std::end(kAdvanced) ||
        name.ends_with("_sampling_rate")) {
      ordered.advanced.push_back(&parameter);
    } else {
      ranked.emplace_back(std::ranges::find(kFirst, name) - std::begin(kFirst), &parameter);
    }
  }
  std::ranges::stable_sort(ranked, {}, [](const auto& one) { return one.first; });
  for (const auto& one : ranked) ordered.usual.push_back(one.second);
  return ordered;
}

}  // namespace kinome::viewer
