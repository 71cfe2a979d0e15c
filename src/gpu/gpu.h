/*
 * gpu: the one owner of EGL and GL. Others describe textures, programs and passes; only this folder
 * calls GL. One thread creates a gpu and it alone may use it and everything made from it (asserted);
 * one gpu at a time in a process, made before threads that read the environment.
 *
 * OpenGL 4.5 core, headless: EGL surfaceless first, then device platforms; hardware before software
 * unless LIBGL_ALWAYS_SOFTWARE is set. A GL error or a lost context is sticky: every later call
 * that can fail returns it, those that cannot do nothing, and reads give zeros.
 *
 * Post = texel: row 0 of a tile's texture is its southern row. Clip space is lower-left, depth
 * zero to one.
 */
#ifndef FURROW_GPU_H
#define FURROW_GPU_H

#include <stddef.h>
#include <stdint.h>

#include "base/base.h"
#include "base/plan.h"
#include "base/plane.h"

struct gpu;
struct gpu_texture;
struct gpu_target;
struct gpu_buffer;
struct gpu_program;
struct gpu_slots;
struct gpu_staging;
struct gpu_counter;

struct gpu_info {
	const char *vendor, *renderer, *version;
	bool software;
	uint32_t samples_most; /* of a pixel that can be drawn */
};

/* What a pass counts as, in the order in which they run. */
enum gpu_stage {
	GPU_UNDERSIDE, /* an object over its window: a closed form, */
	GPU_FACETS,    /* or triangles */
	GPU_LOAD,      /* how deep the soil carries it */
	GPU_PRESS,
	GPU_SMOOTH,
	GPU_SPREAD,
	GPU_SLIDE,     /* over a window */
	GPU_HOLD,      /* what rests on blocks that slide */
	GPU_SETTLE,    /* sliding, over blocks */
	GPU_DIRT,
	GPU_PYRAMID,
	GPU_TERRAIN,
	GPU_SHADOW,    /* of objects, on what is drawn so far */
	GPU_OBJECTS,
	GPU_SKY,
	GPU_RESOLVE,   /* a picture of several samples a pixel to one of one */
	GPU_SUBDIVIDE, /* Technique 4, when a tile below level 0 is loaded */
	GPU_STAGES
};
const char *gpu_stage_name(enum gpu_stage stage);

/* The dissertation's stages, and what else there is. */
enum gpu_group { GPU_DISPLACE, GPU_REDISTRIBUTE, GPU_ATTRIBUTES, GPU_DECIMATE, GPU_RENDER, GPU_DIVIDE, GPU_GROUPS };

/* What was made and run so far; of textures and bytes what is alive. */
struct gpu_stats {
	uint64_t passes[GPU_STAGES];
	double stage_ms[GPU_STAGES]; /* hardware: the GPU's time for the passes that have ended; software:
				      * the caller's, since its timers cannot be believed */
	uint32_t programs;  /* linked, alive */
	uint32_t textures;  /* alive */
	uint64_t bytes;     /* of textures and buffers alive */
	uint64_t uploads, upload_bytes, read_backs, read_back_bytes;
	uint32_t ring_segments; /* of the passes' parameters (PLAN_RING) */
	uint32_t unplanned;     /* programs linked after gpu_seal */
};
/* Over all stages of a group. */
uint64_t gpu_group_passes(const struct gpu_stats *stats, enum gpu_group group);
double gpu_group_ms(const struct gpu_stats *stats, enum gpu_group group);

/* --- context: gpu_context.c --- */
struct gpu_params {
	bool draws; /* a picture will be drawn: llvmpipe keeps its raster threads */
};
enum status gpu_create(const struct gpu_params *params, struct gpu **out) FURROW_CHECKED; /* STATUS_NO_GL */
void gpu_destroy(struct gpu *gpu); /* after everything made from it; takes NULL */
/*
 * A library's host may draw, too, and may call from another thread than before. So each of its calls keeps what is current, takes
 * the context, and in the end gives back what was kept. Between gpu_take and gpu_give the calling thread owns the gpu.
 */
