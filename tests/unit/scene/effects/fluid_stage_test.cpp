#include "acus/scene/effects/fluid/fluid_stage.h"

#include <cmath>
#include <gtest/gtest.h>

#include "acus/data/volume/labels.h"
#include "acus/scene/effects/ports.h"

namespace acus::effects {
namespace {

using Eigen::Vector3d;

fluid::FluidTable Table() {
  return fluid::ReadFluidTable(std::filesystem::path(ACUS_SOURCE_DIR) /
                               "configs/fluid/default.json");
}

/// A needle that goes down z through muscle, ligament, epidural fat and the canal.
class Puncture {
 public:
  static constexpr double kLigamentMm = 20.0, kFatMm = 24.0, kCanalMm = 26.0;

  explicit Puncture(double thumb_n, Thumb thumb = Thumb::kContinuous,
                    fluid::Hub hub = fluid::Hub::kSyringe) {
    fluid::FluidTable table = Table();
    FluidSettings settings;
    settings.rows.of_label.fill(table.TissueIndex("soft_tissue"));
    for (const char* name : {"muscle", "ligament", "fat", "spinal_canal"}) {
      settings.rows.of_label[volume::LabelOf(name)] = table.TissueIndex(name);
    }
    settings.rows.of_label[0] = 0;
    settings.rows.canal = volume::LabelOf("spinal_canal");
    settings.rows.ligament = volume::LabelOf("ligament");
    settings.rows.fat = volume::LabelOf("fat");
    settings.rows.bone = volume::LabelOf("bone");
    settings.rows.epidural = table.TissueIndex("epidural_lumbar");
    settings.rows.subarachnoid = table.TissueIndex("spinal_canal");
    settings.rows.vessel = table.TissueIndex("vein");
    settings.rows.space = settings.rows.subarachnoid;
    settings.hub = hub;
    settings.thumb = thumb;
    settings.thumb_n = thumb_n;
    settings.taps_per_s = 2.0;
    settings.eased_after_ml = 1.0;
    settings.heart_per_s = 1.2;
    settings.epidural_depth_mm = 5.5;
    const fluid::Syringe syringe = table.SyringeNamed("lor_plastic_10ml");
    const fluid::Lumen lumen{.inner_diameter_mm = table.BoreMm(18, "tuohy"), .length_mm = 90.0};
    stage_.emplace(std::make_shared<const fluid::FluidModel>(std::move(table), syringe,
                                                             fluid::Filling{6.0, 0.0}, lumen),
                   settings);
    state_ = stage_->Begin();
  }

  volume::Label LabelAt(double z_mm) const {
    if (z_mm < 0.0) return 0;
    if (z_mm < kLigamentMm) return volume::LabelOf("muscle");
    if (z_mm < kFatMm) return volume::LabelOf("ligament");
    // Voxels of muscle before and within the epidural fat, as coarse label maps have them.
    if (z_mm < kFatMm + muscle_before_fat_mm_) return volume::LabelOf("muscle");
    if (z_mm > kFatMm + 0.2 && z_mm < kFatMm + 0.4) return volume::LabelOf("muscle");
    return volume::LabelOf(z_mm < kCanalMm ? "fat" : "spinal_canal");
  }

  /// One sample at 1 kHz, with the tip at a depth.
  Activity Step(double z_mm) {
    breathing::ToolAtRest needle;
    needle.ct_from_tool = Eigen::Translation3d(0.0, 0.0, z_mm) * turn_;
    const volume::Label label = LabelAt(z_mm);
    const double plunger_n = session_n_;
    PortValues ports;
    ports.Set(ports::kNeedle, &needle);
    ports.Set(ports::kTissue, &label);
    ports.Set(ports::kPlungerForce, &plunger_n);
    columns_.fill(0.0);
    return stage_->Step(state_, {.time_ns = 0, .session_s = 1e-3 * static_cast<double>(++steps_)},
                        ports, columns_);
  }
  void AdvanceTo(double z_mm, double mm_per_s = 4.0) {
    for (; z_mm_ < z_mm; z_mm_ += 1e-3 * mm_per_s) Step(z_mm_);
  }
  void Hold(double seconds) {
    for (int i = 0; i < static_cast<int>(1000.0 * seconds); ++i) Step(z_mm_);
  }
  void MoveTo(double z_mm) { z_mm_ = z_mm; }
  void PutMuscleBeforeFat(double mm) { muscle_before_fat_mm_ = mm; }
  void Turn(const Eigen::Quaterniond& turn) { turn_ = turn; }
  void PressBySession(double force_n) { session_n_ = force_n; }

