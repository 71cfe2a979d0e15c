// The contact at a post. If the object's lower envelope lies below the surface, the surface is lowered to it.
// Defines:
// - CONTACT: also find the posts on which the object rests
// - CONTACT_MORE: members that a model adds to the parameters
// - BATCH: the fragments are those of a batch, which has many windows in one texture layer. The numbers of posts are counted from the layer's
//   first post. The ground is read from the tiles
// - REGION: the fragments are those of a fixed region. The ground is read from its tile, whose offsets the pass may write in place. `written` has
//   posts that no region before writes. CONTACT_MORE has two more numbers. `region`: from a post in the window to that in the tile; 1: the
//   tile has offsets. `reached`: all posts that the contact writes
// - WITH_ENVELOPE: with BATCH: the pass also computes the lower envelope, with the defines of lib/envelope.glsl. So there are no textures of it

#include "lib/int64.glsl"
#include "lib/tally.glsl"
#include "lib/window.glsl"

#ifdef BATCH
#include "lib/part_ground.glsl"
#elif defined REGION
layout(binding = 0, r32i) readonly restrict uniform iimage2D bases;
layout(binding = 1, r32i) restrict uniform iimage2D offsets;
#else
layout(binding = 0, r32i) readonly restrict uniform iimage2DArray bases;
layout(binding = 1, r32i) readonly restrict uniform iimage2DArray offsets;
#endif
#ifndef WITH_ENVELOPE
layout(binding = 2, r32i) readonly restrict uniform iimage2DArray unders;
#ifdef CONTACT
layout(binding = 3, r32i) readonly restrict uniform iimage2DArray rests;
#endif
#endif

#ifndef CONTACT_MORE
#define CONTACT_MORE
#endif
#ifdef BATCH
ivec4 zero = passed[3], written = passed[4];
#else
layout(std140, binding = 0) uniform params {
	// lo, hi: the window's zero height, fixed-point units from the store's reference; the layer; two spacings, fixed-point units
	ivec4 zero;
	ivec4 written; // the posts this window writes: first, one behind the last
	CONTACT_MORE
};
#endif

#ifdef WITH_ENVELOPE
#include "lib/envelope.glsl"

int under_at(ivec3 at)
{
	int height;
	return envelope(0, at.xy, height) ? height : UNDER_NONE;
}

#ifdef CONTACT
int rest_at(ivec3 at)
{
	int height;
#ifdef AT_REST
	return envelope_at_rest(1, at.xy, height) ? height : UNDER_NONE;
#else
	return envelope(1, at.xy, height) ? height : UNDER_NONE;
#endif
}
#endif
#else
int under_at(ivec3 at)
{
	return imageLoad(unders, at).r;
}

#ifdef CONTACT
int rest_at(ivec3 at)
{
	return imageLoad(rests, at).r;
}
#endif
#endif

struct contact_result {
	int offset;
	uint fell;    // fixed-point units
	uint contact;
	bool written; // this window writes the post; posts on its rim are written and counted by another window
};

contact_result contact_at(ivec2 post)
{
	contact_result p;
	ivec3 at = ivec3(post, zero.z);
#ifdef BATCH
	if (!in_part(post))
		discard;
	int base = part_base(post), offset = part_offset(post);
#elif defined REGION
	int base = imageLoad(bases, post + region.xy).r;
	int offset = region.z != 0 ? imageLoad(offsets, post + region.xy).r : 0;
#else
	int base = imageLoad(bases, at).r;
	int offset = imageLoad(offsets, at).r;
#endif
	int under = under_at(at);
	p.written = all(greaterThanEqual(post, written.xy)) && all(lessThan(post, written.zw));
	p.contact = 0u;
	p.fell = 0u;
	// The lower envelope as an offset: from the base, in 64 bits, since it may be far away.
	i64 ground = i64_sub(i64_shl(i64_from(base), 2), i64(zero.y, uint(zero.x)));
	i64 wanted = i64_sub(i64_from(under), ground);
	bool touches = base != BASE_NODATA && under != UNDER_NONE && !i64_less(i64_from(offset), wanted);
#ifdef CONTACT
	p.contact = base == BASE_NODATA ? NO_GROUND : 0u;
	if (base != BASE_NODATA && under != UNDER_NONE && i64_less(wanted, i64_from(offset + zero.w)))
		p.contact |= NEAR;
#endif
	if (touches && i64_less(wanted, i64_from(-OFFSET_LIMIT))) {
		if (p.written)
			tally_add(REFUSED, 1u);
		touches = false;
	}
	if (touches) {
		p.fell = uint(offset) - uint(i64_to_int(wanted));
		offset = i64_to_int(wanted);
		p.contact |= LOWERED;
	}
#ifdef CONTACT
	int rest = rest_at(at);
	if (base != BASE_NODATA && rest != UNDER_NONE &&
	    !i64_less(i64_add(ground, i64_from(offset + TOUCH)), i64_from(rest)))
		p.contact |= HELD;
#endif
	p.offset = offset;
	return p;
}

// The most soil that one post gives away, fixed-point units, so that sums of it fit 32 bits.
const uint CARRIED_MOST = 1u << 23;

// Returns how much of the soil that fell at the post is carried to posts around, fixed-point units. share: in 2^-31. The rest is
// compacted.

int contact_carry(contact_result p, uint share)
{
	uint high, low;
	umulExtended(p.fell, share, high, low);
	uint carried = min((high << 1) | (low >> 31), CARRIED_MOST);
	if (p.written && p.fell > carried)
		tally_add(COMPACTED, p.fell - carried);
	return int(carried);
}
