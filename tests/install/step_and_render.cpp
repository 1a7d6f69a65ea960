// Steps a scenario along a recorded insertion and writes the ultrasound image at its deepest point.
#include <acus/base/core/run_context.h>
#include <acus/data/image/png.h>
#include <acus/data/session/session_import.h>
#include <acus/scene/scenario/scenario.h>
#include <acus/scene/simulation/probe_image_renderer.h>
#include <acus/scene/simulation/simulation.h>
#include <algorithm>
#include <cstdio>
#include <exception>

namespace {

void StepAndRender(const char* scenario_file, const char* session_folder, const char* png_file) {
  acus::RunContext context;
  const auto scenario = acus::scenario::ReadScenario(scenario_file, {});
  const auto session =
      acus::session::ReadAnySession(session_folder, scenario.session, context).session;
  const auto plan =
      acus::simulation::PlanEffects(scenario, {.needle_poses = true, .probe_poses = true});
  const auto scene = acus::simulation::LoadScene(scenario, plan, context);

  const acus::simulation::Simulation simulation(scene);
  auto state = simulation.NewState(session.start_ns());
  double largest_force_n = 0.0;
  double deepest_mm = 0.0;
  acus::simulation::Snapshot deepest;
  for (const auto& reading : session.needle) {
    acus::simulation::Sample sample;
    sample.time_ns = reading.time_ns;
    sample.reference_from_needle = reading.reference_from_tool;
    sample.needle_valid = reading.valid;
    const auto output = simulation.Step(state, sample);
    largest_force_n = std::max(largest_force_n, output.force.force_in_ct_n.norm());
    if (output.force.depth_mm <= deepest_mm) continue;
    deepest_mm = output.force.depth_mm;
    deepest.time_ns = sample.time_ns;
    deepest.ct_from_needle = output.ct_from_needle;
  }
  std::printf("largest force on the needle: %.3f N, %.1f mm deep\n", largest_force_n, deepest_mm);

  const auto probe = acus::session::PoseAt(session.probe, deepest.time_ns);
  deepest.probe_valid = probe.valid;
  deepest.ct_from_probe = scene.ct_from_reference * probe.reference_from_tool;
  acus::simulation::ProbeImageRenderer renderer(scene);
  acus::simulation::ProbeImages images;
  renderer.Render(deepest, images);
  acus::image::WritePng(png_file, images.b_mode);
  std::printf("image: %d x %d\n", images.b_mode.width, images.b_mode.height);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fprintf(stderr, "Usage: step_and_render SCENARIO.json SESSION IMAGE.png\n");
    return 2;
  }
  try {
    StepAndRender(argv[1], argv[2], argv[3]);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "step_and_render: %s\n", error.what());
    return 1;
  }
}
