#pragma once

#include <memory>

#include "batch.h"
#include "kinome/wide/microfacet.h"

/// Parameters that rough BSDFs share.
namespace kinome {

/// Parameters of microfacets: their distribution and roughness.
#define KINOME_MICROFACET_PARAMETERS                                                           \
  ::kinome::choice_of("distribution", ::kinome::kMicrofacetTypes, "beckmann",                  \
                      "distribution of microfacet normals: beckmann or ggx"),                  \
      {"alpha", ::kinome::ParameterType::kUnitlessTexture, "0.1",                              \
       "roughness, root mean square of the slopes; values below 1e-4 are raised to it"},       \
      {"alpha_u", ::kinome::ParameterType::kUnitlessTexture, nullptr,                          \
       "roughness along dp_du; requires alpha_v"},                                             \
      {"alpha_v", ::kinome::ParameterType::kUnitlessTexture, nullptr,                          \
       "roughness along dp_dv; requires alpha_u"},                                             \
  {                                                                                            \
    "sample_visible", ::kinome::ParameterType::kBoolean, "true", "sample visible normals only" \
  }

/// Reads the parameter `name`, or alpha if neither it nor `other` is given. The pair and alpha
/// exclude each other.
inline std::shared_ptr<Texture> alpha_texture(const Properties& props, const char* name,
                                              const char* other) {
  if (!props.has(name) && !props.has(other)) return roughness_texture(props, "alpha");
  if (props.has("alpha")) {
    throw props.error("alpha",
                      "can't be combined with 'alpha_u' and 'alpha_v': remove one of them");
  }
  for (const char* required : {"alpha_u", "alpha_v"}) {
    if (!props.has(required)) {
      throw props.error(required, "is missing: set both alpha_u and alpha_v, or neither");
    }
  }
  return roughness_texture(props, name);
}

}  // namespace kinome
