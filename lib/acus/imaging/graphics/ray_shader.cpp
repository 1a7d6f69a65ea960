#include "acus/imaging/graphics/ray_shader.h"

#include "acus/imaging/graphics/shader_pieces.h"

namespace acus::graphics {
namespace {

constexpr const char* kInputs = R"glsl(
layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 0) uniform sampler3D hu;
layout(binding = 1) uniform sampler3D slopes;
layout(binding = 2) uniform usampler3D classes;
layout(binding = 3) uniform usampler3D distances;
layout(std430, binding = 0) readonly buffer Integral { vec4 integral[]; };
layout(std430, binding = 1) readonly buffer Value { vec4 value[]; };
// The nearest opaque surface: its colour, 1 if it is a tool; its distance.
layout(binding = 10) uniform sampler2D opaque_colour;
layout(binding = 11) uniform sampler2D opaque_mm;

layout(std430, binding = 5) writeonly buffer Pixels { uint pixels[]; };

const float kOutsideHu = -1024.0;
const float kFar = 3.0e38;
const int kEntryIterations = 20;
)glsl";

// What a ray has met. Passed from function to function, without variables that several of them
// change: an optimiser of a driver has reordered those.
constexpr const char* kSurfaces = R"glsl(
struct Ray {
  vec3 colour;  // Weighted by opacity.
  float passing;  // Light that gets through so far.
  vec3 shine_colour;
  float shine_weight;
  ivec2 pixel;
  uint first;  // The head of its list: 1 + index; 0: it is empty.
  float opaque_mm;
  // The next surface: kFar if there is none; 1 + its index, or kOpaque.
  float next_mm;
  uint next;
};

const uint kOpaque = 0xffffffffu;

// Looks for the surface behind one. Those at the same distance are passed by their index.
void FindNext(inout Ray ray, float after_mm, uint after) {
  float best_mm = ray.opaque_mm;
  uint best = kOpaque;
  for (uint at = ray.first; at != 0u;) {
    uvec4 node = nodes[at - 1u];
    float at_mm = uintBitsToFloat(node.x);
    bool is_behind = at_mm > after_mm || (at_mm == after_mm && at > after);
    bool is_before = at_mm < best_mm || (at_mm == best_mm && at < best);
    if (is_behind && is_before) {
      best_mm = at_mm;
      best = at;
    }
    at = node.w & 0x7fffffffu;
  }
  ray.next_mm = best_mm;
  ray.next = best;
}

Ray RayOf(ivec2 pixel) {
  Ray ray;
  ray.colour = vec3(0.0);
  ray.passing = 1.0;
  ray.shine_colour = vec3(0.0);
  ray.shine_weight = 0.0;
  ray.pixel = pixel;
  ray.first = heads[pixel.y * image_size.x * supersampling + pixel.x];
  ray.opaque_mm = texelFetch(opaque_mm, pixel, 0).x;
  FindNext(ray, -1.0, 0u);
  return ray;
}

// Hides what is behind by a share. Returns the weight of what hides it.
float Hide(inout Ray ray, float opacity) {
  float weight = ray.passing * opacity;
  ray.passing -= weight;
  return weight;
}

// The next surface.
void Take(inout Ray ray) {
  vec3 colour;
  float opacity = 1.0;
  bool is_tool;
  if (ray.next == kOpaque) {
    vec4 opaque = texelFetch(opaque_colour, ray.pixel, 0);
    colour = opaque.rgb;
    is_tool = opaque.a > 0.0;
  } else {
    uvec4 node = nodes[ray.next - 1u];
    vec2 blue_opacity = unpackHalf2x16(node.z);
    colour = vec3(unpackHalf2x16(node.y), blue_opacity.x);
    opacity = blue_opacity.y;
    is_tool = (node.w >> 31) != 0u;
  }
  float shine = tool_shine * opacity;
  float weight = Hide(ray, opacity);
  if (is_tool && weight < shine && ray.shine_weight == 0.0) {
    ray.shine_weight = shine - weight;
    ray.shine_colour = colour;
  }
  ray.colour += weight * colour;
  if (ray.next == kOpaque) {
    ray.next_mm = kFar;
  } else {
    FindNext(ray, ray.next_mm, ray.next);
  }
}

void PassSurfaces(inout Ray ray, float to_mm) {
  while (ray.next_mm < kFar && ray.next_mm <= to_mm) Take(ray);
}

// A projection of the whole ray: behind all surfaces but an opaque one.
void Cover(inout Ray ray, float share) {
  while (ray.next_mm < kFar && ray.next != kOpaque) Take(ray);
  float weight = Hide(ray, share);
  ray.colour += vec3(weight);
}

