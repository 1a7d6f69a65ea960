#include "acus/imaging/graphics/ray_shader.h"

namespace acus::graphics {
namespace {

constexpr const char* kInputs = R"glsl(#version 450 core
layout(local_size_x = 8, local_size_y = 8) in;

// The camera; directions of rays are (pixel - centre) / focal, 1.
uniform ivec3 image_size;
uniform vec2 focal_px;
uniform vec2 centre_px;
uniform mat3 ct_from_camera;
uniform vec3 eye_mm;

// The CT, its slopes, and what of it can show.
uniform sampler3D hu;
uniform sampler3D slopes;
uniform usampler3D classes;
uniform usampler3D distances;
uniform ivec3 ct_size;
uniform mat3 index_linear;
uniform vec3 index_offset;
uniform mat3 ct_from_grid;
uniform ivec3 blocks_size;
uniform mat3 blocks_linear;
uniform vec3 blocks_offset;
uniform float steepest_hu_per_mm;
uniform float lowest_hu;
uniform int table_count;
uniform int has_volume;
uniform int has_classes;
layout(std430, binding = 0) readonly buffer Integral { vec4 integral[]; };
layout(std430, binding = 1) readonly buffer Value { vec4 value[]; };

// Breath: a sum of fields. Their scale is what a stored 1 is, in mm, times their weight now.
uniform sampler3D component_0;
uniform sampler3D component_1;
uniform sampler3D component_2;
uniform sampler3D component_3;
uniform vec4 component_scale;
uniform int num_components;
uniform ivec3 nodes_size;
uniform mat3 nodes_linear;
uniform vec3 nodes_offset;
uniform int most_iterations;
uniform float tolerance_mm;

// Tissue under tools.
uniform sampler3D pressed;
uniform int is_pressed;
uniform ivec3 pressed_size;
uniform vec3 pressed_low_mm;
uniform vec3 pressed_high_mm;
uniform float pressed_spacing_mm;

// Light, and shadows of tools.
uniform vec3 to_lamp;
uniform vec4 light;  // Ambient, diffuse, fill, gloss.
uniform float surface_hu_per_mm;
uniform sampler3D shadow_heights;
uniform int has_shadows;
uniform int shadow_size;
uniform mat3 lamp_from_ct;
uniform vec2 shadow_low_mm;
uniform float shadow_cell_mm;
uniform float shadow_clear_mm;

uniform float step_mm;
uniform float tool_shine;
uniform float dark;
uniform int num_cuts;
uniform int is_maximum;  // Rays show their largest HU in this window.
uniform vec2 window_hu;
layout(std430, binding = 2) readonly buffer Cuts { vec4 cuts[]; };

// Surfaces: those of pixel n are from first[n] to first[n + 1], by rising distance.
struct Fragment {
  float distance_mm;
  float opacity;
  float red;
  float green;
  float blue;
  float is_tool;
};
layout(std430, binding = 3) readonly buffer First { uint first[]; };
layout(std430, binding = 4) readonly buffer Fragments { Fragment fragments[]; };

layout(std430, binding = 5) writeonly buffer Pixels { uint pixels[]; };

const float kOutsideHu = -1024.0;
const float kFar = 3.0e38;
const int kEntryIterations = 20;
)glsl";

constexpr const char* kSurfaces = R"glsl(
float passing = 1.0;  // Light that gets through so far.
uint next_fragment;
uint end_fragment;
vec3 surface_colour = vec3(0.0);
float shine_weight = 0.0;
vec3 shine_colour = vec3(0.0);

float AbsorbShare(float opacity) {
  float weight = passing * opacity;
  passing *= 1.0 - opacity;
  return weight;
}

void Take(Fragment met) {
  vec3 colour = vec3(met.red, met.green, met.blue);
  float weight = AbsorbShare(met.opacity);
  float shine = tool_shine * met.opacity;
  if (met.is_tool > 0.0 && weight < shine && shine_weight == 0.0) {
    shine_weight = shine - weight;
    shine_colour = colour;
  }
  surface_colour += weight * colour;
}

void Pass(float to_mm) {
  for (; next_fragment < end_fragment; ++next_fragment) {
    if (fragments[next_fragment].distance_mm > to_mm) return;
    Take(fragments[next_fragment]);
  }
}

// A projection of the whole ray: behind all surfaces but an opaque one. Returns its weight.
float Cover(float opacity) {
  for (; next_fragment < end_fragment && fragments[next_fragment].opacity < 1.0; ++next_fragment) {
    Take(fragments[next_fragment]);
  }
  return AbsorbShare(opacity);
}

float AbsorbPiece(float extinction_per_mm, float length_mm) {
  return AbsorbShare(1.0 - exp(-extinction_per_mm * length_mm));
}

// Volume between two distances, and the surfaces within. Returns the weight of its colour.
float AbsorbAlong(float extinction_per_mm, float from_mm, float to_mm) {
  Pass(from_mm);
  float weight = 0.0;
  while (next_fragment < end_fragment && fragments[next_fragment].distance_mm <= to_mm) {
    float at_mm = fragments[next_fragment].distance_mm;
    weight += AbsorbPiece(extinction_per_mm, at_mm - from_mm);
    from_mm = at_mm;
    Pass(at_mm);
  }
  return weight + AbsorbPiece(extinction_per_mm, to_mm - from_mm);
}
)glsl";

