#pragma once

#include <string>
#include <vector>

#include "kinome/checkpoint.h"
#include "output.h"

namespace kinome::app {

/// Where the frames of a film are kept. Each is there whole or not at all, so that a film that was
/// interrupted goes on with those that are missing. Beside them lies a file that says which film
/// they are of.
class FilmFrames {
 public:
  /// `output`: a video, as film.mp4, whose frames go to film-frames/%04d.png until it is made; or a
  /// pattern of names, as frames/%04d.exr, or .png; "": a video beside the scene file. Throws Error
  /// where it is neither.
  FilmFrames(const std::string& output, const std::string& scene);

  const std::string& pattern() const { return pattern_; }
  const std::string& video() const { return video_; }  ///< "": none is asked for
  std::string name(int frame) const;
  /// Frames are PNGs and nothing else.
  bool are_png() const;
  /// As choose_output() for one picture; throws Error as that does.
  Output output(int frame, const Options& options, const Film& film) const;

  /// Where it is missing.
  void make_folder() const;
  /// Takes the folder for this film. Throws Error where it holds frames of another one, or can't be
  /// written. `frames`: how many there are in all.
  void claim(const Checkpoint::Identity& identity, int frames) const;
  static bool are_there(const Output& output);
  /// Once the video is made.
  void remove(const std::vector<Output>& frames) const;

 private:
  std::string folder() const;
  std::string identity_path() const;

  std::string pattern_, video_;
  std::string before_, after_;  ///< the number, in a file's name
  int digits_ = 0;
};

}  // namespace kinome::app