struct gpu_kept {
	void *display, *draw, *read, *context; /* EGL's; context NULL: none was current */
	unsigned api;
};
void gpu_keep(struct gpu_kept *kept);
void gpu_give(const struct gpu_kept *kept);
/* STATUS_NO_GL: the context cannot be made current on this thread. */
enum status gpu_take(struct gpu *gpu) FURROW_CHECKED;
const struct gpu_info *gpu_info(const struct gpu *gpu);
void gpu_stats(struct gpu *gpu, struct gpu_stats *stats);
/* The sticky failure, or a GL error since the last check; `what` names what was being done. */
enum status gpu_check(struct gpu *gpu, const char *what) FURROW_CHECKED;
void gpu_finish(struct gpu *gpu); /* waits for the driver: benches, and before the first step */

/* --- textures and targets: gpu_texture.c --- */
/* R8 and R16 are normalised, R16F and R32F float: what a bench keeps heights in, to be measured beside the lattice. */
enum gpu_format {
	GPU_R32I, GPU_R16UI, GPU_R8UI, GPU_R8, GPU_R16, GPU_R16F, GPU_R32F, GPU_RGBA32I, GPU_RGBA8, GPU_SRGB8_ALPHA8, GPU_DEPTH32F
};

size_t gpu_format_bytes(enum gpu_format format); /* of a texel */

/* layers 0: a plain 2D texture; otherwise an array. Contents start undefined. NEAREST, clamped. */
enum status gpu_texture_create(struct gpu *gpu, enum gpu_format format, uint32_t width,
			       uint32_t height, uint32_t layers, struct gpu_texture **out) FURROW_CHECKED;
/* Only to be drawn into, resolved, or read in a shader sample by sample. samples: 2 to gpu_info's most; a driver may take
 * more than it is asked for. */
enum status gpu_texture_create_sampled(struct gpu *gpu, enum gpu_format format, uint32_t width, uint32_t height,
				       uint32_t samples, struct gpu_texture **out) FURROW_CHECKED;
/* A square array of all levels down to one texel, of a format that filters: within a level, repeating. Each level is
 * uploaded whole, layer after layer; other transfers are of level 0. */
enum status gpu_texture_create_mipmapped(struct gpu *gpu, enum gpu_format format, uint32_t size, uint32_t layers,
					 struct gpu_texture **out) FURROW_CHECKED;
uint32_t gpu_mipmap_levels(uint32_t size); /* of such a one. Pure */
uint64_t gpu_texture_bytes(enum gpu_format format, uint32_t width, uint32_t height, uint32_t layers, uint32_t levels); /* pure */
void gpu_texture_upload_level(struct gpu_texture *texture, uint32_t level, const void *data);
void gpu_texture_destroy(struct gpu_texture *texture);
/* Rectangles are x, y, width, height in texels; data is tight. The clear value is the texel's bits:
 * an int (of RGBA32I: of each of the four), the low byte or two, four bytes with red lowest, or a float's. */
struct gpu_rect {
	uint32_t x, y, width, height;
};
void gpu_texture_upload(struct gpu_texture *texture, uint32_t layer, struct gpu_rect rect, const void *data);
void gpu_texture_read(struct gpu_texture *texture, uint32_t layer, struct gpu_rect rect, void *data); /* blocks */
void gpu_texture_clear(struct gpu_texture *texture, uint32_t layer, struct gpu_rect rect, int32_t value);
void gpu_texture_copy(struct gpu_texture *from, uint32_t from_layer, uint32_t from_x, uint32_t from_y,
		      struct gpu_texture *to, uint32_t to_layer, struct gpu_rect to_rect);

/* --- staging: gpu_staging.c --- */
/*
 * Host memory that the GPU reads and writes: one buffer, mapped for as long as it lives. Transfers
 * are begun in the order of all other work: after a read into it the texture may at once be drawn
 * into, uploaded to or cleared. Any number may be begun; from the first until the staging is idle
 * again, their bytes are the GPU's, and the others anybody's.
 */
