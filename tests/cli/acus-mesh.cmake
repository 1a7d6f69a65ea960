set(mesh_cube "printf 'v 0 0 0\\nv 9 0 0\\nv 0 9 0\\nv 9 9 0\\nv 0 0 9\\nv 9 0 9\\nv 0 9 9\\nv 9 9 9\\nf 1 3 4 2\\nf 5 6 8 7\\nf 1 2 6 5\\nf 3 7 8 4\\nf 1 5 7 3\\nf 2 4 8 6\\n' > cube.obj")
acus_add_cli_case(acus-mesh.surface EXIT 0 BEFORE "${mesh_cube}"
  CREATES mesh/mesh.vtu mesh/quality.json mesh/quality.svg mesh/provenance.json
  STDOUT "^Mesh: [0-9]+ nodes, [0-9]+ tetrahedra, smallest dihedral angle"
         "^Fixed nodes: 0: nothing holds the mesh"
  STDERR "warning: no node of the mesh is fixed \\(fixed_nodes: 0\\)" "fixed_tissues"
  COMMAND acus-mesh --surface cube.obj --tissue liver -o mesh)
acus_add_cli_case(acus-mesh.open_surface EXIT 3 LEAVES_NOTHING
  BEFORE "${mesh_cube}\nsed -i 's/^f 1 3 4 2/f 1 3 8/' cube.obj"
  STDERR "cube.obj: cannot be filled" "first at \\(" "try:"
  COMMAND acus-mesh --surface cube.obj -o mesh)
acus_add_cli_case(acus-mesh.truncated_surface EXIT 3 LEAVES_NOTHING
  BEFORE "${mesh_cube}\nhead -c 40 cube.obj > cut.obj"
  STDERR "cut.obj" COMMAND acus-mesh --surface cut.obj -o mesh)
acus_add_cli_case(acus-mesh.wrong_kind EXIT 3 LEAVES_NOTHING BEFORE "echo hello > a.png"
  STDERR "a.png: a surface must be .stl, .obj, .ply, .vtp or"
  COMMAND acus-mesh --surface a.png -o mesh)
acus_add_cli_case(acus-mesh.not_a_label_map EXIT 3 LEAVES_NOTHING BEFORE "echo hello > a.nrrd"
  STDERR "a.nrrd" COMMAND acus-mesh a.nrrd -o mesh)
acus_add_cli_case(acus-mesh.missing_file EXIT 2 LEAVES_NOTHING
  STDERR "none.nrrd" COMMAND acus-mesh none.nrrd -o mesh)
acus_add_cli_case(acus-mesh.unknown_tissue EXIT 3 LEAVES_NOTHING BEFORE "${mesh_cube}"
  STDERR "did you mean 'liver'" COMMAND acus-mesh --surface cube.obj --tissue livr -o mesh)
acus_add_cli_case(acus-mesh.half_a_corridor EXIT 2 LEAVES_NOTHING BEFORE "echo hello > a.nrrd"
  STDERR "--corridor-to" COMMAND acus-mesh a.nrrd --corridor-from 1,2,3 -o mesh)
acus_add_cli_case(acus-mesh.bad_point EXIT 3 LEAVES_NOTHING BEFORE "echo hello > a.nrrd"
  STDERR "--corridor-from: '1,2' is not a point"
  COMMAND acus-mesh a.nrrd --corridor-from 1,2 --corridor-to 1,2,3 -o mesh)
acus_add_cli_case(acus-mesh.bad_config EXIT 3 LEAVES_NOTHING
  BEFORE "${mesh_cube}\necho '{\"format\": \"acus-mesh/1\", \"smoothing\": 2}' > c.json"
  STDERR "/smoothing: unknown key; did you mean \"smoothing_mm\""
  COMMAND acus-mesh --surface cube.obj --config c.json -o mesh)
acus_add_cli_case(acus-mesh.condense_without_corridor EXIT 3 LEAVES_NOTHING BEFORE "${mesh_cube}"
  STDERR "give --corridor, or --corridor-from and --corridor-to"
  COMMAND acus-mesh --surface cube.obj --condense -o mesh)
acus_add_cli_case(acus-mesh.condense_without_fixed_nodes EXIT 3 LEAVES_NOTHING BEFORE "${mesh_cube}"
  STDERR "no node of the mesh is fixed" "fixed_tissues"
  COMMAND acus-mesh --surface cube.obj --tissue liver --condense
          --corridor-from 4,4,9 --corridor-to 4,4,2 -o mesh)
acus_add_cli_case(acus-mesh.condense_nothing_to_move EXIT 3 LEAVES_NOTHING BEFORE "${mesh_cube}"
  STDERR "every node of the mesh is held"
  COMMAND acus-mesh --surface cube.obj --tissue bone --condense
          --corridor-from 4,4,9 --corridor-to 4,4,2 -o mesh)
