/* The contact at posts of a row: the same as shaders/lib/contact.glsl. See contact.h. */
#include "soil/kinematic/contact.h"

#include "soil/kinematic/rows.h"

#define OFFSET_LIMIT (1 << 30)   /* fixed-point units: 1024 m */
#define TOUCH 4                  /* fixed-point units; the envelopes of a motion and of its end pose are rounded separately */
#define SHADES 255               /* of disturbance: PLANE_MARK_MOST */
#define CARRIED_MOST (1 << 23)   /* the most soil that one post gives away, so that sums of it fit 32 bits */

/* Returns how far the ground is above the zero of the lower envelopes. */
SOIL_INLINED int64_t ground_of(int32_t base, int64_t zero)
{
	return (int64_t)base * 4 - zero;
}

/* Lowers the posts. `carries` is a literal: writes to `carried` by how much they fell. Returns how many of the written posts refuse. */
SOIL_INLINED int32_t lower(const struct contact_row *r, const int32_t *restrict bases, const int32_t *restrict unders,
				  const int32_t *restrict rests, int32_t *restrict offsets, uint8_t *restrict contacts, bool carries, int32_t *restrict carried)
{
	const int64_t zero = r->zero;
	const int32_t count = r->count, first = r->written[0], last = r->written[1];
	const uint32_t near = (uint32_t)r->near;
	int32_t refused = 0;
	for (int32_t i = 0; i < count; i++) {
		const int32_t base = bases[i], offset = offsets[i], under = unders[i], rest = rests[i];
		const int64_t ground = ground_of(base, zero), wanted = under - ground; /* of the lower envelope, as an offset */
		const bool has_ground = base != BASE_NODATA, above = has_ground & (under != UNDER_NONE);
		const bool is_near = above & (wanted < (int32_t)((uint32_t)offset + near)), meets = above & (wanted <= offset);
		const bool refuses = meets & (wanted < -OFFSET_LIMIT), touches = meets & !refuses;
		const int32_t lowered = touches ? (int32_t)wanted : offset;
		const bool held = has_ground & (rest != UNDER_NONE) & (ground + lowered + TOUCH >= rest);
		offsets[i] = lowered;
		contacts[i] = (uint8_t)((has_ground ? 0 : SOIL_NO_GROUND) | (is_near ? SOIL_NEAR : 0) | (touches ? SOIL_LOWERED : 0) | (held ? SOIL_HELD : 0));
		refused += refuses & (i >= first) & (i < last);
		if (carries)
			carried[i] = (int32_t)((uint32_t)offset - (uint32_t)lowered);
	}
	return refused;
}

SOIL_INLINED void lower_row(const struct contact_row *r, bool carries, struct soil_kinematic_tally *tally)
{
	tally->refused += (uint64_t)lower(r, r->base, r->under, r->rest, r->offset, r->contact, carries, r->carried);
}

/* Parts the soil that fell. kept: the share of each post, or of the first alone; `each` is a literal that tells which. */
SOIL_INLINED void part(int32_t count, const int32_t written[2], const uint32_t *restrict kept, bool each, int32_t *restrict carried,
			      struct soil_kinematic_tally *tally)
{
	const int32_t first = written[0], last = written[1];
	const int64_t share = kept[0];
	int64_t compacted = 0;
	for (int32_t i = 0; i < count; i++) {
		const int64_t fell = (int64_t)(uint32_t)carried[i], by = each ? (int64_t)kept[i] : share, away = fell * by >> 31;
		const int64_t carries = away < CARRIED_MOST ? away : CARRIED_MOST;
		carried[i] = (int32_t)carries;
		compacted += ((i >= first) & (i < last)) ? fell - carries : 0;
	}
	tally->compacted += compacted;
}

static SOIL_LANES void lose(const struct contact_row *row, struct soil_kinematic_tally *tally)
{
	lower_row(row, false, tally);
}

static SOIL_LANES void carry(const struct contact_row *row, const uint32_t *kept, struct soil_kinematic_tally *tally)
{
	lower_row(row, true, tally);
	part(row->count, row->written, kept, false, row->carried, tally);
}

