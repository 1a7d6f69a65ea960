#include "benchmarks/probe_sweep.h"

#include <algorithm>
#include <cmath>

#include "acus/base/config/json_file.h"
#include "acus/base/core/cpu_time.h"
#include "acus/base/math/statistics.h"
#include "acus/physics/forces/laws/force_table.h"
#include "acus/physics/forces/probe/multi_proxy_probe.h"
#include "benchmarks/insertion.h"
#include "benchmarks/pressed_tool.h"

namespace acus::benchmarks {
namespace {

using Kind = PressedTool::Kind;

constexpr Kind kProbeSweepKinds[] = {Kind::kFlat, Kind::kTilted, Kind::kRound, Kind::kFingertip};
constexpr int kDefaultProxies = 16;  ///< acus-scenario: probe_force/proxies.

/// The body as the model sees it: a surface where depth passes 0. Not cut off at air and soft
/// tissue, so that the surface's slope, which is taken over the tool's face, is exact.
class BodyField : public forces::HuField {
 public:
  BodyField(const PressedTool& tool, double skin_hu) : tool_(tool), skin_hu_(skin_hu) {}
  double HuAt(const Eigen::Vector3d& place_in_ct_mm) const noexcept override {
    return skin_hu_ + 100.0 * tool_.DepthMm(place_in_ct_mm);
  }
  double ResolutionMm() const noexcept override { return 0.7; }

 private:
  PressedTool tool_;
  double skin_hu_;
};

/// The shipped springs without friction, damping and smoothing: what is left has an exact answer.
forces::ForceTable SpringsAlone() {
  forces::ForceTable table = forces::ReadForceTable(config::FindConfig("forces/default.json", "."));
  forces::MultiProxySettings& law = table.multi_proxy;
  law.skin.friction = 0.0;
  law.damping_n_s_per_mm = law.smoothing_s = 0.0;
  law.structures.clear();
  return table;
}

struct Errors {
  double force_n = 0.0;  ///< Root mean squares.
  double torque_n_mm = 0.0;
};

struct PressedRun {
  Errors errors;
  std::vector<double> step_us;
  std::string unusable;
};

/// At 1 kHz: 10 mm in within 0.4 s, then 30 mm to and fro along the skin in a second.
PressedRun Press(const PressedTool& tool, int num_proxies, const forces::ForceTable& table) {
  const BodyField body(tool, table.multi_proxy.skin_hu);
  const forces::MultiProxyProbe model(table, tool.Nodes(num_proxies),
                                      {&body, table.multi_proxy.skin_hu, {}});
  forces::MultiProxyState state;
  PressedRun run;
  int count = 0;
  for (int n = 0; n < 1400; ++n) {
    const double depth_mm = std::min(10.0, -1.0 + 0.0275 * n);
    const double aside_mm = n < 400 ? 0.0 : 15.0 * std::sin(2e-3 * M_PI * (n - 400));
    const Eigen::Isometry3d pose = tool.BodyFromTool(depth_mm, aside_mm);
    const double begin_s = ThreadCpuSeconds();
    const forces::ProbeForce felt =
        model.Step(state, {.time_s = 1e-3 * n, .ct_from_probe = pose, .valid = true});
    run.step_us.push_back(1e6 * (ThreadCpuSeconds() - begin_s));
    if (!felt.force_in_ct_n.allFinite()) run.unusable = "a force is not finite";
    if (n % 20 != 0) continue;
    const PressedTool::Load exact = tool.Exact(table.multi_proxy.skin, pose);
    run.errors.force_n += (felt.force_in_ct_n - exact.force_n).squaredNorm();
    run.errors.torque_n_mm += (felt.torque_in_ct_n_mm - exact.torque_n_mm).squaredNorm();
    ++count;
  }
  run.errors.force_n = std::sqrt(run.errors.force_n / count);
  run.errors.torque_n_mm = std::sqrt(run.errors.torque_n_mm / count);
  return run;
}

std::vector<Row> RunSweep(bool quick, const RunContext& context) {
  const forces::ForceTable table = SpringsAlone();
  const std::vector<int> numbers =
      quick ? std::vector{1, 4, 16, 64} : std::vector{1, 2, 4, 8, 16, 32, 64};
  std::vector<Row> rows;
  for (const Kind kind : kProbeSweepKinds) {
    const PressedTool tool{kind};
    context.Checkpoint(std::string(tool.name()), 0.25 * static_cast<double>(kind));
    for (const int num_proxies : numbers) {
      const PressedRun run = Press(tool, num_proxies, table);
      Row row;
      row.knob = "proxies, " + std::string(tool.name());
      row.value = std::to_string(num_proxies);
      row.model = "multi_proxy";
      row.reference = "integral over the tool's surface";
      row.step_us_median = math::Median(run.step_us);
      row.step_us_p999 = math::Quantile(run.step_us, 0.999);
      row.memory_mb = 1e-6 * static_cast<double>(sizeof(forces::MultiProxyState));
      row.is_default = num_proxies == kDefaultProxies;
      row.unusable = run.unusable;
      row.error = run.errors.force_n;
      row.error_unit = "N";
      rows.push_back(row);
      row.error = run.errors.torque_n_mm;
      row.error_unit = "N mm";
      rows.push_back(std::move(row));
    }
  }
  return rows;
}

}  // namespace

Sweep ProbeSweep() {
  return {"probe", "The force on a probe or a finger",
          "The face of a probe, 40 x 12 mm, and a fingertip of 8 mm radius are pressed 10 mm in "
          "and drawn along the skin, at 1 kHz: the springs of multi_proxy without friction, whose "
          "force and torque are known as an integral over the tool's surface. Errors are root "
          "mean squares.",
          RunSweep};
}

}  // namespace acus::benchmarks
