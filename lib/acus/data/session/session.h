// A recorded session: time series of tool poses and signals.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <string>
#include <vector>

#include "acus/data/session/signals.h"
#include "acus/data/transforms/pose.h"

namespace acus::session {

/// One reading of a tracked tool.
struct PoseSample {
  std::int64_t time_ns = 0;
  transforms::Pose reference_from_tool = {};  ///< mm. Use it like an Eigen::Isometry3d.
  bool valid =
      true;  ///< False where the tracker did not see the tool; the pose is the last good one.
};

/// The readings of one tool, in order of time (strictly increasing).
using PoseStream = std::vector<PoseSample>;

/// The pose at a time: that of a reading at this very time, bit for bit, else interpolated between
/// its neighbours and valid only if both are; before the first and after the last, that one. @pre
/// stream is not empty.
PoseSample PoseAt(const PoseStream& stream, std::int64_t time_ns);

/// A recording in one reference frame (the mannequin's or the tracker's "Reference").
///
/// Needle frame: origin at the tip, +z along insertion. Probe frame: origin at the middle of the
/// transducer face, +x towards the marked side, +y along the beam into the body, +z = x cross y.
struct Session {
  std::string name;
  std::string reference_frame = "Reference";
  PoseStream needle;                   ///< Empty if no needle was tracked.
  PoseStream probe;                    ///< Empty if no probe was tracked.
  BreathStream breath = {};            ///< Empty if the patient's breath was not recorded.
  std::vector<Command> commands = {};  ///< Of a live session, in order of time.

  /// Time of the first reading of any tool; 0 if there is none.
  std::int64_t start_ns() const;
};

}  // namespace acus::session
