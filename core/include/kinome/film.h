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

/// The places along an axis that belong to a pixel. Mere addition would sometimes, far from the
/// origin, round up to the next pixel's edge, and leave a pixel without its sample.
class PixelRange {
 public:
  explicit PixelRange(int pixel)
      : first_(static_cast<float>(pixel)), last_(std::nextafter(first_ + 1, first_)) {}
  /// Of a sample at u in [0,1), float or wide::Float.
  template <class F>
  F at(const F& u) const {
    using std::min;
    return min(first_ + u, F(last_));
  }

 private:
  float first_, last_;
};
/// Film position of a sample of pixel (x, y), u in [0,1)².
inline Vec2 film_position(int x, int y, const Vec2& u) {
  return {PixelRange(x).at(u.x), PixelRange(y).at(u.y)};
}

/// A channel of the picture beside the film's colour: the mean, over a pixel's samples, of a value
/// that they have in a layer of the film, or of a power of it.
struct FilmChannel {
  /// Index of one of the layer's own values; or a part of its colour, the sample's R, G, B, its
  /// alpha, or its CIE X, Y, Z, which Mitsuba takes second moments of.
  static constexpr int kR = -7, kG = -6, kB = -5, kA = -4, kX = -3, kY = -2, kZ = -1;

  std::string name;
  int layer = 0;
  int value = 0;
  int power = 1;  ///< 1, or a higher one: splats don't count for those
};
/// A channel for each of the layers' own values, in their order.
KINOME_EXPORT std::vector<FilmChannel> channels_of(
    const std::vector<std::vector<std::string>>& layers);

/// What a layer averages besides its samples' values: a power of one of them, counted from
/// their first (a film's R), or of X, Y or Z (FilmChannel::kX, kY, kZ).
struct FilmPower {
  int value;
  int power;
  /// Of a sample with these values.
  double operator()(const float* values) const;
};

/// The samples of one tile, with a border as wide as the filter. Used by one thread at a time.
class KINOME_EXPORT FilmTile {
 public:
  FilmTile(const Rect& pixels, int layer, int values, const ReconstructionFilter& filter,
           const Rect& crop, std::vector<FilmPower> powers = {});
  /// Adds one sample at `position` (pixels of the full film); `values` as Film::value_count says.
  /// A sample with a non-finite value is counted and dropped.
  void add(const Vec2& position, std::span<const float> values);
  /// add() of each of `count` samples, wherever they are: values[k][i] is value k of sample i. The
  /// filter's weights are those of its eval_block.
  void add_block(const Columns2& position, size_t count, std::span<const float* const> values);
  /// Adds a finished value of one pixel of this tile, which counts for no other: for integrators
  /// that draw samples by the filter themselves. Several are weighed by `weight` (> 0). Non-finite
  /// values as in add().
  void add_pixel(int x, int y, std::span<const float> values, float weight = 1);
  /// Adds samples that have been weighed by the filter and summed: sums of weight x value, and of
  /// weights, for the pixel (x, y), of this tile or of its border; others are left out. All must be
  /// finite: samples that aren't are the caller's to find and to count, by count_non_finite(). Not
  /// for layers of which powers are asked for (Film::has_powers).
  void add_sums(int x, int y, std::span<const float> sums, float weight);
  void count_non_finite(uint64_t samples) { non_finite_ += samples; }
  /// Adds light that arrives at any `position` of the full film, inside this tile or not, whatever
  /// has been sampled there: pixels add it to their weighted means, by the filter's weight over its
  /// integral over Film::sampled(), as samples' means have it. Layers with colour only.
  void add_splat(const Vec2& position, const Rgb& value);
  /// Says how many light paths more the film's splats come from: what they are divided by in the
  /// end. Before it is said at all, by 1.
  void add_light_paths(double count) { light_paths_ += count; }
  const Rect& pixels() const { return pixels_; }
  /// Of the film's, Film::first_layer() being 0.
  int layer() const { return layer_; }
  /// Hands all that was added to `io`, piece by piece: to be sent, or to be replaced by what
  /// another process has sent of the same tile.
  void transfer(const std::function<void(void* bytes, size_t count)>& io);
  bool has_splats() const { return !splats_.empty(); }
  uint64_t non_finite() const { return non_finite_; }

