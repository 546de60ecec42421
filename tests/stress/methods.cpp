#include "methods.h"

#include "xml.h"

namespace kinome::test {
namespace {

std::string clustered(const std::string& importance, int max_depth) {
  return xml::integrator("clustered",
                         xml::text("importance", importance) + xml::integer("light_samples", 100) +
                             xml::integer("cut_size", 20) + xml::integer("emitter_samples", 4) +
                             xml::integer("brdf_samples", 4) +
                             xml::number("rays_per_pixel", kRaysPerPixel) +
                             xml::boolean("trial", false) +
                             xml::integer("max_depth", max_depth));
}
std::string with_depth(const std::string& type, int max_depth) {
  return xml::integrator(type, xml::integer("max_depth", max_depth));
}
std::string truth(int max_depth) {
  return xml::integrator("groundtruth",
                         xml::integer("light_samples", 100) + xml::integer("max_depth", max_depth));
}

}  // namespace

const std::vector<Method>& all_methods() {
  static const std::vector<Method> all = {
      {"direct", xml::integrator("direct"), "emitter sampling"},
      {"emitter sampling",
       xml::integrator("direct",
                       xml::integer("emitter_samples", 1) + xml::integer("bsdf_samples", 0)),
       ""},
      {"path", with_depth("path", 2), "direct"},
      {"ptracer", with_depth("ptracer", 2), "direct"},
      {"product", clustered("product", 2), "direct"},
      {"groundtruth", truth(2), ""},
      {"joint", clustered("joint", 2), "groundtruth", true},
      {"luminance", clustered("luminance", 2), "groundtruth", true},
      {"brdf", clustered("brdf", 2), "groundtruth", true},
      {"path, one bounce", with_depth("path", 3), ""},
      {"ptracer, one bounce", with_depth("ptracer", 3), "path, one bounce"},
      {"product, one bounce", clustered("product", 3), "path, one bounce"},
      {"groundtruth, one bounce", truth(3), ""},
      {"joint, one bounce", clustered("joint", 3), "groundtruth, one bounce", true},
      {"path, any length", xml::integrator("path"), ""},
  };
  return all;
}

std::string integrator_of(const Method& method, const std::string& scene) {
  std::string xml = method.integrator;
  const bool has_sky = scene.find("\"constant\"") != std::string::npos ||
                       scene.find("\"envmap\"") != std::string::npos;
  if (has_sky) xml.insert(xml.rfind("</"), xml::boolean("hide_emitters", true));
  return xml;
}

}  // namespace kinome::test