constexpr const char* kWarp = R"glsl(
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

// Continues with X <- x - u(X). Steps that do not help are halved: it is bounded where the field folds.
vec3 Refined(vec3 rest_mm, vec3 world_mm, int iterations) {
  vec3 error = rest_mm + DisplacementMm(rest_mm) - world_mm;
  float residual_mm = length(error);
  float factor = 1.0;
  for (; iterations > 0 && residual_mm > tolerance_mm; --iterations) {
    vec3 tried_mm = rest_mm - factor * error;
    vec3 tried_error = tried_mm + DisplacementMm(tried_mm) - world_mm;
    float tried_residual_mm = length(tried_error);
    if (tried_residual_mm < residual_mm) {
      rest_mm = tried_mm;
      error = tried_error;
      residual_mm = tried_residual_mm;
      factor = min(1.0, 2.0 * factor);
    } else {
      factor *= 0.5;
    }
  }
  return rest_mm;
}

// The sample before: the tissue there, and how far it has come.
bool has_rest = false;
vec3 last_rest_mm;
vec3 last_displacement_mm = vec3(0.0);

// The tissue that is now at a place, from that of the sample before (Fortmeier-2016, eq. 1-2).
vec3 RestOf(vec3 world_mm, vec3 moved_mm) {
  vec3 rest_mm = has_rest ? last_rest_mm + moved_mm : world_mm - last_displacement_mm;
  int left = has_rest ? most_iterations : kEntryIterations;
  vec3 error = rest_mm + DisplacementMm(rest_mm) - world_mm;
  rest_mm -= error;
  if (left > 1 && length(error) > tolerance_mm) rest_mm = Refined(rest_mm, world_mm, left - 1);
  last_rest_mm = rest_mm;
  last_displacement_mm = world_mm - rest_mm;
  has_rest = true;
  return rest_mm;
}

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

// Where the tissue at a place of the world is in the CT, in voxels.
vec3 RestIndex(vec3 world_mm, vec3 moved_mm) {
  vec3 at_mm = world_mm;
  bool is_moved = IsInPressed(world_mm);
  if (is_moved) {
    at_mm += PressedOffsetMm(world_mm);
    has_rest = false;
  }
  if (num_components > 0) at_mm = RestOf(at_mm, moved_mm);
  if (is_moved) has_rest = false;
  return index_linear * at_mm + index_offset;
}
)glsl";

