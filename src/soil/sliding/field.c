/* The working field of sliding: its arrays in scratch memory, and the heights with which the iterations begin. */
#include <string.h>

#include "soil/sliding/sliding.h"

#define ALIGN 64

/* Returns the next part of the scratch memory, or NULL if it is only counted. */
static void *part(void *scratch, size_t *used, size_t bytes)
{
	size_t at = *used;
	*used = (at + bytes + ALIGN - 1) / ALIGN * ALIGN;
	return scratch != NULL ? (char *)scratch + at : NULL;
}

/* Returns an array of posts with a row before and behind the field, from the field's first post on. */
static int32_t *posts(const struct sliding_field *field, void *scratch, size_t *used)
{
	int32_t *all = part(scratch, used, field->stride * (field->height + 2) * sizeof(int32_t));
	return all != NULL ? all + field->stride + 16 : NULL;
}

size_t soil_sliding_field_init(struct sliding_field *field, const struct soil_sliding *rule, const struct soil_planes *planes, struct post_rect rect,
			       bool blocks, void *scratch)
{
	const bool slopes = rule->reach > 0, critical = (planes->classes != NULL && rule->shed == NULL) || (slopes && blocks);
	size_t used = 0;
	*field = (struct sliding_field){.rule = rule, .planes = planes, .rect = rect, .width = (size_t)(rect.x1 - rect.x0),
					.height = (size_t)(rect.y1 - rect.y0)};
	/* 16 posts before a row and behind it: the one that is still, and alignment. An odd number of cache lines keeps columns apart in the cache. */
	field->stride = ((field->width + 32 + 15) / 16 | 1) * 16;
	field->from = (size_t)(rect.y0 - planes->rect.y0) * planes->width + (size_t)(rect.x0 - planes->rect.x0);
	field->heights = posts(field, scratch, &used);
	if (rule->undisturbed_stable)
		field->grounds = posts(field, scratch, &used);
	if (rule->bounded)
		field->floors = posts(field, scratch, &used);
	for (int k = 0; k < 2 && critical; k++)
		field->critical[k] = posts(field, scratch, &used);
	if (rule->shed != NULL)
		field->sheds = posts(field, scratch, &used);
	field->stills = part(scratch, &used, field->width * field->height);
	field->moved = part(scratch, &used, field->width * field->height);
	if (slopes)
		field->steeps = part(scratch, &used, field->width * field->height);
	if (rule->directions > 0)
		field->ends = part(scratch, &used, 4 * (field->width + field->height) * sizeof(int32_t));
	for (int row = 0; row < 2; row++)
		for (int way = 0; way < 4; way++) {
			int32_t *flows = part(scratch, &used, field->stride * sizeof(int32_t));
			field->flows[row][way] = flows != NULL ? flows + 16 : NULL;
		}
	field->dirty = part(scratch, &used, (field->height + 2) * sizeof *field->dirty);
	field->next = part(scratch, &used, (field->height + 2) * sizeof *field->next);
	for (int k = 0; k < 2; k++) {
		field->limits[k] = rule->classes[0].critical[k];
		field->least[k] = rule->least[k];
	}
	return used;
}

SOIL_INLINED int32_t least_of(int32_t a, int32_t b)
{
	return a < b ? a : b;
}

SOIL_INLINED int32_t most_of(int32_t a, int32_t b)
{
	return a > b ? a : b;
}

/* A row of posts of the planes, and of the field. No pointer is NULL. */
struct begin_row {
	const int32_t *base, *offset, *deposited, *deposits;
	const uint8_t *contact;
	int32_t *height, *ground, *floor;
	uint8_t *still;
	uint8_t closes; /* bits of a contact: the post does not slide */
};

/* Returns whether a post refused soil, or does not slide since its offset is out of range. */
SOIL_LANES static bool begin_row(const struct begin_row *row, size_t width, int32_t depth)
{
	const int32_t *restrict base = row->base, *restrict offsets = row->offset, *restrict deposited = row->deposited;
	const int32_t *restrict deposits = row->deposits;
	const uint8_t *restrict contact = row->contact;
	int32_t *restrict height = row->height, *restrict ground = row->ground, *restrict floor = row->floor;
	uint8_t *restrict still = row->still;
	const uint8_t closes = row->closes;
	uint32_t refused = 0;
	SOIL_APART
	for (size_t x = 0; x < width; x++) {
		int32_t offset = offsets[x], heap = deposited[x], room = SLIDING_HIGH - most_of(offset, heap);
		uint32_t laid = (uint32_t)deposits[x], most = (uint32_t)(room > 0 ? room : 0), fits = laid < most ? laid : most;
		offset += (int32_t)fits;
		heap += (int32_t)fits;
		int32_t beyond = (int32_t)(least_of(offset, heap) < SLIDING_LOW) | (int32_t)(most_of(offset, heap) > SLIDING_HIGH);
		int32_t is = beyond | (int32_t)(base[x] == BASE_NODATA) | (int32_t)((contact[x] & closes) != 0);
		uint32_t up = (uint32_t)base[x] * 4u, top = up + (uint32_t)offset;
		refused |= (laid - fits) | (uint32_t)beyond;
		height[x] = is != 0 ? SLIDING_STILL : (int32_t)top;
		still[x] = (uint8_t)is;
		ground[x] = (int32_t)up;
		floor[x] = (int32_t)(top - (uint32_t)heap - (uint32_t)depth);
	}
	return refused != 0;
}

