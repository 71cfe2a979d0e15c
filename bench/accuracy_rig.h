/* The ground of a variant: tiles in slots, and their base and offsets as they are kept in another format. */
#ifndef FURROW_ACCURACY_RIG_H
#define FURROW_ACCURACY_RIG_H

#include "accuracy.h"
#include "gpu/gpu.h"
#include "resident/resident.h"
#include "store/store.h"

enum { RIG_TILES = 64 };

enum which { BASE, OFFSET, WHICH };

/* A plane as it is kept, of one tile. */
struct kept {
	struct gpu_texture *texture;
	struct gpu_target *encoded, *decoded; /* over the texture, and over the slot's */
};

/* std140 twin of kept.frag's block. */
struct kept_params {
	float low, zero, codes, top;
};

struct rig {
	const struct accuracy_variant *of;
	enum accuracy_format format[WHICH];
	struct store *store;
	struct ground *ground;
	const struct extent *extent;
	struct gpu *gpu;
	struct gpu_slots *slots;
	struct deform *deform;
	struct tile_slot tiles[RIG_TILES];
	struct kept kept[RIG_TILES][WHICH];
	bool read[RIG_TILES], written[RIG_TILES];
	size_t tile_count;
	struct gpu_program *encode[WHICH], *decode[WHICH];
	struct kept_params params[WHICH];
	struct deform_rest rest; /* the wheel where it was set last */
	bool has_last;
	double begins;           /* of this pass over the path, s */
	int64_t intervals;       /* that are over */
};

extern const struct soil_shape rig_wheel;

/* Over the store of the variant's spacing; nothing has moved. */
void rig_open(const struct accuracy_variant *of, const struct scene *scene, struct rig *rig);
void rig_close(struct rig *rig);
/* Before these posts are gathered: base and offsets, from what they are kept in to the lattice. */
void rig_decode(struct rig *rig, struct post_rect read);
/* After these were scattered: offsets, to what they are kept in. */
void rig_encode(struct rig *rig, struct post_rect written);
/* Of slots in these formats, as the product counts them: a base of every tile that was read, an offset of every one that
 * was written. */
int64_t rig_slot_bytes(const struct rig *rig);

#endif
