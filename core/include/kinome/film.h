#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "kinome/film_channels.h"
#include "kinome/film_position.h"
#include "kinome/film_tile.h"
#include "kinome/image.h"
#include "kinome/object.h"

namespace kinome {

/// Accumulates samples into pixels, and writes image files. Pixel (x, y) of the full film covers
/// [x, x+1) x [y, y+1). Threads fill tiles in parallel; the scheduler merges them by commit()
/// in a fixed order, so sums don't depend on threads. Sums are in double precision, because float
/// would lose single samples among many thousands.
///
/// A film may have several lanes: independent renders of the same image side by side. Differences
/// between lanes estimate the variance of their mean.
class KINOME_EXPORT Film : public Object {
 public:
  ~Film() override;
  int width() const { return width_; }  ///< width of the full film, in pixels
  int height() const { return height_; }
  const Rect& crop() const { return crop_; }  ///< pixels to render
  /// Sets the pixels to render, which must be within the film. Call it before prepare().
  void set_crop(const Rect& crop) { crop_ = crop; }
  const ReconstructionFilter& filter() const { return *filter_; }
  /// True if the filter's border outside the crop window is sampled, too.
  bool sample_border() const { return sample_border_; }
  /// Returns the crop window extended by the filter radius. Samples outside don't affect any
  /// rendered pixel.
  Rect reach() const;
  /// Returns the pixels of the full film that are sampled: reach() with sample_border(), otherwise
  /// the crop window. Light that arrives elsewhere is ignored.
  Rect sampled() const { return sample_border_ ? reach() : crop_; }

  /// Clears the film and sets its layers. Layer 0 holds the film's colour ("R", "G", "B", and "A"
  /// if the pixel format has alpha; "Y" for luminance), followed by the names in layers[0]. Other
  /// layers hold only their named values, preceded by colour if a channel shows part of it. Each
  /// layer is filled by a pass of its own, with its own weights. `channels` lists the image's
  /// channels beside the colour of layer 0. Commits go to lane 0 until set_lane().
  void prepare(const std::vector<std::vector<std::string>>& layers,
               std::vector<FilmChannel> channels, uint32_t lanes = 1);
  /// Same, with one channel for each name.
  void prepare(const std::vector<std::vector<std::string>>& layers, uint32_t lanes = 1);
  uint32_t lanes() const;
  /// Sets the lane of subsequent commits.
  void set_lane(uint32_t lane) { lane_ = lane; }
  /// Sets the factor by which developed colours are multiplied: the response of the sensor to its
  /// rays' radiance. Default 1; set by a sensor before rendering.
  void set_response(float factor) { response_ = factor; }
  float response() const { return response_; }
  /// True if samples need an alpha value, for the image's alpha or for a channel.
  bool has_alpha() const { return has_alpha_ || takes_alpha_; }
  /// Channels of the developed image: the film's colour, then the FilmChannels.
  std::vector<std::string> channels() const;
  /// Number of values per sample in a layer, for FilmTile::add(). Layer 0 takes R, G, B (even if
  /// the film stores luminance), then alpha if has_alpha(), then its named values.
  int value_count(int layer) const;
  /// True if the layer averages powers of values, so that it needs every sample separately.
  bool has_powers(int layer) const;
  /// Offset that FilmLayers (kinome/film_layers.h) adds to layer indices.
  int first_layer() const { return first_layer_; }

  FilmTile make_tile(const Rect& pixels, int layer = 0) const;
  /// Merges a tile into the film. Integrators call Scheduler::for_each_tile() or commit()
  /// instead, which also update checkpoints.
  void commit(const FilmTile& tile);
  /// Number of commits since prepare().
  uint64_t commits() const { return commits_; }
  uint64_t non_finite() const { return non_finite_; }
  void add_non_finite(uint64_t samples) { non_finite_ += samples; }
  /// Returns the sums of each layer in the lane of set_lane(), valid until prepare(). Allocates
  /// memory for the splats of layers for which `with_splats` is true; missing entries are false.
  std::vector<FilmSums> layer_sums(const std::vector<bool>& with_splats = {});
  /// Returns the sums of layer 0 in a lane, valid until prepare().
  ConstFilmSums lane_sums(uint32_t lane) const;
  /// Serialises the film: calls `io` for each piece of the committed data, to store the bytes or
  /// overwrite them with stored ones. Returns false, after part of the data, if the stored film was
  /// prepared differently.
  bool transfer(const std::function<void(void* bytes, size_t count)>& io);
  /// Returns for each pixel of the crop window, row by row, whether it lacks samples in a layer.
  /// All false if the layer is built from light paths only, which cover all pixels at once.
  std::vector<bool> gaps(int layer) const;
  /// Returns the image so far: weighted means over all lanes, plus splats. Pixels without either
  /// are 0.
  Image develop() const { return develop(crop_); }
  /// Same for `pixels`, part of the crop window.
  Image develop(const Rect& pixels) const;
  /// Returns the developed colour of one lane (R, G, B; or luminance in all three), or nullopt if
  /// the lane has no samples there. `pixel` is an index into the crop window, row by row.
  std::optional<Rgb> lane_color(size_t pixel, uint32_t lane) const;

  /// Writes the developed image in the film's file format. Appends file_extension() if `path` has
  /// no extension.
  virtual void write(const std::string& path, const Image& image,
                     const ImageMetadata& metadata) const = 0;
  /// Extension with its dot: ".exr", ".pfm".
  virtual std::string file_extension() const = 0;

 protected:
  Film();
  int width_ = 768;
  int height_ = 576;
  Rect crop_{0, 0, 768, 576};
  bool sample_border_ = false;
  bool has_alpha_ = false;
  bool is_luminance_ = false;  ///< stores "Y" in place of R, G, B
  std::shared_ptr<ReconstructionFilter> filter_;

 private:
  friend class FilmLayers;
  void commit_splats(const FilmTile& tile);
  struct Data;  ///< layers, lanes and their sums; see core/image/film_data.h
  std::unique_ptr<Data> data_;
  bool takes_alpha_ = false;  ///< true if a channel shows alpha
  int first_layer_ = 0;
  uint32_t lane_ = 0;
  float response_ = 1;
  uint64_t non_finite_ = 0;
  uint64_t commits_ = 0;
};

}  // namespace kinome
