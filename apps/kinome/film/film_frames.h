#pragma once

#include <string>
#include <vector>

#include "images/output.h"
#include "kinome/checkpoint.h"

namespace kinome::app {

/// Files of an animation's frames. Each frame is complete or absent, so that an interrupted
/// animation continues with the missing ones. A file beside them, film.json, identifies their
/// animation.
class FilmFrames {
 public:
  /// `output` is one of these; any other name throws Error:
  /// - a video such as film.mp4, whose frames are film-frames/%04d.png until it is encoded;
  /// - a pattern of names such as frames/%04d.exr or .png;
  /// - "" for a video beside the scene file.
  FilmFrames(const std::string& output, const std::string& scene);

  const std::string& pattern() const { return pattern_; }
  const std::string& video() const { return video_; }  ///< "" if no video is requested
  std::string name(int frame) const;
  /// Returns true if frames are written as PNGs only.
  bool are_png() const;
  /// Returns the files of a frame, as choose_output() does for an image. Throws the same errors.
  Output output(int frame, const Options& options, const Film& film) const;

  /// Creates the folder of the frames if it is missing.
  void make_folder() const;
  /// Reserves the folder for this animation, of `frames` frames in total. Throws Error if the
  /// folder has frames of another animation or can't be written.
  void claim(const Checkpoint::Identity& identity, int frames) const;
  /// Returns true if all files of a frame exist.
  static bool exists(const Output& output);
  /// Removes the frames and their folder, once the video is encoded.
  void remove(const std::vector<Output>& frames) const;

 private:
  std::string folder() const;
  std::string identity_path() const;

  std::string pattern_, video_;
  std::string before_, after_;  ///< parts of a file name before and after the number
  int digits_ = 0;
};

}  // namespace kinome::app
