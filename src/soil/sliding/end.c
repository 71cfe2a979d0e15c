/*
 * The end of sliding: heights become offsets, and the flags of blocks tell where soil may go on moving.
 *
 * A word of flags is as the GPU writes it. Bit 0: soil still moves in the block. Eight more bits: soil moves near its west, east, south,
 * north, south-west, south-east, north-west and north-east side. From bit 16 on: which squares of 8 x 8 posts changed.
 */
#include <string.h>

#include "soil/sliding/sliding.h"

#define SIDE SOIL_BLOCK

struct end_row {
	const int32_t *base, *height, *deposits;
	int32_t *offset, *deposited;
	const uint8_t *contact, *still, *moved, *steep;
	uint8_t *moves, *changed;
	int32_t disturbs; /* a contact's bits */
	int32_t frees;
	bool wakes;
};

SOIL_INLINED int32_t most_of(int32_t a, int32_t b)
{
	return a > b ? a : b;
}

/* Writes a row of posts. moves, changed: 1 or 0 of each. */
SOIL_INLINED void end(const struct end_row *row, size_t width, bool thickness)
{
	const int32_t *restrict base = row->base, *restrict height = row->height, *restrict deposits = row->deposits;
	int32_t *restrict offsets = row->offset, *restrict deposited = row->deposited;
	const uint8_t *restrict contact = row->contact, *restrict still = row->still, *restrict moved = row->moved, *restrict steep = row->steep;
	uint8_t *restrict moves = row->moves, *restrict changed = row->changed;
	const uint32_t disturbs = (uint32_t)row->disturbs, frees = (uint32_t)row->frees, wakes = row->wakes ? UINT32_MAX : 0;
	SOIL_APART
	for (size_t x = 0; x < width; x++) {
		int32_t before = offsets[x], heap = thickness ? deposited[x] : before, room = SLIDING_HIGH - most_of(before, heap);
		uint32_t laid = (uint32_t)deposits[x], most = (uint32_t)(room > 0 ? room : 0), fits = laid < most ? laid : most;
		int32_t with = before + (int32_t)fits, slid = (int32_t)((uint32_t)height[x] - (uint32_t)base[x] * 4u);
		int32_t offset = still[x] != 0 ? with : slid;
		uint32_t change = ((uint32_t)offset ^ (uint32_t)with) | fits | (contact[x] & disturbs);
		/* A body that rested on a post which slid may not rest on it any more. */
		uint32_t let_go = offset != with ? contact[x] & SOIL_HELD : 0;
		uint32_t move = moved[x] | (contact[x] & frees) | let_go | ((change | steep[x]) & wakes);
		offsets[x] = offset;
		if (thickness)
			deposited[x] = (int32_t)((uint32_t)heap + ((uint32_t)offset - (uint32_t)before));
		changed[x] = (uint8_t)(change != 0);
		moves[x] = (uint8_t)(move != 0);
	}
}

SOIL_LANES static void end_row(const struct end_row *row, size_t width)
{
	if (row->deposited != NULL)
		end(row, width, true);
	else
		end(row, width, false);
}

/* Returns eight bytes as a word, the first one lowest. The compiler makes one load of it. */
SOIL_INLINED uint64_t word_of(const uint8_t *b)
{
	return (uint64_t)b[0] | (uint64_t)b[1] << 8 | (uint64_t)b[2] << 16 | (uint64_t)b[3] << 24 | (uint64_t)b[4] << 32 | (uint64_t)b[5] << 40 |
	       (uint64_t)b[6] << 48 | (uint64_t)b[7] << 56;
}

/* Returns a bit for each of 32 bytes that are 0 or 1. The product moves bit 8 k of a word to bit 56 + k, and no two bits meet. */
SOIL_INLINED uint32_t bits_of(const uint8_t *bytes)
{
	uint32_t bits = 0;
	for (int i = 0; i < SIDE; i += 8)
		bits |= (uint32_t)(word_of(bytes + i) * 0x0102040810204080u >> 56) << i;
	return bits;
}

/* Returns the flags of a block for posts of one row that move. */
static uint32_t flags_of(uint32_t bits, int64_t row, int64_t near)
{
	if (bits == 0)
		return 0;
	const uint32_t to_west = near < SIDE ? (1u << near) - 1 : UINT32_MAX, to_east = near < SIDE ? ~(UINT32_MAX >> near) : UINT32_MAX;
	uint32_t west = (bits & to_west) != 0, east = (bits & to_east) != 0;
	uint32_t south = row < near, north = row >= SIDE - near;
	return 1u | west << 1 | east << 2 | south << 3 | north << 4 | (west & south) << 5 | (east & south) << 6 | (west & north) << 7 | (east & north) << 8;
}

