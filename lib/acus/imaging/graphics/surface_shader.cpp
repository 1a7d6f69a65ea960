#include "acus/imaging/graphics/surface_shader.h"

#include "acus/imaging/graphics/shader_pieces.h"

namespace acus::graphics {
namespace {

constexpr const char* kVersion = "#version 450 core\n";

constexpr const char* kVertex = R"glsl(
layout(location = 0) in vec3 vertex_mm;
layout(location = 1) in vec3 vertex_normal;
layout(location = 2) in vec2 vertex_texel;
out vec3 place_mm;
out vec3 normal;
out vec2 texel;
uniform int is_tissue;
const int kMostSteps = 40;
const float kToleranceMm = 0.02;

// Tangents turn with the gradient of the motion, from differences over a node's spacing.
void MoveByBreath() {
  vec3 rest_mm = place_mm;
  vec3 aside = abs(normal.x) < 0.5 ? vec3(1.0, 0.0, 0.0) : vec3(0.0, 1.0, 0.0);
  vec3 across = normalize(cross(normal, aside));
  vec3 along = cross(normal, across);
  float half_mm = 0.5 / length(nodes_linear[0]);
  vec3 turned_across = across + (DisplacementMm(rest_mm + half_mm * across) -
                                 DisplacementMm(rest_mm - half_mm * across)) / (2.0 * half_mm);
  vec3 turned_along = along + (DisplacementMm(rest_mm + half_mm * along) -
                               DisplacementMm(rest_mm - half_mm * along)) / (2.0 * half_mm);
  place_mm = rest_mm + DisplacementMm(rest_mm);
  vec3 turned = cross(turned_across, turned_along);
  if (dot(turned, turned) > 1e-12) normal = normalize(turned);
}

// Solves x + d(x) = y for the place x of the world, with halved steps where it does not converge.
void MoveByTools() {
  vec3 breathed_mm = place_mm;
  vec3 at_mm = breathed_mm;
  vec3 error = IsInPressed(at_mm) ? PressedOffsetMm(at_mm) : vec3(0.0);
  float factor = 1.0;
  for (int n = 0; n < kMostSteps && length(error) > kToleranceMm; ++n) {
    vec3 tried_mm = at_mm - factor * error;
    vec3 offset_mm = IsInPressed(tried_mm) ? PressedOffsetMm(tried_mm) : vec3(0.0);
    vec3 tried_error = tried_mm + offset_mm - breathed_mm;
    if (length(tried_error) < length(error)) {
      at_mm = tried_mm;
      error = tried_error;
      factor = min(1.0, 2.0 * factor);
    } else {
      factor *= 0.5;
    }
  }
  place_mm = at_mm;
  if (!IsInPressed(at_mm)) return;
  vec3 turned = transpose(PressedGradientAt(at_mm)) * normal;
  if (dot(turned, turned) > 1e-12) normal = normalize(turned);
}

void main() {
  place_mm = vertex_mm;
  normal = vertex_normal;
  texel = vertex_texel;
  if (is_tissue != 0 && num_components > 0) MoveByBreath();
  if (is_tissue != 0 && is_pressed != 0) MoveByTools();
  gl_Position = clip_from_ct * vec4(place_mm, 1.0);
}
)glsl";

constexpr const char* kPaint = R"glsl(
in vec3 place_mm;
in vec3 normal;
in vec2 texel;
uniform vec4 surface_colour;  // And its opacity.
uniform int is_lit;
uniform int is_cut;
uniform int is_in_shadow;
uniform int is_tool;
uniform int has_grey;
layout(binding = 12) uniform sampler2D grey;

bool IsCutAway() {
  for (int n = 0; is_cut != 0 && n < num_cuts; ++n) {
    if (dot(cuts[n].xyz, place_mm) + cuts[n].w > 0.0) return true;
  }
  return false;
}

// Colour, not weighted by opacity, and that.
vec4 Paint() {
  vec4 paint = surface_colour;
  if (has_grey != 0) {
    paint.rgb *= textureLod(grey, (texel + 0.5) / vec2(textureSize(grey, 0)), 0.0).x;
  }
  if (is_lit == 0) return paint;
  vec3 to_eye = normalize(eye_mm - place_mm);
  vec3 unit_normal = normalize(normal);
  float lit = is_in_shadow != 0 ? LitAt(place_mm) : 1.0;
  paint.rgb = Shaded(paint.rgb, unit_normal, to_eye, lit);
  if (paint.a < 1.0) {
    float way = 1.0 / max(0.25, abs(dot(unit_normal, to_eye)));
    paint.a = 1.0 - pow(1.0 - paint.a, way);
  }
  return paint;
}
)glsl";

constexpr const char* kOpaque = R"glsl(
layout(location = 0) out vec4 colour_and_tool;
layout(location = 1) out float distance_mm;

void main() {
  if (IsCutAway()) discard;
  colour_and_tool = vec4(Paint().rgb, float(is_tool));
  distance_mm = length(place_mm - eye_mm);
}
)glsl";

constexpr const char* kTranslucent = R"glsl(
layout(early_fragment_tests) in;
layout(std430, binding = 5) buffer NumNodes { uint num_nodes; };

void main() {
  if (IsCutAway()) return;
  vec4 paint = Paint();
  uint node = atomicAdd(num_nodes, 1u);
  if (node >= uint(most_nodes)) return;
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  uint behind = atomicExchange(heads[pixel.y * image_size.x * supersampling + pixel.x], node + 1u);
  nodes[node] = uvec4(floatBitsToUint(length(place_mm - eye_mm)), packHalf2x16(paint.rg),
                      packHalf2x16(paint.ba), (is_tool != 0 ? 0x80000000u : 0u) | behind);
}
)glsl";

// Whole numbers of cells are their middles.
constexpr const char* kShadowVertex = R"glsl(
layout(location = 0) in vec3 vertex_mm;
out float height_mm;

void main() {
  vec3 at = lamp_from_ct * vertex_mm;
  vec2 cell = (at.xy - shadow_low_mm) / shadow_cell_mm;
  height_mm = at.z;
  gl_Position = vec4(2.0 * (cell + 0.5) / float(shadow_size) - 1.0, 0.5, 1.0);
}
)glsl";

constexpr const char* kShadowFragment = R"glsl(#version 450 core
in float height_mm;
layout(location = 0) out float nearest_mm;

void main() {
  nearest_mm = height_mm;
}
)glsl";

std::string Joined(std::initializer_list<const char*> parts) {
  std::string source = kVersion;
  for (const char* part : parts) source += part;
  return source;
}

}  // namespace

std::string SurfaceVertexSource() {
  return Joined({glsl::kMoment, glsl::kBreath, glsl::kPressed, kVertex});
}

std::string OpaqueFragmentSource() {
  return Joined({glsl::kMoment, glsl::kCuts, glsl::kLight, kPaint, kOpaque});
}

std::string TranslucentFragmentSource() {
  return Joined({glsl::kMoment, glsl::kLists, glsl::kCuts, glsl::kLight, kPaint, kTranslucent});
}

std::string ShadowVertexSource() {
  return Joined({glsl::kMoment, kShadowVertex});
}

std::string ShadowFragmentSource() {
  return kShadowFragment;
}

}  // namespace acus::graphics
