/* What batch.c and batch_parts.c share: the windows of a batch, and the parts in which passes draw them. */
#ifndef FURROW_DEFORM_BATCH_H
#define FURROW_DEFORM_BATCH_H

#include "deform/internal.h"

#define PARTS_MOST (DEFORM_BATCH_MOST * 5 / 4 + 8) /* of all windows of a batch, for gathering and for storing each */

/* Windows of one group have one program for their contact, which also computes the lower envelope. In the last group that is drawn for
 * each window alone. */
enum group { WHEELS, SIDEWAYS_WHEELS, SPHERES, OTHERS, GROUPS };

/* The numbers of a part that batch.vert takes. */
struct record {
	float hull[4][2]; /* corners, in the layer, of a quadrilateral outside which the pass has nothing to do: a strip */
	int32_t posts[4]; /* those of the part, in the layer: first, one behind the last */
	int32_t tile[4];  /* x, y: from a post in the layer to that in the tile; layers of base and deform arrays, -1: none */
	int32_t window[4]; /* posts of the whole window, in the layer */
	int32_t zero[4], written[4]; /* lib/contact.glsl */
	int32_t bodies[18][4]; /* lib/envelope.glsl: functionals and numbers of the motion, then those of the end pose */
};
_Static_assert(sizeof(struct record) == DEFORM_BATCH_RECORD * 16, "deform_programs_batch");

struct batched {
	struct deform_contact contact;
	struct deform_window window;
	struct gpu_rect posts; /* where it lies in the layer */
	struct tile_slot tiles[DEFORM_BATCH_TILES];
	size_t tile_count;
	enum group group;
	struct record numbers; /* those that all its parts have in common */
};

/* The posts of a window on one tile. Parts with the same arrays are drawn together; where contacts are computed, those of one group. */
struct part {
	const struct batched *of;
	struct post_rect posts;
	struct gpu_texture *base, *offset, *disturbance; /* arrays; NULL: none, the post has no ground, or was never deformed */
	int32_t tile[4]; /* as in the record */
};

struct batch {
	struct batched windows[DEFORM_BATCH_MOST];
	size_t count, part_count; /* part_count: the most parts that they may have */
	uint32_t x, y, height; /* the first free post of the last row of windows, and the rows of posts that it takes */
	struct part gathers[PARTS_MOST], stores[PARTS_MOST];
	size_t gather_count, store_count;
	struct record records[2 * PARTS_MOST]; /* of gathers, then of stores */
	struct gpu_list *list;
	struct gpu_program *contact[GROUPS], *gather, *smooth, *store, *disturb;
};

/* batch_parts.c: cuts all windows into parts. The tiles that are written get planes. */
enum status deform_batch_cut(struct deform *deform) FURROW_CHECKED;
/* Returns how many parts from `first` on such a pass draws together. */
enum part_pass { PARTS_GATHER, PARTS_CONTACT, PARTS_STORE };
size_t deform_batch_run(const struct part *parts, size_t first, size_t count, enum part_pass pass);
/* Fills the records of all parts, in their order. */
void deform_batch_record(struct deform *deform);

#endif
