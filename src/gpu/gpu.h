/*
 * gpu: the only folder that calls EGL and GL. Others describe textures, programs and passes. One thread creates a gpu. Only
 * this thread may use it and everything made from it (asserted). There is at most one gpu in a process at a time. Make it
 * before threads that read the environment.
 *
 * It uses OpenGL 4.5 core without a window: EGL surfaceless first, then device platforms. Hardware comes before software,
 * unless LIBGL_ALWAYS_SOFTWARE is set. A GL error or a lost context is sticky. Every later call that can fail returns it; other
 * calls do nothing, and reads give zeros.
 *
 * A post is a texel: row 0 of a tile's texture is its southern row. Clip space has its origin at the lower left, and depth zero
 * to one.
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
	uint32_t samples_most; /* most samples a pixel that can be drawn */
};

/* The stage under which a pass is counted, in the order in which stages run. */
enum gpu_stage {
	GPU_ENVELOPE, /* lower envelope of an object over its window, from a closed form, */
	GPU_FACETS,    /* or from triangles */
	GPU_LOAD,      /* equilibrium height of a loaded body */
	GPU_CONTACT,
	GPU_SMOOTH,
	GPU_SPREAD,
	GPU_SLIDE,     /* relaxation over a window */
	GPU_HOLD,      /* objects at rest on blocks that relax */
	GPU_SETTLE,    /* relaxation over blocks */
	GPU_DISTURBANCE,
	GPU_PYRAMID,
	GPU_TERRAIN,
	GPU_SHADOW,    /* of objects, on the terrain */
	GPU_OBJECTS,
	GPU_SKY,
	GPU_RESOLVE,   /* from several samples a pixel to one */
	GPU_SUBDIVIDE, /* Technique 4, when a tile below level 0 is loaded */
	GPU_STAGES
};
const char *gpu_stage_name(enum gpu_stage stage);

/* The dissertation's stages, and the other groups. */
enum gpu_group { GPU_DISPLACE, GPU_REDISTRIBUTE, GPU_ATTRIBUTES, GPU_DECIMATE, GPU_RENDER, GPU_DIVIDE, GPU_GROUPS };

/* What was made and run so far. Textures and bytes: those that exist now. */
struct gpu_stats {
	uint64_t passes[GPU_STAGES];
	/* hardware: the GPU's time of the passes that have ended. Software: the caller's time, since its timers are wrong */
	double stage_ms[GPU_STAGES];
	uint32_t programs;  /* linked, that exist now */
	uint32_t textures;  /* alive */
	uint64_t bytes;     /* of textures and buffers that exist now */
	uint64_t uploads, upload_bytes, read_backs, read_back_bytes;
	uint32_t ring_segments; /* segments of the ring of pass parameters (PLAN_RING) */
	uint32_t unplanned;     /* programs linked after gpu_seal */
};
/* These return sums over all stages of a group. */
uint64_t gpu_group_passes(const struct gpu_stats *stats, enum gpu_group group);
double gpu_group_ms(const struct gpu_stats *stats, enum gpu_group group);

/* --- context: gpu_context.c --- */
struct gpu_params {
	bool draws; /* a picture will be drawn, so llvmpipe keeps its raster threads */
};
enum status gpu_create(const struct gpu_params *params, struct gpu **out) FURROW_CHECKED; /* STATUS_NO_GL */
void gpu_destroy(struct gpu *gpu); /* after everything made from it; takes NULL */
/*
 * The host of the library may draw too, and may call from changing threads. So each call of the library keeps the current
 * context, takes its own, and gives back the kept one at its end. Between gpu_take and gpu_give the calling thread owns the
 * gpu.
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
/* Returns the sticky failure, or a GL error since the last check. `what` says what was being done. */
enum status gpu_check(struct gpu *gpu, const char *what) FURROW_CHECKED;
void gpu_finish(struct gpu *gpu); /* waits for the driver: for benches, and before the first step */

