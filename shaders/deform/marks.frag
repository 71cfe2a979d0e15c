#version 450 core
// Marks that fade: each post has the time at which its mark is gone. One fragment for each post.
// Defines: HEALS: disturbance that heals is kept. GROWS: vegetation is kept.

layout(binding = 0) uniform isampler2DArray offsets;
layout(binding = 1) uniform usampler2DArray contacts;
layout(binding = 2) uniform isampler2DArray healed;
layout(binding = 3) uniform isampler2DArray risen;
layout(binding = 4) uniform isampler2DArray grown;

layout(std140, binding = 0) uniform params {
	ivec4 window; // posts in x and y; the layer
	ivec4 mark;   // in quarter seconds. x: the time now. y: how long the darkest disturbance heals. z: the time at which stems bent now have risen; w: cover torn now has grown
};

#ifdef HEALS
layout(location = 0) out int healed_out;
#define FIRST 1
#else
#define FIRST 0
#endif
#ifdef GROWS
layout(location = FIRST) out int risen_out;
layout(location = FIRST + 1) out int grown_out;
#endif

// As plane_mark() of src/base/plane.c: rounded up.
int until(int shades)
{
	return mark.x + shades * (mark.y / 255) + (shades * (mark.y % 255) + 254) / 255;
}

void main()
{
	ivec3 post = ivec3(ivec2(gl_FragCoord.xy), window.z);
	bool lowered = (texelFetch(contacts, post, 0).r & 1u) != 0u;
#ifdef HEALS
	int before = texelFetch(healed, post, 0).r, shades = min(255, 96 + (max(0, -texelFetch(offsets, post, 0).r) >> 10));
	healed_out = lowered ? max(before, until(shades)) : before;
#endif
#ifdef GROWS
	int bent = texelFetch(risen, post, 0).r, torn = texelFetch(grown, post, 0).r;
	risen_out = lowered ? max(bent, mark.z) : bent;
	grown_out = lowered ? max(torn, mark.w) : torn;
#endif
}
