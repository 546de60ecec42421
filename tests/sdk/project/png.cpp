// A film with 8 bits per channel, for viewers that support no other format.
//
//     <film type="png"> <float name="exposure" value="1"/> </film>

#include <kinome/image_files.h>
#include <kinome/film.h>
#include <kinome/plugin.h>

namespace {

using namespace kinome;

constexpr Parameter kParameters[] = {
    {"width", ParameterType::kInteger, "768", "Pixels."},
    {"height", ParameterType::kInteger, "576", "Pixels."},
    {"exposure", ParameterType::kFloat, "0", "Exposure in stops."},
    {"rfilter", ParameterType::kObject, nullptr, "gaussian if not given.", false,
     Category::kReconstructionFilter},
};

// The base class collects samples. A film defines the size and writes the image.
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
