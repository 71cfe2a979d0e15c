#version 450 core
// The ground beyond the terrain: a frame around it. Its heights are those of the coarsest tile, mirrored at the terrain's edge, and level off
// away from it. There the ground bends down as the planet does.
//
// Each of the four sides has blocks like those of a tile. The first row lies within the terrain, the second at its edge, and the others are
// farther and farther away. Sides meet in the corners' diagonals.
#include "lib/picture.glsl"
#include "lib/body.glsl"
#include "lib/apron.glsl"
#ifdef FOG
#include "lib/sky.glsl"
#include "lib/haze.glsl"
#endif

#define NODATA int(0x80000000)
// Blocks along a side, and away from it: RENDER_APRON_ALONG and RENDER_APRON_AWAY. A block has 8 cells along each.
#define ALONG 8
#define AWAY 2

layout(binding = 0) uniform isampler2D base_map;

// Distances of rows from the edge. The first lies within the terrain. The ground is level from 1 on, and two more rows go to the horizon.
const float rows[15] = float[15](-0.02, 0.0, 0.02, 0.05, 0.09, 0.14, 0.20, 0.27, 0.35, 0.44, 0.54, 0.65, 0.77, 0.90, 1.0);

out vec3 place;
out vec2 gradient;
out vec2 metres; // from the terrain's south-west post
#ifdef FOG
out vec2 air;
#endif

// Returns the height of a post of the coarsest tile relative to the eye; of one without data, `level`.
float post_height(ivec2 at, float level)
{
	int base = texelFetch(base_map, at, 0).r;
	return base == NODATA ? level : float((base >> 1) - tile.z) * half_base_metre - origin.w;
}

float height_between(vec2 post, float level)
{
	ivec2 low = ivec2(post), high = min(low + 1, ivec2(ground.xy));
	vec2 part = post - vec2(low);
	return mix(mix(post_height(low, level), post_height(ivec2(high.x, low.y), level), part.x),
		   mix(post_height(ivec2(low.x, high.y), level), post_height(high, level), part.x), part.y);
}

// Returns the slope of the coarsest tile around a post, over as many metres as rows are apart.
vec2 slope_around(vec2 post, float level)
{
	ivec2 at = ivec2(post + 0.5), last = ivec2(ground.xy);
	int reach = max(int(0.03 * detail.x / origin.z), 1);
	ivec2 low = max(at - reach, ivec2(0)), high = min(at + reach, last);
	return vec2(post_height(ivec2(high.x, at.y), level) - post_height(ivec2(low.x, at.y), level),
		    post_height(ivec2(at.x, high.y), level) - post_height(ivec2(at.x, low.y), level)) / (vec2(max(high - low, ivec2(1))) * origin.z);
}

void main()
{
	int side = tile.w + 1, edge = gl_InstanceID / (ALONG * AWAY), block = gl_InstanceID % (ALONG * AWAY);
	int row = min((block / ALONG) * tile.w + gl_VertexID / side, 16);
	float along = float((block % ALONG) * tile.w + gl_VertexID % side) / float(ALONG * tile.w);
	along = edge == 0 || edge == 3 ? 1.0 - along : along; // so that all sides have their front above
	float level = relief.x + detail.y - relief.w, horizon_distance = sqrt(2.0 * planet_radius * max(-level, 2.0));
	float apart = detail.x * rows[min(row, 14)] + horizon_distance * (row == 15 ? 0.2 : row == 16 ? 1.0 : 0.0);

	// 0 south, 1 north, 2 west, 3 east.
	vec2 size = ground.zw;
	bool upright = edge >= 2;
	float there = mix(-apart, (upright ? size.y : size.x) + apart, along);
	float beyond = (edge & 1) == 0 ? -apart : (upright ? size.x : size.y) + apart;
	metres = upright ? vec2(beyond, there) : vec2(there, beyond);
	vec2 outward = metres - clamp(metres, vec2(0.0), size);
	if (row > 14) { // the horizon is round
		outward *= apart / length(outward);
		metres = clamp(metres, vec2(0.0), size) + outward;
	}

	vec2 mirrored = clamp(size - abs(size - abs(metres)), vec2(0.0), size);
	vec2 post = min(mirrored / origin.z, ground.xy);
	float height = height_between(post, level), fade = smoothstep(0.0, 1.0, rows[min(row, 14)]);
	place = vec3(origin.xy + metres, mix(height, level, fade) - dot(outward, outward) / (2.0 * planet_radius));
	gradient = slope_around(post, level) * (1.0 - fade) * mix(vec2(-1.0), vec2(1.0), vec2(equal(mirrored, metres)));
#ifdef FOG
	air = haze_between(place);
#endif
	// Behind all terrain, and before the sky: what reads the depth takes both for sky.
	gl_Position = project * vec4(place, 1.0);
	gl_Position.z *= 1e-11;
}
