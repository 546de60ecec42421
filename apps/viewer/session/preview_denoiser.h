#pragma once

#include <memory>

#include "kinome/denoise.h"
#include "kinome/render_context.h"
#include "kinome/scene_editor.h"

namespace kinome::viewer {

/// Denoises previews by Open Image Denoise, with albedo and normals. Not thread-safe.
class PreviewDenoiser {
 public:
  /// Throws Error if the library can't be loaded.
  explicit PreviewDenoiser(unsigned threads);

  /// Returns a scene that renders the albedo and normals of the editor's scene.
  static std::shared_ptr<const Scene> guides_of(SceneEditor& editor);
  /// Replaces the colour of a preview, which `sensor` has rendered. Uses the sensor's film. Returns
  /// false if the context was interrupted; the image is unchanged then.
  bool denoise(Image& image, const Scene& guides, const Sensor& sensor,
               RenderContext& context) const;

 private:
  Denoiser denoiser_;
};

}  // namespace kinome::viewer
