#include "acus/run/replay/trace.h"

#include <array>
#include <charconv>
#include <functional>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/provenance.h"
#include "acus/data/session/pose_csv.h"

namespace acus::replay {
namespace {

using simulation::StepOutput;

/// The shortest exact text, also of values that are not finite.
std::string ExactText(double value) {
  std::array<char, 32> text{};
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr};
}

/// One column of the trace.
struct TraceColumn {
  std::string name;
  std::function<std::string(const StepOutput&)> text;
};

class Columns {
 public:
  explicit Columns(const simulation::Scene& scene) : scene_(scene) {}

  template <typename Get>
  void Number(effects::PortRef written, const char* name, const char* variable, Get get) {
    Text(written, name, variable, [get](const StepOutput& step) { return ExactText(get(step)); });
  }

  template <typename Get>
  void Vector(effects::PortRef written, const char* name, const char* variable, const char* unit,
              Get get) {
    for (int i = 0; i < 3; ++i) {
      const std::string full = std::string(variable) + "_" + "xyz"[i] + unit;
      Number(written, name, full.c_str(),
             [get, i](const StepOutput& step) { return get(step)[i]; });
    }
  }

  template <typename Get>
  void Text(effects::PortRef written, const char* name, const char* variable, Get get) {
    if (scene_.plan.Writes(written)) list.push_back({std::string(name) + "/" + variable, get});
  }

  std::vector<TraceColumn> list;

 private:
  const simulation::Scene& scene_;
};

void AddPose(Columns& columns, effects::PortRef written, const char* name,
             const std::function<const Eigen::Isometry3d&(const StepOutput&)>& pose) {
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      const std::string entry = "ct_from_needle_" + std::to_string(row) + std::to_string(column);
      columns.Number(written, name, entry.c_str(), [pose, row, column](const StepOutput& step) {
        return pose(step).matrix()(row, column);
      });
    }
  }
}

void AddForce(Columns& columns, effects::PortRef written, const char* name,
              const std::function<const forces::NeedleForce&(const StepOutput&)>& force) {
  const std::array<std::pair<const char*, double forces::NeedleForce::*>, 7> parts = {
      {{"depth_mm", &forces::NeedleForce::depth_mm},
       {"puncture_n", &forces::NeedleForce::puncture_n},
       {"cutting_n", &forces::NeedleForce::cutting_n},
       {"friction_n", &forces::NeedleForce::friction_n},
       {"bone_n", &forces::NeedleForce::bone_n},
       {"bone_penetration_mm", &forces::NeedleForce::bone_penetration_mm},
       {"lateral_n", &forces::NeedleForce::lateral_n}}};
  for (const auto& [variable, part] : parts) {
    columns.Number(written, name, variable,
                   [force, part = part](const StepOutput& step) { return force(step).*part; });
  }
  columns.Vector(written, name, "force", "_n",
                 [force](const StepOutput& step) { return force(step).force_in_ct_n; });
  columns.Vector(written, name, "torque", "_n_mm",
                 [force](const StepOutput& step) { return force(step).torque_in_ct_n_mm; });
  columns.Text(written, name, "event", [force](const StepOutput& step) {
    return std::string(forces::NameOf(force(step).event));
  });
}

std::vector<TraceColumn> ColumnsOf(const simulation::Scene& scene) {
  Columns columns(scene);
  AddPose(
      columns, effects::ports::kNeedle, "needle pose",
      [](const StepOutput& s) -> const auto& { return s.ct_from_needle; });
  AddPose(
      columns, effects::ports::kBreath, "breathing",
      [](const StepOutput& s) -> const auto& { return s.needle_at_rest.ct_from_tool; });
  columns.Text(effects::ports::kTissue, "tissue lookup", "tissue",
               [](const StepOutput& s) { return std::to_string(int{s.tissue_at_tip}); });
  AddForce(
      columns, effects::ports::kContact, "tissue contact",
      [](const StepOutput& s) -> const auto& { return s.tissue.needle; });
  columns.Vector(effects::ports::kContact, "tissue contact", "probe", "_n",
                 [](const StepOutput& s) { return s.tissue.probe_in_ct_n; });
  AddForce(
      columns, effects::ports::kForce, "needle force",
      [](const StepOutput& s) -> const auto& { return s.force; });
  columns.Vector(effects::ports::kShape, "needle shape", "tip", "_mm",
                 [](const StepOutput& s) { return s.shape.tip_in_ct_mm; });
  columns.Number(effects::ports::kShape, "needle shape", "deflection_mm",
                 [](const StepOutput& s) { return s.shape.tip_deflection_mm; });
  columns.Vector(effects::ports::kProbeForce, "probe force", "force", "_n",
                 [](const StepOutput& s) { return s.probe.force_in_ct_n; });
  columns.Number(effects::ports::kProbeForce, "probe force", "skin_mm",
                 [](const StepOutput& s) { return s.probe.skin_mm; });
  for (const simulation::ListedEffect& effect : scene.listed.all()) {
    for (std::size_t n = 0; n < effect.columns.size(); ++n) {
      const std::size_t at = effect.first_column + n;
      columns.list.push_back({std::string(effect.key) + "/" + effect.columns[n].name,
                              [at](const StepOutput& s) { return ExactText(s.effect[at]); }});
    }
  }
  return columns.list;
}

std::string HashOf(const image::GrayImage& image) {
  return Sha256OfText(std::string(image.pixels.begin(), image.pixels.end()));
}

}  // namespace

void WriteTrace(const std::filesystem::path& path, const StepLog& log,
                const simulation::Scene& scene) {
  const std::vector<TraceColumn> columns = ColumnsOf(scene);
  std::string text = "time_s";
  for (const TraceColumn& column : columns) text += ',' + column.name;
  text += '\n';
  for (const StepOutput& step : log.steps) {
    text += session::SecondsText(step.time_ns);
    for (const TraceColumn& column : columns) text += ',' + column.text(step);
    text += '\n';
  }
  WriteTextFile(path, text);
}

void ImageTrace::Add(std::int64_t time_ns, const simulation::ProbeImages& images) {
  rows_ += session::SecondsText(time_ns) + ',' + HashOf(images.ct_slice) + ',' +
           HashOf(images.b_mode) + '\n';
}

void ImageTrace::Write(const std::filesystem::path& path) const {
  WriteTextFile(path, "time_s,CT slice/sha256,B-mode/sha256\n" + rows_);
}

}  // namespace acus::replay