  double Column(FluidColumn column) const { return columns_[static_cast<std::size_t>(column)]; }
  const FluidStage& stage() const { return *stage_; }
  const FluidStageState& state() const { return state_; }
  double z_mm() const { return z_mm_; }

 private:
  std::optional<FluidStage> stage_;
  FluidStageState state_;
  std::array<double, static_cast<std::size_t>(FluidColumn::kCount)> columns_{};
  double z_mm_ = -2.0;
  double session_n_ = 0.0;
  double muscle_before_fat_mm_ = 0.0;
  Eigen::Quaterniond turn_ = Eigen::Quaterniond::Identity();
  int steps_ = 0;
};

TEST(FluidStage, ResistanceIsLostBehindTheLigamentAndTheDuraComesLater) {
  Puncture puncture(10.0);
  puncture.AdvanceTo(Puncture::kLigamentMm - 0.1);
  EXPECT_EQ(puncture.Column(FluidColumn::kPlungerN), 0.0);  // The thumb waits for the ligament.
  puncture.AdvanceTo(Puncture::kFatMm - 0.1);
  const double in_ligament_kpa = puncture.Column(FluidColumn::kSyringeKpa);
  EXPECT_GT(in_ligament_kpa, 20.0);
  EXPECT_EQ(puncture.Column(FluidColumn::kLosses), 0.0);
  EXPECT_EQ(puncture.Column(FluidColumn::kFalseLosses), 0.0);
  puncture.AdvanceTo(Puncture::kFatMm + 3.0);
  EXPECT_EQ(puncture.Column(FluidColumn::kLosses), 1.0);
  EXPECT_EQ(puncture.Column(FluidColumn::kFalseLosses), 0.0);
  EXPECT_LT(puncture.Column(FluidColumn::kSyringeKpa), 0.3 * in_ligament_kpa);
  // The loss is noticed within a millimetre of 4 mm/s.
  const double beyond_mm = puncture.Column(FluidColumn::kBeyondLossMm);
  EXPECT_GT(beyond_mm, 2.0);
  EXPECT_LE(beyond_mm, 3.0);
  EXPECT_EQ(puncture.Column(FluidColumn::kDuralPunctures), 0.0);
  puncture.AdvanceTo(Puncture::kFatMm + 6.0);
  EXPECT_EQ(puncture.Column(FluidColumn::kDuralPunctures), 1.0);
  // The thumb has let go after 1 ml.
  EXPECT_EQ(puncture.Column(FluidColumn::kPlungerN), 0.0);
}

// Between ligament and fat of a coarse label map there may be voxels of muscle.
TEST(FluidStage, ResistanceIsLostInTheEpiduralSpaceBehindVoxelsOfMuscle) {
  Puncture puncture(10.0);
  puncture.PutMuscleBeforeFat(1.0);
  puncture.AdvanceTo(Puncture::kFatMm + 1.9, 1.5);
  EXPECT_EQ(puncture.Column(FluidColumn::kLosses), 1.0);
  EXPECT_EQ(puncture.Column(FluidColumn::kFalseLosses), 0.0);
}

TEST(FluidStage, TheOtherHandHoldsWhatTheThumbPresses) {
  Puncture puncture(12.0);
  puncture.AdvanceTo(Puncture::kLigamentMm + 2.0);
  puncture.Hold(4.0);
  const Vector3d force_n = puncture.stage().ForceInCtN(puncture.state());
  EXPECT_NEAR(force_n.z(), 12.0, 0.5);  // The plunger hardly moves in the ligament.
  EXPECT_EQ(force_n.head<2>().norm(), 0.0);
}

TEST(FluidStage, DoesNothingOutsideWithoutAThumb) {
  Puncture puncture(12.0, Thumb::kSession);
  EXPECT_EQ(puncture.Step(-1.0), Activity::kIdle);
  puncture.Hold(0.2);
  EXPECT_EQ(puncture.stage().ForceInCtN(puncture.state()).norm(), 0.0);
  EXPECT_FALSE(puncture.stage().ChangesEcho(puncture.state()));
  const Vector3d place(1.0, 2.0, 3.0);
  EXPECT_EQ(puncture.stage().RestInCtMm(puncture.state(), place), place);
}

TEST(FluidStage, TheThumbOfTheSessionInjects) {
  Puncture puncture(0.0, Thumb::kSession);
  puncture.AdvanceTo(Puncture::kFatMm + 1.0);
  EXPECT_EQ(puncture.Column(FluidColumn::kPlungerN), 0.0);
  puncture.PressBySession(15.0);
  puncture.Hold(2.0);
  EXPECT_EQ(puncture.Column(FluidColumn::kPlungerN), 15.0);
  EXPECT_GT(puncture.Column(FluidColumn::kInjectedMl), 1.0);
}

TEST(FluidStage, CerebrospinalFluidDripsOnceTheStyletIsRemoved) {
  Puncture puncture(0.0, Thumb::kSession, fluid::Hub::kStylet);
  puncture.AdvanceTo(Puncture::kCanalMm + 8.0, 40.0);
  puncture.Hold(2.0);
  EXPECT_EQ(puncture.Column(FluidColumn::kReturnedMl), 0.0);
  EXPECT_EQ(puncture.Column(FluidColumn::kStyletRemovals), 0.0);
  puncture.PressBySession(-2.0);
  puncture.Hold(5.0);
  const double returned_ml = puncture.Column(FluidColumn::kReturnedMl);
  EXPECT_GT(returned_ml, 0.5);
  EXPECT_GT(puncture.Column(FluidColumn::kDropsPerMin), 60.0);
  // What is not at the hub yet is in the needle.
  EXPECT_NEAR(-puncture.Column(FluidColumn::kSpaceMl), returned_ml, 0.1);
  EXPECT_GE(-puncture.Column(FluidColumn::kSpaceMl), returned_ml);
  EXPECT_EQ(puncture.Column(FluidColumn::kStyletRemovals), 1.0);
  EXPECT_EQ(puncture.Column(FluidColumn::kAspiratedMl), 0.0);
  // Back in place, the stylet empties the needle and nothing runs any more.
  puncture.PressBySession(2.0);
  puncture.Hold(0.1);
  const double in_all_ml = puncture.Column(FluidColumn::kReturnedMl);
  puncture.Hold(2.0);
  EXPECT_EQ(puncture.Column(FluidColumn::kReturnedMl), in_all_ml);
  EXPECT_EQ(puncture.Column(FluidColumn::kStyletRemovals), 1.0);
}

TEST(FluidStage, NothingRunsFromTheHubInTheLigament) {
  Puncture puncture(0.0, Thumb::kSession, fluid::Hub::kStylet);
  puncture.AdvanceTo(Puncture::kLigamentMm + 2.0, 40.0);
  puncture.PressBySession(-2.0);
  puncture.Hold(3.0);
  EXPECT_EQ(puncture.Column(FluidColumn::kStyletRemovals), 1.0);
  EXPECT_EQ(puncture.Column(FluidColumn::kReturnedMl), 0.0);
  EXPECT_EQ(puncture.Column(FluidColumn::kSpaceMl), 0.0);
}

TEST(FluidStage, APulledPlungerAspirates) {
  Puncture puncture(0.0, Thumb::kSession);
  puncture.AdvanceTo(Puncture::kCanalMm + 8.0, 40.0);
  puncture.PressBySession(-8.0);
  puncture.Hold(3.0);
  const double aspirated_ml = puncture.Column(FluidColumn::kAspiratedMl);
  EXPECT_GT(aspirated_ml, 1.0);
  EXPECT_NEAR(-puncture.Column(FluidColumn::kSpaceMl), aspirated_ml, 1e-3);
  EXPECT_EQ(puncture.Column(FluidColumn::kReturnedMl), 0.0);
}

TEST(FluidStage, TapsLeaveThePlungerBetweenThem) {
  Puncture puncture(10.0, Thumb::kTaps);
  puncture.AdvanceTo(Puncture::kLigamentMm + 1.0);
  int pressed = 0;
  for (int i = 0; i < 1000; ++i) {
    puncture.Step(Puncture::kLigamentMm + 1.0);
    pressed += puncture.Column(FluidColumn::kPlungerN) > 0.0 ? 1 : 0;
  }
  EXPECT_NEAR(pressed, 400, 2);
}

TEST(FluidStage, ADepotIsDarkEnhancesWhatIsBehindAndDisplacesTissueByItsVolume) {
  Puncture puncture(0.0, Thumb::kSession);
  puncture.AdvanceTo(Puncture::kFatMm + 1.0);
  puncture.PressBySession(15.0);
  puncture.Hold(4.0);
  const FluidStageState& state = puncture.state();
  const FluidStage& stage = puncture.stage();
  ASSERT_EQ(state.num_depots, 1);
  const ShownDepot& depot = state.depot[0];
  const Vector3d centre_mm = Vector3d::Map(depot.centre_in_ct_mm.data());
  const auto change_db = [&](const Vector3d& place_mm) {
    return stage.EchoChangeDb(state, {.place_in_ct_mm = place_mm,
                                      .beam_in_ct = Vector3d::UnitX(),
                                      .depth_mm = 50.0,
                                      .frequency_mhz = 5.0});
  };
  EXPECT_LT(change_db(centre_mm), -20.0);
  const double beyond_mm = depot.width_radius_mm + 3.0;
  EXPECT_GT(change_db(centre_mm + beyond_mm * Vector3d::UnitX()), 0.5);  // Behind it.
  EXPECT_EQ(change_db(centre_mm - beyond_mm * Vector3d::UnitX()), 0.0);  // Before it.
  EXPECT_EQ(change_db(centre_mm + beyond_mm * Vector3d::UnitY()), 0.0);  // Beside it.

  // What lies within an ellipsoid beyond the depot, of its shape, is its volume less.
  const double r_mm = depot.width_radius_mm + 5.0;
  const Vector3d rest_mm = stage.RestInCtMm(state, centre_mm + r_mm * Vector3d::UnitY());
  const double rest_r_mm = (rest_mm - centre_mm).norm();
  const double injected_mm3 = 1000.0 * state.injected_ml;
  const double flatness = depot.thickness_radius_mm / depot.width_radius_mm;
  const double displaced_mm3 =
      4.0 / 3.0 * M_PI * flatness * (std::pow(r_mm, 3) - std::pow(rest_r_mm, 3));
  EXPECT_GT(injected_mm3, 500.0);
  EXPECT_NEAR(displaced_mm3, injected_mm3, 0.1 * injected_mm3);  // Some is absorbed meanwhile.
  // A flat depot opens its layers and hardly moves what is some millimetres above and below it.
  const Vector3d above_mm = centre_mm + 2.0 * depot.width_radius_mm * Vector3d::UnitZ();
  EXPECT_LT((stage.RestInCtMm(state, above_mm) - above_mm).norm(), 0.1);
}

// Layers of a depot are those that the needle met there, whatever is injected elsewhere later.
TEST(FluidStage, EachDepotKeepsItsNormal) {
  Puncture puncture(0.0, Thumb::kSession);
  puncture.AdvanceTo(Puncture::kFatMm + 1.0);
  puncture.PressBySession(40.0);
  puncture.Hold(0.3);  // Fat takes the syringe's content in a second.
  ASSERT_EQ(puncture.state().num_depots, 1);
  const ShownDepot in_fat = puncture.state().depot[0];
  puncture.PressBySession(0.0);
  puncture.Turn(Eigen::Quaterniond(Eigen::AngleAxisd(1.2, Vector3d::UnitX())));
  puncture.MoveTo(10.0);
  puncture.PressBySession(40.0);
  puncture.Hold(10.0);
  ASSERT_EQ(puncture.state().num_depots, 2);
  for (const ShownDepot& depot : {puncture.state().depot[0], puncture.state().depot[1]}) {
    EXPECT_EQ(depot.normal_in_ct == in_fat.normal_in_ct, depot.row == in_fat.row);
  }
}

}  // namespace
}  // namespace acus::effects
