#version 450 core
// An elastic sheet, second pass: the body makes a rut of what is beyond the yield, and holds the sheet down to its envelope. One fragment for each post
// of the window.

#include "lib/sheet.glsl"
#include "lib/tally.glsl"

layout(binding = 0) uniform isampler2DArray bases;
layout(binding = 1) uniform isampler2DArray offsets;
layout(binding = 2) uniform isampler2DArray floors;
layout(binding = 3) uniform isampler2DArray unders;
layout(binding = 4) uniform isampler2DArray rests;

layout(location = 0) out int surface_out; // where the post may change; elsewhere its offset
layout(location = 1) out uint contact_out;
layout(location = 2) out int bent_out;    // its deflection
layout(location = 3) out int holder_out;

// Returns how far the sheet's own surface sinks, fixed-point units.
uint sinks(int base, int under, int surface)
{
	i64 depth = depth_below(base, under, surface), beyond = i64_sub(depth, i64(0, law.z));
	bool holds = !i64_less(i64_sub(i64_from(surface), depth), i64_from(-OFFSET_LIMIT));
	if (under == UNDER_NONE || !holds || !i64_less(i64(0, 0u), beyond))
		return 0u;
	uint rut = uint(max(-surface, 0)), whole = share_of(rut + beyond.lo, law.w); // less than 2^32, as the depth is at most twice OFFSET_LIMIT and 8 m
	return whole > rut ? whole - rut : 0u;
}

void main()
{
	ivec3 at = ivec3(ivec2(gl_FragCoord.xy), zero.z);
	int base = texelFetch(bases, at, 0).r, offset = texelFetch(offsets, at, 0).r, held = texelFetch(floors, at, 0).r;
	bool ground = base != BASE_NODATA, may = ground && is_written(at.xy), acts = may && zero.w == 0;
	int deflection = ground ? deflection_of(held) : 0, surface = surface_of(offset, deflection), rest = texelFetch(rests, at, 0).r;
	uint contact = ground ? 0u : NO_GROUND, by = ground && (held & 1) != 0 ? OF_OTHERS : 0u, least = 0u;
	uint sunk = acts && law.z < uint(SHEET_MOST) ? sinks(base, texelFetch(unders, at, 0).r, surface) : 0u;
	if (sunk > 0u) {
		surface = int(uint(surface) - sunk);
		deflection = sunk < uint(deflection) ? deflection - int(sunk) : 0;
		contact |= LOWERED;
	}
	i64 depth = depth_below(base, rest, surface);
	bool deeper = acts && rest != UNDER_NONE && i64_less(i64(0, 0u), depth);
	bool refuses = deeper && (!i64_less(depth, i64_from(SHEET_MOST)) || i64_less(i64_sub(i64_from(surface), depth), i64_from(-OFFSET_LIMIT)));
	if (refuses)
		tally_add(REFUSED, 1u);
	if (deeper && !refuses && !(by == OF_OTHERS && i64_to_int(depth) <= deflection)) {
		by = OF_THIS;
		least = depth.lo << SHEET_BITS;
		deflection = max(deflection, i64_to_int(depth));
		contact |= LOWERED | HELD;
	}
	surface_out = may ? surface : offset;
	contact_out = contact;
	bent_out = deflection << SHEET_BITS;
	holder_out = int(by << 29 | least);
}