 private:
  friend class Film;
  int stride() const { return values_ + static_cast<int>(powers_.size()) + 1; }
  /// One sample, or the mean of some, by `weight`.
  void add_to(double* pixel, const float* values, double weight) const;
  Rect pixels_;   ///< what the tile is responsible for
  Rect covered_;  ///< with its border, clipped to the film
  int layer_;
  int values_;
  std::vector<FilmPower> powers_;
  const ReconstructionFilter* filter_;
  std::vector<double> data_;  ///< sums of values, of their powers, then of weights, interleaved
  struct Splat {
    Vec2 position;
    Rgb value;
  };
  std::vector<Splat> splats_;
  double light_paths_ = 0;
  uint64_t non_finite_ = 0;
};

/// How far the colours of a picture may be off: variances, in the square of their unit. Infinite
/// where fewer than two lanes have samples.
struct KINOME_EXPORT FilmNoise {
  static constexpr int kTile = 16;  ///< pixels a side; tiles begin at the crop window's corner
  /// Channels "variance.R", "variance.G", "variance.B" (or "variance.Y"): of each pixel.
  /// "tile_variance.R", ...: of the mean over the tile that the pixel lies in. Pixels may have
  /// noise in common (by their filter, by light paths): pixels' variances don't add up to a tile's.
  Image image;
  std::vector<double> variance_of_mean;  ///< over the whole picture: R, G, B or Y
  uint32_t renders = 0;  ///< lanes that the variances come from, at the pixel with the fewest
};

/// Collects samples into pixels, and writes files. The pixel of the full film at (x, y) covers
/// [x, x+1) x [y, y+1). Tiles are filled side by side by threads, and merged by commit(), which the
/// render context calls in the order of the tiles: sums do not depend on threads. They are of
/// double precision, since those of float would lose what a sample adds to many thousands.
///
/// A film may have several lanes: renders of the same picture that go on side by side and know
/// nothing of each other, so that what they differ by tells how far their mean is off.
class KINOME_EXPORT Film : public Object {
 public:
  int width() const { return width_; }  ///< of the full film
  int height() const { return height_; }
  const Rect& crop() const { return crop_; }  ///< pixels that are rendered
  const ReconstructionFilter& filter() const { return *filter_; }
  /// Also sample the border that the filter reaches.
  bool sample_border() const { return sample_border_; }
  /// The crop window, grown by the border that the filter reaches: a sample in any other pixel
  /// counts for none that is rendered.
  Rect reach() const;
  /// Which pixels of the full film samples are taken in: reach() with sample_border(), otherwise
  /// the crop window. Light that arrives anywhere else counts for no pixel either.
  Rect sampled() const { return sample_border_ ? reach() : crop_; }

