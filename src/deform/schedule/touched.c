/* Implements the set of touched posts that touched.h describes: a row of bits for each row of a block. */
#include "deform/schedule/touched.h"

#include <assert.h>
#include <string.h>

/* Returns the bits of the columns from `first` up to, not including, `end`, as far as a block has them. */
static uint32_t columns(int64_t first, int64_t end)
{
	first = first > 0 ? first : 0;
	end = end < SOIL_BLOCK ? end : SOIL_BLOCK;
	return first < end ? UINT32_MAX >> (SOIL_BLOCK - (end - first)) << first : 0;
}

void deform_touched_finish(struct touched *touched)
{
	soil_block_set_finish(&touched->blocks);
	mem_free_all(touched->whiches, touched->rows);
	*touched = (struct touched){.count = 0};
}

void deform_touched_clear(struct touched *touched)
{
	soil_block_set_clear(&touched->blocks);
	touched->count = touched->count > 0;
}

/* Returns the block's rows; NULL: none of its posts is touched. */
static const uint32_t *rows_of(const struct touched *touched, struct soil_block block)
{
	size_t at = soil_block_set_place(&touched->blocks, block);
	return at < touched->blocks.count ? touched->rows[touched->whiches[at]] : NULL;
}

/* Makes room for one more block and its rows. */
static enum status make_room(struct touched *touched)
{
	TRY(mem_grow(&touched->whiches, &touched->which_room, touched->blocks.count + 1, sizeof *touched->whiches, "the touched ground"));
	if (touched->count == touched->room) {
		TRY(mem_grow(&touched->rows, &touched->room, touched->count + 1, sizeof *touched->rows, "the touched ground"));
		memset(touched->rows[0], 0xff, sizeof *touched->rows);
		touched->count = touched->count > 0 ? touched->count : 1;
	}
	return STATUS_OK;
}

static enum status add_rows(struct touched *touched, struct soil_block block, const uint32_t rows[SOIL_BLOCK])
{
	size_t at = soil_block_set_place(&touched->blocks, block);
	if (at == touched->blocks.count) {
		bool all = true;
		TRY(make_room(touched));
		TRY(soil_block_set_add(&touched->blocks, block));
		for (int y = 0; y < SOIL_BLOCK; y++)
			all = all && rows[y] == UINT32_MAX;
		touched->whiches[at] = all ? 0 : (uint32_t)touched->count;
		if (!all)
			memset(touched->rows[touched->count++], 0, sizeof *touched->rows);
	}
	for (int y = 0; y < SOIL_BLOCK; y++)
		touched->rows[touched->whiches[at]][y] |= rows[y];
	return STATUS_OK;
}

static struct post_rect within(struct post_rect rect)
{
	rect.x0 = rect.x0 > 0 ? rect.x0 : 0;
	rect.y0 = rect.y0 > 0 ? rect.y0 : 0;
	return rect;
}

enum status deform_touched_add(struct touched *touched, struct post_rect rect)
{
	rect = within(rect);
	if (post_rect_empty(rect))
		return STATUS_OK;
	for (int64_t by = rect.y0 / SOIL_BLOCK; by <= (rect.y1 - 1) / SOIL_BLOCK; by++)
		for (int64_t bx = rect.x0 / SOIL_BLOCK; bx <= (rect.x1 - 1) / SOIL_BLOCK; bx++) {
			uint32_t rows[SOIL_BLOCK];
			uint32_t across = columns(rect.x0 - bx * SOIL_BLOCK, rect.x1 - bx * SOIL_BLOCK);
			for (int64_t y = 0; y < SOIL_BLOCK; y++) {
				int64_t post = by * SOIL_BLOCK + y;
				rows[y] = post >= rect.y0 && post < rect.y1 ? across : 0;
			}
			TRY(add_rows(touched, (struct soil_block){bx, by}, rows));
		}
	return STATUS_OK;
}

