#include "acus/imaging/ultrasound/beams/beam_tracer.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "acus/base/core/error.h"
#include "acus/imaging/acoustics/beam_width.h"

namespace acus::ultrasound {
namespace {

/// A CT blurs the skin over this: with gel on it there is no slope from air up to skin.
constexpr double kSkinBlurMm = 2.0;
/// Changes of zeta that are flatter than this are no interface.
constexpr double kFlattestPerMm = 0.01;
constexpr std::size_t kEchoesPerLane = 192;

std::size_t Slot(int n) {
  return static_cast<std::size_t>(n);
}

}  // namespace

BeamTracer::BeamTracer(const BeamTissue& tissue, const BeamOptions& options,
                       const BeamMaterials& materials, const BeamFilter& filter,
                       const acoustics::ScanGrid& grid, const Eigen::Matrix3d& lattice_from_index)
    : tissue_(tissue),
      options_(options),
      materials_(materials),
      filter_(filter),
      grid_(grid),
      normals_(tissue),
      lattice_from_index_(lattice_from_index.cast<float>()),
      spacing_mm_(
          (tissue.labels != nullptr ? tissue.labels->geometry : tissue.ct->geometry).spacing_mm),
      marched_(options.time_of_flight || options.refraction),
      fibres_(!materials.fibres().empty()) {
  if (tissue.ct != nullptr) {
    sampler_.emplace(*tissue.ct);
    ct_ = sampler_->Voxels(tissue.labels == nullptr ? slicing::CtSampler::kNotScanned
                                                    : slicing::CtSampler::kOutsideHu);
  }
  if (tissue.labels != nullptr) {
    const auto& size = tissue.labels->geometry.size;
    labels_ = {.data = tissue.labels->voxels.data(),
               .last_word = static_cast<std::int32_t>(tissue.labels->voxels.size()) - 4,
               .edge = {static_cast<float>(size[0]) - 0.5F, static_cast<float>(size[1]) - 0.5F,
                        static_cast<float>(size[2]) - 0.5F},
               .row_bytes = size[0],
               .slice_bytes = size[0] * size[1]};
  }
  strong_transmission_ = std::pow(10.0, options.strong_transmission_db / 20.0);
  gel_samples_ = static_cast<int>(options.coupling_gap_mm / grid.step_mm + 1e-9);
  skin_samples_ = tissue.labels != nullptr ? 0 : static_cast<int>(kSkinBlurMm / grid.step_mm);
  min_step_ = static_cast<float>(kFlattestPerMm * grid.step_mm);
  min_run_ = static_cast<float>(tissue.labels != nullptr && tissue.ct == nullptr
                                    ? 1e-5
                                    : std::atanh(options.smallest_reflection));
  work_.resize(Slot((grid.lines() + kLanesPerBlock - 1) / kLanesPerBlock));
  for (Work& work : work_) work.echoes.reserve(kEchoesPerLane * kLanesPerBlock);
}

void BeamTracer::TraceBlock(const std::vector<ElevationPlane>& planes, const BeamNeedle& needle,
                            int block, ComplexBeams& out) {
  const int first = block * kLanesPerBlock;
  const int lanes = std::min(kLanesPerBlock, slicing::kernels::RoundUp(grid_.lines()) - first);
  Work& work = work_[Slot(block)];
  work.echoes.clear();
  for (std::size_t p = 0; p < planes.size(); ++p) {
    Pass pass{.work = work,
              .path = planes[p].path,
              .out = out,
              .mark = needle.begin(block),
              .last_mark = needle.end(block),
              .ring_samples = needle.ring_samples(),
              .first = first,
              .lanes = lanes,
              .weight = planes[p].weight,
              .speckle_weight = planes[p].speckle_weight,
              .add = p > 0};
    TracePlane(pass);
  }
  Pass pass{.work = work,
            .path = planes[0].path,
            .out = out,
            .mark = nullptr,
            .last_mark = nullptr,
            .ring_samples = 0.0,
            .first = first,
            .lanes = lanes,
            .weight = 1.0,
            .speckle_weight = 1.0,
            .add = true};
  PutEchoes(pass);
}

void BeamTracer::TracePlane(Pass& pass) {
  Work& work = pass.work;
  std::fill_n(work.energy[0], kLanesPerBlock, 1.0F);
  std::fill_n(work.moment, kLanesPerBlock, 0.0F);
  std::fill_n(work.quiet_until, kLanesPerBlock, 1);
  std::fill_n(work.dry, kLanesPerBlock, true);
  std::fill_n(work.entered, kLanesPerBlock, 0);
  work.all_entered = false;
  std::fill_n(work.outside, kLanesPerBlock, 0);
  std::fill_n(work.strong_count, kLanesPerBlock, 0);
  if (marched_) work.march.Start();
  for (int k = 0; k < grid_.samples; ++k) {
    PlaceSample(pass, k);
    const bool outside = SampleTissue(pass, k);
    if (k <= gel_samples_ + skin_samples_) MeetSkin(work, k);
    if (outside) EndOfScan(work, k);
    if (fibres_) FollowFibres(pass, k);
    bool any = false;
    if (options_.interfaces) {
      any = kernels::FindInterfacesRow({.log_impedance = work.log_impedance,
                                        .previous = work.previous,
                                        .start = work.start,
                                        .moment = work.moment,
                                        .run = work.run,
                                        .place = work.place,
                                        .k = static_cast<float>(k),
                                        .min_step = min_step_,
                                        .min_run = min_run_},
                                       pass.lanes);
    }
    const float* energy = work.energy[k % kRing];
    float* after = work.energy[(k + 1) % kRing];
    float* re = pass.out.re.row(k) + pass.first;
    float* im = pass.out.im.row(k) + pass.first;
    if (options_.speckle) {
      const auto weight = static_cast<float>(pass.speckle_weight);
      kernels::SpeckleRow row{.lattice = pass.lattice,
                              .scatter = work.scatter,
                              .decay = work.decay,
                              .energy = energy,
                              .energy_after = after,
                              .gain = filter_.SpeckleGain(k) * weight,
                              .re = re,
                              .im = im};
      filter_.look().Set(k, pass.first, row);
      kernels::SpeckleEchoRow(row, pass.s, pass.lanes, pass.add);
    } else {
      if (!pass.add) {
        std::fill_n(re, pass.lanes, 0.0F);
        std::fill_n(im, pass.lanes, 0.0F);
      }
      kernels::DecayRow(energy, work.decay, pass.lanes, after);
    }
    if (marched_) GoOn(pass, k);
    if (any) AnswerInterfaces(pass, k);
    AnswerNeedle(pass, k);
  }
}

void BeamTracer::PlaceSample(Pass& pass, int k) const {
  if (marched_) {
    pass.work.march.Place(pass.path, lattice_from_index_, pass.first, pass.lanes);
    pass.voxels = pass.work.march.Voxels();
    pass.lattice = pass.work.march.Lattice();
    pass.s = 0.0F;
    return;
  }
  const int piece = pass.path.PieceAt(k);
  pass.voxels = pass.path.Voxels(piece, pass.first);
  pass.lattice = pass.path.Lattice(piece, pass.first);
  pass.s = static_cast<float>(k);
}

void BeamTracer::GoOn(Pass& pass, int k) const {
  Work& work = pass.work;
  if (!options_.time_of_flight) {
    std::fill_n(work.speed_ratio, pass.lanes, 1.0F);
  } else {
    for (int l = 0; l < pass.lanes; ++l) {
      const int label = tissue_.labels != nullptr ? work.label[k % kRing][l] : 0;
      const bool by_hu = tissue_.ct != nullptr && label == 0;
      const double speed =
          by_hu ? materials_.SpeedAtHu(work.value[k % kRing][l]) : materials_.SpeedAtLabel(label);
      work.speed_ratio[l] = static_cast<float>(speed / acoustics::kScannerSpeedMPerS);
    }
  }
  work.march.Advance(work.speed_ratio, pass.lanes);
}

bool BeamTracer::FillOutside(Work& work, int k) const {
  float* hu = work.value[k % kRing];
  std::int32_t* label = work.label[k % kRing];
  std::int32_t any = 0;
  if (tissue_.labels != nullptr) {
    for (int l = 0; l < kLanesPerBlock; ++l) any |= label[l] & kernels::kNotScannedLabel;
    any = any < 0 ? 1 : 0;  // Labels are not negative.
  } else {
    for (int l = 0; l < kLanesPerBlock; ++l) {
      any |= hu[l] == slicing::CtSampler::kNotScanned ? 1 : 0;
    }
  }
  if (any == 0 && work.all_entered) return false;  // Most samples.
  work.all_entered = any == 0;
  for (int l = 0; l < kLanesPerBlock; ++l) {
    std::int32_t outside = 0;
    if (tissue_.labels != nullptr) {
      outside = label[l] == kernels::kNotScannedLabel ? 1 : 0;
      label[l] = outside != 0 ? 0 : label[l];
    } else {
      outside = hu[l] == slicing::CtSampler::kNotScanned ? 1 : 0;
      hu[l] = outside != 0 ? slicing::CtSampler::kOutsideHu : hu[l];
    }
    work.outside[l] = outside;
    work.entered[l] |= 1 - outside;
  }
  return any != 0;
}

void BeamTracer::EndOfScan(Work& work, int k) const {
  for (int l = 0; l < kLanesPerBlock; ++l) {
    const bool may_enter = work.entered[l] == 0 && k <= gel_samples_ + skin_samples_;
    if (work.outside[l] == 0 || may_enter) continue;
    work.energy[k % kRing][l] = 0.0F;
    work.scatter[l] = 0.0F;
    work.previous[l] = work.start[l] = work.log_impedance[l];
    work.moment[l] = 0.0F;
  }
}

bool BeamTracer::SampleTissue(Pass& pass, int k) {
  Work& work = pass.work;
  const kernels::TissueRow tissue{work.log_impedance, work.decay, work.scatter};
  float* hu = work.value[k % kRing];
  std::int32_t* label = work.label[k % kRing];
  if (tissue_.labels == nullptr) {
    slicing::kernels::SampleRow(ct_, pass.voxels, pass.s, pass.lanes, hu);
    const bool outside = FillOutside(work, k);
    kernels::TissueOfHuRow(materials_.hu_curves(), hu, pass.lanes, tissue);
    return outside;
  }
  kernels::LabelRow(labels_, pass.voxels, pass.s, pass.lanes, label);
  const bool outside = FillOutside(work, k);
  kernels::TissueOfLabelRow(materials_.label_tables(), label, pass.lanes, tissue);
  if (tissue_.ct == nullptr) return outside;
  if (std::find(label, label + pass.lanes, 0) == label + pass.lanes) return outside;
  slicing::kernels::SampleRow(ct_, pass.voxels, pass.s, pass.lanes, hu);
  const kernels::TissueRow of_hu{work.of_hu[0], work.of_hu[1], work.of_hu[2]};
  kernels::TissueOfHuRow(materials_.hu_curves(), hu, pass.lanes, of_hu);
  kernels::FillUnlabelledRow(label, of_hu, pass.lanes, tissue);
  return outside;
}

void BeamTracer::MeetSkin(Work& work, int k) const {
  for (int l = 0; l < kLanesPerBlock; ++l) {
    const bool air = work.log_impedance[l] < kAirLogImpedance;
    if (work.dry[l] && air) {
      // Gel fills a gap; a face that sees nothing but air radiates nothing into the body.
      work.scatter[l] = 0.0F;
      work.decay[l] = 1.0F;
      work.quiet_until[l] = k + 2;
      if (k >= gel_samples_) {
        work.energy[k % kRing][l] = 0.0F;
        work.dry[l] = false;
      }
    } else if (work.dry[l]) {
      work.dry[l] = false;
      work.quiet_until[l] = k > 0 ? k + 1 + skin_samples_ : 1;
    }
    if (k < work.quiet_until[l]) {
      work.previous[l] = work.start[l] = work.log_impedance[l];
      work.moment[l] = 0.0F;
    }
  }
}

void BeamTracer::FollowFibres(Pass& pass, int k) const {
  Work& work = pass.work;
  const slicing::kernels::Lines straight = pass.lattice;
  const std::int32_t* label = work.label[k % kRing];
  bool stretched = false;
  for (const FibreLabel& fibre : materials_.fibres()) {
    if (std::find(label, label + pass.lanes, fibre.label) == label + pass.lanes) continue;
    if (!stretched) {
      stretched = true;
      for (int a = 0; a < 3; ++a) {
        std::copy_n(straight.start[a], pass.lanes, work.lattice[2 * a]);
        std::copy_n(straight.step[a], pass.lanes, work.lattice[2 * a + 1]);
        pass.lattice.start[a] = work.lattice[2 * a];
        pass.lattice.step[a] = work.lattice[2 * a + 1];
      }
    }
    const Eigen::Vector3f grain = fibre.grain_in_lattice.cast<float>();
    const Eigen::Vector3f dual = fibre.dual_in_lattice.cast<float>();
    const auto shrink = static_cast<float>(1.0 / fibre.ratio - 1.0);
    const auto grains_per_step = static_cast<float>(filter_.grain_mm() / grid_.step_mm);
    for (int l = 0; l < pass.lanes; ++l) {
      if (label[l] != fibre.label) continue;
      const Eigen::Vector3f step(straight.step[0][l], straight.step[1][l], straight.step[2][l]);
      const Eigen::Vector3f start(straight.start[0][l], straight.start[1][l], straight.start[2][l]);
      const float cosine = dual.dot(step) * grains_per_step;
      work.decay[l] *=
          std::exp(static_cast<float>(-fibre.extra_nepers_per_sample) * cosine * cosine);
      for (int a = 0; a < 3; ++a) {
        work.lattice[2 * a][l] += shrink * dual.dot(start) * grain[a];
        work.lattice[2 * a + 1][l] += shrink * dual.dot(step) * grain[a];
      }
    }
  }
}

}  // namespace acus::ultrasound