acus_add_cli_case(acus-mesh.corridor_without_target EXIT 3 LEAVES_NOTHING
  BEFORE "${mesh_cube}\nprintf 'name,x_mm,y_mm,z_mm\nentry,4,4,9\n' > c.csv"
  STDERR "--corridor c.csv: has no point .target."
  COMMAND acus-mesh --surface cube.obj --corridor c.csv -o mesh)
acus_add_cli_case(acus-mesh.mesh_without_condense EXIT 2 LEAVES_NOTHING BEFORE "echo x > mesh.vtu"
  STDERR "--mesh requires --condense" COMMAND acus-mesh --mesh mesh.vtu -o out)
acus_add_cli_case(acus-mesh.broken_mesh EXIT 3 LEAVES_NOTHING BEFORE "echo x > mesh.vtu"
  STDERR "mesh.vtu: cannot be used" COMMAND acus-mesh --mesh mesh.vtu --condense
          --corridor-from 4,4,9 --corridor-to 4,4,2 -o out)
acus_add_cli_case(acus-mesh.bad_probe EXIT 3 LEAVES_NOTHING BEFORE "echo x > mesh.vtu"
  STDERR "--probe-at: '1,2' is not a point" COMMAND acus-mesh --mesh mesh.vtu --condense
          --corridor-from 4,4,9 --corridor-to 4,4,2 --probe-at 1,2 -o out)
acus_add_cli_case(acus-mesh.condense_along_the_corridor_of_a_file EXIT 0 NEEDS inputs
  BEFORE "printf 'name,x_mm,y_mm,z_mm\nentry,7,7,25\ntarget,7,7,10\n' > c.csv && acus-mesh --mesh $INPUTS/box.vtu --condense --corridor-from 7,7,25 --corridor-to 7,7,10 -o one >/dev/null && acus-mesh --mesh $INPUTS/box.vtu --condense --corridor c.csv -o two >/dev/null"
  COMMAND cmp one/compliance.acc two/compliance.acc)
acus_add_cli_case(acus-mesh.condense_mesh EXIT 0 NEEDS inputs
  BEFORE "ln -s $INPUTS/box.vtu ." CREATES out/mesh.vtu out/compliance.acc out/condensation.json
          out/provenance.json
  COMMAND acus-mesh --mesh box.vtu --condense --corridor-from 7,7,25 --corridor-to 7,7,10
          --probe-at 7,7,20 -o out)
acus_add_cli_case(acus-mesh.no_tissue_ids EXIT 3 LEAVES_NOTHING NEEDS inputs
  BEFORE "sed s/tissue/colour/ $INPUTS/box.vtu > box.vtu"
  STDERR "box.vtu: has no tissue ids" "mesh the label map with acus-mesh"
  COMMAND acus-mesh --mesh box.vtu --condense --corridor-from 7,7,25 --corridor-to 7,7,10 -o out)
acus_add_cli_case(acus-mesh.no_elasticity EXIT 3 LEAVES_NOTHING NEEDS inputs
  BEFORE "ln -s $INPUTS/box.vtu .\necho '{\"format\": \"acus-elasticity/1\", \"tissues\": [{\"tissue\": \"fat\", \"source\": \"test\", \"youngs_modulus_kpa\": 3}]}' > fat.json\necho '{\"format\": \"acus-mesh/1\", \"condensation\": {\"elasticity\": \"fat.json\"}}' > c.json"
  STDERR "'liver'" "fat.json has no row for it" "add a row"
  COMMAND acus-mesh --mesh box.vtu --condense --config c.json --corridor-from 7,7,25
          --corridor-to 7,7,10 -o out)
# With a tolerance that it meets at once.
set(coarse_patient "ln -s $INPUTS/labels.seg.nrrd .\nsed s/0.5/0.9/ $INPUTS/coarse_mesh.json > coarse_mesh.json")
acus_add_cli_case(acus-mesh.condense EXIT 0 NEEDS inputs TIMEOUT 200
  BEFORE "${coarse_patient}"
  CREATES mesh/mesh.vtu mesh/quality.json mesh/compliance.acc mesh/condensation.json
          mesh/provenance.json
  COMMAND acus-mesh labels.seg.nrrd --config coarse_mesh.json --condense
          --corridor-from 0,120,0 --corridor-to 0,30,0 --probe-at 0,80,20 -o mesh)
acus_add_cli_case(acus-mesh.corridor_outside EXIT 3 LEAVES_NOTHING NEEDS inputs TIMEOUT 200
  BEFORE "${coarse_patient}"
  STDERR "is outside the mesh, which reaches from"
  COMMAND acus-mesh labels.seg.nrrd --config coarse_mesh.json --condense
          --corridor-from 900,120,0 --corridor-to 900,30,0 -o mesh)
