// A film of eight bits a channel, for viewers that know nothing else.
//
//     <film type="png"> <float name="exposure" value="1"/> </film>

#include <kinome/film.h>
#include <kinome/plugin.h>

namespace {

using namespace kinome;

constexpr Parameter kParameters[] = {
    {"width", ParameterType::kInteger, "768", "Pixels."},
    {"height", ParameterType::kInteger, "576", "Pixels."},
    {"exposure", ParameterType::kFloat, "0", "Makes the picture brighter by as many stops."},
    {"rfilter", ParameterType::kObject, nullptr, "gaussian if not given.", false,
     Category::kReconstructionFilter},
};

// What collects samples is the base's: a film says how large it is, and writes the picture.
class Png final : public Film {
 public:
  explicit Png(const Properties& props) : exposure_(props.real("exposure")) {
    width_ = static_cast<int>(props.integer("width", 1, 1 << 15));
    height_ = static_cast<int>(props.integer("height", 1, 1 << 15));
    crop_ = {0, 0, width_, height_};
    filter_ = props.object<ReconstructionFilter>();
  }

  void write(const std::string& path, const Image& image,
             const ImageMetadata& /*metadata*/) const override {
    write_png(path.ends_with(".png") ? path : path + ".png", image, exposure_);
  }
  std::string file_extension() const override { return ".png"; }

 private:
  float exposure_;
};

}  // namespace

KINOME_PLUGIN(Png, Category::kFilm, "png", "Eight bits a channel, in sRGB.", kParameters);
