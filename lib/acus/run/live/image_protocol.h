// The protocol between a live session and the computer that renders its images, as messages of
// OpenIGTLink (docs/concepts/live_session.md):
//
//   to that computer                          back
//   STRING  Images    format and digest       STATUS  Images   code 1: accepted, or why not
//   NDARRAY Steps     inputs of steps         IMAGE   ...      an image that has changed
//                                             NDARRAY Moment   end of the images of one time
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
/// reads, not their paths: two computers with the same digest render the same images.
/// @throws InputError if a file does not exist.
std::string DigestOf(const scenario::Scenario& scenario, const simulation::Scene& scene);

tracking::Bytes PackRequest(const std::string& digest);
/// The digest; nothing if the message is no request.
std::optional<std::string> ReadRequest(const tracking::IgtlHeader& header,
                                       tracking::ByteView content);

/// @pre 1 to kMostStepsInMessage steps. @param first_number  Number of the first; from 0.
tracking::Bytes PackSteps(std::span<const StepInput> steps, std::int64_t first_number);
/// Nothing if a value is not possible in a step, the first step has another number, or times do not
/// rise above `after_ns`.
std::optional<std::vector<StepInput>> ReadSteps(tracking::ByteView content,
                                                std::int64_t first_number, std::int64_t after_ns);

/// Names of the messages with images, in the order of ProbeImages and LiveImage::effects.
std::vector<std::string> ImageNames(const simulation::Scene& scene);

/// Messages with the images of a snapshot that differ from the previous ones, and an end message.
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

/// Assembles the messages of snapshots.
class MomentReader {
 public:
  explicit MomentReader(const simulation::Scene& scene) : names_(ImageNames(scene)) {}
  /// False: the message does not belong to a snapshot, or is not readable.
  bool Take(const tracking::IgtlHeader& header, tracking::ByteView content);
  /// True once for each complete snapshot: images() are all of it.
  bool TakeWhole();
  const MadeImages& images() const { return images_; }

 private:
  bool TakeImage(const tracking::IgtlHeader& header, tracking::ByteView content);

  std::vector<std::string> names_;
  MadeImages images_;
  bool whole_ = false;
};

}  // namespace acus::live
