#include "acus/physics/breathing/motion_model.h"

#include <algorithm>
#include <cmath>

#include "acus/base/core/error.h"

namespace acus::breathing {
namespace {

void CheckFrames(const std::vector<KeyFrame>& frames, const MotionField& field) {
  ACUS_REQUIRE(frames.size() >= 2, "motion model: ", frames.size(),
               " key frames; at least two are needed");
  for (std::size_t n = 0; n < frames.size(); ++n) {
    ACUS_REQUIRE(std::isfinite(frames[n].at), "motion model: key frame ", n,
                 " is at a place that is not finite");
    ACUS_REQUIRE(
        frames[n].component >= KeyFrame::kReference && frames[n].component < field.num_components(),
        "motion model: key frame ", n, " names component ", frames[n].component, "; there are ",
        field.num_components());
    if (n == 0) continue;
    ACUS_REQUIRE(frames[n].at > frames[n - 1].at, "motion model: key frame ", n, " at ",
                 frames[n].at, " does not follow the one before it at ", frames[n - 1].at);
  }
}

}  // namespace

std::string_view NameOf(MotionKind kind) {
  switch (kind) {
    case MotionKind::kSinusoid:
      return "sinusoid";
    case MotionKind::kFullCycle:
      return "full_cycle";
    case MotionKind::kHalfCycle:
      return "half_cycle";
    case MotionKind::kSurrogate:
      return "surrogate";
  }
  return "";
}

MotionKind MotionKindOf(std::string_view name) {
  for (const MotionKind kind : {MotionKind::kSinusoid, MotionKind::kFullCycle,
                                MotionKind::kHalfCycle, MotionKind::kSurrogate}) {
    if (name == NameOf(kind)) return kind;
  }
  throw InputError(Message("no motion model is named '", name,
                           "'; sinusoid, full_cycle, half_cycle and surrogate are"));
}

MotionModel MotionModel::Sinusoid(MotionField field, double reference_level) {
  ACUS_REQUIRE(std::isfinite(reference_level), "motion model: the reference level is not finite");
  MotionModel model(MotionKind::kSinusoid, std::move(field));
  model.reference_level_ = reference_level;
  return model;
}

MotionModel MotionModel::FullCycle(MotionField field, std::vector<KeyFrame> frames) {
  CheckFrames(frames, field);
  ACUS_REQUIRE(frames.front().at >= 0.0 && frames.back().at < 1.0,
               "motion model: key frames of a cycle lie at ", frames.front().at, " to ",
               frames.back().at, "; allowed is 0 to below 1");
  MotionModel model(MotionKind::kFullCycle, std::move(field));
  model.frames_ = std::move(frames);
  return model;
}

MotionModel MotionModel::HalfCycle(MotionField field, std::vector<KeyFrame> frames) {
  if (frames.size() >= 2 && frames.front().at > frames.back().at) std::ranges::reverse(frames);
  CheckFrames(frames, field);
  MotionModel model(MotionKind::kHalfCycle, std::move(field));
  model.frames_ = std::move(frames);
  return model;
}

MotionModel MotionModel::Surrogate(MotionField field) {
  ACUS_REQUIRE(field.num_components() == 3,
               "motion model: a surrogate model has three fields, not ", field.num_components());
  return {MotionKind::kSurrogate, std::move(field)};
}

void MotionModel::AddFrame(const KeyFrame& frame, double share, MotionWeights& out) const noexcept {
  if (frame.component != KeyFrame::kReference) out.Add(frame.component, share);
}

void MotionModel::BetweenFrames(double at, double amplitude, MotionWeights& out) const noexcept {
  const auto next = std::ranges::upper_bound(frames_, at, {}, &KeyFrame::at);
  KeyFrame before;
  KeyFrame after;
  double span = 1.0;
  if (kind_ == MotionKind::kFullCycle && (next == frames_.begin() || next == frames_.end())) {
    // Round the end of the cycle.
    before = frames_.back();
    after = frames_.front();
    span = after.at + 1.0 - before.at;
    if (at < before.at) before.at -= 1.0;
  } else if (next == frames_.begin() || next == frames_.end()) {
    // Eq. 10: beyond the ends, along the line between the ends.
    before = frames_.front();
    after = frames_.back();
    span = after.at - before.at;
  } else {
    before = *(next - 1);
    after = *next;
    span = after.at - before.at;
  }
  const double share = (at - before.at) / span;
  AddFrame(before, amplitude * (1.0 - share), out);
  AddFrame(after, amplitude * share, out);
}

MotionWeights MotionModel::WeightsAt(const Breath& breath, double amplitude) const noexcept {
  MotionWeights out;
  if (amplitude == 0.0 || !std::isfinite(amplitude) || !std::isfinite(breath.cycle) ||
      !std::isfinite(breath.level) || !std::isfinite(breath.level_per_s)) {
    return out;
  }
  switch (kind_) {
    case MotionKind::kSinusoid:
      out.Add(0, amplitude * (reference_level_ - breath.level));
      break;
    case MotionKind::kFullCycle:
      BetweenFrames(breath.cycle, amplitude, out);
      break;
    case MotionKind::kHalfCycle:
      BetweenFrames(breath.level, amplitude, out);
      break;
    case MotionKind::kSurrogate:
      out.Add(0, amplitude * breath.level);
      out.Add(1, amplitude * breath.level_per_s);
      out.Add(2, amplitude);
      break;
  }
  return out;
}

}  // namespace acus::breathing