/* Tells what a row refused. */
static void refuse_row(const struct begin_row *row, size_t width, struct soil_slid *slid)
{
	for (size_t x = 0; x < width; x++) {
		int32_t most = most_of(row->offset[x], row->deposited[x]), least = least_of(row->offset[x], row->deposited[x]);
		uint32_t laid = (uint32_t)row->deposits[x], room = (uint32_t)(most < SLIDING_HIGH ? SLIDING_HIGH - most : 0), fits = laid < room ? laid : room;
		bool closed = row->base[x] == BASE_NODATA || (row->contact[x] & row->closes) != 0;
		slid->compacted += laid - fits;
		slid->refused += (laid > fits) + (!closed && (least + (int32_t)fits < SLIDING_LOW || most + (int32_t)fits > SLIDING_HIGH));
	}
}

SOIL_LANES static void critical_row(const uint8_t *restrict classes, const struct soil_sliding *rule, size_t width, int32_t *restrict axial,
					int32_t *restrict diagonal)
{
	SOIL_APART
	for (size_t x = 0; x < width; x++) {
		int class = classes[x] < SOIL_CLASSES ? classes[x] : SOIL_CLASSES - 1;
		axial[x] = rule->classes[class].critical[0];
		diagonal[x] = rule->classes[class].critical[1];
	}
}

static void fill(int32_t *to, size_t count, int32_t value)
{
	for (size_t i = 0; i < count; i++)
		to[i] = value;
}

/* The posts around the field are still. */
static void close_around(struct sliding_field *field)
{
	const size_t stride = field->stride;
	fill(field->heights - stride - 1, field->width + 2, SLIDING_STILL);
	fill(field->heights + field->height * stride - 1, field->width + 2, SLIDING_STILL);
	for (size_t y = 0; y < field->height; y++)
		field->heights[y * stride - 1] = field->heights[y * stride + field->width] = SLIDING_STILL;
	/* Nothing slides between posts of which one is still, but numbers of both are read. */
	int32_t *const others[] = {field->grounds, field->floors, field->critical[0], field->critical[1], field->sheds};
	for (size_t i = 0; i < sizeof others / sizeof *others; i++) {
		if (others[i] == NULL)
			continue;
		fill(others[i] - stride - 1, field->width + 2, 0);
		fill(others[i] + field->height * stride - 1, field->width + 2, 0);
		for (size_t y = 0; y < field->height; y++)
			others[i][y * stride - 1] = others[i][y * stride + field->width] = 0;
	}
}

static void begin_critical(struct sliding_field *field, size_t y)
{
	const struct soil_planes *planes = field->planes;
	int32_t *const axial = field->critical[0] + y * field->stride, *const diagonal = field->critical[1] + y * field->stride;
	if (planes->classes != NULL) {
		critical_row(planes->classes + field->from + y * planes->width, field->rule, field->width, axial, diagonal);
		return;
	}
	fill(axial, field->width, field->limits[0]);
	fill(diagonal, field->width, field->limits[1]);
}

void soil_sliding_begin(struct sliding_field *field, struct soil_slid *slid)
{
	const struct soil_planes *planes = field->planes;
	int32_t *const zeros = field->flows[0][0], *const unread = field->flows[0][1]; /* rows that are free as yet */
	for (int row = 0; row < 2; row++)
		for (int way = 0; way < 4; way++)
			memset(field->flows[row][way] - 16, 0, field->stride * sizeof(int32_t));
	for (size_t y = 0; y < field->height; y++) {
		const size_t at = field->from + y * planes->width, to = y * field->stride;
		const struct begin_row row = {
			.base = planes->base + at,
			.offset = planes->offset + at,
			.deposited = (planes->deposited != NULL ? planes->deposited : planes->offset) + at,
			.deposits = field->deposits != NULL ? field->deposits + at : zeros,
			.contact = planes->contact != NULL ? planes->contact + at : (const uint8_t *)zeros,
			.height = field->heights + to,
			.ground = field->grounds != NULL ? field->grounds + to : unread,
			.floor = field->floors != NULL ? field->floors + to : field->flows[0][2],
			.still = field->stills + y * field->width,
			.closes = field->rule->shed != NULL ? SOIL_CLOSED : SOIL_HELD | SOIL_CLOSED,
		};
		if (begin_row(&row, field->width, field->rule->depth) && field->deposits != NULL)
			refuse_row(&row, field->width, slid);
		if (field->critical[0] != NULL)
			begin_critical(field, y);
	}
	close_around(field);
}