static SOIL_LANES void carry_by_class(const struct contact_row *row, const uint32_t *kept, struct soil_kinematic_tally *tally)
{
	uint32_t shares[8 * LANES];
	lower_row(row, true, tally);
	for (int32_t at = 0; at < row->count; at += 8 * LANES) {
		const int32_t count = lane_least(row->count - at, 8 * LANES), written[2] = {row->written[0] - at, row->written[1] - at};
		for (int32_t i = 0; i < count; i++)
			shares[i] = kept[row->classes[at + i] < SOIL_CLASSES ? row->classes[at + i] : SOIL_CLASSES - 1];
		part(count, written, shares, true, row->carried + at, tally);
	}
}

void soil_contact_row(const struct contact_row *row, const uint32_t kept[SOIL_CLASSES], struct soil_kinematic_tally *tally)
{
	if (row->carried == NULL)
		lose(row, tally);
	else
		(row->classes == NULL ? carry : carry_by_class)(row, kept, tally);
}

SOIL_INLINED void hold(int32_t count, int64_t zero, const int32_t *restrict bases, const int32_t *restrict offsets, const int32_t *restrict rests,
			      uint8_t *restrict contacts)
{
	for (int32_t i = 0; i < count; i++) {
		const int64_t above = ground_of(bases[i], zero) + offsets[i] - rests[i];
		const bool held = (bases[i] != BASE_NODATA) & (rests[i] != UNDER_NONE) & (above >= -TOUCH) & (above <= TOUCH);
		contacts[i] = (uint8_t)(contacts[i] | (held ? SOIL_HELD : 0));
	}
}

SOIL_LANES void soil_hold_row(const struct contact_row *row)
{
	hold(row->count, row->zero, row->base, row->offset, row->rest, row->contact);
}

bool soil_is_inside_row(const struct contact_row *row)
{
	for (int32_t i = 0; i < row->count; i++)
		if (row->base[i] != BASE_NODATA && row->rest[i] != UNDER_NONE && ground_of(row->base[i], row->zero) + row->offset[i] > (int64_t)row->rest[i] + TOUCH)
			return true;
	return false;
}

bool soil_roof_row(const struct contact_row *row, const int32_t *tops, int32_t *highest)
{
	bool any = false;
	for (int32_t i = 0; i < row->count; i++) {
		if (row->base[i] == BASE_NODATA || row->rest[i] == UNDER_NONE)
			continue;
		const int64_t ground = ground_of(row->base[i], row->zero), room = row->rest[i] - ground;
		const bool inside = row->offset[i] > room + TOUCH;
		if (room >= OFFSET_LIMIT || room <= -OFFSET_LIMIT || (inside && tops != NULL && tops[i] != UNDER_NONE && ground + row->offset[i] >= -(int64_t)tops[i]))
			continue;
		highest[i] = room < highest[i] ? (int32_t)room : highest[i];
		any = true;
	}
	return any;
}

/* Returns how dark a post is that was lowered to this offset. */
SOIL_INLINED int32_t shades_of(int32_t offset)
{
	const int32_t down = offset < 0 ? -offset >> 10 : 0;
	return 96 + down < SHADES ? 96 + down : SHADES;
}

SOIL_LANES void soil_disturb_row(int32_t count, const uint8_t *restrict contact, const int32_t *restrict offset, uint8_t *restrict disturbance)
{
	for (int32_t i = 0; i < count; i++) {
		const int32_t depth = shades_of(offset[i]);
		disturbance[i] = (uint8_t)((contact[i] & SOIL_LOWERED) && disturbance[i] < depth ? depth : disturbance[i]);
	}
}

/* The same as plane_mark(), in 32 bits, as marks.frag has it. */
SOIL_LANES void soil_heal_row(int32_t count, const uint8_t *restrict contact, const int32_t *restrict offset, int32_t now, int32_t heals, int32_t *restrict healed)
{
	const int32_t each = heals / SHADES, rest = heals % SHADES;
	for (int32_t i = 0; i < count; i++) {
		const int32_t shades = shades_of(offset[i]), until = now + shades * each + (shades * rest + SHADES - 1) / SHADES;
		healed[i] = (contact[i] & SOIL_LOWERED) && healed[i] < until ? until : healed[i];
	}
}

SOIL_LANES void soil_mark_row(int32_t count, const uint8_t *restrict contact, int32_t until, int32_t *restrict plane)
{
	for (int32_t i = 0; i < count; i++)
		plane[i] = (contact[i] & SOIL_LOWERED) && plane[i] < until ? until : plane[i];
}
