#include "acus/patient/phantom/planning/spinal_level.h"

#include <algorithm>
#include <vector>

#include "acus/base/core/csv.h"
#include "acus/base/core/error.h"
#include "acus/base/core/words.h"

namespace acus::phantom {

namespace fs = std::filesystem;

double SpinalLevel::ShareAt(const Eigen::Vector3d& point_ct_mm) const {
  const Eigen::Vector3d down = lower_ct_mm - upper_ct_mm;
  return (point_ct_mm - upper_ct_mm).dot(down) / down.squaredNorm();
}

bool SpinalLevel::HasAt(const Eigen::Vector3d& point_ct_mm) const {
  const double share = ShareAt(point_ct_mm);
  return share >= 0.3 && share <= 0.8;
}

bool NamesSpinalLevel(std::string_view target) {
  return target.find('-') != std::string_view::npos &&
         std::string_view("+-.0123456789").find(target.front()) == std::string_view::npos;
}

SpinalLevel ReadSpinalLevel(const std::string& target, const fs::path& vertebrae_csv) {
  ACUS_REQUIRE(fs::exists(vertebrae_csv), "--target ", target, ": the height of vertebrae is read ",
               "from ", vertebrae_csv.string(), ", which does not exist; acus-segment writes it ",
               "beside the label map where it finds a spine");
  const CsvTable table(vertebrae_csv);
  const std::vector<std::string> names = table.Texts("name");
  const std::size_t dash = target.find('-');
  const auto upper = std::ranges::find(names, target.substr(0, dash));
  ACUS_REQUIRE(
      upper != names.end() && upper + 1 != names.end() && *(upper + 1) == target.substr(dash + 1),
      "--target ", target, ": ", vertebrae_csv.string(),
      " has no such two vertebrae, the upper one first; from the head it has ", Joined(names));
  const std::vector<double> x = table.Numbers("x_mm");
  const std::vector<double> y = table.Numbers("y_mm");
  const std::vector<double> z = table.Numbers("z_mm");
  const auto n = static_cast<std::size_t>(upper - names.begin());
  const SpinalLevel level{{x[n], y[n], z[n]}, {x[n + 1], y[n + 1], z[n + 1]}};
  ACUS_REQUIRE((level.lower_ct_mm - level.upper_ct_mm).norm() > 1.0, table.Where(n + 1),
               ": lies at the same place as the vertebra above it");
  return level;
}

}  // namespace acus::phantom
