#include "acus/patient/meshing/interface_shift.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "acus/data/mesh/quality.h"

namespace acus::meshing {

double ShiftInterfaces(const TetraEditor& editor, const std::vector<double>& target_mm3,
                       MaterialField& field) {
  const auto num_materials = static_cast<int>(target_mm3.size());
  std::vector<double> volume(num_materials, 0.0);
  std::vector<double> area(num_materials, 0.0);
  // Volume per unit of offset: area over slope.
  std::vector<double> gain_mm3(num_materials, 0.0);
  const double flattest = 0.5 / field.spacing_mm().maxCoeff();
  for (int t = 0; t < editor.num_slots(); ++t) {
    if (!editor.is_alive(t)) continue;
    const int m = editor.material(t);
    const mesh::Corners x = editor.CornersOf(editor.tetrahedron(t));
    volume[m] += mesh::VolumeMm3(x);
    for (int c = 0; c < 4; ++c) {
      const int other = editor.Neighbour(t, c);
      if (other < 0 || editor.material(other) == m) continue;
      const Eigen::Vector3d& p = x[(c + 1) & 3];
      const double mm2 = 0.5 * (x[(c + 2) & 3] - p).cross(x[(c + 3) & 3] - p).norm();
      const Eigen::Vector3d middle = (p + x[(c + 2) & 3] + x[(c + 3) & 3]) / 3.0;
      area[m] += mm2;
      const double slope = field.Gradient(middle, m, editor.material(other)).norm();
      gain_mm3[m] += mm2 / std::max(slope, flattest);
    }
  }
  double worst = 0.0;
  // The rest (1) follows from the others. Outside (0) is the body's total, turned round.
  const double body = std::accumulate(volume.begin() + 1, volume.end(), 0.0);
  const double body_target = std::accumulate(target_mm3.begin() + 1, target_mm3.end(), 0.0);
  for (int m = 0; m < num_materials; ++m) {
    if (m == 1 || area[m] <= 0.0) continue;
    const double lack = m == 0 ? body - body_target : target_mm3[m] - volume[m];
    worst = std::max(worst, std::abs(lack) / (m == 0 ? body_target : target_mm3[m]));
    const double step_mm3 = std::clamp(1.3 * lack, -area[m], area[m]);  // 1 mm on average.
    const double offset = field.offset(m) + step_mm3 / gain_mm3[m];
    field.set_offset(m, std::clamp(offset, -0.8, 0.8));
  }
  return worst;
}

}  // namespace acus::meshing