bool deform_touched_any(const struct touched *touched, struct post_rect rect)
{
	rect = within(rect);
	if (post_rect_empty(rect))
		return false;
	for (int64_t by = rect.y0 / SOIL_BLOCK; by <= (rect.y1 - 1) / SOIL_BLOCK; by++)
		for (int64_t bx = rect.x0 / SOIL_BLOCK; bx <= (rect.x1 - 1) / SOIL_BLOCK; bx++) {
			const uint32_t *rows = rows_of(touched, (struct soil_block){bx, by});
			uint32_t across = columns(rect.x0 - bx * SOIL_BLOCK, rect.x1 - bx * SOIL_BLOCK);
			int64_t low = by * SOIL_BLOCK, end = low + SOIL_BLOCK < rect.y1 ? low + SOIL_BLOCK : rect.y1;
			for (int64_t y = rect.y0 > low ? rect.y0 : low; rows != NULL && y < end; y++)
				if (rows[y - low] & across)
					return true;
		}
	return false;
}

/* Widens row y of the middle block by `by` posts along x, and returns its bits. `rows`: of the western, the middle and the eastern
 * block; NULL: none is touched. */
static uint32_t widened(const uint32_t *const rows[3], int64_t y, int64_t by)
{
	uint64_t west = rows[0] != NULL ? rows[0][y] : 0, east = rows[2] != NULL ? rows[2][y] : 0;
	uint64_t own = rows[1] != NULL ? (uint64_t)rows[1][y] << SOIL_BLOCK : 0, wide = own;
	for (int64_t k = 1; k <= by; k++)
		wide |= (own | west) << k | own >> k | east << (2 * SOIL_BLOCK - k);
	return (uint32_t)(wide >> SOIL_BLOCK);
}

/* Returns the bits of row y of a block that lie in the parts. */
static uint32_t row_of_parts(uint32_t parts, int64_t y)
{
	uint32_t row = 0;
	for (int x = 0; x < SOIL_BLOCK / TOUCHED_PART; x++)
		if (parts >> (y / TOUCHED_PART * (SOIL_BLOCK / TOUCHED_PART) + x) & 1)
			row |= columns(x * TOUCHED_PART, (x + 1) * TOUCHED_PART);
	return row;
}

enum status deform_touched_grow(struct touched *touched, const struct touched *from, struct soil_block block, int64_t by,
			 uint32_t parts)
{
	const uint32_t *near[3][3];
	uint32_t wide[3 * SOIL_BLOCK], rows[SOIL_BLOCK], any = 0;
	assert(by >= 0 && by < SOIL_BLOCK);
	for (int k = 0; k < 9; k++)
		near[k / 3][k % 3] = rows_of(from, (struct soil_block){block.x + k % 3 - 1, block.y + k / 3 - 1});
	for (int64_t y = -by; y < SOIL_BLOCK + by; y++)
		wide[y + by] = widened(near[y < 0 ? 0 : y < SOIL_BLOCK ? 1 : 2], (y + SOIL_BLOCK) % SOIL_BLOCK, by);
	for (int64_t y = 0; y < SOIL_BLOCK; y++) {
		rows[y] = 0;
		for (int64_t k = 0; k <= 2 * by; k++)
			rows[y] |= wide[y + k];
		rows[y] &= row_of_parts(parts, y);
		any |= rows[y];
	}
	return any != 0 ? add_rows(touched, block, rows) : STATUS_OK;
}

struct post_rect deform_touched_part(struct soil_block block, int part)
{
	int64_t x = block.x * SOIL_BLOCK + part % (SOIL_BLOCK / TOUCHED_PART) * TOUCHED_PART;
	int64_t y = block.y * SOIL_BLOCK + part / (SOIL_BLOCK / TOUCHED_PART) * TOUCHED_PART;
	return (struct post_rect){x, y, x + TOUCHED_PART, y + TOUCHED_PART};
}