/* --- textures and targets: gpu_texture.c --- */
/* R8 and R16 are normalised; R16F and R32F are float. A bench keeps heights in them, to compare with the lattice. */
enum gpu_format {
	GPU_R32I, GPU_R16UI, GPU_R8UI, GPU_R8, GPU_R16, GPU_R16F, GPU_R32F, GPU_RGBA32I, GPU_RGBA8, GPU_SRGB8_ALPHA8, GPU_DEPTH32F
};

size_t gpu_format_bytes(enum gpu_format format); /* bytes of a texel */

/* Makes a texture. layers 0: a plain 2D texture; otherwise an array. Contents are undefined. NEAREST, clamped. */
enum status gpu_texture_create(struct gpu *gpu, enum gpu_format format, uint32_t width,
			       uint32_t height, uint32_t layers, struct gpu_texture **out) FURROW_CHECKED;
/* Makes a multisample texture. It can only be drawn into, resolved, or read in a shader sample by sample. samples: 2 to
 * gpu_info.samples_most. A driver may take more samples than asked for. */
enum status gpu_texture_create_sampled(struct gpu *gpu, enum gpu_format format, uint32_t width, uint32_t height,
				       uint32_t samples, struct gpu_texture **out) FURROW_CHECKED;
/* Makes a square array with all mip levels down to one texel, of a format that can be filtered. It filters within a level, and
 * repeats. Each level is uploaded whole, layer after layer. Other transfers use level 0. */
enum status gpu_texture_create_mipmapped(struct gpu *gpu, enum gpu_format format, uint32_t size, uint32_t layers,
					 struct gpu_texture **out) FURROW_CHECKED;
uint32_t gpu_mipmap_levels(uint32_t size); /* number of levels of such a texture. Pure */
uint64_t gpu_texture_bytes(enum gpu_format format, uint32_t width, uint32_t height, uint32_t layers, uint32_t levels); /* pure */
void gpu_texture_upload_level(struct gpu_texture *texture, uint32_t level, const void *data);
void gpu_texture_destroy(struct gpu_texture *texture);
/* Rectangles are x, y, width, height in texels. Data has no padding. The clear value is the bits of a texel. For RGBA32I it is
 * an int for each of the four; for small formats the low byte or two. For RGBA8 it is four bytes, red lowest; for floats the
 * float's bits. */
struct gpu_rect {
	uint32_t x, y, width, height;
};
void gpu_texture_upload(struct gpu_texture *texture, uint32_t layer, struct gpu_rect rect, const void *data);
void gpu_texture_read(struct gpu_texture *texture, uint32_t layer, struct gpu_rect rect, void *data); /* waits for the GPU */
void gpu_texture_clear(struct gpu_texture *texture, uint32_t layer, struct gpu_rect rect, int32_t value);
void gpu_texture_copy(struct gpu_texture *from, uint32_t from_layer, uint32_t from_x, uint32_t from_y,
		      struct gpu_texture *to, uint32_t to_layer, struct gpu_rect to_rect);

/* --- staging: gpu_staging.c --- */
/*
 * Host memory that the GPU reads and writes: one buffer, mapped as long as it exists. Transfers keep their order among all
 * other work. So after a read into it, the texture may at once be drawn into, uploaded to or cleared. Any number of transfers
 * may be begun. The GPU owns their bytes from the first transfer until the staging is idle again. The other bytes are free to
 * use.
 */
enum status gpu_staging_create(struct gpu *gpu, size_t bytes, struct gpu_staging **out) FURROW_CHECKED;
void gpu_staging_destroy(struct gpu_staging *staging); /* waits for transfers in flight; takes NULL */
/* Returns the bytes, aligned for any plane. The address never changes. Any thread may use them while the staging is idle. */
void *gpu_staging_bytes(struct gpu_staging *staging);
/* Returns true when every transfer started with this staging has finished. Never waits. After a failure, which gpu_check
 * returns, it is idle and the bytes are undefined. */
bool gpu_staging_idle(struct gpu_staging *staging);
/* Begin a transfer. `offset`: bytes, a multiple of a texel's size. A read after a failure gives zeros. */
void gpu_texture_upload_from(struct gpu_texture *texture, uint32_t layer, struct gpu_rect rect,
			     struct gpu_staging *staging, size_t offset);
