// Steps a scenario along a straight insertion and writes the ultrasound image at its end.
#include <acus/base/core/run_context.h>
#include <acus/data/image/png.h>
#include <acus/scene/scenario/scenario.h>
#include <acus/scene/simulation/image_renderer.h>
#include <acus/scene/simulation/simulation.h>
#include <cstdio>
#include <exception>

namespace {

int StepAndRender(const char* scenario_file, const char* png_file) {
  acus::RunContext context;
  const auto scenario = acus::scenario::ReadScenario(scenario_file, {});
  const auto plan =
      acus::simulation::PlanEffects(scenario, {.needle_poses = true, .probe_poses = true});
  const auto scene = acus::simulation::LoadScene(scenario, plan, context);

  // 2 s at 1 kHz: the needle goes along its axis, 20 mm/s; the probe stays at the reference.
  const acus::simulation::Simulation simulation(scene);
  auto state = simulation.NewState();
  acus::simulation::StepOutput output;
  acus::simulation::Sample sample;
  sample.needle_valid = sample.probe_valid = true;
  for (int i = 0; i < 2000; ++i) {
    sample.time_ns = i * std::int64_t{1'000'000};
    sample.reference_from_needle.translation().z() = 0.02 * i;
    output = simulation.Step(state, sample);
  }
  std::printf("force on the needle: %.3f N\n", output.force.force_in_ct_n.norm());

  acus::simulation::ImageRenderer renderer(scene);
  acus::simulation::Snapshot snapshot;
  snapshot.time_ns = sample.time_ns;
  snapshot.probe_valid = true;
  snapshot.ct_from_probe = scene.ct_from_reference * sample.reference_from_probe;
  acus::simulation::Images images;
  renderer.Render(snapshot, images);
  acus::image::WritePng(png_file, images.b_mode);
  std::printf("image: %d x %d\n", images.b_mode.width, images.b_mode.height);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "Usage: step_and_render SCENARIO.json IMAGE.png\n");
    return 2;
  }
  try {
    return StepAndRender(argv[1], argv[2]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "step_and_render: %s\n", error.what());
    return 1;
  }
}
