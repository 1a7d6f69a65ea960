#include "acus/imaging/ultrasound/aperture/aperture_field.h"

#include <algorithm>
#include <cmath>

#include "acus/base/core/parallel.h"
#include "acus/imaging/ultrasound/aperture/aperture_kernels.h"

namespace acus::ultrasound {

ApertureField::ApertureField(const ApertureRays& rays, int lines, int rows,
                             const SteeredRays* steered)
    : rays_(rays),
      steered_(steered),
      lines_(lines),
      rows_(rows),
      margin_(
          kernels::RoundUp(static_cast<int>(std::ceil(rays.MostLines())) + 2 * kernels::kBlock)),
      stride_(kernels::RoundUp(lines) + 2 * margin_) {
  left_.Reserve(static_cast<std::size_t>(stride_) * static_cast<std::size_t>(rows));
  for (int g = 0; g < kGroups; ++g) {
    ray_[g].Reserve(static_cast<std::size_t>(
        std::max<std::ptrdiff_t>(stride_, steered != nullptr ? steered->rays() : 0)));
    sum_[g].Resize(lines, rows);
  }
  arriving_.Resize(lines, rows);
}

void ApertureField::FillMargins(float* row) const {
  std::fill(row - margin_, row, row[0]);
  std::fill(row + lines_, row - margin_ + stride_, row[lines_ - 1]);
}

void ApertureField::MarchSteered(int group, const std::vector<float>& contact) {
  const auto between = [](const float* row, float place, int last) {
    const int low = std::min(static_cast<int>(place), last - 1);
    return row[low] + (place - static_cast<float>(low)) * (row[low + 1] - row[low]);
  };
  const int lanes = kernels::RoundUp(lines_);
  float* const ray = ray_[group].data();
  for (int k = 0; k < rows_; ++k) std::fill_n(sum_[group].row(k), lanes, 0.0F);
  for (int d = group; d < steered_->directions(); d += kGroups) {
    for (int r = 0; r < steered_->rays(); ++r) {
      ray[r] = contact[static_cast<std::size_t>(std::clamp(r + steered_->first(), 0, lines_ - 1))];
    }
    for (int k = 0; k < rows_; ++k) {
      if (!steered_->Reached(d, k)) continue;
      const float* loss = left(k);
      const float* line = steered_->LineOfRay(d, k);
      for (int r = 0; r < steered_->rays(); ++r) ray[r] *= between(loss, line[r], lines_ - 1);
      const float weight = steered_->Weight(d, k);
      if (weight == 0.0F) continue;
      const float* from = steered_->RayOfLine(d, k);
      float* out = sum_[group].row(k);
      for (int l = 0; l < lines_; ++l) {
        out[l] += weight * between(ray, from[l], steered_->rays() - 1);
      }
    }
  }
}

void ApertureField::MarchGroup(int group, const std::vector<float>& contact) {
  const int lanes = kernels::RoundUp(lines_);
  float* const ray = ray_[group].data() + margin_;
  slicing::BeamImage& sum = sum_[group];
  for (int k = 0; k < rows_; ++k) std::fill_n(sum.row(k), lanes, 0.0F);
  for (int d = group; d < rays_.directions(); d += kGroups) {
    std::copy_n(contact.begin(), lines_, ray);
    FillMargins(ray);
    for (int k = 0; k <= rays_.LastRow(d); ++k) {
      kernels::MarchRayRow({.left = left_.data() + k * stride_ + margin_,
                            .ray = ray,
                            .arriving = sum.row(k),
                            .shift = rays_.ShiftLines(d, k),
                            .weight = rays_.Weight(d, k),
                            .margin = static_cast<int>(margin_)},
                           lanes);
    }
  }
}

void ApertureField::March(const std::vector<float>& contact, int num_threads) {
  for (int k = 0; k < rows_; ++k) FillMargins(left(k));
  ParallelFor(kGroups, num_threads, [&](int group) {
    if (steered_ != nullptr) {
      MarchSteered(group, contact);
    } else {
      MarchGroup(group, contact);
    }
  });
  const int lanes = kernels::RoundUp(lines_);
  for (int k = 0; k < rows_; ++k) {
    float* out = arriving_.row(k);
    const float* a = sum_[0].row(k);
    const float* b = sum_[1].row(k);
    const float* c = sum_[2].row(k);
    for (int l = 0; l < lanes; ++l) {
      const float one_way = a[l] + b[l] + c[l];
      out[l] = one_way * one_way;
    }
    if (steered_ == nullptr) continue;
    for (int l = 0; l < lines_; ++l) out[l] *= steered_->Directivity(l);
  }
}

void ApertureField::Scale(int row, const float* factor) {
  float* out = arriving_.row(row);
  for (int l = 0; l < lines_; ++l) out[l] *= factor[l];
}

}  // namespace acus::ultrasound