void gpu_texture_read_into(struct gpu_texture *texture, uint32_t layer, struct gpu_rect rect,
			   struct gpu_staging *staging, size_t offset);

struct gpu_attachment {
	struct gpu_texture *texture;
	uint32_t layer;
};
/* Makes an FBO. At most 8 colours of one size. depth.texture may be NULL if there are colours. The textures stay the caller's
 * and must outlive it. */
enum status gpu_target_create(struct gpu *gpu, const struct gpu_attachment *colours, uint32_t count,
			      struct gpu_attachment depth, struct gpu_target **out) FURROW_CHECKED;
/* Makes an FBO without attachments, for passes that only write images and storage buffers. */
enum status gpu_target_create_bare(struct gpu *gpu, uint32_t width, uint32_t height,
				   struct gpu_target **out) FURROW_CHECKED;
void gpu_target_destroy(struct gpu_target *target);
/* Clears floating-point and normalised attachments only. Depth is cleared to 0 (reversed depth). */
void gpu_target_clear(struct gpu_target *target, const float rgba[4]);
/* Writes the mean of each pixel's samples to a target of one sample and the same size, and the format of the first colour. sRGB
 * colours are averaged as light. Counts as a pass of GPU_RESOLVE. */
void gpu_target_resolve(struct gpu_target *from, struct gpu_target *to);

/* --- programs: gpu_program.c --- */
/* Shaders are files of shaders/, embedded by the build ("deform/none.frag"). `#include "lib/x.glsl"` is resolved. Each define
 * is "NAME" or "NAME value" and makes a variant. The same request returns the same program, which the gpu owns. An error
 * carries file:line and the driver's text. */
#define GPU_DEFINES_MAX 16
struct gpu_program_request {
	const char *vertex, *fragment;
	const char *defines[GPU_DEFINES_MAX]; /* NULL-terminated unless full */
};
enum status gpu_program_get(struct gpu *gpu, const struct gpu_program_request *request,
			    struct gpu_program **out) FURROW_CHECKED;
/* Writes the program's name for plans and listings: "VERTEX FRAGMENT DEFINE ...", cut to `size`. Pure. */
#define GPU_PROGRAM_NAME 256
void gpu_program_name(const struct gpu_program_request *request, char *name, size_t size);
/* Tells every linked program, the latest first, and the passes that ran with it since the start. */
void gpu_programs_each(const struct gpu *gpu, void (*each)(void *user, const char *name, uint64_t passes), void *user);
/* Says that all programs are linked. A program linked later is counted (stats.unplanned), and a note names the first one. */
void gpu_seal(struct gpu *gpu);

/* --- buffers: gpu_buffer.c --- */
/* Makes a buffer of fixed size, with zeros if there is no data. */
enum gpu_buffer_use { GPU_INDICES, GPU_STORAGE, GPU_UNIFORMS };
enum status gpu_buffer_create(struct gpu *gpu, enum gpu_buffer_use use, size_t bytes,
			      const void *data_or_null, struct gpu_buffer **out) FURROW_CHECKED;
void gpu_buffer_destroy(struct gpu_buffer *buffer);
void gpu_buffer_write(struct gpu_buffer *buffer, size_t offset, size_t bytes, const void *data);
void gpu_buffer_read(struct gpu_buffer *buffer, size_t offset, size_t bytes, void *data); /* waits for the GPU */
/* Begins a read, as gpu_texture_read_into does. Offsets are multiples of 4. */
void gpu_buffer_read_into(struct gpu_buffer *buffer, size_t offset, size_t bytes, struct gpu_staging *staging,
			  size_t staging_offset);
void gpu_buffer_clear(struct gpu_buffer *buffer, size_t offset, size_t bytes); /* to zeros; multiples of 4 */