constexpr const char* kVolume = R"glsl(
float HuAt(vec3 index) {
  if (any(lessThan(index, vec3(0.0))) || any(greaterThan(index, vec3(ct_size - 1)))) {
    return kOutsideHu;
  }
  return 32767.0 * textureLod(hu, (index + 0.5) / vec3(ct_size), 0.0).x;
}

int EntryOf(float at_hu) {
  return int(clamp(at_hu - lowest_hu, 0.0, float(table_count - 1)));
}

// Extinction times colour, and extinction, per mm: the mean from one HU to another.
vec4 Between(int from, int to, int tissue_class) {
  int begin = tissue_class * table_count;
  if (from == to) return value[begin + from];
  return (integral[begin + to] - integral[begin + from]) / float(to - from);
}

vec4 EmissionAt(vec3 index, float from_hu, float to_hu) {
  int from = EntryOf(from_hu);
  int to = EntryOf(to_hu);
  if (has_classes == 0) return Between(from, to, 0);
  vec3 inside = clamp(index, vec3(0.0), vec3(ct_size - 1));
  ivec3 cell = min(ivec3(inside), ct_size - 2);
  vec3 share = inside - vec3(cell);
  vec4 sum = vec4(0.0);
  for (int n = 0; n < 8; ++n) {
    ivec3 corner = ivec3(n & 1, (n >> 1) & 1, n >> 2);
    vec3 weight = mix(1.0 - share, share, vec3(corner));
    int tissue_class = int(texelFetch(classes, cell + corner, 0).x);
    sum += weight.x * weight.y * weight.z * Between(from, to, tissue_class);
  }
  return sum;
}

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
      float height = texelFetch(shadow_heights, ivec3(low + ivec2(i - 1, j - 1), 0), 0).x;
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

vec3 ColourAt(vec3 colour, vec3 index, vec3 place_mm, vec3 direction) {
  vec3 inside = clamp(index, vec3(0.0), vec3(ct_size - 1));
  vec3 slope = ct_from_grid * (steepest_hu_per_mm *
                               textureLod(slopes, (inside + 0.5) / vec3(ct_size), 0.0).xyz);
  if (IsInPressed(place_mm)) slope = transpose(PressedGradientAt(place_mm)) * slope;
  vec3 flat_colour = (light[0] + 0.5 * (light[1] + light[2])) * colour;
  float steepness = length(slope);
  if (!(steepness > 0.0)) return flat_colour;
  vec3 shaded = Shaded(colour, slope / steepness, -direction, LitAt(place_mm));
  return mix(flat_colour, shaded, min(1.0, steepness / surface_hu_per_mm));
}
)glsl";

constexpr const char* kMarch = R"glsl(
// The part of a ray within the blocks, and not cut away.
vec2 PartOf(vec3 direction, vec3 blocks_eye, vec3 blocks_step, float end_mm) {
  vec2 part = vec2(0.0, end_mm);
  for (int axis = 0; axis < 3; ++axis) {
    float most = float(blocks_size[axis]);
    if (blocks_step[axis] == 0.0) {
      if (blocks_eye[axis] < 0.0 || blocks_eye[axis] >= most) return vec2(0.0, -1.0);
      continue;
    }
    float a = -blocks_eye[axis] / blocks_step[axis];
    float b = (most - blocks_eye[axis]) / blocks_step[axis];
    part = vec2(max(part.x, min(a, b)), min(part.y, max(a, b)));
  }
  for (int n = 0; n < num_cuts; ++n) {
    float height_mm = dot(cuts[n].xyz, eye_mm) + cuts[n].w;
    float rise = dot(cuts[n].xyz, direction);
    if (rise < 0.0) {
      part.x = max(part.x, -height_mm / rise);
    } else if (rise > 0.0) {
      part.y = min(part.y, -height_mm / rise);
    } else if (height_mm > 0.0) {
      part.y = -1.0;
    }
  }
  return part;
}

