#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "kinome/color.h"
#include "kinome/columns.h"
#include "kinome/image.h"
#include "kinome/math.h"
#include "kinome/object.h"
#include "kinome/reconstruction_filter.h"
#include "kinome/zeroed_array.h"

namespace kinome {

/// Sample positions along one axis of a pixel. They never reach the next pixel's edge, to which
/// plain addition would sometimes round up far from the origin.
class PixelRange {
 public:
  explicit PixelRange(int pixel)
      : first_(static_cast<float>(pixel)), last_(std::nextafter(first_ + 1, first_)) {}
  /// Position of a sample at u in [0,1); F is float or wide::Float.
  template <class F>
  F at(const F& u) const {
    using std::min;
    return min(first_ + u, F(last_));
  }

 private:
  float first_, last_;
};
/// Returns the film position of a sample of pixel (x, y), for u in [0,1)².
inline Vec2 film_position(int x, int y, const Vec2& u) {
  return {PixelRange(x).at(u.x), PixelRange(y).at(u.y)};
}

/// Image channel beside the film's colour: the mean over a pixel's samples of one value of a film
/// layer, or of a power of it.
struct FilmChannel {
  /// Index of one of the layer's own values, or a component of the sample's colour: R, G, B, alpha,
  /// or CIE X, Y, Z. (Mitsuba takes second moments of X, Y, Z.)
  static constexpr int kR = -7, kG = -6, kB = -5, kA = -4, kX = -3, kY = -2, kZ = -1;

  std::string name;
  int layer = 0;
  int value = 0;
  int power = 1;  ///< exponent; splats are ignored if it is above 1
};
/// Returns one channel for each value of the layers, in order.
KINOME_EXPORT std::vector<FilmChannel> channels_of(
    const std::vector<std::vector<std::string>>& layers);

/// Power of a sample value that a layer averages in addition to the values. `value` counts from the
/// sample's first value (the film's R), or is FilmChannel::kX, kY or kZ.
struct FilmPower {
  int value;
  int power;
  /// Returns the power for a sample with these values.
  double operator()(const float* values) const;
};

/// Samples of one tile, with a border as wide as the filter. Not thread-safe: used by one thread at
/// a time.
class KINOME_EXPORT FilmTile {
 public:
  FilmTile(const Rect& pixels, int layer, int values, const ReconstructionFilter& filter,
           const Rect& crop, std::vector<FilmPower> powers = {});
  /// Adds one sample at `position` (pixels of the full film). `values` has Film::value_count()
  /// entries. A sample with a non-finite value is counted and dropped.
  void add(const Vec2& position, std::span<const float> values);
  /// Adds `count` samples at any positions, as add() does; values[k][i] is value k of sample i.
  /// Filter weights come from eval_block().
  void add_block(const Columns2& position, size_t count, std::span<const float* const> values);
  /// Adds an unfiltered value to one pixel of this tile, for integrators that sample the filter
  /// themselves. Several values of a pixel are averaged by `weight` (> 0). Non-finite values are
  /// handled as in add().
  void add_pixel(int x, int y, std::span<const float> values, float weight = 1);
  /// Adds prefiltered sums (weight x value) and the sum of weights to pixel (x, y) of this tile or
  /// its border; other pixels are ignored. All sums must be finite: callers drop non-finite samples
  /// and report them by count_non_finite(). Not supported by layers with powers
  /// (Film::has_powers()).
  void add_sums(int x, int y, std::span<const float> sums, float weight);
  void count_non_finite(uint64_t samples) { non_finite_ += samples; }
  /// Adds light that arrives at `position` of the full film, inside or outside this tile. Pixels
  /// add it to their weighted means, scaled by the filter's weight divided by its integral over
  /// Film::sampled(). Only for layers with colour.
  void add_splat(const Vec2& position, const Rgb& value);
  /// Adds to the number of light paths. The film divides its splats by the total, or by 1 if this
  /// is never called.
  void add_light_paths(double count) { light_paths_ += count; }
  const Rect& pixels() const { return pixels_; }
  /// Index of the layer in the film, with Film::first_layer() as 0.
  int layer() const { return layer_; }
  /// Serialises the tile: passes all its data to `io`, piece by piece, which copies it or replaces
  /// it by the data of the same tile from another process.
  void transfer(const std::function<void(void* bytes, size_t count)>& io);
  bool has_splats() const { return !splats_.empty(); }
  uint64_t non_finite() const { return non_finite_; }

