#include "acus/assess/trials/trainee_session.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <numbers>

#include "acus/assess/trials/hand_noise.h"
#include "acus/base/math/angles.h"
#include "acus/scene/simulation/simulation.h"

namespace acus::trials {
namespace {

using math::kRadPerDegree;

constexpr double kRestOutsideMm = 40.0;  ///< Distance of the tip before aiming.
constexpr double kAimedOutsideMm = 3.0;
constexpr double kLongestS = 180.0;
constexpr double kTurnS = 0.8;
constexpr double kHandS = 0.1;     ///< Time in which the hand reaches a speed.
constexpr double kEyeS = 1.0;      ///< Time in which the image plane follows the needle.
constexpr double kSlowingS = 0.6;  ///< Near the target, speed is the remaining depth over this.
constexpr double kLeastMmPerS = 1.0;
constexpr double kLeftInMm = 5.0;   ///< Smallest depth after a withdrawal from deeper.
constexpr double kPlaneKept = 0.6;  ///< Share of the image plane's errors after each stop.
constexpr double kProbeHz = 50.0;

double MinimumJerk(double share) {
  const double s = std::clamp(share, 0.0, 1.0);
  return s * s * s * (10.0 - 15.0 * s + 6.0 * s * s);
}

Eigen::Vector3d NormalVector(double sd, RandomStream& random) {
  const double x = random.Normal(), y = random.Normal(), z = random.Normal();
  return sd * Eigen::Vector3d(x, y, z);
}

/// The axis rotated by a random angle in a random perpendicular direction.
Eigen::Vector3d Jittered(const Eigen::Vector3d& axis, double sd_rad, RandomStream& random) {
  const Eigen::Vector3d a = axis.unitOrthogonal();
  const Eigen::Vector3d b = axis.cross(a);
  const double along_a = sd_rad * random.Normal(), along_b = sd_rad * random.Normal();
  return (axis + along_a * a + along_b * b).normalized();
}

enum class Phase { kSearch, kAim, kAdvance, kStop, kWithdraw, kTurn, kPlace, kDone };

/// The intended motion of a person, without tremor. In CT space.
class Intention {
 public:
  Intention(const TrialScene& scene, const PlannedPath& path, const TraineeSkill& person,
            const Eigen::Vector3d& bias_mm, RandomStream& random)
      : person_(person), random_(random) {
    target_mm_ = path.target_ct_mm + bias_mm + NormalVector(person.target_mm, random);
    depth_error_mm_ = person.depth_mm * random.Normal();
    const Eigen::Vector3d off_mm = NormalVector(person.entry_mm, random);
    const Eigen::Vector3d near_mm =
        path.entry_ct_mm + off_mm - off_mm.dot(path.inward_in_ct) * path.inward_in_ct;
    axis_ = Jittered((target_mm_ - near_mm).normalized(), person.aim_deg * kRadPerDegree, random);
    entry_mm_ = EntryOfLine(scene, near_mm, axis_).value_or(near_mm);
    plane_mm_ = person.plane_mm * random.Normal();
    plane_rad_ = person.plane_deg * kRadPerDegree * random.Normal();
    search_angle_rad_ = random.Uniform(0.0, 2.0 * std::numbers::pi);
    seen_axis_ = path.axis_in_ct;
    Begin(Phase::kSearch, 0.0);
  }

