#include "acus/assess/trials/trainee.h"

#include <cmath>

#include "acus/base/config/json_file.h"
#include "acus/base/core/random.h"

namespace acus::trials {

TraineeSkill ReadTraineeSkill(const std::filesystem::path& path) {
  const nlohmann::json file = config::ReadConfig(path, "acus-trainee");
  TraineeSkill skill;
  skill.grade = file.at("grade");
  const auto take = [&file](const char* group, const char* key, double& value) {
    value = file.at(group).at(key);
  };
  skill.spread = file.at("spread");
  skill.learning = file.at("learning");
  skill.delay_s = file.at("delay_s");
  take("tremor", "position_mm", skill.tremor_mm);
  take("tremor", "rotation_deg", skill.tremor_deg);
  take("tremor", "drift_mm", skill.drift_mm);
  take("probe", "search_s", skill.search_s);
  take("probe", "sweep_mm", skill.sweep_mm);
  take("probe", "plane_mm", skill.plane_mm);
  take("probe", "plane_deg", skill.plane_deg);
  take("aim", "entry_mm", skill.entry_mm);
  take("aim", "direction_deg", skill.aim_deg);
  take("aim", "bias_mm", skill.bias_mm);
  take("aim", "target_mm", skill.target_mm);
  take("aim", "depth_mm", skill.depth_mm);
  take("aim", "approach_s", skill.aim_s);
  take("insertion", "speed_mm_per_s", skill.speed_mm_per_s);
  take("insertion", "speed_spread", skill.speed_spread);
  take("insertion", "stretch_mm", skill.stretch_mm);
  take("insertion", "stop_s", skill.stop_s);
  take("insertion", "place_s", skill.place_s);
  take("correction", "notice_mm", skill.notice_mm);
  take("correction", "gain", skill.correction_gain);
  take("correction", "direction_deg", skill.correction_deg);
  take("correction", "withdraw_share", skill.withdraw_share);
  take("correction", "bone_n", skill.bone_n);
  skill.most_corrections = file.at("correction").at("most");
  return skill;
}

TraineeSkill PersonOf(const TraineeSkill& grade, std::uint64_t seed, const std::string& code,
                      int trial) {
  TraineeSkill person = grade;
  RandomStream random(seed, "person " + code);
  const double practice = std::pow(static_cast<double>(trial), -grade.learning);
  // The order must not change: each value has its draw.
  for (double* value : {&person.tremor_mm, &person.tremor_deg, &person.drift_mm, &person.delay_s}) {
    *value *= std::exp(grade.spread * random.Normal());
  }
  for (double* value : {&person.search_s, &person.sweep_mm, &person.plane_mm, &person.plane_deg,
                        &person.entry_mm, &person.aim_deg, &person.bias_mm, &person.target_mm,
                        &person.depth_mm, &person.aim_s, &person.stop_s, &person.correction_deg}) {
    *value *= practice * std::exp(grade.spread * random.Normal());
  }
  person.speed_mm_per_s *= std::exp(grade.spread * random.Normal());
  person.notice_mm *= std::exp(grade.spread * random.Normal());
  return person;
}

}  // namespace acus::trials
