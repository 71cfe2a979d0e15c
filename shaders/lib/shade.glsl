// Shadows that the terrain casts on itself, from depth maps that were drawn toward the sun (src/render/shade_map.c). Each map covers a
// larger region than the one before, with coarser texels.
//
// A surface must not shade itself. So the place is moved out of the surface by a share of a texel. Also, each texel is compared with the
// depth that the place's own triangle has there. A move shortens shadows by itself divided by the tangent of the sun's height. Where the sun
// is low and texels are large, that is metres. So toward its edge each map passes gradually to the next. The move grows to that of the
// next map, and the next map's light takes over.
layout(binding = 6) uniform sampler2DArray shade_map;

#define SHADE_MAPS 4
// How far from the map's middle the next map begins to take over, and from where on it counts alone. 1 is the side of the map.
#define SHADE_BLEND 0.70
#define SHADE_END 0.98
// The triangle's own depth gives half of what is needed, the move the other half and some more. With the depth alone light would get to the
// foot of slopes. With the move alone shadows would be shorter. SHADE_MOVE: texels, times the slope of the surface as the sun sees it.
#define SHADE_OWN 0.5
#define SHADE_MOVE 0.6

// Returns where a place is in a map: -1 .. 1 across and along, then toward the sun.
vec3 shade_place(int map, vec3 place)
{
	return (vec3(dot(shade_across.xyz, place), dot(shade_along.xyz, place), dot(sun.xyz, place)) - shade_middle[map].xyz) * shade_scale[map].xyz;
}

// Returns the size of a map's texels across and along, metres.
vec2 shade_texel(int map)
{
	return shade_scale[map].w * vec2(1.0, shade_scale[map].x / shade_scale[map].y);
}

// Returns the share of the sun that a place is lit by in one map: between the four texels around it. rise: of the place's triangle toward
// the sun, for each metre across and along.
float shade_look(int map, vec3 place, vec2 rise)
{
	vec3 at = shade_place(map, place);
	vec2 texel = (0.5 * at.xy + 0.5) * vec2(textureSize(shade_map, 0).xy) - 0.5;
	ivec2 low = ivec2(floor(texel));
	vec2 part = texel - vec2(low), one = rise * shade_texel(map) * shade_scale[map].z;
	float toward = at.z + shade_middle[map].w - dot(one, part);
	vec4 nearest = vec4(texelFetch(shade_map, ivec3(low, map), 0).r, texelFetch(shade_map, ivec3(low + ivec2(1, 0), map), 0).r,
			    texelFetch(shade_map, ivec3(low + ivec2(0, 1), map), 0).r, texelFetch(shade_map, ivec3(low + 1, map), 0).r);
	vec4 lit = step(nearest, toward + vec4(0.0, one.x, one.y, one.x + one.y));
	vec2 row = mix(lit.xz, lit.yw, part.x);
	return mix(row.x, row.y, part.y);
}

// Returns the share of the sun that a place is lit by. normal: of the surface there, without detail finer than the mesh. triangle: normal
// of the triangle that is drawn there, or the direction to the sun, for what is not in the maps itself.
float sunlit(vec3 place, vec3 normal, vec3 triangle)
{
	vec2 lean = abs(vec2(dot(shade_across.xyz, normal), dot(shade_along.xyz, normal))) * SHADE_MOVE;
	// A triangle that is turned away from the sun more than level ground would see through others.
	float turned = dot(sun.xyz, triangle), least = max(sun.z, 1e-3);
	vec2 rise = -vec2(dot(shade_across.xyz, triangle), dot(shade_along.xyz, triangle)) *
		    (SHADE_OWN * clamp(turned / least, 0.0, 1.0) / max(turned, least));
	for (int map = 0; map < SHADE_MAPS; map++) {
		vec2 from_middle = abs(shade_place(map, place).xy);
		float part = clamp((max(from_middle.x, from_middle.y) - SHADE_BLEND) * (1.0 / (SHADE_END - SHADE_BLEND)), 0.0, 1.0);
		if (part >= 1.0)
			continue;
		float move = dot(lean, shade_texel(map));
		if (part <= 0.0)
			return shade_look(map, place + normal * move, rise);
		// Beyond the last map the ground is in the sun.
		const bool last = map == SHADE_MAPS - 1;
		float next = last ? move : dot(lean, shade_texel(map + 1));
		float beyond = last ? 1.0 : shade_look(map + 1, place + normal * next, rise);
		return mix(shade_look(map, place + normal * mix(move, next, part), rise), beyond, part);
	}
	return 1.0;
}
