// The scene of 7,864,320 triangles of Alamilla-2021: images by rays against triangles beside those
// by voxels. Run: build/tests/bench_surfaces [LEVELS [FOLDER]]. Table: docs/models/surfaces.md.
// The deformed image by voxels of 1 and 0.5 mm and by triangles goes into the folder.
// Exit code 1 if labels are not those of the closed form.
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <utility>
#include <vector>

#include "acus/base/config/json_file.h"
#include "acus/base/core/cpu_time.h"
#include "acus/data/image/png.h"
#include "acus/imaging/slicing/tracing/beam_labels.h"
#include "acus/imaging/ultrasound/columns/alamilla.h"
#include "benchmarks/bumpy_balls.h"
#include "support/paired_times.h"

namespace acus::benchmarks {
namespace {

using testing_support::LeastTime;

constexpr int kRounds = 100;

/// The least of all rounds: CPU time with one thread, wall time with two.
struct ImageTimes {
  LeastTime one;
  LeastTime two;

  template <typename Render>
  void Add(Render&& render) {
    one.Add([&] { render(1); });
    two.Add([&] { render(2); });
  }
  void Print(const char* what) const {
    std::printf("%-44s %8.2f %8.2f\n", what, one.cpu_ms, two.wall_ms);
  }
};

/// Labels alone, without what the image makes of them.
class LabelsOnly {
 public:
  LabelsOnly(const tracing::SurfaceTracer& tracer, const slicing::RestMap* rest)
      : labels_(tracer, ct_from_index_), grid_(acoustics::ScanGridOf(BumpyBalls::Probe())) {
    slicing::PlaceLines(grid_, ct_from_index_.inverse(), BumpyBalls::CtFromProbe(), lines_);
    bend_.Set(grid_, BumpyBalls::CtFromProbe(), ct_from_index_.inverse(), rest);
    label_.Resize(grid_.lines(), grid_.samples);
  }
  void operator()(int num_threads) { labels_.Fill(lines_, bend_, num_threads, label_); }
  std::size_t num_pieces() const { return labels_.num_pieces(); }

 private:
  Eigen::Affine3d ct_from_index_ = Eigen::Translation3d(-90, -90, -90) * Eigen::Scaling(0.5);
  tracing::BeamLabels labels_;
  acoustics::ScanGrid grid_;
  slicing::BeamLines lines_;
  slicing::BeamBend bend_;
  slicing::BeamImage label_;
};

void PrintErrors(const char* what, const LabelErrors& e) {
  std::printf("%-44s %8.4f %8.4f %8.4f %8.2f\n", what, e.wrong_percent, e.rms_mm, e.most_mm,
              e.lost_percent);
}

void WriteImages(const std::filesystem::path& folder, const ultrasound::AlamillaOptions& options,
                 const volume::LabelMap& coarse, const volume::LabelMap& fine,
                 const tracing::SurfaceTracer& tracer) {
  const TakenAlong moved;
  const auto write = [&](const char* name, const volume::LabelMap& labels,
                         const tracing::SurfaceTracer* triangles) {
    image::GrayImage image;
    ultrasound::AlamillaRenderer(labels, BumpyBalls::Probe(), options, triangles)
        .Render(BumpyBalls::CtFromProbe(), std::nullopt, image, 1, &moved);
    image::WritePng(folder / name, image);
  };
  write("voxels_1.png", coarse, nullptr);
  write("voxels_05.png", fine, nullptr);
  write("triangles.png", fine, &tracer);
}

int Run(int levels, const std::filesystem::path& folder) {
  std::vector<tracing::LabelledSurface> surfaces = BumpyBalls::Surfaces(levels);
  double fill_s = 0.0;
  const volume::LabelMap coarse = BumpyBalls::Voxels(surfaces, 1.0, fill_s);
  const volume::LabelMap voxels = BumpyBalls::Voxels(surfaces, 0.5, fill_s);
  const double begin_s = ProcessCpuSeconds();
  const double begin_ms = testing_support::WallMs();
  const tracing::SurfaceTracer tracer(std::move(surfaces), 2);
  std::printf(
      "%zu triangles: hierarchy in %.2f s of CPU time, %.2f s with two threads; %.0f MB, "
      "%.0f bytes a triangle\n0.5 mm voxels: filled in %.2f s of CPU time; %.0f MB\n\n",
      tracer.num_triangles(), ProcessCpuSeconds() - begin_s,
      1e-3 * (testing_support::WallMs() - begin_ms),
      1e-6 * static_cast<double>(tracer.memory_bytes()),
      static_cast<double>(tracer.memory_bytes()) / static_cast<double>(tracer.num_triangles()),
      fill_s, 1e-6 * static_cast<double>(voxels.voxels.size()));

  const TakenAlong moved;
  std::printf("%-44s %8s %8s %8s %8s\n", "labels against the closed form", "wrong %", "rms mm",
              "most mm", "lost %");
  PrintErrors("voxels, at rest", ErrorsOfVoxels(voxels, nullptr));
  PrintErrors("voxels, deformed", ErrorsOfVoxels(voxels, &moved));
  const LabelErrors at_rest = ErrorsOfTriangles(tracer, nullptr);
  const LabelErrors deformed = ErrorsOfTriangles(tracer, &moved);
  PrintErrors("triangles, at rest", at_rest);
  PrintErrors("triangles, deformed", deformed);

  const auto options =
      ultrasound::ReadAlamillaOptions(config::FindConfig("acoustics/alamilla_2021.json", "."));
  if (!folder.empty()) WriteImages(folder, options, coarse, voxels, tracer);
  ultrasound::AlamillaRenderer by_voxels(voxels, BumpyBalls::Probe(), options);
  ultrasound::AlamillaRenderer by_triangles(voxels, BumpyBalls::Probe(), options, &tracer);
  image::GrayImage image;
  std::printf("\n%-44s %8s %8s\n", "512 x 512 pixels, ms an image", "1 CPU", "2 wall");
  for (const slicing::RestMap* rest : {static_cast<const slicing::RestMap*>(nullptr),
                                       static_cast<const slicing::RestMap*>(&moved)}) {
    LabelsOnly labels(tracer, rest);
    labels(1);
    std::printf("%s, %zu pieces of lines\n", rest == nullptr ? "at rest" : "deformed",
                labels.num_pieces());
    ImageTimes voxel_times, triangle_times, label_times;
    for (int n = 0; n < kRounds; ++n) {
      voxel_times.Add([&](int threads) {
        by_voxels.Render(BumpyBalls::CtFromProbe(), std::nullopt, image, threads, rest);
      });
      triangle_times.Add([&](int threads) {
        by_triangles.Render(BumpyBalls::CtFromProbe(), std::nullopt, image, threads, rest);
      });
      label_times.Add(labels);
    }
    voxel_times.Print("  image by voxels");
    triangle_times.Print("  image by triangles");
    label_times.Print("  ... of which rays against triangles");
  }
  return at_rest.lost_percent + deformed.lost_percent > 0.5 || deformed.rms_mm > 0.02 ? 1 : 0;
}

}  // namespace
}  // namespace acus::benchmarks

int main(int argc, char** argv) {
  return acus::benchmarks::Run(argc > 1 ? std::atoi(argv[1]) : 8, argc > 2 ? argv[2] : "");
}
