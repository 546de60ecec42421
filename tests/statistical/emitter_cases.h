#pragma once

#include <string>
#include <vector>

#include "kinome/image_files.h"
#include "kinome/emitter.h"
#include "kinome/image.h"
#include "kinome/scene.h"
#include "support/render.h"

/// Emitters for the tests of light, each above a floor.
namespace kinome::test {

struct EmitterCase {
  std::string name;
  std::string xml;  ///< the emitter, or the shape that emits; FILE is replaced by an image's path
};

/// Camera transform that looks at the floor from beside its centre.
inline const std::string kAboveOperation =
    "<lookat origin='.4 .2 1.6' target='0 .1 0' up='.3 1 0'/>";
inline const std::string kAbove = "<transform name='to_world'>" + kAboveOperation + "</transform>";
inline const std::string kImage =
    "<texture type='bitmap' name='NAME'><string name='filename' value='FILE'/></texture>";

inline std::string image_named(const std::string& name) {
  std::string xml = kImage;
  return xml.replace(xml.find("NAME"), 4, name);
}

inline std::string number_xml(const std::string& name, double value) {
  return "<float name='" + name + "' value='" + std::to_string(value) + "'/>";
}

inline std::string spot_xml(double cutoff, double beam_width, const std::string& more = "") {
  return "<emitter type='spot'>" + kAbove + number_xml("cutoff_angle", cutoff) +
         number_xml("beam_width", beam_width) + "<rgb name='intensity' value='1 2 3'/>" + more +
         "</emitter>";
}

inline std::string projector_xml(const std::string& more) {
  return "<emitter type='projector'>" + kAbove + more + "</emitter>";
}

inline std::string area_xml(const std::string& shape, const std::string& transform,
                            const std::string& radiance = "<rgb name='radiance' value='1 2 3'/>") {
  return "<shape type='" + shape + "'><transform name='to_world'>" + transform +
         "</transform><emitter type='area'>" + radiance + "</emitter></shape>";
}

inline std::string area_mesh_xml(const std::string& radiance) {
  return "<shape type='obj'><string name='filename' value='MESH'/><emitter type='area'>" +
         radiance + "</emitter></shape>";
}

inline const std::vector<EmitterCase>& emitter_cases() {
  static const std::vector<EmitterCase> all = {
      {"point",
       "<emitter type='point'><point name='position' value='.3 -.2 .9'/>"
       "<rgb name='intensity' value='1 2 3'/></emitter>"},
      {"spot", spot_xml(35, 10)},
      {"spot with a hard edge", spot_xml(25, 25)},
      {"spot without a beam", spot_xml(40, 0)},
      {"spot that shines backward, too", spot_xml(170, 100)},
      {"spot with an image", spot_xml(35, 30, image_named("texture"))},
      {"spot with a checkerboard",
       spot_xml(35, 30, "<texture type='checkerboard' name='texture'/>")},
      {"projector", projector_xml(number_xml("fov", 50) + image_named("irradiance"))},
      {"projector of a turned image",
       projector_xml(number_xml("scale", 2) + "<texture type='bitmap' name='irradiance'><string "
                                              "name='filename' value='FILE'/><transform "
                                              "name='to_uv'><rotate z='1' angle='30'/><scale "
                                              "value='3'/></transform></texture>")},
      {"projector of a checkerboard",
       projector_xml("<texture type='checkerboard' name='irradiance'>" + number_xml("color0", 0) +
                     "<transform name='to_uv'><scale value='3.1'/></transform></texture>")},
      {"projector of a stretched image",
       "<emitter type='projector'><transform name='to_world'><scale x='1.5' y='.7' z='2'/>" +
           kAboveOperation + "</transform>" + number_xml("fov", 50) + image_named("irradiance") +
           "</emitter>"},
      {"projector without an image", projector_xml(number_xml("fov", 90))},
      {"directional",
       "<emitter type='directional'><vector name='direction' value='1 .5 -2'/>"
       "<rgb name='irradiance' value='1 2 3'/></emitter>"},
      {"rectangle", area_xml("rectangle",
                             "<scale value='.3 .5 1'/><rotate x='1' angle='160'/>"
                             "<translate value='.2 -.3 .8'/>")},
      {"rectangle beside the floor's middle, edge on",
       area_xml("rectangle", "<scale value='.4'/><rotate y='1' angle='90'/><translate z='.5'/>")},
      {"disk with an image",
       area_xml("disk", "<scale value='.4'/><rotate x='1' angle='180'/><translate z='.7'/>",
                image_named("radiance"))},
      {"sphere", area_xml("sphere", "<scale value='.2'/><translate value='.1 .2 .4'/>")},
      {"sphere turned inside out around everything",
       "<shape type='sphere'><boolean name='flip_normals' value='true'/><float name='radius' "
       "value='3'/><emitter type='area'><rgb name='radiance' value='1 2 3'/></emitter></shape>"},
      {"cylinder", area_xml("cylinder",
                            "<scale value='.1 .1 .5'/><rotate x='1' angle='60'/><translate "
                            "value='.1 .2 .3'/>")},
      {"cube", area_xml("cube",
                        "<scale value='.2'/><rotate x='.6' y='.8' angle='50'/><translate "
                        "z='.6'/>")},
      {"mesh with bent normals", area_mesh_xml("<rgb name='radiance' value='1 2 3'/>")},
      {"constant", "<emitter type='constant'><rgb name='radiance' value='1 2 3'/></emitter>"},
      {"envmap",
       "<emitter type='envmap'><string name='filename' value='FILE'/><transform "
       "name='to_world'><rotate x='1' angle='70'/></transform></emitter>"},
      {"sunsky",
       "<emitter type='sunsky'><vector name='sun_direction' value='.5 -.3 .8'/><float "
       "name='turbidity' value='2.5'/></emitter>"},
      {"sunsky with a large sun that sets, turned",
       "<emitter type='sunsky'><float name='sun_aperture' value='30'/><float name='turbidity' "
       "value='6'/><rgb name='albedo' value='.1 .5 .9'/><transform name='to_world'><rotate x='1' "
       "angle='40'/></transform><vector name='sun_direction' value='1 -.5 .7'/></emitter>"},
      {"sky without a sun",
       "<emitter type='sunsky'><float name='sun_scale' value='0'/><float name='hour' "
       "value='9'/></emitter>"},
      {"sun without a sky",
       "<emitter type='sunsky'><float name='sky_scale' value='0'/><float name='hour' "
       "value='12'/></emitter>"},
      {"timed_sunsky",
       "<emitter type='timed_sunsky'><integer name='start_month' value='5'/><float "
       "name='window_start_time' value='10.5'/></emitter>"},
  };
  return all;
}

/// A few texels of different colours, one of them much brighter than the rest.
inline Image small_image() {
  Image image{5, 3, {"R", "G", "B"}, {}};
  for (int i = 0; i < 15; ++i) {
    image.data.insert(image.data.end(),
                      {0.1f + static_cast<float>(i * 7 % 15), 0.5f + static_cast<float>(i * 4 % 13),
                       i == 8 ? 100.f : 1.f});
  }
  return image;
}

/// A floor [-1, 1]² in the plane z = 0, which faces +z, and one emitter.
class LitFloor {
 public:
  explicit LitFloor(std::string xml) {
    write_pfm(folder_.path("image.pfm"), small_image());
    // The normals lean outward, so that there is light beyond the horizon of the faces.
    folder_.write("mesh.obj",
                  "v -.3 -.3 .6\nv .3 -.3 .6\nv .3 .3 .8\nv -.3 .3 .6\n"
                  "vn -.9 -.5 -1\nvn .9 -.5 -1\nvn .9 .5 -1\nvn -.9 .5 -1\n"
                  "f 3//3 2//2 1//1\nf 4//4 3//3 1//1\n");
    for (const auto& [word, file] : {std::pair{"FILE", "image.pfm"}, {"MESH", "mesh.obj"}}) {
      const size_t at = xml.find(word);
      if (at != std::string::npos) xml.replace(at, 4, folder_.path(file));
    }
    scene_ = scene_from("<shape type='rectangle'><bsdf type='diffuse'/></shape>" + xml);
  }
  const Scene& scene() const { return *scene_; }
  const Emitter& emitter() const { return *scene_->emitters().at(0); }

 private:
  TemporaryFolder folder_;
  std::unique_ptr<Scene> scene_;
};

}  // namespace kinome::test