// Volume between two distances, and the surfaces within.
void AbsorbAlong(inout Ray ray, vec3 colour, float extinction_per_mm, float from_mm, float to_mm) {
  PassSurfaces(ray, from_mm);
  bool is_left = true;
  while (is_left) {
    float end_mm = min(ray.next_mm, to_mm);
    float weight = Hide(ray, 1.0 - exp(-extinction_per_mm * (end_mm - from_mm)));
    ray.colour += weight * colour;
    is_left = ray.next_mm <= to_mm;
    from_mm = end_mm;
    PassSurfaces(ray, end_mm);
  }
}
)glsl";

constexpr const char* kRest = R"glsl(
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

void CastVolume(inout Ray ray, vec3 direction) {
  vec3 blocks_eye = blocks_linear * eye_mm + blocks_offset;
  vec3 blocks_step = blocks_linear * direction;
  vec2 part = PartOf(direction, blocks_eye, blocks_step, ray.opaque_mm);
  if (!(part.x < part.y)) return;
  has_rest = false;
  last_displacement_mm = vec3(0.0);
  bool has_before = false;
  float hu_before = kOutsideHu;
  float highest_hu = kOutsideHu;
  // A piece needs a sample beyond either end; a maximum takes none that is hidden or cut away.
  int first_sample = int(is_maximum != 0 ? ceil(part.x / step_mm) : part.x / step_mm);
  int last = int(is_maximum != 0 ? part.y / step_mm : ceil(part.y / step_mm));
  for (int n = first_sample; n <= last && ray.passing > dark;) {
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
        AbsorbAlong(ray, lit, emission.w, at_mm - step_mm, at_mm);
      }
    }
    has_before = true;
    hu_before = hu_now;
    ++n;
  }
  if (is_maximum == 0) return;
  float share = (highest_hu - window_hu[0]) / (window_hu[1] - window_hu[0]);
  Cover(ray, clamp(share, 0.0, 1.0));
}

// Colour weighted by opacity, and that.
vec4 Cast(ivec2 pixel) {
  vec3 direction = ct_from_camera * normalize(vec3((vec2(pixel) - centre_px) / focal_px, 1.0));
  Ray ray = RayOf(pixel);
  if (has_volume != 0) CastVolume(ray, direction);
  PassSurfaces(ray, kFar);
  vec4 seen = vec4(mix(ray.colour, ray.shine_colour, ray.shine_weight),
                   mix(1.0 - ray.passing, 1.0, ray.shine_weight));
  return vec4(min(seen.rgb, vec3(1.0)), seen.a);
}

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(pixel, image_size))) return;
  vec4 sum = vec4(0.0);
  for (int j = 0; j < supersampling; ++j) {
    for (int i = 0; i < supersampling; ++i) sum += Cast(supersampling * pixel + ivec2(i, j));
  }
  sum /= float(supersampling * supersampling);
  vec3 background =
      mix(background_top, background_bottom, float(pixel.y) / float(image_size.y));
  vec3 colour = sum.rgb + (1.0 - sum.a) * background;
  pixels[pixel.y * image_size.x + pixel.x] = packUnorm4x8(vec4(colour, sum.a));
}
)glsl";

constexpr const char* kSplit = R"glsl(#version 450 core
layout(local_size_x = 64) in;
layout(std430, binding = 5) readonly buffer Pixels { uint pixels[]; };
layout(std430, binding = 6) writeonly buffer Colours { uint colours[]; };
layout(std430, binding = 7) writeonly buffer Coverage { uint coverage[]; };
uniform int num_pixels;

void main() {
  uint n = gl_GlobalInvocationID.x;
  if (4u * n >= uint(num_pixels)) return;
  uint a = pixels[4u * n];
  uint b = pixels[4u * n + 1u];
  uint c = pixels[4u * n + 2u];
  uint d = pixels[4u * n + 3u];
  colours[3u * n] = (a & 0xffffffu) | (b << 24);
  colours[3u * n + 1u] = ((b >> 8) & 0xffffu) | (c << 16);
  colours[3u * n + 2u] = ((c >> 16) & 0xffu) | (d << 8);
  coverage[n] = (a >> 24) | ((b >> 24) << 8) | ((c >> 24) << 16) | (d & 0xff000000u);
}
)glsl";

}  // namespace

std::string RayShaderSource() {
  std::string source = "#version 450 core\n";
  for (const char* part : {glsl::kMoment, glsl::kLists, glsl::kCuts, kInputs, kSurfaces,
                           glsl::kBreath, glsl::kPressed, kRest, glsl::kLight, kVolume, kMarch}) {
    source += part;
  }
  return source;
}

std::string SplitShaderSource() {
  return kSplit;
}

}  // namespace acus::graphics
