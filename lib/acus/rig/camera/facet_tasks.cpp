#include "acus/rig/camera/facet_tasks.h"

#include <CLI/CLI.hpp>
#include <memory>

#include "acus/base/config/json_file.h"
#include "acus/rig/camera/tracking_run.h"

namespace acus::camera {
namespace {

struct FacetTaskOptions {
  std::filesystem::path images, right, stereo;
  double rate_hz = 30.0;
  int count = 20;
};

std::filesystem::path Preset(const std::filesystem::path& name, RunContext& context) {
  const auto path = config::FindConfig(name, std::filesystem::current_path());
  context.provenance.AddInput(path);
  return path;
}

std::vector<std::filesystem::path> FilesIn(const std::filesystem::path& folder,
                                           RunContext& context) {
  auto files = ImageFiles(folder);
  for (const auto& file : files) context.provenance.AddInput(file);
  return files;
}

std::string TrackFacets(const FacetTaskOptions& o, const FacetTaskFiles& files,
                        const std::filesystem::path& folder, RunContext& context) {
  const FacetSet facets = ReadFacets(Preset(files.facets, context));
  const auto images = FilesIn(o.images, context);
  const TrackingRun run =
      o.right.empty()
          ? TrackImages(images, ReadCamera(Preset(files.camera, context)), facets, o.rate_hz,
                        context)
          : TrackPairs(images, FilesIn(o.right, context), ReadStereo(Preset(o.stereo, context)),
                       facets, o.rate_hz, context);
  WriteResult(folder, run, context);
  return TableText(run);
}

void DrawSample(const FacetTaskOptions& o, const FacetTaskFiles& files,
                const std::filesystem::path& folder, RunContext& context) {
  const CalibrationBoard board = ReadBoard(Preset(files.board, context));
  const FacetSet facets = ReadFacets(Preset(files.facets, context));
  if (o.stereo.empty()) {
    const CameraModel camera = ReadCamera(Preset(files.camera, context));
    const Viewpoint view{.camera = &camera};
    WriteSamples(folder, {&view, 1}, board, facets, o.count, context);
    return;
  }
  const StereoPair pair = ReadStereo(Preset(o.stereo, context));
  const Viewpoint views[] = {{.camera = &pair.left},
                             {.camera = &pair.right, .here_from_first = pair.right_from_left}};
  WriteSamples(folder, views, board, facets, o.count, context);
}

}  // namespace

FacetTasks AddFacetTasks(CLI::App& app) {
  const auto options = std::make_shared<FacetTaskOptions>();
  FacetTaskOptions& o = *options;
  CLI::App* track = app.add_subcommand("track", "Images of facets to poses, with their jitter");
  CLI::App* sample = app.add_subcommand("sample", "Draw images to try the others with");
  track->fallthrough()
      ->add_option("images", o.images, "Folder")
      ->required()
      ->check(CLI::ExistingDirectory);
  track->add_option("--rate-hz", o.rate_hz, "Of the images")->check(CLI::Range(0.01, 1e4));
  CLI::Option* stereo = track->add_option("--stereo", o.stereo, "Track by this pair (stereo.json)");
  CLI::Option* right = track->add_option("--right", o.right, "Folder of its right camera's images")
                           ->check(CLI::ExistingDirectory)
                           ->needs(stereo);
  stereo->needs(right);
  sample->add_option("--stereo", o.stereo, "Draw for both cameras of a pair (stereo.json)");
  sample->fallthrough()->add_option("--count", o.count, "Images")->check(CLI::Range(1, 9999));
  return [=](const FacetTaskFiles& files, const std::filesystem::path& folder,
             RunContext& context) -> std::string {
    if (track->parsed()) return TrackFacets(*options, files, folder, context);
    if (sample->parsed()) DrawSample(*options, files, folder, context);
    return {};
  };
}

}  // namespace acus::camera