enum status gpu_staging_create(struct gpu *gpu, size_t bytes, struct gpu_staging **out) FURROW_CHECKED;
void gpu_staging_destroy(struct gpu_staging *staging); /* waits for what is under way; takes NULL */
/* Aligned for any plane; the same address for life. Any thread may use them while it is idle. */
void *gpu_staging_bytes(struct gpu_staging *staging);
/* Whether all that was begun with it is over. Never waits. After a failure, which gpu_check tells,
 * it is idle, whatever the bytes are. */
bool gpu_staging_idle(struct gpu_staging *staging);
/* `offset` in bytes, a multiple of a texel's. A read after a failure gives zeros. */
void gpu_texture_upload_from(struct gpu_texture *texture, uint32_t layer, struct gpu_rect rect,
			     struct gpu_staging *staging, size_t offset);
void gpu_texture_read_into(struct gpu_texture *texture, uint32_t layer, struct gpu_rect rect,
			   struct gpu_staging *staging, size_t offset);

struct gpu_attachment {
	struct gpu_texture *texture;
	uint32_t layer;
};
/* An FBO. At most 8 colours of one size; depth.texture may be NULL, or else there may be no colours.
 * Textures stay the caller's and must outlive it. */
enum status gpu_target_create(struct gpu *gpu, const struct gpu_attachment *colours, uint32_t count,
			      struct gpu_attachment depth, struct gpu_target **out) FURROW_CHECKED;
/* One without attachments, for passes that only write images and storage buffers. */
enum status gpu_target_create_bare(struct gpu *gpu, uint32_t width, uint32_t height,
				   struct gpu_target **out) FURROW_CHECKED;
void gpu_target_destroy(struct gpu_target *target);
/* Floating-point and normalised attachments only; depth is cleared to 0 (reversed depth). */
void gpu_target_clear(struct gpu_target *target, const float rgba[4]);
/* The mean of each pixel's samples, of light where the colours are sRGB, to a target of one sample and the same size and
 * format of its first colour. Counts as a pass of GPU_RESOLVE. */
void gpu_target_resolve(struct gpu_target *from, struct gpu_target *to);

/* --- programs: gpu_program.c --- */
/* Shaders are files of shaders/, embedded by the build ("deform/none.frag"); `#include "lib/x.glsl"`
 * is resolved. Each define is "NAME" or "NAME value": a variant. The same request returns the same
 * program; the gpu keeps it. An error carries file:line and the driver's text. */
#define GPU_DEFINES_MAX 16
struct gpu_program_request {
	const char *vertex, *fragment;
	const char *defines[GPU_DEFINES_MAX]; /* NULL-terminated unless full */
};
enum status gpu_program_get(struct gpu *gpu, const struct gpu_program_request *request,
			    struct gpu_program **out) FURROW_CHECKED;
/* What plans and listings call it: "VERTEX FRAGMENT DEFINE ...", cut to `size`. Pure. */
#define GPU_PROGRAM_NAME 256
void gpu_program_name(const struct gpu_program_request *request, char *name, size_t size);
/* Every program that was linked, the latest first, and the passes that ran with it since the start. */
void gpu_programs_each(const struct gpu *gpu, void (*each)(void *user, const char *name, uint64_t passes), void *user);
/* From now on no program should be missing: one that is linked all the same is counted (stats.unplanned), and the first is
 * told in a note. */
void gpu_seal(struct gpu *gpu);

/* --- buffers: gpu_buffer.c --- */
/* Of fixed size; zeroed if there is no data. */
enum gpu_buffer_use { GPU_INDICES, GPU_STORAGE, GPU_UNIFORMS };
enum status gpu_buffer_create(struct gpu *gpu, enum gpu_buffer_use use, size_t bytes,
			      const void *data_or_null, struct gpu_buffer **out) FURROW_CHECKED;
void gpu_buffer_destroy(struct gpu_buffer *buffer);
void gpu_buffer_write(struct gpu_buffer *buffer, size_t offset, size_t bytes, const void *data);
void gpu_buffer_read(struct gpu_buffer *buffer, size_t offset, size_t bytes, void *data); /* blocks */
/* As gpu_texture_read_into; offsets are multiples of 4. */
void gpu_buffer_read_into(struct gpu_buffer *buffer, size_t offset, size_t bytes, struct gpu_staging *staging,
			  size_t staging_offset);