/* --- passes: gpu_pass.c --- */
#define GPU_PASS_TEXTURES 8
#define GPU_PASS_BUFFERS 4
#define GPU_PASS_IMAGES 8
struct gpu_pass {
	enum gpu_stage stage; /* stage under which it is counted */
	struct gpu_program *program;
	struct gpu_target *target;
	struct gpu_rect viewport; /* within the target; nothing outside it is written */
	struct gpu_texture *textures[GPU_PASS_TEXTURES]; /* layout(binding = i); NULL: none */
	struct gpu_buffer *storage[GPU_PASS_BUFFERS];    /* layout(std430, binding = i) */
	/* layout(binding = i), read and written, all layers of an array; integer formats. Every later pass, copy and read sees
	 * what a pass writes. Not the target's own textures. */
	struct gpu_texture *images[GPU_PASS_IMAGES];
	bool only_reads; /* storage and images are not written; such passes do not wait for each other */
	const void *params; /* std140 block, layout(binding = 0); copied; NULL: none */
	size_t params_bytes; /* at most 16 KiB */
	/* The geometry. indices NULL and instances 0: one triangle over the viewport; full.vert makes it from gl_VertexID.
	 * indices NULL and `instances`: that many strips of four vertices. Otherwise: triangles with uint16 indices,
	 * `instances` times. */
	struct gpu_buffer *indices;
	uint32_t index_count, instances;
	uint32_t first_index;
	bool wide_indices; /* uint32 instead */
	bool depth_test;  /* reversed: GREATER */
	bool cull_back;   /* counter-clockwise is front */
	bool cull_front;  /* not both */
	bool multiply;    /* multiplies the target by what is drawn, as light if the target is sRGB */
};
void gpu_pass_run(struct gpu *gpu, const struct gpu_pass *pass);

/* --- counters: gpu_query.c --- */
/* Counts the samples that pass the depth test, of all passes between begin and end. Only one counter counts at a time. Never
 * waits. */
enum status gpu_counter_create(struct gpu *gpu, struct gpu_counter **out) FURROW_CHECKED;
void gpu_counter_destroy(struct gpu_counter *counter); /* takes NULL */
void gpu_counter_begin(struct gpu_counter *counter);
void gpu_counter_end(struct gpu_counter *counter);
/* Takes the results that arrived since the last call: the samples, and the number of counts. After gpu_finish all counts have
 * arrived. A count that began while too many were in flight has no result. */
void gpu_counter_take(struct gpu_counter *counter, uint64_t *samples, uint64_t *times);

/* --- slots: gpu_slots.c --- */
/*
 * Two pools of slots. A slot is allocated when it is first needed, reused from then on, and freed at the end.
 *
 * A base slot is a (cells + 1)^2 R32I texture (2^-18 m relative to the store's reference) with an FBO. It has classes of soil
 * (R8UI) if those are loaded. A deform slot is a set of planes (base/plane.h), each a texture of its own format. A base slot
 * has one only while its tile is deformed.
 *
 * Offset and disturbance are drawn: every deformed tile has them, also coarser ones. The other planes are the soil's state of
 * the working level. All of them exist once gpu_slots_deform or an upload asked for one.
 */
#define GPU_DRAWN_PLANES (PLANE_BIT(PLANE_OFFSET) | PLANE_BIT(PLANE_DISTURBANCE))
struct gpu_slot {
	struct gpu_texture *base;           /* NULL: no tile was ever loaded here */
	struct gpu_texture *classes;        /* NULL: no classes were ever loaded here */
	struct gpu_texture *planes[PLANES]; /* NULL: not deformed, or no such plane; it counts as zeros */
	struct gpu_target *target;          /* FBO over offset and disturbance (colours 0, 1); NULL: not deformed */
};
/* Makes the pools. `planes`: a mask of all planes that may be used; the offset always is. */
enum status gpu_slots_create(struct gpu *gpu, uint32_t cells, uint32_t count, unsigned planes,
			     struct gpu_slots **out) FURROW_CHECKED;
