// acus-mesh: label map or closed surface to a tetrahedral mesh.
#include <CLI/CLI.hpp>
#include <iostream>

#include "acus/base/config/json_file.h"
#include "acus/base/core/run_main.h"
#include "acus/patient/meshing/mesh_folder.h"

int main(int argc, char** argv) {
  std::filesystem::path labels, surface, mesh, config_path, corridor, folder;
  std::string from, to, probe, tissue = "soft_tissue";
  bool condenses = false, as_it_is = false, may_repair = false;
  CLI::App app{
      "Divide a patient into tetrahedra with a tissue each: faces along skin and bone, fine "
      "along the needle's path, bone nodes marked fixed.",
      "acus-mesh"};
  app.footer(
      "Writes mesh.vtu (ParaView: cell data tissue, point data fixed), quality.json and "
      "quality.svg;\nwith --condense also compliance.acc and condensation.json, for scenes with "
      "deformable tissue.\n"
      "\nEXAMPLE\n"
      "  acus-mesh labels.seg.nrrd -o mesh\n"
      "  acus-mesh labels.seg.nrrd --corridor-from 0,120,0 --corridor-to 0,30,0 --condense "
      "-o fine\n");
  auto* labels_option =
      app.add_option("labels", labels, "Label map, such as acus-segment's labels.seg.nrrd")
          ->check(CLI::ExistingFile);
  app.add_option("--surface", surface,
                 "Fill this closed surface instead (.stl, .obj, .ply, .vtp, .vtk)")
      ->check(CLI::ExistingFile)
      ->excludes(labels_option);
  auto* mesh_option = app.add_option("--mesh", mesh, "Condense this mesh (.vtu of acus-mesh)")
                          ->check(CLI::ExistingFile)
                          ->excludes(labels_option);
  app.add_flag("--as-it-is", as_it_is, "Take a surface that seems to be in metres as it is");
  app.add_flag(
      "--repair", may_repair,
      "Close small cracks and fill the union of overlapping shells; says what was changed");
  app.add_option("--tissue", tissue, "Tissue inside the surface")->capture_default_str();
  app.add_option("--config", config_path,
                 "Settings (format acus-mesh/1); default: the preset meshes/default.json")
      ->check(CLI::ExistingFile);
  auto* from_option = app.add_option("--corridor-from", from,
                                     "One end of the needle's path, x,y,z in mm (CT space, LPS)");
  auto* to_option = app.add_option("--corridor-to", to, "Its other end; elements are fine between");
  from_option->needs(to_option);
  to_option->needs(from_option);
  app.add_option("--corridor", corridor,
                 "Both ends: a file with the points entry and target, as corridor_ct.csv of\n"
                 "acus-phantom")
      ->check(CLI::ExistingFile)
      ->excludes(from_option);
  auto* condense_option = app.add_flag(
      "--condense", condenses, "Compute the compliance of the nodes along the needle's path");
  mesh_option->needs(condense_option);
  app.add_option("--probe-at", probe, "Where a probe presses the skin, x,y,z in mm")
      ->needs(condense_option);
  app.add_option("-o,--output", folder, "Folder to write")->required();
  app.callback([&] {
    if (labels.empty() && surface.empty() && mesh.empty()) {
      throw CLI::ValidationError("a label map is needed, or --surface FILE, or --mesh FILE");
    }
  });

  return acus::RunMain(app, argc, argv, [&](acus::RunContext& context) {
    if (config_path.empty()) config_path = acus::config::FindConfig("meshes/default.json", ".");
    context.provenance.AddInput(config_path);
    const auto document = acus::config::ReadConfig(config_path, "acus-mesh");
    auto config = acus::meshing::MeshConfigFromJson(document);
    config.as_it_is = as_it_is;
    config.surface.may_repair = may_repair;
    if (!from.empty()) acus::meshing::SetCorridor(config, from, to);
    if (!corridor.empty()) {
      acus::meshing::SetCorridorOfFile(config, corridor);
      context.provenance.AddInput(corridor);
    }
    if (condenses) {
      acus::meshing::RequestCondensation(config, document, config_path.parent_path(), probe);
      context.provenance.AddInput(config.condense->elasticity.file);
    }
    const std::filesystem::path& input = !mesh.empty() ? mesh : surface.empty() ? labels : surface;
    context.provenance.AddInput(input);
    if (!mesh.empty()) {
      std::cout << acus::meshing::CondenseMeshToFolder(input, config, folder, context);
    } else if (surface.empty()) {
      std::cout << acus::meshing::MeshLabelsToFolder(input, config, folder, context);
    } else {
      std::cout << acus::meshing::MeshSurfaceToFolder(input, tissue, config, folder, context);
    }
    return acus::ExitCode::kOk;
  });
}
