// Fluid through the needle at every sample: what the syringe, the thumb and the tissue at the bevel
// do, and what of it the hand feels and the images show.
#pragma once

#include <array>
#include <memory>

#include "acus/data/volume/volume.h"
#include "acus/physics/fluid/depot.h"
#include "acus/physics/fluid/fluid_events.h"
#include "acus/physics/fluid/fluid_model.h"
#include "acus/scene/effects/stage.h"

namespace acus::effects {

/// Who presses the plunger.
enum class Thumb {
  kSession,     ///< The session: its recorded orders, or keys.
  kContinuous,  ///< A steady force, eased after the loss of resistance.
  kTaps,        ///< The same in short pushes.
};

/// Rows of the table of tissues, by what the needle's tip is in.
struct FluidRows {
  std::array<int, 256> of_label{};  ///< Outside the spinal canal.
  volume::Label canal = 0;          ///< Labels: of the spinal canal ...
  volume::Label ligament = 0;       ///< ... of the ligaments before it ...
  volume::Label fat = 0;            ///< ... of fat, which right behind them is epidural ...
  volume::Label bone = 0;           ///< ... and of bone.
  int epidural = 0;
  int subarachnoid = 0;
  int vessel = 0;
  int space = 0;  ///< Where fluid is injected or drawn.
};

struct FluidSettings {
  FluidRows rows;
  fluid::Hub hub = fluid::Hub::kSyringe;  ///< At the start; a stylet can be removed.
  Thumb thumb = Thumb::kSession;
  double thumb_n = 0.0;
  double taps_per_s = 0.0;
  bool presses_from_ligament = true;  ///< Before the first ligament the steady thumb waits.
  double eased_after_ml = 0.0;        ///< Injected since the loss of resistance.
  double heart_per_s = 0.0;
  double epidural_depth_mm = 0.0;  ///< On the needle's way through the canal, until the dura.
  /// Gives the layers of depots; null: they lie across the needle. Must outlive the stage.
  const volume::LabelMap* layers = nullptr;
};

/// A region of injected fluid.
struct ShownDepot {
  std::array<double, 3> centre_in_ct_mm{};
  std::array<double, 3> normal_in_ct{};  ///< Normal of its layers, unit length.
  double width_radius_mm = 0.0;
  double thickness_radius_mm = 0.0;
  double displaced_radius_mm = 0.0;  ///< Radius of a sphere of the displaced volume.
  double wet_share = 0.0;
  double air_ml = 0.0;
  std::size_t row = 0;  ///< Tissue or space, in fluid::FluidTable::tissues.
};
inline constexpr int kMostShownDepots = 4;

struct FluidStageState {
  fluid::FluidState fluid;
  fluid::FluidEvents events;
  double last_s = 0.0;
  bool is_started = false;
  volume::Label label = 0;                 ///< At the tip.
  bool is_in_canal = false;                ///< The canal, or epidural fat before it.
  std::array<double, 3> canal_entry_mm{};  ///< Where the tip came into the canal.
  std::array<double, 3> ligament_mm{};     ///< Where the tip was last in a ligament.
  int row = 0;                             ///< At the bevel.
  double thumb_n = 0.0;
  fluid::Hub hub = fluid::Hub::kSyringe;
  double injected_ml = 0.0;   ///< Into tissue, from the syringe.
  double aspirated_ml = 0.0;  ///< Into the syringe.
  bool has_met_ligament = false;
  bool is_lost = false;  ///< There was a loss of resistance: what follows is of the last one.
  std::array<double, 3> loss_tip_mm{};
  double injected_at_loss_ml = 0.0;
  double beyond_loss_mm = 0.0;
  std::int32_t losses = 0;
  std::int32_t false_losses = 0;
  std::int32_t dural_punctures = 0;
  std::int32_t vessel_entries = 0;
  std::int32_t stylet_removals = 0;
  std::array<double, 3> force_in_ct_n{};
  std::array<ShownDepot, kMostShownDepots> depot{};
  int num_depots = 0;
};

/// Columns of the stage, in this order.
enum class FluidColumn {
  kPlungerN,
  kPlungerMm,
  kSyringeKpa,
  kBevelKpa,
  kFlowMlPerMin,
  kInjectedMl,
  kReturnedMl,
  kDropsPerMin,
  kBeyondLossMm,
  kLosses,
  kFalseLosses,
  kDuralPunctures,
  kVesselEntries,
  kAspiratedMl,
  kSpaceMl,
  kStyletRemovals,
  kCount,
};

class FluidStage final : public StepStageOf<FluidStageState> {
 public:
  FluidStage(std::shared_ptr<const fluid::FluidModel> model, const FluidSettings& settings)
      : model_(std::move(model)), settings_(settings) {
    if (settings.layers != nullptr) index_from_ct_ = settings.layers->geometry.index_from_ct();
  }

  FluidStageState Begin() const noexcept override;
  Activity Step(FluidStageState& state, const StepTime& time, PortValues& ports,
                std::span<double> columns) const noexcept override;
  /// Syringe and needle are one body: what the thumb presses, the other hand holds.
  Eigen::Vector3d ForceInCtN(const FluidStageState& state) const noexcept override;
  /// Tissue around a depot is displaced by its volume, without compression.
  Eigen::Vector3d RestInCtMm(const FluidStageState& state,
                             const Eigen::Vector3d& place_in_ct_mm) const noexcept override;
  bool IsSameMotion(const FluidStageState& a, const FluidStageState& b) const noexcept override;
  double MotionSpacingMm() const noexcept override { return 2.0; }
  bool ChangesEcho(const FluidStageState& state) const noexcept override {
    return state.num_depots > 0;
  }
  double EchoChangeDb(const FluidStageState& state, const EchoPlace& place) const noexcept override;
  bool IsSameEcho(const FluidStageState& a, const FluidStageState& b) const noexcept override {
    return IsSameMotion(a, b);
  }

 private:
  int RowAt(FluidStageState& state, volume::Label label, const Eigen::Vector3d& tip_mm,
            const Eigen::Vector3d& axis_in_ct) const noexcept;
  double ThumbN(const FluidStageState& state, double session_n, double session_s) const noexcept;
  void MoveStylet(FluidStageState& state, double session_n) const noexcept;
  void Count(FluidStageState& state, int row, const Eigen::Vector3d& tip_mm) const noexcept;
  void KeepDepots(FluidStageState& state, const Eigen::Vector3d& axis_in_ct) const noexcept;
  Eigen::Vector3d NormalAt(const Eigen::Vector3d& place_in_ct_mm,
                           const Eigen::Vector3d& axis_in_ct) const noexcept;

  std::shared_ptr<const fluid::FluidModel> model_;
  FluidSettings settings_;
  Eigen::Affine3d index_from_ct_ = Eigen::Affine3d::Identity();
  fluid::FluidEventLimits limits_;
};

}  // namespace acus::effects
