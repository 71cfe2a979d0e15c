// Shadows that the terrain casts on itself, from depth maps that were drawn toward the sun (src/render/shade_map.c). Each map covers a
// larger region than the one before.
layout(binding = 6) uniform sampler2DArray shade_map;

// Returns the share of the sun that a place is lit by. normal: of the surface there.
float sunlit(vec3 place, vec3 normal)
{
	for (int i = 0; i < 4; i++) {
		vec4 middle = shade_middle[i], scale = shade_scale[i];
		// The place is moved out of the surface by two texels, so that the surface does not shade itself.
		vec3 from = place + normal * (2.0 * scale.w);
		vec3 at = (vec3(dot(shade_across.xyz, from), dot(shade_along.xyz, from), dot(sun.xyz, from)) - middle.xyz) * scale.xyz;
		if (max(abs(at.x), abs(at.y)) >= 0.98)
			continue;
		vec2 texel = (0.5 * at.xy + 0.5) * vec2(textureSize(shade_map, 0).xy) - 0.5;
		ivec2 low = ivec2(floor(texel));
		vec2 part = texel - vec2(low);
		float toward = at.z + middle.w;
		vec4 nearest = vec4(texelFetch(shade_map, ivec3(low, i), 0).r, texelFetch(shade_map, ivec3(low + ivec2(1, 0), i), 0).r,
				    texelFetch(shade_map, ivec3(low + ivec2(0, 1), i), 0).r, texelFetch(shade_map, ivec3(low + 1, i), 0).r);
		vec4 lit = step(nearest, vec4(toward));
		vec2 row = mix(lit.xz, lit.yw, part.x);
		return mix(row.x, row.y, part.y);
	}
	return 1.0;
}
