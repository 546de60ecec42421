#pragma once

#include <memory>

#include "batch.h"
#include "kinome/wide/microfacet.h"

/// The parameters that rough BSDFs share.
namespace kinome {

/// Rows of a plugin's table: the distribution of microfacets and their roughness.
#define KINOME_MICROFACET_PARAMETERS                                                           \
  ::kinome::choice_of("distribution", ::kinome::kMicrofacetTypes, "beckmann",                  \
                      "of microfacet slopes: beckmann or ggx"),                                \
      {"alpha", ::kinome::ParameterType::kUnitlessTexture, "0.1",                              \
       "roughness, root mean square of the slopes; at least 1e-4 is used"},                    \
      {"alpha_u", ::kinome::ParameterType::kUnitlessTexture, nullptr,                          \
       "along dp_du, together with alpha_v"},                                                  \
      {"alpha_v", ::kinome::ParameterType::kUnitlessTexture, nullptr,                          \
       "along dp_dv, together with alpha_u"},                                                  \
  {                                                                                            \
    "sample_visible", ::kinome::ParameterType::kBoolean, "true", "sample visible normals only" \
  }

/// `name`, which comes together with `other`, or alpha.
inline std::shared_ptr<Texture> alpha_texture(const Properties& props, const char* name,
                                              const char* other) {
  if (!props.has(name) && !props.has(other)) return roughness_texture(props, "alpha");
  if (props.has("alpha")) {
    throw props.error("alpha", "excludes alpha_u and alpha_v: give either, not both");
  }
  for (const char* wanted : {"alpha_u", "alpha_v"}) {
    if (!props.has(wanted)) {
      throw props.error(wanted, "is missing: alpha_u and alpha_v come together");
    }
  }
  return roughness_texture(props, name);
}

}  // namespace kinome
