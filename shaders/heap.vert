#version 450 core
// Places the corners of soil that bodies carry. The CPU has found where they are (src/render/heaps.c).
#include "lib/picture.glsl"
#ifdef TEXTURE
#include "lib/ground_map.glsl"
#endif
#ifdef FOG
#include "lib/body.glsl"
#include "lib/sky.glsl"
#include "lib/haze.glsl"
#endif

// A corner has two uvec4. In the first xyz are the bits of three floats: the place relative to the eye, metres. Its w has the normal's three components, 10 bits each.
// In the second xy are the bits of two floats: the place along the axes of the cells, metres. Its z has the bits of these axes' angle, rad. The low 8 bits of w are the
// soil's class. Those above them are how high the ground below the body is: 0 the lowest, 65535 the highest.
layout(std430, binding = 0) readonly buffer corners {
	uvec4 corner[];
};

out vec3 place;  // metres relative to the eye
out vec3 normal;
flat out vec2 along; // direction of the cells' first axis
flat out int heap_class;
#ifdef TEXTURE
out vec4 squares; // place in the ground's near texture (xy) and far one (zw), which go with the body
out vec2 country; // as terrain.vert has it, of the ground below the body
#else
flat out float high;
#endif
#ifdef FOG
out vec2 air;
#endif

void main()
{
	uvec4 where = corner[2 * gl_VertexID], what = corner[2 * gl_VertexID + 1];
	vec2 own = uintBitsToFloat(what.xy);
	float angle = uintBitsToFloat(what.z);
	place = uintBitsToFloat(where.xyz);
	normal = vec3(ivec3(where.www << uvec3(22, 12, 2)) >> 22);
	along = vec2(cos(angle), sin(angle));
	heap_class = int(what.w & 255u);
	float rise = float(what.w >> 8) / 65535.0;
#ifdef TEXTURE
	squares = vec4(vec2(2.0 * own.x + own.y, 2.0 * own.y - own.x) / 8.0, vec2(3.0 * own.x + own.y, 3.0 * own.y - own.x) / 512.0);
	country.x = ground_region(pattern.xy + place.xy);
	country.y = min(rise, 0.3) + max(rise - 0.3, 0.0) * relief.z;
#else
	high = rise;
#endif
#ifdef FOG
	air = haze_between(place);
#endif
	gl_Position = project * vec4(place, 1.0);
}
