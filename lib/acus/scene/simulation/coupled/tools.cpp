// Poses of the tools, and the tissue at the needle's tip: the stages that all effects share.
#include "acus/physics/forces/laws/tissue_lookup.h"
#include "acus/scene/simulation/coupled/coupled_effect.h"
#include "acus/scene/simulation/coupled/declaration.h"

namespace acus::simulation::coupled {
namespace {

using scenario::Scenario;

class NeedlePoseStage final : public CoupledStage {
 public:
  explicit NeedlePoseStage(const Scene& scene) : scene_(scene) {}

  Sleep Step(StepFrame& frame) const noexcept override {
    if (frame.state.needle_seen) {
      frame.out.ct_from_needle = scene_.ct_from_reference * frame.sample.reference_from_needle;
    }
    frame.out.needle_at_rest = frame.tools.needle;
    return frame.unseen();
  }

 private:
  const Scene& scene_;
};

class TissueLookupStage final : public CoupledStage {
 public:
  explicit TissueLookupStage(const Scene& scene)
      : is_bent_(scene.shape.has_value()),
        lookup_(scene.labels ? forces::TissueLookup(*scene.labels)
                             : forces::TissueLookup(*scene.hu, *scene.hu_tissues)) {}

  Sleep Step(StepFrame& frame) const noexcept override {
    frame.lookup = &lookup_;
    // A bent needle's tip is at the position of the previous step.
    if (frame.state.needle_seen) {
      const Eigen::Vector3d tip_in_ct_mm = frame.tip_in_ct_mm();
      frame.out.tissue_at_tip =
          lookup_.At(is_bent_ ? Eigen::Vector3d(tip_in_ct_mm + frame.state.shape.tip_offset_mm)
                              : tip_in_ct_mm);
    }
    return frame.unseen();
  }

 private:
  bool is_bent_;
  forces::TissueLookup lookup_;
};

class ToolPoses final : public CoupledEffect {
 public:
  std::string_view key() const override { return ""; }

  std::vector<PlannedStage> Stages(const Scenario& s, bool /*breath_from_session*/) const override {
    // In a patient who breathes, the needle has another pose in the CT.
    Ports needle{ports::kNeedlePoses};
    AddMotion(s, needle);
    Ports lookup = AreTissuesByHu(s) ? Ports{ports::kNeedle, ports::kCt, ports::kForceTable}
                                     : Ports{ports::kNeedle, ports::kLabels};
    return {StepStage("needle pose", std::move(needle), {ports::kNeedle}),
            StepStage("tissue lookup", std::move(lookup), {ports::kTissue}),
            ImageStage("probe pose", {ports::kProbePoses}, {ports::kProbe})};
  }

  std::unique_ptr<const CoupledStage> NewStage(effects::PortRef writes,
                                               const Scene& scene) const override {
    if (writes == ports::kNeedle) return std::make_unique<NeedlePoseStage>(scene);
    if (writes == ports::kTissue) return std::make_unique<TissueLookupStage>(scene);
    return nullptr;
  }
};

}  // namespace

const CoupledEffect& Tools() {
  static const ToolPoses effect;
  return effect;
}

}  // namespace acus::simulation::coupled
