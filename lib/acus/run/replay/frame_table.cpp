#include "acus/run/replay/frame_table.h"

#include <cmath>
#include <limits>

#include "acus/base/core/csv.h"

namespace acus::replay {
namespace {

constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

void NamePose(const std::string& pose, std::vector<std::string>& names) {
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      names.push_back(Message(pose, "_", row, column));
    }
  }
}

std::vector<std::string> FrameColumns() {
  std::vector<std::string> names = {"frame", "time_s", "probe_seen", "needle_seen"};
  NamePose("ct_from_image", names);
  NamePose("ct_from_probe", names);
  NamePose("ct_from_needle", names);
  for (const char* name : {"tip_column_px", "tip_row_px", "tip_off_plane_mm", "target_column_px",
                           "target_row_px", "target_off_plane_mm", "inserted_mm", "visible_share",
                           "tissue_at_tip", "needle_depth_mm", "force_axial_n", "puncture_n",
                           "cutting_n", "friction_n", "bone_n", "lateral_n", "probe_force_n"}) {
    names.emplace_back(name);
  }
  return names;
}

void AppendRows(const Eigen::Matrix4d& pose, bool there, std::vector<double>& row) {
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 4; ++c) row.push_back(there ? pose(r, c) : kMissing);
  }
}

void AppendPlace(const std::optional<Eigen::Vector3d>& place, std::vector<double>& row) {
  for (int axis = 0; axis < 3; ++axis) row.push_back(place ? (*place)[axis] : kMissing);
}

void AppendForces(const simulation::Scene& scene, const simulation::StepOutput* step,
                  std::vector<double>& row) {
  const bool felt = step != nullptr && scene.plan.Writes(effects::ports::kForce);
  row.push_back(felt ? step->tissue_at_tip : kMissing);
  const forces::NeedleForce force = felt ? step->force : forces::NeedleForce{};
  for (const double value : {force.depth_mm, force.AxialN(), force.puncture_n, force.cutting_n,
                             force.friction_n, force.bone_n, force.lateral_n}) {
    row.push_back(felt ? value : kMissing);
  }
  const bool pressed = step != nullptr && scene.plan.Writes(effects::ports::kProbeForce);
  row.push_back(pressed ? step->probe.force_in_ct_n.norm() : kMissing);
}

}  // namespace

const std::vector<std::string>& FrameTable::Columns() {
  static const std::vector<std::string> columns = FrameColumns();
  return columns;
}

void FrameTable::AddFrame(const simulation::Scene& scene, const simulation::Snapshot& snapshot,
                          const simulation::StepOutput* step, const simulation::ImageTruth& truth) {
  std::vector<double> row = {static_cast<double>(rows_.size()), snapshot.session_s,
                             snapshot.probe_valid ? 1.0 : 0.0, snapshot.ct_from_needle ? 1.0 : 0.0};
  const Eigen::Affine3d ct_from_image =
      acoustics::ImageOf(*scene.probe).ct_from_image(snapshot.ct_from_probe);
  AppendRows(ct_from_image.matrix(), snapshot.probe_valid, row);
  AppendRows(snapshot.ct_from_probe.matrix(), snapshot.probe_valid, row);
  const Eigen::Isometry3d needle = snapshot.ct_from_needle.value_or(Eigen::Isometry3d::Identity());
  AppendRows(needle.matrix(), snapshot.ct_from_needle.has_value(), row);
  AppendPlace(truth.tip_in_image, row);
  AppendPlace(truth.target_in_image, row);
  row.push_back(truth.tip_in_image ? truth.inserted_mm : kMissing);
  row.push_back(truth.visible_share.value_or(kMissing));
  AppendForces(scene, step, row);
  rows_.push_back(std::move(row));
}

std::string FrameTable::CsvText() const {
  std::string text;
  for (const std::string& name : Columns()) text += (text.empty() ? "" : ",") + name;
  text += '\n';
  for (const std::vector<double>& row : rows_) {
    for (std::size_t n = 0; n < row.size(); ++n) {
      if (n > 0) text += ',';
      if (!std::isnan(row[n])) text += NumberText(row[n]);
    }
    text += '\n';
  }
  return text;
}

}  // namespace acus::replay
