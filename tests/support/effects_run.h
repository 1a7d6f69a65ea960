// A short session through a scene in memory: all that its stages give.
#pragma once

#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "acus/scene/simulation/effect_images.h"
#include "acus/scene/simulation/probe_image_renderer.h"
#include "acus/scene/simulation/simulation.h"

namespace acus::testing_support {

/// What the hands do: what a tool that is away cannot touch, its effects have nothing to do for.
struct Hands {
  bool needle_in = true;  ///< Into the tissue; else well above the skin.
  bool probe_on = true;   ///< Pressed on the skin; else well above it.
};

/// The needle goes in along z at (0, -10), a little askew, and halts; the probe slides.
inline simulation::Sample HandsAt(int ms, const Hands& hands) {
  const double t = 1e-3 * ms;
  simulation::Sample sample{.time_ns = ms * std::int64_t{1'000'000}, .needle_valid = true};
  const double depth_mm = -3.0 + std::min(0.1 * ms, 28.0);
  sample.reference_from_needle =
      Eigen::Translation3d(0.3 * std::sin(7.0 * t), -10.0,
                           hands.needle_in ? depth_mm : depth_mm - 60.0) *
      Eigen::AngleAxisd(0.02 * std::sin(3.0 * t), Eigen::Vector3d::UnitX());
  sample.probe_valid = true;
  Eigen::Isometry3d probe = Eigen::Isometry3d::Identity();
  probe.linear() << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  probe.translation() << 2.0 + t, -9.0, hands.probe_on ? 2.0 : -60.0;
  sample.reference_from_probe = probe;
  sample.breath = {.cycle = 0.2 + 0.1 * t, .level = 0.7 - 0.3 * t, .level_per_s = -0.3};
  return sample;
}

/// Everything that a scene's stages gave, as bits.
struct Outputs {
  std::vector<double> needle_force;  ///< With what the shape adds; empty without the effect.
  std::vector<double> needle;
  std::vector<double> probe_force;
  std::vector<double> tissue;
  std::vector<std::uint8_t> ultrasound;
  std::vector<std::uint8_t> ct_slice;
  std::map<std::string, std::vector<std::uint8_t>> effects;  ///< Of the list, by key.

  bool operator==(const Outputs&) const = default;
};

class EffectsRun {
 public:
  explicit EffectsRun(const simulation::Scene& scene)
      : scene_(scene), simulation_(scene), state_(simulation_.NewState()) {}

  /// Steps up to and without `end_ms`.
  void Steps(int end_ms, const Hands& hands, Outputs* out = nullptr,
             simulation::StageTimes* times = nullptr) {
    for (; ms_ < end_ms; ++ms_) {
      last_sample_ = HandsAt(ms_, hands);
      last_ = simulation_.Step(state_, last_sample_, times);
      if (out != nullptr) Keep(last_, *out);
    }
  }

  /// The moment after the last step. Valid until the next steps.
  simulation::Snapshot Now() {
    simulation::Snapshot now{.time_ns = last_.time_ns,
                             .session_s = 1e-9 * static_cast<double>(last_.time_ns)};
    now.breath = last_sample_.breath;
    now.needle_force_in_ct_n = last_.force.force_in_ct_n;
    now.probe_valid = true;
    now.ct_from_probe = scene_.ct_from_reference * last_sample_.reference_from_probe;
    if (scene_.plan.Writes(effects::ports::kNeedle)) {
      now.ct_from_needle = scene_.ct_from_reference * last_sample_.reference_from_needle;
    }
    if (simulation_.ShapeOf(state_, shape_)) now.needle_shape = &shape_;
    if (scene_.tools_deform_images && simulation_.LoadOf(state_, last_, load_)) now.load = &load_;
    if (scene_.listed.has_steps()) now.memory = &(memory_ = state_.effects);
    return now;
  }

  void RenderImages(const simulation::Snapshot& now, Outputs& out,
                    simulation::StageTimes* times = nullptr) {
    if (!renderer_) renderer_.emplace(scene_);
    renderer_->Render(now, images_, times);
    out.ultrasound = images_.b_mode.pixels;
    out.ct_slice = images_.ct_slice.pixels;
    for (const simulation::ListedEffect& effect : scene_.listed.all()) {
      if (!effect.has_image) continue;
      if (!effects_.contains(effect.key)) {
        effects_.try_emplace(effect.key, scene_, effect, RunContext());
      }
      effects::EffectPixels pixels;
      effects_.at(effect.key).Render(now, &images_, pixels, times);
      auto& bytes = out.effects[std::string(effect.key)];
      bytes = pixels.colour.rgb.empty() ? pixels.gray.pixels : pixels.colour.rgb;
    }
  }

 private:
  void Keep(const simulation::StepOutput& step, Outputs& out) const {
    const auto add = [](std::vector<double>& to, const auto& vector) {
      to.insert(to.end(), vector.data(), vector.data() + vector.size());
    };
    if (scene_.plan.Writes(effects::ports::kForce)) {
      add(out.needle_force, step.force.force_in_ct_n);
      add(out.needle_force, step.force.torque_in_ct_n_mm);
      out.needle_force.push_back(step.force.depth_mm);
      out.needle_force.push_back(static_cast<double>(step.tissue_at_tip));
    }
    if (scene_.plan.Writes(effects::ports::kShape)) {
      add(out.needle, step.shape.tip_in_ct_mm);
      out.needle.push_back(step.shape.tip_deflection_mm);
    }
    if (scene_.plan.Writes(effects::ports::kProbeForce)) {
      add(out.probe_force, step.probe.force_in_ct_n);
      add(out.probe_force, step.probe.torque_in_ct_n_mm);
    }
    if (scene_.plan.Writes(effects::ports::kContact)) {
      add(out.tissue, step.tissue.needle.force_in_ct_n);
      add(out.tissue, step.tissue.probe_in_ct_n);
    }
  }

  const simulation::Scene& scene_;
  simulation::Simulation simulation_;
  simulation::State state_;
  simulation::StepOutput last_;
  simulation::Sample last_sample_;
  int ms_ = 0;
  math::Polyline shape_;
  tissue::TissueLoad load_;
  effects::Memory memory_;
  std::optional<simulation::ProbeImageRenderer> renderer_;
  std::map<std::string_view, simulation::EffectImageRenderer> effects_;
  simulation::ProbeImages images_;
};

}  // namespace acus::testing_support