  /// @param bone_n  Simulated resistance of bone in the last step.
  void Advance(double time_s, double dt_s, double bone_n) {
    Sense(time_s, bone_n);
    const double in_phase_s = time_s - begin_s_;
    if (time_s > kLongestS && phase_ != Phase::kDone) Begin(Phase::kDone, time_s);
    switch (phase_) {
      case Phase::kSearch:
        if (in_phase_s >= person_.search_s) Begin(Phase::kAim, time_s);
        break;
      case Phase::kAim:
        along_mm_ = -kRestOutsideMm +
                    (kRestOutsideMm - kAimedOutsideMm) * MinimumJerk(in_phase_s / person_.aim_s);
        if (in_phase_s >= person_.aim_s) BeginStretch(time_s);
        break;
      case Phase::kAdvance:
        MoveOn(time_s, dt_s);
        break;
      case Phase::kStop:
        if (in_phase_s >= person_.stop_s + person_.delay_s) Judge(time_s);
        break;
      case Phase::kWithdraw:
        along_mm_ = std::max(withdraw_to_mm_, along_mm_ - 1.5 * person_.speed_mm_per_s * dt_s);
        if (along_mm_ <= withdraw_to_mm_) Begin(Phase::kTurn, time_s);
        break;
      case Phase::kTurn:
        axis_ = Between(MinimumJerk(in_phase_s / kTurnS));
        if (in_phase_s >= kTurnS) BeginStretch(time_s);
        break;
      case Phase::kPlace:
        if (in_phase_s >= person_.place_s) Begin(Phase::kDone, time_s);
        break;
      case Phase::kDone:
        break;
    }
    if (phase_ != Phase::kSearch) {
      seen_axis_ = (seen_axis_ + std::min(1.0, dt_s / kEyeS) * (axis_ - seen_axis_)).normalized();
    }
  }

  bool done() const { return phase_ == Phase::kDone; }
  Eigen::Vector3d TipMm() const { return entry_mm_ + along_mm_ * axis_; }
  const Eigen::Vector3d& axis() const { return axis_; }
  const Eigen::Vector3d& seen_axis() const { return seen_axis_; }
  double along_mm() const { return along_mm_; }
  double plane_mm() const { return plane_mm_; }
  double plane_rad() const { return plane_rad_; }
  double search_angle_rad() const { return search_angle_rad_; }
  /// Remaining share of the search with the probe, 1 to 0.
  double SearchShare(double time_s) const {
    return phase_ == Phase::kSearch ? 1.0 - MinimumJerk((time_s - begin_s_) / person_.search_s)
                                    : 0.0;
  }
  int num_corrections() const { return num_corrections_; }
  int num_bone_contacts() const { return num_bone_contacts_; }

 private:
  struct Sensed {
    double time_s = 0.0;
    double along_mm = 0.0;
    double bone_n = 0.0;
  };

  void Begin(Phase phase, double time_s) {
    phase_ = phase;
    begin_s_ = time_s;
    if (phase != Phase::kAdvance) speed_mm_per_s_ = 0.0;
  }

  void BeginStretch(double time_s) {
    stretch_end_mm_ = std::max(along_mm_, 0.0) + person_.stretch_mm;
    stretch_speed_mm_per_s_ =
        person_.speed_mm_per_s * std::exp(person_.speed_spread * random_.Normal());
    Begin(Phase::kAdvance, time_s);
  }

  /// Stores what the person perceives after the delay.
  void Sense(double time_s, double bone_n) {
    sensed_.push_back({time_s, along_mm_, bone_n});
    while (sensed_.size() > 1 && sensed_[1].time_s <= time_s - person_.delay_s) {
      sensed_.pop_front();
    }
  }

  /// Depth at which the person assumes the tip to be beside the target.
  double StopDepthMm() const { return (target_mm_ - entry_mm_).dot(axis_) + depth_error_mm_; }

  void MoveOn(double time_s, double dt_s) {
    const Sensed& sensed = sensed_.front();
    if (sensed.bone_n > person_.bone_n && sensed.time_s > begin_s_) {
      ++num_bone_contacts_;
      AvoidBone(time_s);
      return;
    }
    const double remaining_mm = StopDepthMm() - sensed.along_mm;
    if (remaining_mm <= 0.0) {
      Begin(Phase::kStop, time_s);
      at_depth_ = true;
      return;
    }
    const double goal_mm_per_s =
        std::min(stretch_speed_mm_per_s_, kLeastMmPerS + remaining_mm / kSlowingS);
    speed_mm_per_s_ += std::min(1.0, dt_s / kHandS) * (goal_mm_per_s - speed_mm_per_s_);
    along_mm_ += speed_mm_per_s_ * dt_s;
    if (along_mm_ >= stretch_end_mm_) {
      at_depth_ = false;
      Begin(Phase::kStop, time_s);
      plane_mm_ *= kPlaneKept;
      plane_rad_ *= kPlaneKept;
    }
  }

