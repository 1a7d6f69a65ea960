// Parts of more than one shader, in the language of graphics cards. Bindings of textures and
// buffers are those of Unit and Binding.
#pragma once

namespace acus::graphics::glsl {

/// All that holds for one image: MomentBlock.
inline constexpr const char* kMoment = R"glsl(
layout(std140, binding = 0) uniform Moment {
  // The camera; directions of rays are (pixel - centre) / focal, 1.
  mat3 ct_from_camera;
  vec3 eye_mm;
  float step_mm;
  mat4 clip_from_ct;
  vec2 focal_px;
  vec2 centre_px;

  // The CT, its slopes, and what of it can show.
  mat3 index_linear;
  vec3 index_offset;
  float tool_shine;
  mat3 ct_from_grid;
  mat3 blocks_linear;
  vec3 blocks_offset;
  float dark;

  // Breath: a sum of fields. Their scale is what a stored 1 is, in mm, times their weight now.
  mat3 nodes_linear;
  vec3 nodes_offset;
  float tolerance_mm;
  vec4 component_scale;

  // Tissue under tools.
  vec3 pressed_low_mm;
  float pressed_spacing_mm;
  vec3 pressed_high_mm;
  float surface_hu_per_mm;

  // Light, and shadows of tools.
  vec3 to_lamp;
  float steepest_hu_per_mm;
  vec4 light;  // Ambient, diffuse, fill, gloss.
  mat3 lamp_from_ct;
  vec2 shadow_low_mm;
  float shadow_cell_mm;
  float shadow_clear_mm;

  vec3 background_top;
  float lowest_hu;
  vec3 background_bottom;
  int supersampling;
  vec2 window_hu;  // Projections: the largest HU of a ray is seen in this window.
  int is_maximum;
  int most_nodes;  // Room for the surfaces of all lists.
  ivec3 ct_size;
  int table_count;
  ivec3 blocks_size;
  int has_volume;
  ivec3 nodes_size;
  int num_components;
  ivec3 pressed_size;
  int is_pressed;
  ivec2 image_size;
  int has_classes;
  int has_shadows;
  int shadow_size;
  int num_cuts;
  int most_iterations;
  int unused;
};
)glsl";

inline constexpr const char* kLists = R"glsl(
// Translucent surfaces: a list for each ray, in no order. A node is the bits of its distance in mm,
// red and green, blue and opacity, the latter as numbers of 16 bits; and the next node, 0 for none,
// else 1 + its index, with bit 31 for a tool.
layout(std430, binding = 3) buffer Heads { uint heads[]; };
layout(std430, binding = 4) buffer Nodes { uvec4 nodes[]; };
)glsl";

inline constexpr const char* kCuts = R"glsl(
layout(std430, binding = 2) readonly buffer Cuts { vec4 cuts[]; };
)glsl";

inline constexpr const char* kBreath = R"glsl(
layout(binding = 6) uniform sampler3D component_0;
layout(binding = 7) uniform sampler3D component_1;
layout(binding = 8) uniform sampler3D component_2;
layout(binding = 9) uniform sampler3D component_3;

vec3 DisplacementMm(vec3 rest_mm) {
  vec3 node = clamp(nodes_linear * rest_mm + nodes_offset, vec3(0.0), vec3(nodes_size - 1));
  vec3 at = (node + 0.5) / vec3(nodes_size);
  vec3 sum = vec3(0.0);
  if (num_components > 0) sum += component_scale[0] * textureLod(component_0, at, 0.0).xyz;
  if (num_components > 1) sum += component_scale[1] * textureLod(component_1, at, 0.0).xyz;
  if (num_components > 2) sum += component_scale[2] * textureLod(component_2, at, 0.0).xyz;
  if (num_components > 3) sum += component_scale[3] * textureLod(component_3, at, 0.0).xyz;
  return sum;
}
)glsl";

inline constexpr const char* kPressed = R"glsl(
layout(binding = 4) uniform sampler3D pressed;

bool IsInPressed(vec3 world_mm) {
  return is_pressed != 0 && all(greaterThanEqual(world_mm, pressed_low_mm)) &&
         all(lessThanEqual(world_mm, pressed_high_mm));
}

vec3 PressedOffsetMm(vec3 world_mm) {
  vec3 knot = clamp((world_mm - pressed_low_mm) / pressed_spacing_mm, vec3(0.0),
                    vec3(pressed_size - 1));
  return textureLod(pressed, (knot + 0.5) / vec3(pressed_size), 0.0).xyz;
}

mat3 PressedGradientAt(vec3 world_mm) {
  mat3 gradient = mat3(1.0);
  for (int axis = 0; axis < 3; ++axis) {
    vec3 aside_mm = vec3(0.0);
    aside_mm[axis] = 0.5 * pressed_spacing_mm;
    gradient[axis] += (PressedOffsetMm(world_mm + aside_mm) - PressedOffsetMm(world_mm - aside_mm)) /
                      pressed_spacing_mm;
  }
  return gradient;
}
)glsl";

inline constexpr const char* kLight = R"glsl(
layout(binding = 5) uniform sampler2D shadow_heights;

float LitAt(vec3 place_mm) {
  if (has_shadows == 0) return 1.0;
  vec3 at = lamp_from_ct * place_mm;
  vec2 cell = (at.xy - shadow_low_mm) / shadow_cell_mm;
  if (!(all(greaterThanEqual(cell, vec2(1.0))) && all(lessThan(cell, vec2(shadow_size - 2))))) {
    return 1.0;
  }
  ivec2 low = ivec2(cell);
  vec2 share = cell - vec2(low);
  float shadow = 0.0;
  for (int j = 0; j < 4; ++j) {
    for (int i = 0; i < 4; ++i) {
      float height = texelFetch(shadow_heights, low + ivec2(i - 1, j - 1), 0).x;
      float across = i == 0 ? 1.0 - share.x : i == 3 ? share.x : 1.0;
      float down = j == 0 ? 1.0 - share.y : j == 3 ? share.y : 1.0;
      if (height > at.z + shadow_clear_mm) shadow += across * down;
    }
  }
  return 1.0 - shadow / 9.0;
}

vec3 Shaded(vec3 colour, vec3 normal, vec3 to_eye, float lit) {
  float toward_eye = dot(normal, to_eye);
  float side = toward_eye < 0.0 ? -1.0 : 1.0;
  float toward_lamp = max(0.0, side * dot(normal, to_lamp));
  float shine = max(0.0, side * dot(normal, normalize(to_lamp + to_eye)));
  for (int n = 0; n < 5; ++n) shine *= shine;
  float matt = light[0] + light[2] * side * toward_eye + lit * light[1] * toward_lamp;
  return colour * matt + lit * light[3] * shine;
}
)glsl";

}  // namespace acus::graphics::glsl
