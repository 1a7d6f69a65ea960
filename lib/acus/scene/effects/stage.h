// Stages of an effect: the work that it adds to every sample and to every image.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <new>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "acus/data/image/image.h"
#include "acus/physics/breathing/motion_map.h"
#include "acus/scene/effects/memory.h"
#include "acus/scene/effects/port.h"

namespace acus::effects {

/// What a stage did.
enum class Activity {
  kActive,
  kIdle,       ///< There was nothing to do.
  kUnchanged,  ///< The last image still holds.
};

/// The moment of a step.
struct StepTime {
  std::int64_t time_ns = 0;
  double session_s = 0.0;  ///< Since the session began.
};

/// Where an echo comes from, CT space.
struct EchoPlace {
  Eigen::Vector3d place_in_ct_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d beam_in_ct = Eigen::Vector3d::UnitZ();  ///< Unit, from the face to the place.
  double depth_mm = 0.0;                                  ///< Along the beam, from the face.
  double frequency_mhz = 0.0;                             ///< Centre frequency of the probe.
};

/// The work of an effect at every sample. Const after loading: all that changes is in its state, a
/// plain value of state_bytes() that the simulation keeps. Implement StepStageOf<State> instead.
class StepStage {
 public:
  virtual ~StepStage() = default;

  virtual std::size_t state_bytes() const noexcept = 0;
  virtual void BeginIn(std::byte* state) const noexcept = 0;

  /// Real time: must not allocate, lock, log or throw. The same inputs give the same bits.
  /// @param ports  What the stage reads is set; it may set what it writes to parts of its state.
  /// @param columns  One number for each of the effect's columns, zero before.
  virtual Activity StepIn(std::byte* state, const StepTime& time, PortValues& ports,
                          std::span<double> columns) const noexcept = 0;

  /// Where tissue that is now at a place was without this effect, CT space. Only called if the
  /// stage writes ports::kTissueMotion, by tools at every sample and by images at their knots, or
  /// ports::kSwelling, by images.
  virtual Eigen::Vector3d RestIn(const std::byte* /*state*/,
                                 const Eigen::Vector3d& place_in_ct_mm) const noexcept {
    return place_in_ct_mm;
  }
  /// True if tissue is at the same place in both states, so that images of it need not be rendered
  /// again.
  virtual bool IsSameMotionIn(const std::byte* /*a*/, const std::byte* /*b*/) const noexcept {
    return true;
  }
  /// Distance over which the motion may be taken as linear.
  virtual double MotionSpacingMm() const noexcept { return 1e3; }

  /// Force on the needle in N, CT space, beside those of other stages; the device displays their
  /// sum and logs have it. Only called if the stage writes ports::kAddedForce, after each step.
  virtual Eigen::Vector3d ForceIn(const std::byte* /*state*/) const noexcept {
    return Eigen::Vector3d::Zero();
  }

  /// False: there is no change of any echo in this state.
  virtual bool ChangesEchoIn(const std::byte* /*state*/) const noexcept { return true; }
  /// By how many dB the echo of a place differs from that without this effect. Only called if the
  /// stage writes ports::kEcho, for each pixel of a B-mode image.
  virtual double EchoChangeDbIn(const std::byte* /*state*/,
                                const EchoPlace& /*place*/) const noexcept {
    return 0.0;
  }
  /// True if echoes are the same in both states, so that a B-mode image need not be rendered again.
  virtual bool IsSameEchoIn(const std::byte* /*a*/, const std::byte* /*b*/) const noexcept {
    return true;
  }
};

/// A stage whose state is of a type of its own.
template <PlainState State>
class StepStageOf : public StepStage {
 public:
  virtual State Begin() const noexcept { return {}; }
  virtual Activity Step(State& state, const StepTime& time, PortValues& ports,
                        std::span<double> columns) const noexcept = 0;
  virtual Eigen::Vector3d RestInCtMm(const State& /*state*/,
                                     const Eigen::Vector3d& place_in_ct_mm) const noexcept {
    return place_in_ct_mm;
  }
  virtual bool IsSameMotion(const State& /*a*/, const State& /*b*/) const noexcept { return true; }
  virtual Eigen::Vector3d ForceInCtN(const State& /*state*/) const noexcept {
    return Eigen::Vector3d::Zero();
  }
  virtual bool ChangesEcho(const State& /*state*/) const noexcept { return true; }
  virtual double EchoChangeDb(const State& /*state*/, const EchoPlace& /*place*/) const noexcept {
    return 0.0;
  }
  virtual bool IsSameEcho(const State& /*a*/, const State& /*b*/) const noexcept { return true; }

