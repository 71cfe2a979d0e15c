// What the ground is made of: grass, soil, rock and snow by slope and height, with borders that noise
// moves.
#include "lib/noise.glsl"

struct ground_surface {
	vec3 albedo;
	float loose; // how much of it a wheel digs up: 0 rock .. 1 soil
	float rough; // how far its noise tilts it
};

// `large` is noise of kilometres, `near` of pixels.
ground_surface ground_at(vec2 metres, float large, float near, float height, float steep)
{
	float middle = noise_at(metres + 91.0, 256.0).x;
	float crag = 1.0 - 2.0 * abs(near);

	// 0 at the lowest, 1 at the highest; flat country stays green to its top.
	float mountain = smoothstep(250.0, 900.0, relief.z);
	float rise = clamp((height - relief.x) * relief.y, 0.0, 1.0) + 0.20 * large + 0.08 * middle + 0.08 * near;
	float slope = steep + 0.30 * near + 0.18 * middle;

	vec3 grass = mix(vec3(0.052, 0.064, 0.024), vec3(0.135, 0.120, 0.055),
			 clamp(0.45 + 1.3 * large + 0.6 * middle + 0.9 * near, 0.0, 1.0));
	vec3 soil = mix(vec3(0.100, 0.072, 0.046), vec3(0.215, 0.165, 0.112),
			clamp(0.5 + 1.0 * middle + 0.6 * large + 0.8 * near, 0.0, 1.0));
	vec3 rock = mix(vec3(0.075, 0.070, 0.066), vec3(0.210, 0.192, 0.168),
			clamp(0.9 * crag - 0.25 + 0.5 * middle + 0.3 * large, 0.0, 1.0));
	const vec3 snow = vec3(0.70, 0.74, 0.80);

	float bare = smoothstep(0.36, 0.58, slope) + mountain * smoothstep(0.46, 0.62, rise);
	bare = max(bare, 0.75 * smoothstep(0.02, 0.16, 0.6 * large + 0.5 * middle + 0.3 * near));
	float stony = smoothstep(0.55, 0.80, slope) + 0.85 * mountain * smoothstep(0.60, 0.78, rise);
	float white = mountain * smoothstep(0.69, 0.75, rise - 0.10 * max(steep - 0.6, 0.0)) *
		      (1.0 - smoothstep(0.75, 1.05, slope));

	ground_surface surface;
	stony = clamp(stony, 0.0, 1.0);
	surface.albedo = mix(grass, soil, clamp(bare, 0.0, 1.0)) * (1.0 + 0.8 * near);
	surface.albedo = mix(surface.albedo, rock, stony);
	surface.albedo = mix(surface.albedo, snow * (1.0 + 0.10 * near), white);
	surface.loose = 1.0 - 0.6 * stony;
	surface.rough = (0.018 + 0.030 * stony) * (1.0 - 0.75 * white);
	return surface;
}
