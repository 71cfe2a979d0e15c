/* The contact at posts of a row: the same as shaders/lib/contact.glsl. See contact.h. */
#include "soil/kinematic/contact.h"

#include "soil/kinematic/rows.h"

#define OFFSET_LIMIT (1 << 30)   /* fixed-point units: 1024 m */
#define TOUCH 4                  /* fixed-point units; the envelopes of a motion and of its end pose are rounded separately */
#define CARRIED_MOST (1u << 23)  /* the most soil that one post gives away, so that sums of it fit 32 bits */

/* Returns how far the ground is above the zero of the lower envelopes. */
static SOIL_INLINED int64_t ground_of(int32_t base, int64_t zero)
{
	return (int64_t)base * 4 - zero;
}

/* `carries` and `classes` are literals. */
static SOIL_INLINED void contact_row(const struct contact_row *r, const uint32_t *kept, bool carries, bool has_classes, struct soil_kinematic_tally *tally)
{
	const int64_t zero = r->zero;
	const int32_t count = r->count, first = r->written[0], last = r->written[1];
	const int32_t *restrict bases = r->base, *restrict unders = r->under, *restrict rests = r->rest;
	int32_t *restrict offsets = r->offset, *restrict carried = r->carried;
	uint8_t *restrict contacts = r->contact;
	const uint8_t *restrict classes = r->classes;
	const uint32_t near = (uint32_t)r->near, share = kept[0];
	int64_t compacted = 0;
	uint64_t refused = 0;
	for (int32_t i = 0; i < count; i++) {
		const int32_t base = bases[i], offset = offsets[i], under = unders[i], rest = rests[i];
		const int64_t ground = ground_of(base, zero), wanted = under - ground; /* of the lower envelope, as an offset */
		const bool has_ground = base != BASE_NODATA, above = has_ground & (under != UNDER_NONE);
		const bool is_near = above & (wanted < (int32_t)((uint32_t)offset + near)), meets = above & (wanted <= offset);
		const bool refuses = meets & (wanted < -OFFSET_LIMIT), touches = meets & !refuses;
		const bool counts = (i >= first) & (i < last);
		const int32_t lowered = touches ? (int32_t)wanted : offset;
		const bool held = has_ground & (rest != UNDER_NONE) & (ground + lowered + TOUCH >= rest);
		offsets[i] = lowered;
		contacts[i] = (uint8_t)((has_ground ? 0 : SOIL_NO_GROUND) | (is_near ? SOIL_NEAR : 0) | (touches ? SOIL_LOWERED : 0) | (held ? SOIL_HELD : 0));
		refused += refuses & counts;
		if (carries) {
			const uint32_t fell = (uint32_t)offset - (uint32_t)lowered, by = has_classes ? kept[classes[i] < SOIL_CLASSES ? classes[i] : SOIL_CLASSES - 1] : share;
			const uint32_t part = (uint32_t)((uint64_t)fell * by >> 31), carries_away = part < CARRIED_MOST ? part : CARRIED_MOST;
			carried[i] = (int32_t)carries_away;
			compacted += counts & (fell > carries_away) ? (int64_t)(fell - carries_away) : 0;
		}
	}
	tally->compacted += compacted;
	tally->refused += refused;
}

static SOIL_CLONED void contact_row_loses(const struct contact_row *row, const uint32_t *kept, struct soil_kinematic_tally *tally)
{
	contact_row(row, kept, false, false, tally);
}

static SOIL_CLONED void contact_row_carries(const struct contact_row *row, const uint32_t *kept, struct soil_kinematic_tally *tally)
{
	contact_row(row, kept, true, false, tally);
}

static SOIL_CLONED void contact_row_of_classes(const struct contact_row *row, const uint32_t *kept, struct soil_kinematic_tally *tally)
{
	contact_row(row, kept, true, true, tally);
}

void soil_contact_row(const struct contact_row *row, const uint32_t kept[SOIL_CLASSES], struct soil_kinematic_tally *tally)
{
	(row->carried == NULL ? contact_row_loses : row->classes == NULL ? contact_row_carries : contact_row_of_classes)(row, kept, tally);
}

SOIL_CLONED void soil_hold_row(const struct contact_row *row)
{
	for (int32_t i = 0; i < row->count; i++) {
		const int64_t above = ground_of(row->base[i], row->zero) + row->offset[i] - row->rest[i];
		const bool held = (row->base[i] != BASE_NODATA) & (row->rest[i] != UNDER_NONE) & (above >= -TOUCH) & (above <= TOUCH);
		row->contact[i] |= held ? SOIL_HELD : 0;
	}
}

SOIL_CLONED void soil_disturb_row(int32_t count, const uint8_t *restrict contact, const int32_t *restrict offset, uint8_t *restrict disturbance)
{
	for (int32_t i = 0; i < count; i++) {
		const int32_t down = offset[i] < 0 ? -offset[i] >> 10 : 0, depth = 96 + down < 255 ? 96 + down : 255;
		disturbance[i] = (uint8_t)((contact[i] & SOIL_LOWERED) && disturbance[i] < depth ? depth : disturbance[i]);
	}
}