unsigned gpu_slots_planes(const struct gpu_slots *slots); /* returns that mask */
void gpu_slots_destroy(struct gpu_slots *slots);
const struct gpu_slot *gpu_slots_get(const struct gpu_slots *slots, uint32_t slot);
/* Tells the bytes of all slots, with free deform slots and without scratch. */
struct gpu_slots_bytes {
	uint64_t base, classes, planes[PLANES];
};
void gpu_slots_bytes(const struct gpu_slots *slots, struct gpu_slots_bytes *bytes);
/* How many slots were allocated (they stay until the end), and what was computed in them. */
struct gpu_slots_figures {
	uint64_t base_slots, class_slots, deform_slots, state_slots, patches;
	uint64_t subdivided, decimated; /* bases interpolated; decimations of a deformed tile */
};
void gpu_slots_figures(const struct gpu_slots *slots, struct gpu_slots_figures *figures);
/* Adds the plan's lines of slots with these planes (0: nothing is deformed), and of the ring of pass parameters. `classes`:
 * there are classes of soil. `divides`: the working level is below 0. `decimates`: coarser levels are used. `effect`: the
 * effect that needs the planes, except disturbance. Pure. */
void gpu_slots_plan(uint32_t cells, unsigned planes, bool classes, bool divides, bool decimates, const char *effect,
		    struct plan *plan);
/* Links the programs that such slots can run. */
enum status gpu_slots_warm(struct gpu_slots *slots, bool divides, bool decimates) FURROW_CHECKED;
/* Planes have no padding in staging, row 0 first, each at an offset in bytes. The offset of a plane of int32 is a multiple of
 * 4, of uint16 a multiple of 2. The functions below only begin transfers and never wait. */
#define GPU_NO_PLANE SIZE_MAX /* as an offset: the plane is not there, or not wanted */
/* Fill the base from posts, or by a pass from a patch of level-0 posts (the arguments of lattice_subdivide). */
enum status gpu_slots_upload_base(struct gpu_slots *slots, uint32_t slot, struct gpu_staging *staging,
				  size_t posts) FURROW_CHECKED;
enum status gpu_slots_subdivide_base(struct gpu_slots *slots, uint32_t slot, struct gpu_staging *staging,
				     size_t patch, int shift, uint32_t sub_x, uint32_t sub_y) FURROW_CHECKED;
/* Fills the class of soil of every post, uint8. They stay until the next upload. */
enum status gpu_slots_upload_classes(struct gpu_slots *slots, uint32_t slot, struct gpu_staging *staging,
				     size_t classes) FURROW_CHECKED;
/* Gives the slot a deform slot with every plane that may be used. New planes are zeros. */
enum status gpu_slots_deform(struct gpu_slots *slots, uint32_t slot) FURROW_CHECKED;
/* Takes the deform slot away, before another tile is loaded. */
void gpu_slots_undeform(struct gpu_slots *slots, uint32_t slot);
/* `places`: an offset for each plane. An upload fills all planes of the deform slot; a plane with GPU_NO_PLANE gets zeros. A
 * read copies the planes that have an offset; a plane that the slot lacks gives zeros at once. Planes that the slots were not
 * created with are ignored, and read as zeros. */
enum status gpu_slots_upload_deform(struct gpu_slots *slots, uint32_t slot, struct gpu_staging *staging,
				    const size_t places[PLANES]) FURROW_CHECKED;
enum status gpu_slots_read_deform(struct gpu_slots *slots, uint32_t slot, struct gpu_staging *staging,
				  const size_t places[PLANES]) FURROW_CHECKED;
/* Writes every 2^steps-th post of `fine` inside `rect` into the coarse slot's offset and disturbance at (to_x, to_y). `rect` is
 * in posts of `fine`, and its first post must be a post of the coarse level. A fine slot that is not deformed counts as zeros.
 * A coarse one gets a deform slot of zeros, with the planes that are drawn. */
enum status gpu_slots_decimate(struct gpu_slots *slots, uint32_t fine, struct gpu_rect rect, int steps,
			       uint32_t coarse, uint32_t to_x, uint32_t to_y) FURROW_CHECKED;

#endif
