#include "acus/imaging/graphics/blocks_shader.h"

namespace acus::graphics {
namespace {

constexpr const char* kMark = R"glsl(#version 450 core
layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer Rest { ivec4 rest[]; };
// Lowest and highest displacement, by block and component.
layout(std430, binding = 1) readonly buffer Ranges { vec4 ranges_mm[]; };
layout(binding = 0, r8ui) writeonly uniform uimage3D marked;
uniform int num_blocks;
uniform int num_components;  // The field has so many.
uniform int num_weights;     // At this instant.
uniform ivec4 component;
uniform vec4 weight;
uniform ivec4 margin;
uniform vec4 reach;
uniform vec4 blocks_per_mm_x;
uniform vec4 blocks_per_mm_y;
uniform vec4 blocks_per_mm_z;
// The arithmetic of cards differs in the last bits.
const float kSlack = 1.0e-3;

void main() {
  int block = int(gl_GlobalInvocationID.x);
  if (block >= num_blocks) return;
  vec3 low_mm = vec3(0.0);
  vec3 high_mm = vec3(0.0);
  for (int n = 0; n < num_weights; ++n) {
    int at = 2 * (block * num_components + component[n]);
    vec3 a = weight[n] * ranges_mm[at].xyz;
    vec3 b = weight[n] * ranges_mm[at + 1].xyz;
    low_mm += min(a, b);
    high_mm += max(a, b);
  }
  vec3 middle_mm = 0.5 * (low_mm + high_mm);
  vec3 half_mm = 0.5 * (high_mm - low_mm);
  vec3 middle = vec3(dot(blocks_per_mm_x.xyz, middle_mm), dot(blocks_per_mm_y.xyz, middle_mm),
                     dot(blocks_per_mm_z.xyz, middle_mm));
  vec3 aside = vec3(dot(abs(blocks_per_mm_x.xyz), half_mm), dot(abs(blocks_per_mm_y.xyz), half_mm),
                    dot(abs(blocks_per_mm_z.xyz), half_mm)) + reach.xyz + kSlack;
  vec3 at = vec3(rest[block].xyz + 1 + margin.xyz) + middle;
  ivec3 from = max(ivec3(floor(at - aside)), ivec3(0));
  ivec3 to = min(ivec3(floor(at + 1.0 + aside)), imageSize(marked) - 1);
  for (int k = from.z; k <= to.z; ++k) {
    for (int j = from.y; j <= to.y; ++j) {
      for (int i = from.x; i <= to.x; ++i) imageStore(marked, ivec3(i, j, k), uvec4(0u));
    }
  }
}
)glsl";

constexpr const char* kSpread = R"glsl(#version 450 core
layout(local_size_x = 4, local_size_y = 4, local_size_z = 4) in;
layout(binding = 0, r8ui) readonly uniform uimage3D before;
layout(binding = 1, r8ui) writeonly uniform uimage3D after;
uniform ivec4 along;

void main() {
  ivec3 block = ivec3(gl_GlobalInvocationID);
  ivec3 size = imageSize(before);
  if (any(greaterThanEqual(block, size))) return;
  uint best = imageLoad(before, block).x;
  for (uint n = 1u; n < best; ++n) {
    ivec3 low = block - int(n) * along.xyz;
    ivec3 high = block + int(n) * along.xyz;
    bool is_low_inside = all(greaterThanEqual(low, ivec3(0)));
    bool is_high_inside = all(lessThan(high, size));
    if (!is_low_inside && !is_high_inside) break;
    if (is_low_inside) best = min(best, max(n, imageLoad(before, low).x));
    if (is_high_inside) best = min(best, max(n, imageLoad(before, high).x));
  }
  imageStore(after, block, uvec4(best));
}
)glsl";

constexpr const char* kWiden = R"glsl(#version 450 core
layout(local_size_x = 4, local_size_y = 4, local_size_z = 4) in;
layout(binding = 0, r8ui) uniform uimage3D distances;
uniform ivec4 from;
uniform ivec4 to;
uniform int reach;

void main() {
  ivec3 block = from.xyz + ivec3(gl_GlobalInvocationID);
  if (any(greaterThan(block, to.xyz))) return;
  if (imageLoad(distances, block).x <= uint(reach)) imageStore(distances, block, uvec4(0u));
}
)glsl";

}  // namespace

std::string MarkBlocksSource() {
  return kMark;
}

std::string SpreadDistancesSource() {
  return kSpread;
}

std::string WidenBlocksSource() {
  return kWiden;
}

}  // namespace acus::graphics