  /// At the end of a stop: decides on an advance, another direction, or the end.
  void Judge(double time_s) {
    const Eigen::Vector3d to_target_mm = target_mm_ - TipMm();
    const Eigen::Vector3d miss_mm = to_target_mm - to_target_mm.dot(axis_) * axis_;
    if (miss_mm.norm() > person_.notice_mm && num_corrections_ < person_.most_corrections) {
      const Eigen::Vector3d goal_mm = target_mm_ - (1.0 - person_.correction_gain) * miss_mm;
      TurnTo((goal_mm - entry_mm_).normalized(), (1.0 - person_.withdraw_share) * along_mm_,
             time_s);
      return;
    }
    if (at_depth_) {
      Begin(Phase::kPlace, time_s);
    } else {
      BeginStretch(time_s);
    }
  }

  void AvoidBone(double time_s) {
    if (num_corrections_ >= person_.most_corrections) {
      Begin(Phase::kPlace, time_s);
      return;
    }
    constexpr double kAwayDeg = 4.0;
    TurnTo(Jittered((target_mm_ - entry_mm_).normalized(), kAwayDeg * kRadPerDegree, random_),
           0.3 * along_mm_, time_s);
  }

  void TurnTo(const Eigen::Vector3d& axis, double withdraw_to_mm, double time_s) {
    ++num_corrections_;
    from_axis_ = axis_;
    to_axis_ = Jittered(axis, person_.correction_deg * kRadPerDegree, random_);
    if (along_mm_ > kLeftInMm) withdraw_to_mm = std::max(kLeftInMm, withdraw_to_mm);
    withdraw_to_mm_ = std::min(along_mm_, withdraw_to_mm);
    Begin(Phase::kWithdraw, time_s);
  }

  Eigen::Vector3d Between(double share) const {
    return ((1.0 - share) * from_axis_ + share * to_axis_).normalized();
  }

  const TraineeSkill& person_;
  RandomStream& random_;
  Phase phase_ = Phase::kSearch;
  double begin_s_ = 0.0;  ///< Start of the phase.
  Eigen::Vector3d target_mm_, entry_mm_, axis_, seen_axis_;
  Eigen::Vector3d from_axis_ = Eigen::Vector3d::UnitZ(), to_axis_ = Eigen::Vector3d::UnitZ();
  double depth_error_mm_ = 0.0;
  double plane_mm_ = 0.0;
  double plane_rad_ = 0.0;
  double search_angle_rad_ = 0.0;
  double along_mm_ = -kRestOutsideMm;
  double speed_mm_per_s_ = 0.0;
  double stretch_speed_mm_per_s_ = 0.0;
  double stretch_end_mm_ = 0.0;
  double withdraw_to_mm_ = 0.0;
  bool at_depth_ = false;
  int num_corrections_ = 0;
  int num_bone_contacts_ = 0;
  std::deque<Sensed> sensed_;
};

/// Tremor and drift of one hand.
struct HandNoise {
  HandNoise(const TraineeSkill& person, RandomStream& random)
      : tremor_mm(person.tremor_mm, 8.0, 12.0, random),
        tremor_rad(person.tremor_deg * kRadPerDegree, 8.0, 12.0, random),
        drift_mm(person.drift_mm, 0.2, 0.8, random) {}

  /// @param share  1 in the air.
  Eigen::Isometry3d Moved(const Eigen::Isometry3d& pose, double time_s, double share) const {
    Eigen::Isometry3d moved = pose;
    moved.translation() += share * (tremor_mm.At(time_s) + drift_mm.At(time_s));
    const Eigen::Vector3d turn = share * tremor_rad.At(time_s);
    const double angle = turn.norm();
    if (angle > 0.0) {
      moved.linear() = Eigen::AngleAxisd(angle, turn / angle) * pose.linear();
    }
    return moved;
  }