// Steps to the first sample out of the cube of empty blocks around this one.
int StepsToVisible(vec3 in_blocks, ivec3 block, int distance, vec3 blocks_step) {
  float exit_mm = kFar;
  for (int axis = 0; axis < 3; ++axis) {
    float along = blocks_step[axis];
    if (along == 0.0) continue;
    int wall = along > 0.0 ? block[axis] + distance : block[axis] - distance + 1;
    exit_mm = min(exit_mm, (float(wall) - in_blocks[axis]) / along);
  }
  return max(1, int(exit_mm / step_mm));
}

vec3 CastVolume(vec3 direction, float end_mm) {
  vec3 colour = vec3(0.0);
  vec3 blocks_eye = blocks_linear * eye_mm + blocks_offset;
  vec3 blocks_step = blocks_linear * direction;
  vec2 part = PartOf(direction, blocks_eye, blocks_step, end_mm);
  if (!(part.x < part.y)) return colour;
  bool has_before = false;
  float hu_before = kOutsideHu;
  float highest_hu = kOutsideHu;
  // A piece needs a sample beyond either end; a maximum takes none that is hidden or cut away.
  int first_sample = int(is_maximum != 0 ? ceil(part.x / step_mm) : part.x / step_mm);
  int last = int(is_maximum != 0 ? part.y / step_mm : ceil(part.y / step_mm));
  for (int n = first_sample; n <= last && passing > dark;) {
    float at_mm = float(n) * step_mm;
    vec3 in_blocks = blocks_eye + at_mm * blocks_step;
    ivec3 block = ivec3(in_blocks);
    bool outside = any(lessThan(in_blocks, vec3(0.0))) || any(greaterThanEqual(block, blocks_size));
    int distance = outside ? 0 : int(texelFetch(distances, block, 0).x);
    if (outside || distance > 0) {
      has_before = has_rest = false;
      n += outside ? 1 : StepsToVisible(in_blocks, block, distance, blocks_step);
      continue;
    }
    vec3 place_mm = eye_mm + at_mm * direction;
    vec3 index = RestIndex(place_mm, step_mm * direction);
    float hu_now = HuAt(index);
    highest_hu = max(highest_hu, hu_now);
    if (is_maximum != 0 && highest_hu >= window_hu[1]) break;
    if (has_before && is_maximum == 0) {
      vec4 emission = EmissionAt(index, hu_before, hu_now);
      if (emission.w > 0.0) {
        vec3 lit = ColourAt(emission.rgb / emission.w, index, place_mm, direction);
        colour += AbsorbAlong(emission.w, at_mm - step_mm, at_mm) * lit;
      }
    }
    has_before = true;
    hu_before = hu_now;
    ++n;
  }
  if (is_maximum == 0) return colour;
  float share = (highest_hu - window_hu[0]) / (window_hu[1] - window_hu[0]);
  return vec3(Cover(clamp(share, 0.0, 1.0)));
}

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (pixel.x >= image_size.x || pixel.y >= image_size.y) return;
  int at = pixel.y * image_size.x + pixel.x;
  next_fragment = first[at];
  end_fragment = first[at + 1];
  float end_mm = kFar;
  if (end_fragment > next_fragment && fragments[end_fragment - 1].opacity >= 1.0) {
    end_mm = fragments[end_fragment - 1].distance_mm;
  }
  vec3 direction =
      ct_from_camera * normalize(vec3((vec2(pixel) - centre_px) / focal_px, 1.0));
  vec3 colour = has_volume != 0 ? CastVolume(direction, end_mm) : vec3(0.0);
  Pass(kFar);
  float opacity = 1.0 - passing;
  colour += surface_colour;
  colour = mix(colour, shine_colour, shine_weight);
  opacity = mix(opacity, 1.0, shine_weight);
  pixels[at] = packUnorm4x8(vec4(min(colour, vec3(1.0)), opacity));
}
)glsl";

}  // namespace

std::string RayShaderSource() {
  std::string source;
  for (const char* part : {kInputs, kSurfaces, kWarp, kVolume, kMarch}) source += part;
  return source;
}

}  // namespace acus::graphics