  /// Forgets all samples. Layer 0 holds the film's colour channels ("R", "G", "B", and "A" where
  /// the pixel format has alpha; "Y" for luminance) followed by the names in layers[0]; further
  /// layers hold just their names, or colour before them where a channel shows a part of it. Each
  /// layer is filled by a pass of its own, with weights of its own. `channels` are what the picture
  /// has beside the colour of layer 0. Commits go to lane 0 until set_lane().
  void prepare(const std::vector<std::vector<std::string>>& layers,
               std::vector<FilmChannel> channels, uint32_t lanes = 1);
  /// With a channel for each name.
  void prepare(const std::vector<std::vector<std::string>>& layers, uint32_t lanes = 1);
  uint32_t lanes() const { return static_cast<uint32_t>(lanes_.size()); }
  /// Where commits go from now on.
  void set_lane(uint32_t lane) { lane_ = lane; }
  /// What all colours are multiplied by as they are developed; 1 unless a sensor sets it before it
  /// renders: what its rays' radiance counts for.
  void set_response(float factor) { response_ = factor; }
  /// Samples of colour have an alpha: for the picture's, or for a channel of its own.
  bool has_alpha() const { return has_alpha_ || takes_alpha_; }
  /// The film's colour, then FilmChannels: the channels of develop().
  std::vector<std::string> channels() const;
  /// Values that FilmTile::add expects in a layer. Layer 0: always R, G, B (converted here where
  /// the film stores luminance), then alpha if has_alpha(), then the extra ones.
  int value_count(int layer) const;
  /// The layer takes the mean of powers: it must be told of each sample by itself.
  bool has_powers(int layer) const;
  /// While an object of this class lives, layers are counted from its `first`, in all that
  /// integrators ask the film for (value_count, has_powers, make_tile): so one nested in another,
  /// which knows of none but its own, fills those that are meant for it.
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
  /// Integrators go by RenderContext::for_each_tile or commit, without which there are no
  /// checkpoints.
  void commit(const FilmTile& tile);
  /// How many there were since prepare().
  uint64_t commits() const { return commits_; }
  uint64_t non_finite() const { return non_finite_; }
  /// Hands all that was committed to `io`, piece by piece: to be written, or to be replaced by what
  /// a film that was prepared alike has written so. False, half way, where that film was another.
  bool transfer(const std::function<void(void* bytes, size_t count)>& io);
  /// Which pixels of the crop window, row by row, have no samples of a layer. None, where it is
  /// made of light paths alone: those show all of it at once.
  std::vector<bool> gaps(int layer) const;
  /// Weighted means so far, of all lanes together, plus splats; pixels without either are 0.
  Image develop() const { return develop(crop_); }
  /// A part of it: `pixels`, which lie in the crop window.
  Image develop(const Rect& pixels) const;
  /// What develop() would make of one lane: R, G, B, or luminance in all three; nullopt where the
  /// lane has no samples. `pixel` counts those of the crop window, row by row.
  std::optional<Rgb> lane_color(size_t pixel, uint32_t lane) const;
  /// Of the colours that develop() gives, by what lanes differ by.
  FilmNoise noise() const;

  /// Writes the developed image in the film's file format. Extension appended where `path` has
  /// none.
  virtual void write(const std::string& path, const Image& image,
                     const ImageMetadata& metadata) const = 0;
  /// ".exr", ".pfm"
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
  /// What one lane has of one layer.
  struct Sums {
    ZeroedArray<double> values;  ///< of each pixel: values, their powers, the weight
    ZeroedArray<double> splats;  ///< R, G, B of each pixel; empty until there is one
    double light_paths = 0;
  };
  using Lane = std::vector<Sums>;  ///< by layer
  struct Layer {
    std::vector<std::string> names;  ///< beside the colours
    bool has_color = false;
    std::vector<FilmPower> powers;
  };
  /// Of a layer that isn't counted from first_layer_, as all that follows.
  int values_of(size_t layer) const;
  size_t stride_of(size_t layer) const {
    return values_of(layer) + layers_[layer].powers.size() + 1;
  }
  int place_of(const FilmChannel& channel) const;
  void commit_splats(const FilmTile& tile);
  /// Those that there are, or zeros for them.
  ZeroedArray<double>& splats_of(Sums& sums);
  /// By how much each lane moves a pixel's colour, such that the sum of the squares is the colour's
  /// variance: see film_noise.cpp. Returns how many lanes have samples; of fewer than two there
  /// is nothing to tell.
  uint32_t lane_shares(size_t pixel, std::vector<glm::dvec3>& shares) const;
  /// Of lanes [first, end) together.
  Rgb color(size_t layer, size_t pixel, size_t first, size_t end) const;
  double splat_scale(size_t layer, size_t first, size_t end) const;
  /// Of all lanes: one of a layer's values, or of the powers after them.
  double mean(size_t layer, size_t pixel, size_t value) const;
  float value_of(const FilmChannel& channel, size_t pixel) const;

  std::vector<Layer> layers_;
  std::vector<FilmChannel> channels_;
  bool takes_alpha_ = false;  ///< a channel shows it
  int first_layer_ = 0;
  std::vector<Lane> lanes_ = std::vector<Lane>(1);
  uint32_t lane_ = 0;
  float response_ = 1;
  /// Of the crop window's columns and rows: 1 / the filter's integral over what is sampled.
  std::vector<double> splat_columns_, splat_rows_;
  uint64_t non_finite_ = 0;
  uint64_t commits_ = 0;
};

}  // namespace kinome