/* Returns the flags of squares for posts of one row that changed. */
static uint32_t parts_of(uint32_t bits, int64_t row)
{
	uint32_t squares = 0;
	for (int i = 0; i < 4; i++)
		squares |= (uint32_t)((bits >> 8 * i & 0xffu) != 0) << i;
	return squares << (16 + row / 8 * 4);
}

static int64_t block_of(int64_t post)
{
	return post >= 0 ? post / SIDE : -((SIDE - 1 - post) / SIDE);
}

/* Returns the bytes of a row whose first byte is the first post of a block. */
static size_t row_bytes(size_t width)
{
	return (width + 3 * SIDE) / SIDE * SIDE;
}

size_t soil_sliding_end_bytes(size_t width)
{
	return 2 * row_bytes(width) + (width + 16) * sizeof(int32_t);
}

/* Sets the flags of the blocks of a row, from the bytes of its posts. */
static void flag_row(const struct sliding_end *end, int64_t x0, int64_t x1, int64_t y, int64_t near, const uint8_t *moves, const uint8_t *changed)
{
	const int64_t columns = end->blocks.x1 - end->blocks.x0, row = y - block_of(y) * SIDE;
	for (int64_t block = block_of(x0); block * SIDE < x1; block++, moves += SIDE, changed += SIDE) {
		uint32_t bits = bits_of(moves), changes = bits_of(changed);
		if ((bits | changes) == 0)
			continue;
		end->words[(block_of(y) - end->blocks.y0) * columns + block - end->blocks.x0] |= flags_of(bits, row, near) | parts_of(changes, row);
	}
}

void soil_sliding_end(struct sliding_field *field, const struct sliding_end *end, void *scratch)
{
	const struct soil_planes *planes = field->planes;
	const size_t width = field->width - 2 * end->trim, bytes = row_bytes(width);
	const int64_t x0 = field->rect.x0 + (int64_t)end->trim, rim = soil_sliding_rim(field->rule);
	int32_t *const zeros = scratch;
	uint8_t *const bytes_of[2] = {(uint8_t *)(zeros + width + 16), (uint8_t *)(zeros + width + 16) + bytes};
	const size_t skip = (size_t)(x0 - block_of(x0) * SIDE);
	memset(scratch, 0, soil_sliding_end_bytes(width));
	for (size_t y = end->trim; y < field->height - end->trim; y++) {
		const size_t at = field->from + y * planes->width + end->trim, own = y * field->width + end->trim;
		uint8_t *const moves = bytes_of[0] + skip, *const changed = bytes_of[1] + skip;
		const struct end_row row = {
			.base = planes->base + at,
			.height = field->heights + y * field->stride + end->trim,
			.deposits = field->deposits != NULL ? field->deposits + at : zeros,
			.offset = planes->offset + at,
			.deposited = planes->deposited != NULL ? planes->deposited + at : NULL,
			.contact = planes->contact != NULL ? planes->contact + at : (const uint8_t *)zeros,
			.still = field->stills + own,
			.moved = field->moved + own,
			.steep = field->steeps != NULL ? field->steeps + own : (const uint8_t *)zeros,
			.moves = moves,
			.changed = changed,
			.disturbs = end->window ? SOIL_LOWERED : 0,
			.frees = end->loaded ? SOIL_HELD : 0,
			.wakes = field->rule->reach > 0,
		};
		end_row(&row, width);
		/* Neighbours beyond a border were not looked at, so a change there may make soil move. */
		const size_t step = (size_t)field->rule->step;
		bool beside = end->window && ((end->borders[1] && y < step) || (end->borders[3] && y + step >= field->height));
		for (size_t x = 0; x < width && beside; x++)
			moves[x] |= changed[x];
		for (size_t x = 0; x < step && x < width && end->window; x++) {
			moves[x] |= end->borders[0] ? changed[x] : 0;
			moves[width - 1 - x] |= end->borders[2] ? changed[width - 1 - x] : 0;
		}
		flag_row(end, x0, x0 + (int64_t)width, field->rect.y0 + (int64_t)y, rim, bytes_of[0], bytes_of[1]);
	}
}