void gpu_buffer_clear(struct gpu_buffer *buffer, size_t offset, size_t bytes); /* to zeros; multiples of 4 */

/* --- passes: gpu_pass.c --- */
#define GPU_PASS_TEXTURES 8
#define GPU_PASS_BUFFERS 4
#define GPU_PASS_IMAGES 8
struct gpu_pass {
	enum gpu_stage stage; /* what it counts as */
	struct gpu_program *program;
	struct gpu_target *target;
	struct gpu_rect viewport; /* of the target; nothing outside is written */
	struct gpu_texture *textures[GPU_PASS_TEXTURES]; /* layout(binding = i); NULL: none */
	struct gpu_buffer *storage[GPU_PASS_BUFFERS];    /* layout(std430, binding = i) */
	/* layout(binding = i), read and written, all layers of an array; integer formats. What a pass writes
	 * every later pass, copy and read sees. Not the target's own textures. */
	struct gpu_texture *images[GPU_PASS_IMAGES];
	bool only_reads; /* nothing is written into storage and images: passes that say so do not wait for each other */
	const void *params; /* std140 block, layout(binding = 0); copied; NULL: none */
	size_t params_bytes; /* at most 16 KiB */
	/* What is drawn. indices NULL: one triangle over the viewport (vertex shader full.vert makes
	 * it from gl_VertexID), or, if there are `instances`, so many strips of four vertices. Otherwise
	 * triangles, uint16 indices, `instances` times. */
	struct gpu_buffer *indices;
	uint32_t index_count, instances;
	uint32_t first_index;
	bool wide_indices; /* uint32 instead */
	bool depth_test;  /* reversed: GREATER */
	bool cull_back;   /* counter-clockwise is front */
	bool cull_front;  /* not both */
	bool multiply;    /* what is there by what is drawn, in light where the target is sRGB */
};
void gpu_pass_run(struct gpu *gpu, const struct gpu_pass *pass);

/* --- counters: gpu_query.c --- */
/* Counts the samples that pass the depth test, of all passes between begin and end; one counter at a time. Never waits. */
enum status gpu_counter_create(struct gpu *gpu, struct gpu_counter **out) FURROW_CHECKED;
void gpu_counter_destroy(struct gpu_counter *counter); /* takes NULL */
void gpu_counter_begin(struct gpu_counter *counter);
void gpu_counter_end(struct gpu_counter *counter);
/* The results that came since it was last asked: samples, over so many times. After gpu_finish all that were begun have;
 * what began while too many were on their way has none. */
void gpu_counter_take(struct gpu_counter *counter, uint64_t *samples, uint64_t *times);

/* --- slots: gpu_slots.c --- */
/*
 * Two pools, each slot allocated when first needed and reused from then on, never freed before the
 * end. Base slots: a (cells + 1)^2 R32I texture (2^-18 m relative to the store's reference) and an
 * FBO, and classes of soil (R8UI) where those are loaded. Deform slots: planes (base/plane.h), each in
 * a texture of its own format; a base slot has one only while its tile is deformed.
 *
 * Offset and dirt are drawn: every deformed tile has them, coarser ones too. The others are state of
 * the working level alone, all of them there once gpu_slots_deform or an upload asked for one.
 */
#define GPU_DRAWN_PLANES (PLANE_BIT(PLANE_OFFSET) | PLANE_BIT(PLANE_DIRT))
struct gpu_slot {
	struct gpu_texture *base;           /* NULL: nothing was loaded here yet */
	struct gpu_texture *classes;        /* NULL: none were loaded here yet */
	struct gpu_texture *planes[PLANES]; /* NULL: not deformed, or no such plane: zeros */
	struct gpu_target *target;          /* FBO over offset and dirt (colour 0, 1); NULL: not deformed */
};
/* `planes`: a mask of those that there may be at all; the offset always is. */
enum status gpu_slots_create(struct gpu *gpu, uint32_t cells, uint32_t count, unsigned planes,
			     struct gpu_slots **out) FURROW_CHECKED;
