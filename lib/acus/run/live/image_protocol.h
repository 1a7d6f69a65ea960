// What a live session and the computer that makes its images say to each other, as messages of
// OpenIGTLink (docs/concepts/live_session.md):
//
//   to that computer                          back
//   STRING  Images    format and digest       STATUS  Images   code 1: accepted, or why not
//   NDARRAY Steps     inputs of steps         IMAGE   ...      what has changed since the last
//   moment
//                                             NDARRAY Moment   these were all of that moment
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "acus/rig/tracking/igtl_wire.h"
#include "acus/run/live/live_image.h"
#include "acus/run/live/step_feed.h"
#include "acus/scene/scenario/scenario.h"
#include "acus/scene/simulation/scene.h"

namespace acus::live {

inline constexpr int kImagePort = 18946;
inline constexpr std::size_t kMostStepsInMessage = 200;

/// SHA-256 over the build, the settings of the scenario and the contents of the files that its plan
/// reads, not their places: two computers with the same digest make the same images.
/// @throws InputError if a file is gone.
std::string DigestOf(const scenario::Scenario& scenario, const simulation::Scene& scene);

tracking::Bytes PackRequest(const std::string& digest);
/// The digest. Nothing if it is no request.
std::optional<std::string> ReadRequest(const tracking::IgtlHeader& header,
                                       tracking::ByteView content);

/// @pre 1 to kMostStepsInMessage of them. @param first_number  Of the first; steps count from 0.
tracking::Bytes PackSteps(std::span<const StepInput> steps, std::int64_t first_number);
/// Nothing if there is a number that a step never has, the first has another number, or times do
/// not rise above `after_ns`.
std::optional<std::vector<StepInput>> ReadSteps(tracking::ByteView content,
                                                std::int64_t first_number, std::int64_t after_ns);

/// Names of the messages with images, in the order of ProbeImages and LiveImage::effects.
std::vector<std::string> ImageNames(const simulation::Scene& scene);

/// The messages of a moment: images that differ from `sent`, which follows, and the end.
class MomentPacker {
 public:
  explicit MomentPacker(const simulation::Scene& scene)
      : scene_(scene), names_(ImageNames(scene)) {}
  std::vector<tracking::Bytes> Pack(const LiveImage& image);

 private:
  const simulation::Scene& scene_;
  std::vector<std::string> names_;
  std::vector<std::vector<std::uint8_t>> sent_;
};

/// Puts the messages of moments together again.
class MomentReader {
 public:
  explicit MomentReader(const simulation::Scene& scene) : names_(ImageNames(scene)) {}
  /// False: that is no message of a moment, or not readable.
  bool Take(const tracking::IgtlHeader& header, tracking::ByteView content);
  /// True once for each whole moment: images() are all of it.
  bool TakeWhole();
  const MadeImages& images() const { return images_; }

 private:
  bool TakeImage(const tracking::IgtlHeader& header, tracking::ByteView content);

  std::vector<std::string> names_;
  MadeImages images_;
  bool whole_ = false;
};

}  // namespace acus::live
