#include "acus/patient/phantom/planning/spinal_level.h"

#include <algorithm>
#include <array>

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

std::vector<NamedLevel> ReadSpinalLevels(const fs::path& vertebrae_csv) {
  const CsvTable table(vertebrae_csv);
  const std::vector<std::string> names = table.Texts("name");
  const std::vector<double> x = table.Numbers("x_mm");
  const std::vector<double> y = table.Numbers("y_mm");
  const std::vector<double> z = table.Numbers("z_mm");
  std::vector<NamedLevel> levels;
  for (std::size_t n = 0; n + 1 < names.size(); ++n) {
    const SpinalLevel level{{x[n], y[n], z[n]}, {x[n + 1], y[n + 1], z[n + 1]}};
    ACUS_REQUIRE((level.lower_ct_mm - level.upper_ct_mm).norm() > 1.0, table.Where(n + 1),
                 ": lies at the same place as the vertebra above it");
    levels.push_back({names[n] + "-" + names[n + 1], level});
  }
  return levels;
}

std::span<const std::string_view> LumbarPunctureLevels() {
  static constexpr std::array<std::string_view, 4> kLevels = {"L3-L4", "L4-L5", "L2-L3", "L5-S1"};
  return kLevels;
}

std::string LevelNameAt(std::span<const NamedLevel> levels, const Eigen::Vector3d& point_ct_mm) {
  const auto at = std::ranges::find_if(levels, [&](const NamedLevel& level) {
    const double share = level.level.ShareAt(point_ct_mm);
    return share >= 0.0 && share < 1.0;
  });
  return at == levels.end() ? std::string() : at->name;
}

SpinalLevel ReadSpinalLevel(const std::string& target, const fs::path& vertebrae_csv) {
  ACUS_REQUIRE(fs::exists(vertebrae_csv), "--target ", target, ": the height of vertebrae is read ",
               "from ", vertebrae_csv.string(), ", which does not exist; acus-segment writes it ",
               "beside the label map where it finds a spine");
  const std::vector<NamedLevel> levels = ReadSpinalLevels(vertebrae_csv);
  const auto at = std::ranges::find(levels, target, &NamedLevel::name);
  ACUS_REQUIRE(at != levels.end(), "--target ", target, ": ", vertebrae_csv.string(),
               " has no such two vertebrae, the upper one first; from the head it has ",
               Joined(CsvTable(vertebrae_csv).Texts("name")));
  return at->level;
}

}  // namespace acus::phantom
