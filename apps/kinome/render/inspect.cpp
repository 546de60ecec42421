#include "render/inspect.h"

#include <fmt/format.h>

#include "drawing/inspection_image.h"
#include "kinome/output_files.h"
#include "kinome/image_files.h"
#include "kinome/image.h"

namespace kinome::app {
namespace {

void draw(const Inspection& report, const Scene& scene, const Sensor& sensor, const Vec2& pixel,
          const std::string& path) {
  drawing::InspectionView view = drawing::inspection_view(report, scene, sensor);
  drawing::add_legend(report, pixel, view.canvas);
  write_png(path, view.canvas.image, 0);
}

std::string table(const Inspection& report) {
  std::string text =
      "cluster,points,light,brdf,geometric,probability,samples,hits,mean_x,mean_y,mean_z,"
      "normal_x,normal_y,normal_z,lo_x,lo_y,lo_z,hi_x,hi_y,hi_z";
  text += report.is_learned ? ",visibility,sigma\n" : "\n";
  for (size_t c = 0; c < report.clusters.size(); ++c) {
    const InspectedCluster& k = report.clusters[c];
    text += fmt::format("{},{},{:.6g},{:.6g},{:.6g},{:.6g},{},{}", c, k.points, k.light, k.brdf,
                        k.geometric, k.probability, k.samples, k.hits);
    for (const Vec3& v : {k.mean, k.normal, k.box.lo, k.box.hi}) {
      text += fmt::format(",{:.6g},{:.6g},{:.6g}", v.x, v.y, v.z);
    }
    if (report.is_learned) text += fmt::format(",{:.6g},{:.6g}", k.visibility, k.sigma);
    text += '\n';
  }
  return text;
}

}  // namespace

std::string inspect(const Scene& scene, const Sensor& sensor, RenderContext& context,
                    const Vec2& pixel, const std::string& stem) {
  const Film& film = sensor.film();
  if (pixel.x < 0 || pixel.y < 0 || pixel.x >= static_cast<float>(film.width()) ||
      pixel.y >= static_cast<float>(film.height())) {
    throw Error(fmt::format("the pixel must be between 0,0 and {},{}, got {},{}", film.width() - 1,
                            film.height() - 1, pixel.x, pixel.y));
  }
  for (const char* const ending : {".csv", ".png"}) check_writable(stem + ending);
  const auto reports = scene.integrator().inspect(scene, sensor, context, pixel + 0.5f);
  if (reports.empty()) throw Error(drawing::kNoLightPoints);
  std::string names;
  for (size_t i = 0; i < reports.size(); ++i) {
    const std::string name = i == 0 ? stem : fmt::format("{}-{}", stem, i + 1);
    write_text(name + ".csv", table(reports[i]));
    draw(reports[i], scene, sensor, pixel, name + ".png");
    names += fmt::format("{}{}.png and .csv", i == 0 ? "" : ", ", name);
  }
  return names;
}

}  // namespace kinome::app