  static const State& StateAt(const std::byte* state) noexcept {
    return *std::launder(reinterpret_cast<const State*>(state));
  }

  std::size_t state_bytes() const noexcept final { return sizeof(State); }
  void BeginIn(std::byte* state) const noexcept final { new (state) State(Begin()); }
  Activity StepIn(std::byte* state, const StepTime& time, PortValues& ports,
                  std::span<double> columns) const noexcept final {
    return Step(*std::launder(reinterpret_cast<State*>(state)), time, ports, columns);
  }
  Eigen::Vector3d RestIn(const std::byte* state,
                         const Eigen::Vector3d& place_in_ct_mm) const noexcept final {
    return RestInCtMm(StateAt(state), place_in_ct_mm);
  }
  bool IsSameMotionIn(const std::byte* a, const std::byte* b) const noexcept final {
    return IsSameMotion(StateAt(a), StateAt(b));
  }
  Eigen::Vector3d ForceIn(const std::byte* state) const noexcept final {
    return ForceInCtN(StateAt(state));
  }
  bool ChangesEchoIn(const std::byte* state) const noexcept final {
    return ChangesEcho(StateAt(state));
  }
  double EchoChangeDbIn(const std::byte* state, const EchoPlace& place) const noexcept final {
    return EchoChangeDb(StateAt(state), place);
  }
  bool IsSameEchoIn(const std::byte* a, const std::byte* b) const noexcept final {
    return IsSameEcho(StateAt(a), StateAt(b));
  }
};

/// What differs from the moment of the stage's last image, to the bit. All of it for the first.
struct ImageChanges {
  bool needle = true;  ///< Pose and shape.
  bool probe = true;
  bool breath = true;
  bool tissue = true;  ///< Any motion of tissue, breath included.
  bool images = true;  ///< The images of the probe that the stage reads.
  bool force = true;   ///< The force on the needle.
};

/// The moment of an image.
struct ImageMoment {
  std::int64_t time_ns = 0;
  double session_s = 0.0;
  bool probe_valid = false;
  Eigen::Isometry3d ct_from_probe = Eigen::Isometry3d::Identity();
  std::optional<Eigen::Isometry3d> ct_from_needle = std::nullopt;
  /// As images see it: bent. Null if there is none or the stage does not read
  /// ports::kNeedlePreset.
  const image::NeedleInImage* needle = nullptr;
  /// Force of the needle on the hand, CT space. Zero if the scene computes none.
  Eigen::Vector3d needle_force_in_ct_n = Eigen::Vector3d::Zero();
  /// Null if the stage does not read ports::kBreath.
  const breathing::MotionMap* breath = nullptr;
  /// Path of the needle's tip since the session began; only for stills.
  std::span<const Eigen::Vector3d> tip_path_in_ct_mm = {};
  ImageChanges changes = {};
  /// State of the effect's stage at every sample, after the last step before the image; null if
  /// the effect has no such stage. See StepStageOf::StateAt.
  const std::byte* state = nullptr;
};

/// A grey image or one in colour: the other is empty.
struct EffectPixels {
  image::GrayImage gray;
  image::ColourImage colour;

  bool empty() const { return gray.pixels.empty() && colour.rgb.empty(); }
};

/// Text in black bands above and below a grey image of a video; the time is above, on the right.
struct ImageText {
  std::string above;  ///< On the left.
  std::string left;   ///< Above the left half: a side of the patient.
  std::string right;  ///< Above the right half.
  std::string below;
};

/// The image that an effect adds. One for each thread.
class ImageStage {
 public:
  virtual ~ImageStage() = default;

  /// The same bits for the same moment, whatever was rendered before, and with any number of
  /// threads.
  /// @param ports  What the stage reads is set; ports::kRestMap to null while no tissue is moved.
  /// @param out  Holds the stage's last image; on kUnchanged it is not written.
  virtual Activity Render(const ImageMoment& moment, const PortValues& ports,
                          EffectPixels& out) = 0;

  /// True: replays also render a still of each event, KEY_event_NN.png, with the path of the tip.
  virtual bool ShowsEvents() const { return false; }
  /// False: after such changes Render does without ports::kRestMap.
  virtual bool NeedsRestMap(const ImageChanges& /*changes*/) const { return true; }
  /// Where the pixels of a grey image lie, if they stay there: column, row, 0 to CT space, mm.
  /// Replays then write a sequence, KEY.igs.mha.
  virtual std::optional<Eigen::Affine3d> ct_from_image() const { return std::nullopt; }
  /// Nothing: videos show the image alone.
  virtual std::optional<ImageText> Text() const { return std::nullopt; }
};

}  // namespace acus::effects