  BandNoise tremor_mm, tremor_rad, drift_mm;
};

Eigen::Isometry3d NeedlePose(const Intention& intention, const Eigen::Vector3d& x_hint) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  const Eigen::Vector3d z = intention.axis();
  Eigen::Vector3d x = x_hint - x_hint.dot(z) * z;
  if (x.norm() < 1e-3) x = z.unitOrthogonal();
  x.normalize();
  pose.linear().col(0) = x;
  pose.linear().col(1) = z.cross(x);
  pose.linear().col(2) = z;
  pose.translation() = intention.TipMm();
  return pose;
}

Eigen::Isometry3d ProbePose(const PlannedPath& path, const Intention& intention,
                            const TraineeSkill& person, double time_s) {
  Eigen::Isometry3d pose =
      ProbeAlongNeedle(path, intention.seen_axis(), intention.plane_mm(), intention.plane_rad());
  const double share = intention.SearchShare(time_s);
  if (share <= 0.0) return pose;
  constexpr double kSweepHz = 0.4;
  const double sweep_mm =
      person.sweep_mm * share * std::sin(2.0 * std::numbers::pi * kSweepHz * time_s);
  const double angle = intention.search_angle_rad();
  pose.translation() +=
      share * 2.0 * person.sweep_mm *
          (std::cos(angle) * pose.linear().col(0) + std::sin(angle) * pose.linear().col(2)) +
      sweep_mm * pose.linear().col(2);
  return pose;
}

Eigen::Vector3d BiasOf(const TraineeSkill& person, const std::string& code, std::uint64_t seed) {
  RandomStream random(seed, "bias " + code);
  return person.bias_mm * NormalVector(1.0, random).normalized();
}

}  // namespace

session::Session LikeTrainees() {
  session::Session like;
  like.needle.resize(1);
  like.probe.resize(1);
  return like;
}

SimulatedTrial SimulateTrial(const TrialScene& scene, const PlannedPath& path,
                             const TraineeSkill& grade, const std::string& code, int trial,
                             std::uint64_t seed, double rate_hz) {
  const TraineeSkill person = PersonOf(grade, seed, code, trial);
  RandomStream random(seed, "trial " + code, static_cast<std::uint64_t>(trial));
  Intention intention(scene, path, person, BiasOf(person, code, seed), random);
  const HandNoise needle_hand(person, random);
  const HandNoise probe_hand(person, random);
  const simulation::Simulation simulation(scene.scene);
  simulation::State state = simulation.NewState(0);
  const Eigen::Isometry3d reference_from_ct = scene.scene.ct_from_reference.inverse();
  const Eigen::Vector3d roll_hint = path.axis_in_ct.unitOrthogonal();
  const auto every = std::max<std::int64_t>(1, std::llround(rate_hz / kProbeHz));

  SimulatedTrial made;
  made.session.name = Message(code, " trial ", trial);
  double bone_n = 0.0;
  for (std::int64_t i = 0; !intention.done(); ++i) {
    const double time_s = static_cast<double>(i) / rate_hz;
    const auto time_ns = static_cast<std::int64_t>(std::llround(1e9 * time_s));
    intention.Advance(time_s, 1.0 / rate_hz, bone_n);
    const double share = 1.0 - 0.5 * std::clamp(intention.along_mm() / 20.0, 0.0, 1.0);
    const transforms::Pose needle(
        reference_from_ct * needle_hand.Moved(NeedlePose(intention, roll_hint), time_s, share));
    const transforms::Pose probe(
        reference_from_ct *
        probe_hand.Moved(ProbePose(path, intention, person, time_s), time_s, 0.5));
    made.session.needle.push_back({time_ns, needle, true});
    if (i % every == 0) made.session.probe.push_back({time_ns, probe, true});
    const auto step = simulation.Step(state, {.time_ns = time_ns,
                                              .reference_from_needle = needle,
                                              .needle_valid = true,
                                              .reference_from_probe = probe,
                                              .probe_valid = true});
    bone_n = step.force.bone_n;
  }
  made.num_corrections = intention.num_corrections();
  made.num_bone_contacts = intention.num_bone_contacts();
  return made;
}

}  // namespace acus::trials
