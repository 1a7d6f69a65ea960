#include "acus/imaging/ultrasound/aperture/aperture_field.h"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

#include "support/beam_targets.h"

namespace acus::ultrasound {
namespace {

using testing_support::TargetProbe;

acoustics::Probe ApertureTestFan() {
  acoustics::Probe probe = TargetProbe();
  probe.kind = acoustics::ProbeKind::kCurvilinear;
  probe.radius_mm = 50.0;
  probe.field_of_view_rad = 1.0;
  probe.depth_mm = 120.0;
  probe.focus_mm = 60.0;
  return probe;
}

/// Amplitude at row `at`, in the middle, under a plate that lets nothing through.
/// @param half_lines  Half its width.
float ApertureUnderPlate(const acoustics::Probe& probe, int directions, int plate_row,
                         int half_lines, int at) {
  const acoustics::ScanGrid grid = acoustics::BeamGridOf(probe);
  const ApertureRays rays(probe, grid, directions);
  ApertureField field(rays, grid.lines(), grid.samples);
  const int middle = grid.lines() / 2;
  for (int k = 0; k < grid.samples; ++k) {
    for (int l = 0; l < grid.lines(); ++l) {
      field.left(k)[l] = k == plate_row && std::abs(l - middle) <= half_lines ? 0.0F : 1.0F;
    }
  }
  field.March(std::vector<float>(static_cast<std::size_t>(grid.lines()) + 16, 1.0F), 1);
  return field.arriving(at)[middle];
}

TEST(ApertureRays, InAFanTheyAreStraight) {
  const acoustics::Probe probe = ApertureTestFan();
  const acoustics::ScanGrid grid = acoustics::BeamGridOf(probe);
  const ApertureRays rays(probe, grid, 9);
  const double line_rad = probe.field_of_view_rad / (grid.lines() - 1);
  for (int d = 0; d < rays.directions(); ++d) {
    const auto place = [&](int k) {
      const double angle = rays.ShiftLines(d, k) * line_rad;
      const double radius = probe.radius_mm + k * grid.step_mm;
      return Eigen::Vector2d(radius * std::sin(angle), radius * std::cos(angle));
    };
    const Eigen::Vector2d start = place(0);
    const Eigen::Vector2d along = (place(grid.samples - 1) - start).normalized();
    for (int k = 1; k < grid.samples; k += 17) {
      const Eigen::Vector2d to = place(k) - start;
      EXPECT_NEAR(along.x() * to.y() - along.y() * to.x(), 0.0, 1e-3) << d << " " << k;
    }
  }
}

TEST(ApertureRays, SharesAddUpToOneAtEveryDepth) {
  for (const acoustics::Probe& probe : {TargetProbe(), ApertureTestFan()}) {
    const acoustics::ScanGrid grid = acoustics::BeamGridOf(probe);
    const ApertureRays rays(probe, grid, 13);
    for (int k = 0; k < grid.samples; ++k) {
      double sum = 0.0;
      for (int d = 0; d < rays.directions(); ++d) {
        sum += double{rays.Weight(d, k)};
        EXPECT_NEAR(double{rays.ShiftLines(d, k)},
                    -double{rays.ShiftLines(rays.directions() - 1 - d, k)}, 1e-4);
      }
      EXPECT_NEAR(sum, 1.0, 1e-5) << k;
    }
  }
}

TEST(ApertureField, NothingIsLostWithoutAnObstacle) {
  EXPECT_NEAR(ApertureUnderPlate(TargetProbe(), 9, 100, -1, 300), 1.0, 1e-5);
}

// A place at depth z sees elements at u, |u| <= a / 2 = z / (2 F), each along a straight way that
// passes depth d at u (1 - d / z). With the cosine apodisation, a plate of half width h at d leaves
// 1 - sin(pi h / (a (1 - d / z))) of the one-way amplitude, if that is not the whole aperture.
TEST(ApertureField, TheShadowOfANarrowPlateFillsInByTheClosedForm) {
  const acoustics::Probe probe = TargetProbe();  // Lines 0.2 mm apart, samples 0.1 mm, F-number 2.
  const int plate_row = 100;
  for (const int at : {200, 300, 400}) {
    const double aperture_mm = std::min(0.5 * at * 0.1, 25.6);
    for (const int half_lines : {2, 5, 10}) {
      const double half_mm = (half_lines + 0.5) * 0.2;
      const double blocked = half_mm / (aperture_mm * (1.0 - double{plate_row} / at));
      const double left = blocked < 0.5 ? 1.0 - std::sin(std::numbers::pi * blocked) : 0.0;
      EXPECT_NEAR(std::sqrt(ApertureUnderPlate(probe, 31, plate_row, half_lines, at)), left, 0.06)
          << at << " " << half_lines;
    }
  }
}

TEST(ApertureField, MoreRaysComeCloserToTheClosedForm) {
  const auto error = [](int directions) {
    double sum = 0.0;
    for (const int half_lines : {1, 2, 3, 4, 5, 6, 7, 8}) {
      const double blocked = (half_lines + 0.5) * 0.2 / (20.0 * 0.75);
      const double got =
          std::sqrt(ApertureUnderPlate(TargetProbe(), directions, 100, half_lines, 400));
      sum += std::abs(got - (1.0 - std::sin(std::numbers::pi * blocked)));
    }
    return sum / 8.0;
  };
  EXPECT_LT(error(31), 0.03);
  EXPECT_LT(error(31), error(5));
  EXPECT_LT(error(13), 0.06);
}

TEST(ApertureField, OneRaySeesAlongItsLineOnly) {
  EXPECT_EQ(ApertureUnderPlate(TargetProbe(), 1, 100, 0, 400), 0.0F);
}

acoustics::Probe ApertureTestSector() {
  acoustics::Probe probe = TargetProbe();
  probe.kind = acoustics::ProbeKind::kPhased;
  probe.frequency_mhz = 2.8;
  probe.elements = 80;
  probe.pitch_mm = 0.28;
  probe.width_mm = 22.4;
  probe.field_of_view_rad = 1.4;
  probe.scan_lines = 193;
  probe.depth_mm = 120.0;
  probe.focus_mm = 80.0;
  return probe;
}

// The path from u to (rho, theta) crosses a plate at a smaller range where straight lines do; w(u)
// is the cosine over the aperture of the F-number. Elements far from the middle see past it.
TEST(ApertureField, EverySteeredLineIsServedByAllElements) {
  const acoustics::Probe probe = ApertureTestSector();
  const acoustics::ScanGrid grid = acoustics::BeamGridOf(probe);
  const ApertureRays rays(probe, grid, 31);
  const SteeredRays steered(probe, grid, 31);
  const double line_rad = probe.field_of_view_rad / (grid.lines() - 1);
  constexpr int kPlateRow = 100;  // 30 mm.
  constexpr int kHalfLines = 8;
  for (const int plate_line : {96, 40, 150}) {
    ApertureField field(rays, grid.lines(), grid.samples, &steered);
    for (int k = 0; k < grid.samples; ++k) {
      for (int l = 0; l < grid.lines(); ++l) {
        field.left(k)[l] = k == kPlateRow && std::abs(l - plate_line) <= kHalfLines ? 0.0F : 1.0F;
      }
    }
    field.March(std::vector<float>(static_cast<std::size_t>(grid.lines()) + 16, 1.0F), 1);
    const double plate_rad = (plate_line - 96) * line_rad;
    for (const int row : {200, 300, 400}) {
      for (const int beside : {0, 6, 12}) {
        const int line = plate_line + beside;
        const double theta = (line - 96) * line_rad;
        const double rho = row * grid.step_mm;
        const double plate_mm = kPlateRow * grid.step_mm;
        const double half_mm = std::min(rho / probe.f_number, 22.4) / 2.0;
        double sum = 0.0;
        double left = 0.0;
        for (double u = -half_mm; u <= half_mm; u += half_mm / 2000.0) {
          const Eigen::Vector2d from(u, 0.0);
          const Eigen::Vector2d way =
              Eigen::Vector2d(rho * std::sin(theta), rho * std::cos(theta)) - from;
          // |from + t way| = plate_mm
          const double a = way.squaredNorm();
          const double b = from.dot(way);
          const double t = (-b + std::sqrt(b * b - a * (u * u - plate_mm * plate_mm))) / a;
          const Eigen::Vector2d at = from + t * way;
          const double weight = std::cos(0.5 * std::numbers::pi * u / half_mm);
          sum += weight;
          const double off = std::abs(std::atan2(at.x(), at.y()) - plate_rad);
          if (off > (kHalfLines + 0.5) * line_rad) left += weight;
        }
        const double got =
            std::sqrt(double{field.arriving(row)[line]} / double{steered.Directivity(line)});
        EXPECT_NEAR(got, left / sum, 0.06) << plate_line << " " << row << " " << beside;
      }
    }
  }
}

TEST(ApertureField, SteeringWeakensByTheElementsDirectivity) {
  const acoustics::Probe probe = ApertureTestSector();
  const acoustics::ScanGrid grid = acoustics::BeamGridOf(probe);
  const ApertureRays rays(probe, grid, 13);
  const SteeredRays steered(probe, grid, 13);
  ApertureField field(rays, grid.lines(), grid.samples, &steered);
  for (int k = 0; k < grid.samples; ++k) std::fill_n(field.left(k), grid.lines(), 1.0F);
  field.March(std::vector<float>(static_cast<std::size_t>(grid.lines()) + 16, 1.0F), 2);
  for (int line = 0; line < grid.lines(); line += 16) {
    const double sine = std::sin(probe.field_of_view_rad * (line / 192.0 - 0.5));
    const double x = std::numbers::pi * 0.9 * 0.28 / 0.55 * sine;
    const double piston = (x == 0.0 ? 1.0 : std::sin(x) / x) * std::sqrt(1.0 - sine * sine);
    for (const int row : {30, 200, 400}) {
      EXPECT_NEAR(double{field.arriving(row)[line]}, piston * piston, 1e-4) << line;
    }
  }
}

TEST(ApertureField, SameBitsWithAnyNumberOfThreads) {
  const acoustics::Probe probe = ApertureTestFan();
  const acoustics::ScanGrid grid = acoustics::BeamGridOf(probe);
  const ApertureRays rays(probe, grid, 13);
  std::vector<float> first;
  for (const int threads : {1, 2, 4}) {
    ApertureField field(rays, grid.lines(), grid.samples);
    std::vector<float> contact(static_cast<std::size_t>(grid.lines()) + 16, 1.0F);
    for (std::size_t l = 20; l < 40; ++l) contact[l] = 0.0F;
    for (int k = 0; k < grid.samples; ++k) {
      for (int l = 0; l < grid.lines(); ++l) {
        field.left(k)[l] = 0.99F + 0.01F * std::sin(static_cast<float>(k * l));
      }
    }
    field.March(contact, threads);
    std::vector<float> all;
    for (int k = 0; k < grid.samples; ++k) {
      all.insert(all.end(), field.arriving(k), field.arriving(k) + grid.lines());
    }
    if (first.empty()) first = all;
    EXPECT_EQ(all, first) << threads;
  }
}

}  // namespace
}  // namespace acus::ultrasound