 private:
  friend class Film;
  int stride() const { return values_ + static_cast<int>(powers_.size()) + 1; }
  /// Adds one sample, or the mean of several, with the given weight.
  void add_to(double* pixel, const float* values, double weight) const;
  Rect pixels_;   ///< pixels of the tile
  Rect covered_;  ///< pixels and border, clipped to the film
  int layer_;
  int values_;
  std::vector<FilmPower> powers_;
  const ReconstructionFilter* filter_;
  std::vector<double> data_;  ///< per pixel: sums of values, of their powers, and of weights
  struct Splat {
    Vec2 position;
    Rgb value;
  };
  std::vector<Splat> splats_;
  double light_paths_ = 0;
  uint64_t non_finite_ = 0;
};

/// Estimated variance of an image's colours, in squared colour units. Infinite if fewer than two
/// lanes have samples.
struct KINOME_EXPORT FilmNoise {
  static constexpr int kTile = 16;  ///< side in pixels; tiles start at the crop window's corner
  /// Channels "variance.R", "variance.G", "variance.B" (or "variance.Y") hold the variance of each
  /// pixel. "tile_variance.R", ... hold the variance of the mean over the pixel's tile.
  /// Neighbouring pixels may have correlated noise (filter, light paths), so pixel variances don't
  /// sum to a tile's.
  Image image;
  std::vector<double> variance_of_mean;  ///< variance of the image's mean: R, G, B or Y
  uint32_t renders = 0;  ///< number of lanes with samples, at the pixel with the fewest
};

/// Accumulates samples into pixels, and writes image files. Pixel (x, y) of the full film covers
/// [x, x+1) x [y, y+1). Threads fill tiles in parallel; the render context merges them by commit()
/// in a fixed order, so sums don't depend on threads. Sums are in double precision, because float
/// would lose single samples among many thousands.
///
/// A film may have several lanes: independent renders of the same image side by side. Differences
/// between lanes estimate the variance of their mean.
class KINOME_EXPORT Film : public Object {
 public:
  int width() const { return width_; }  ///< of the full film
  int height() const { return height_; }
  const Rect& crop() const { return crop_; }  ///< pixels to render
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
  /// layers hold only their names, preceded by colour if a channel shows part of it. Each layer is
  /// filled by a pass of its own, with its own weights. `channels` lists the image's channels
  /// beside the colour of layer 0. Commits go to lane 0 until set_lane().
  void prepare(const std::vector<std::vector<std::string>>& layers,
               std::vector<FilmChannel> channels, uint32_t lanes = 1);
  /// Same, with one channel for each name.
  void prepare(const std::vector<std::vector<std::string>>& layers, uint32_t lanes = 1);
  uint32_t lanes() const { return static_cast<uint32_t>(lanes_.size()); }
  /// Sets the lane of subsequent commits.
  void set_lane(uint32_t lane) { lane_ = lane; }
  /// Sets the factor by which developed colours are multiplied: the response of the sensor to its
  /// rays' radiance. Default 1; set by a sensor before rendering.
  void set_response(float factor) { response_ = factor; }
  /// True if samples need an alpha value, for the image's alpha or for a channel.
  bool has_alpha() const { return has_alpha_ || takes_alpha_; }
  /// Channels of the developed image: the film's colour, then the FilmChannels.
  std::vector<std::string> channels() const;
  /// Number of values per sample in a layer, for FilmTile::add(). Layer 0 takes R, G, B (even if
  /// the film stores luminance), then alpha if has_alpha(), then its named values.
  int value_count(int layer) const;
  /// True if the layer averages powers of values, so that it needs every sample separately.
  bool has_powers(int layer) const;
  /// Shifts layer indices by `first` during its lifetime, in all functions that integrators call
  /// (value_count(), has_powers(), make_tile()). A nested integrator, which counts its layers from
  /// 0, thus fills its own range of layers.
  class KINOME_EXPORT FirstLayer {
   public:
    FirstLayer(Film& film, int first) : film_(film), before_(film.first_layer_) {
      film.first_layer_ += first;
    }
    ~FirstLayer() { film_.first_layer_ = before_; }
    FirstLayer(const FirstLayer&) = delete;
    FirstLayer& operator=(const FirstLayer&) = delete;