unsigned gpu_slots_planes(const struct gpu_slots *slots); /* that mask */
void gpu_slots_destroy(struct gpu_slots *slots);
const struct gpu_slot *gpu_slots_get(const struct gpu_slots *slots, uint32_t slot);
/* What the planes of all slots take, free deform slots included; scratch is not counted. */
struct gpu_slots_bytes {
	uint64_t base, classes, planes[PLANES];
};
void gpu_slots_bytes(const struct gpu_slots *slots, struct gpu_slots_bytes *bytes);
/* How many of each there ever were: they stay until the end. And what was worked out in them. */
struct gpu_slots_figures {
	uint64_t base_slots, class_slots, deform_slots, state_slots, patches;
	uint64_t subdivided, decimated; /* bases interpolated; decimations of a tile that was deformed */
};
void gpu_slots_figures(const struct gpu_slots *slots, struct gpu_slots_figures *figures);
/* The lines of slots of so many cells and those planes (0: nothing is deformed), and of the ring of the passes' parameters.
 * `classes`: of soil. `divides`: the working level is below 0. `decimates`: what is deformed is looked at. `effect`: what
 * calls for the planes, but for dirt. Pure. */
void gpu_slots_plan(uint32_t cells, unsigned planes, bool classes, bool divides, bool decimates, const char *effect,
		    struct plan *plan);
/* Links the programs that such slots will run. */
enum status gpu_slots_warm(struct gpu_slots *slots, bool divides, bool decimates) FURROW_CHECKED;
/* Planes are tight in staging, row 0 first, each at an offset in bytes; a plane of int32 posts at a
 * multiple of 4, one of uint16 at one of 2. What follows only begins transfers, none of them waits for one. */
#define GPU_NO_PLANE SIZE_MAX /* an offset: it is not there, or not wanted */
/* Base from posts, or from a patch of level-0 posts (lattice_subdivide's arguments) by a pass. */
enum status gpu_slots_upload_base(struct gpu_slots *slots, uint32_t slot, struct gpu_staging *staging,
				  size_t posts) FURROW_CHECKED;
enum status gpu_slots_subdivide_base(struct gpu_slots *slots, uint32_t slot, struct gpu_staging *staging,
				     size_t patch, int shift, uint32_t sub_x, uint32_t sub_y) FURROW_CHECKED;
/* The class of soil of every post, uint8. Until another upload they are those of this tile. */
enum status gpu_slots_upload_classes(struct gpu_slots *slots, uint32_t slot, struct gpu_staging *staging,
				     size_t classes) FURROW_CHECKED;
/* Gives the slot a deform slot with every plane that there may be; those it did not have are zeros. */
enum status gpu_slots_deform(struct gpu_slots *slots, uint32_t slot) FURROW_CHECKED;
/* Takes it away again (the tile in it is about to change). */
void gpu_slots_undeform(struct gpu_slots *slots, uint32_t slot);
/* An offset for each plane. Uploaded: all of the slot's deform slot; a plane with GPU_NO_PLANE is zeros.
 * Read: those with an offset; one that the slot has not is zeros, there at once. Planes that the slots
 * were not created with are ignored, and read as zeros. */
enum status gpu_slots_upload_deform(struct gpu_slots *slots, uint32_t slot, struct gpu_staging *staging,
				    const size_t places[PLANES]) FURROW_CHECKED;
enum status gpu_slots_read_deform(struct gpu_slots *slots, uint32_t slot, struct gpu_staging *staging,
				  const size_t places[PLANES]) FURROW_CHECKED;
/* Writes every 2^steps-th post of `fine` inside `rect` of it (in its posts), beginning with the
 * rectangle's first, into the coarse slot's offset and dirt at (to_x, to_y). The rectangle's first
 * post must be one the coarse level has. A fine slot that is not deformed counts as zeros; a coarse one
 * gets a deform slot, zeroed, with the planes that are drawn. */
enum status gpu_slots_decimate(struct gpu_slots *slots, uint32_t fine, struct gpu_rect rect, int steps,
			       uint32_t coarse, uint32_t to_x, uint32_t to_y) FURROW_CHECKED;

#endif