   private:
    Film& film_;
    int before_;
  };
  int first_layer() const { return first_layer_; }

  FilmTile make_tile(const Rect& pixels, int layer = 0) const;
  /// Merges a tile into the film. Integrators call RenderContext::for_each_tile() or commit()
  /// instead, which also update checkpoints.
  void commit(const FilmTile& tile);
  /// Number of commits since prepare().
  uint64_t commits() const { return commits_; }
  uint64_t non_finite() const { return non_finite_; }
  /// Serialises the film: passes all committed data to `io`, piece by piece, which writes it or
  /// replaces it by stored data. Returns false, with part of the data transferred, if the stored
  /// film was prepared differently.
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
  /// Estimates the variance of develop()'s colours from the differences between lanes.
  FilmNoise noise() const;

  /// Writes the developed image in the film's file format. Appends file_extension() if `path` has
  /// no extension.
  virtual void write(const std::string& path, const Image& image,
                     const ImageMetadata& metadata) const = 0;
  /// Extension with its dot: ".exr", ".pfm".
  virtual std::string file_extension() const = 0;

 protected:
  int width_ = 768;
  int height_ = 576;
  Rect crop_{0, 0, 768, 576};
  bool sample_border_ = false;
  bool has_alpha_ = false;
  bool is_luminance_ = false;  ///< stores "Y" in place of R, G, B
  std::shared_ptr<ReconstructionFilter> filter_;

 private:
  /// Sums of one layer in one lane.
  struct Sums {
    ZeroedArray<double> values;  ///< per pixel: values, their powers, the weight
    ZeroedArray<double> splats;  ///< R, G, B per pixel; empty until the first splat
    double light_paths = 0;
  };
  using Lane = std::vector<Sums>;  ///< indexed by layer
  struct Layer {
    std::vector<std::string> names;  ///< values beside the colour
    bool has_color = false;
    std::vector<FilmPower> powers;
  };
  /// Number of values of a layer. From here on, layers count from 0, not from first_layer_.
  int values_of(size_t layer) const;
  size_t stride_of(size_t layer) const {
    return values_of(layer) + layers_[layer].powers.size() + 1;
  }
  /// Offset of the channel's value in a layer's pixel.
  int place_of(const FilmChannel& channel) const;
  void commit_splats(const FilmTile& tile);
  /// Returns the splats of `sums`, allocating zeros first if there are none.
  ZeroedArray<double>& splats_of(Sums& sums);
  /// Computes how far each lane shifts a pixel's colour, such that the sum of squares is the
  /// colour's variance (see film_noise.cpp). Returns the number of lanes with samples; the variance
  /// is unknown if it is below two.
  uint32_t lane_shares(size_t pixel, std::vector<glm::dvec3>& shares) const;
  /// Colour over lanes [first, end).
  Rgb color(size_t layer, size_t pixel, size_t first, size_t end) const;
  double splat_scale(size_t layer, size_t first, size_t end) const;
  /// Mean over all lanes of a layer's value; indices beyond the values are their powers.
  double mean(size_t layer, size_t pixel, size_t value) const;
  float value_of(const FilmChannel& channel, size_t pixel) const;

  std::vector<Layer> layers_;
  std::vector<FilmChannel> channels_;
  bool takes_alpha_ = false;  ///< true if a channel shows alpha
  int first_layer_ = 0;
  std::vector<Lane> lanes_ = std::vector<Lane>(1);
  uint32_t lane_ = 0;
  float response_ = 1;
  /// Per column and row of the crop window: 1 / (integral of the filter over the sampled area).
  std::vector<double> splat_columns_, splat_rows_;
  uint64_t non_finite_ = 0;
  uint64_t commits_ = 0;
};

}  // namespace kinome
