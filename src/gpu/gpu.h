/*
 * gpu: the only folder that calls EGL and GL. Other folders describe textures, programs and passes. The thread that creates a
 * gpu is the only one that may use it, and everything made from it (asserted). A process has at most one gpu at a time. Create
 * it before any thread that reads the environment.
 *
 * It uses OpenGL 4.5 core without a window: first EGL surfaceless, then device platforms. A hardware GPU is preferred to
 * software, unless LIBGL_ALWAYS_SOFTWARE is set. A GL error or a lost context is sticky: every later call that can fail returns
 * it. Other calls then do nothing, and reads give zeros.
 *
 * A texel of a tile's texture is a post; row 0 is the southern row. Clip space has its origin at the lower left. Its depth is
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
struct gpu_list;
struct gpu_program;
struct gpu_slots;
struct gpu_staging;
struct gpu_counter;

struct gpu_info {
	const char *vendor, *renderer, *version;
	bool software;
	uint32_t samples_most; /* most samples for each pixel */
	/* a vertex shader can read two buffers of storage, and pass GPU_PASSED_MOST vectors on. OpenGL 4.5 promises no storage and 15 vectors; usual drivers
	 * have both */
	bool vertices_pass;
};
#define GPU_PASSED_MOST 23

/* Every pass belongs to a stage, for counts and times. The order is that in which stages run. */
enum gpu_stage {
	GPU_ENVELOPE,  /* lower envelope of an object over its window, computed from a formula */
	GPU_FACETS,    /* the same, computed from triangles */
	GPU_CONTACT,
	GPU_SMOOTH,
	GPU_BEND,      /* an elastic sheet bends */
	GPU_SPREAD,
	GPU_SLIDE,     /* relaxation over a window */
	GPU_HOLD,      /* objects at rest on ground blocks that relax */
	GPU_SETTLE,    /* relaxation over blocks */
	GPU_DISTURBANCE,
	GPU_PYRAMID,
	GPU_TERRAIN,
	GPU_SHADOW,    /* draws the shadows of objects on the terrain */
	GPU_OBJECTS,
	GPU_SKY,
	GPU_RESOLVE,   /* averages the samples of each pixel */
	GPU_EXPOSE,    /* turns light into colours */
	/* fills a tile finer than level 0 by interpolation when the tile is loaded (Technique 4 of the dissertation) */
	GPU_SUBDIVIDE,
	GPU_STAGES
};
const char *gpu_stage_name(enum gpu_stage stage);

/* Groups of stages: those of the dissertation, and others. */
enum gpu_group { GPU_DISPLACE, GPU_REDISTRIBUTE, GPU_ATTRIBUTES, GPU_DECIMATE, GPU_RENDER, GPU_DIVIDE, GPU_GROUPS };

/* What was made and run so far. Textures and bytes count what exists now. */
struct gpu_stats {
	uint64_t passes[GPU_STAGES];
	/* On hardware: GPU time of the passes that have ended. In software: CPU time of the calling thread, since timers of
	 * software GL are wrong. */
	double stage_ms[GPU_STAGES];
	uint32_t programs;  /* linked programs that exist now */
	uint32_t textures;  /* textures that exist now */
	uint64_t bytes;     /* of textures and buffers that exist now */
	uint64_t uploads, upload_bytes, read_backs, read_back_bytes;
	uint64_t copies, copy_bytes; /* from texture to texture: the bytes of the texels that were written */
	uint32_t ring_segments; /* segments of the ring of pass parameters (PLAN_RING) */
	uint32_t unplanned;     /* programs linked after gpu_seal */
};
/* These return sums over all stages of a group. */
uint64_t gpu_group_passes(const struct gpu_stats *stats, enum gpu_group group);
double gpu_group_ms(const struct gpu_stats *stats, enum gpu_group group);

/* --- context: gpu_context.c --- */
struct gpu_params {
	bool draws; /* passes are large, as those of a picture, so llvmpipe keeps its raster threads */
};
enum status gpu_create(const struct gpu_params *params, struct gpu **out) FURROW_CHECKED; /* STATUS_NO_GL */
void gpu_destroy(struct gpu *gpu); /* destroy everything made from it before; gpu may be NULL */
/*
 * The program that calls the library may draw with GL too, and may call from changing threads. So each call of the library
 * first saves the current context (gpu_keep) and makes its own current (gpu_take). At its end it restores the saved one
 * (gpu_give). Between gpu_take and gpu_give the calling thread owns the gpu. Where GL is software, and while a context is made,
 * a call waits until the calls that began before it have ended: see gpu_turn.c.
 */
struct gpu_kept {
	void *display, *draw, *read, *context; /* of EGL; context NULL: no context was current */
	unsigned api;
	bool turn; /* other threads wait */
};
void gpu_keep(const struct gpu *gpu, struct gpu_kept *kept); /* gpu NULL: it will be made */
void gpu_give(const struct gpu_kept *kept);
/* STATUS_NO_GL: the context cannot be made current on this thread. */
enum status gpu_take(struct gpu *gpu) FURROW_CHECKED;
/* gpu NULL: there is no context, and nothing was done. */
const struct gpu_info *gpu_info(const struct gpu *gpu);
void gpu_stats(struct gpu *gpu, struct gpu_stats *stats);
/* Returns the sticky failure, or a GL error since the last check. `what`: what was being done, for the message. */
enum status gpu_check(struct gpu *gpu, const char *what) FURROW_CHECKED;
void gpu_start(struct gpu *gpu); /* lets the GPU begin with all that was queued. Does not wait */
void gpu_finish(struct gpu *gpu); /* waits until the GPU has finished; for benches, and before the first step */

/* --- textures and targets: gpu_texture.c --- */
/* R8 and R16 are normalised; R16F and R32F are float. A bench keeps heights in these formats, to compare them with integer
 * heights. */
enum gpu_format {
	GPU_R32I, GPU_R8UI, GPU_R8, GPU_R16, GPU_R16F, GPU_R32F, GPU_RGBA32I, GPU_RGBA32F, GPU_RGBA8, GPU_SRGB8_ALPHA8, GPU_DEPTH32F
};

size_t gpu_format_bytes(enum gpu_format format); /* bytes of a texel */

/* Makes a texture. layers 0: a plain 2D texture; otherwise an array with that many layers. Contents are undefined. Lookups take
 * the nearest texel; outside 0..1 they take the edge. */
enum status gpu_texture_create(struct gpu *gpu, enum gpu_format format, uint32_t width,
			       uint32_t height, uint32_t layers, struct gpu_texture **out) FURROW_CHECKED;
/* Makes a multisample texture. It can only be drawn into, resolved, or read in a shader sample by sample. samples: 2 to
 * gpu_info.samples_most. A driver may take more samples than asked for. */
enum status gpu_texture_create_sampled(struct gpu *gpu, enum gpu_format format, uint32_t width, uint32_t height,
				       uint32_t samples, struct gpu_texture **out) FURROW_CHECKED;
/* Makes an array of square textures with all mip levels down to one texel. The format must allow filtering. A lookup takes the
 * nearest mip level and interpolates linearly within it. Outside 0..1 the texture repeats. Upload each level whole, layer after
 * layer. Other transfers use level 0. */
enum status gpu_texture_create_mipmapped(struct gpu *gpu, enum gpu_format format, uint32_t size, uint32_t layers,
					 struct gpu_texture **out) FURROW_CHECKED;
/* Makes an array of square textures. A lookup interpolates linearly between texels, sRGB as light. Outside 0..1 it takes the edge. The
 * format must allow filtering. */
enum status gpu_texture_create_filtered(struct gpu *gpu, enum gpu_format format, uint32_t size, uint32_t layers, struct gpu_texture **out)
	FURROW_CHECKED;
uint32_t gpu_mipmap_levels(uint32_t size); /* returns the number of mip levels of such a texture. Pure */
uint64_t gpu_texture_bytes(enum gpu_format format, uint32_t width, uint32_t height, uint32_t layers, uint32_t levels); /* pure */
void gpu_texture_upload_level(struct gpu_texture *texture, uint32_t level, const void *data);
void gpu_texture_destroy(struct gpu_texture *texture);
/* Rectangles are x, y, width, height in texels. Data has no padding between rows. The clear value has the bits of a texel.
 * RGBA32I: the value is written to all four. Formats of one or two bytes: the low bytes. RGBA8: four bytes, red lowest. Float
 * formats: the bits of the float. */
struct gpu_rect {
	uint32_t x, y, width, height;
};
void gpu_texture_upload(struct gpu_texture *texture, uint32_t layer, struct gpu_rect rect, const void *data);
/* Uploads a rectangle of `data`, which has all texels of the layer. */
void gpu_texture_upload_part(struct gpu_texture *texture, uint32_t layer, struct gpu_rect rect, const void *data);
void gpu_texture_read(struct gpu_texture *texture, uint32_t layer, struct gpu_rect rect, void *data); /* waits for the GPU */
void gpu_texture_clear(struct gpu_texture *texture, uint32_t layer, struct gpu_rect rect, int32_t value);
void gpu_texture_copy(struct gpu_texture *from, uint32_t from_layer, uint32_t from_x, uint32_t from_y,
		      struct gpu_texture *to, uint32_t to_layer, struct gpu_rect to_rect);

/* --- staging: gpu_staging.c --- */
/*
 * Memory that both the CPU and the GPU use: one buffer, mapped as long as it exists. Transfers run in the order of the calls,
 * together with all other GPU work. So after a read into the staging buffer is begun, its texture may at once be drawn into,
 * uploaded to or cleared.
 *
 * Any number of transfers may be in flight. Their bytes belong to the GPU until the staging buffer is idle again. Other bytes
 * of the buffer may be used.
 */
enum status gpu_staging_create(struct gpu *gpu, size_t bytes, struct gpu_staging **out) FURROW_CHECKED;
void gpu_staging_destroy(struct gpu_staging *staging); /* waits for transfers in flight; staging may be NULL */
/* Returns the mapped bytes, aligned for any plane. The address never changes. Any thread may use them while the staging buffer
 * is idle. */
void *gpu_staging_bytes(struct gpu_staging *staging);
/* Returns true when every transfer started with this staging buffer has finished. Never waits. After a failure (see gpu_check)
 * it returns true, and the bytes are undefined. */
bool gpu_staging_idle(struct gpu_staging *staging);
/* Begin a transfer and do not wait for it. `offset`: in bytes, a multiple of the texel's size. A read after a failure gives
 * zeros. */
void gpu_texture_upload_from(struct gpu_texture *texture, uint32_t layer, struct gpu_rect rect,
			     struct gpu_staging *staging, size_t offset);
void gpu_texture_read_into(struct gpu_texture *texture, uint32_t layer, struct gpu_rect rect,
			   struct gpu_staging *staging, size_t offset);

struct gpu_attachment {
	struct gpu_texture *texture;
	uint32_t layer;
};
/* Makes an FBO with at most 8 colour textures of one size. depth.texture may be NULL if there are colours. The caller owns the
 * textures. They must stay valid longer than the target. */
enum status gpu_target_create(struct gpu *gpu, const struct gpu_attachment *colours, uint32_t count,
			      struct gpu_attachment depth, struct gpu_target **out) FURROW_CHECKED;
/* Makes an FBO without attachments, for passes that only write images and storage buffers. */
enum status gpu_target_create_bare(struct gpu *gpu, uint32_t width, uint32_t height,
				   struct gpu_target **out) FURROW_CHECKED;
void gpu_target_destroy(struct gpu_target *target);
/* Clears floating-point and normalised attachments only. Depth is cleared to 0 (reversed depth). */
void gpu_target_clear(struct gpu_target *target, const float rgba[4]);
/* Writes the mean of each pixel's samples to the target `to`. `to` has one sample for each pixel, the same size, and the format
 * of the first colour of `from`. sRGB colours are averaged as linear light. Counts as a pass of GPU_RESOLVE. */
void gpu_target_resolve(struct gpu_target *from, struct gpu_target *to);

/* --- programs: gpu_program.c --- */
/* Shaders are files of shaders/ ("deform/none.frag"), which the build embeds in the program. A program has a vertex and a fragment
 * shader. `#include "lib/x.glsl"` is resolved. Each define is "NAME" or "NAME value" and makes a variant. The same request returns
 * the same program. The gpu owns all programs. An error message has file:line and the driver's text. */
#define GPU_DEFINES_MAX 20
struct gpu_program_request {
	const char *vertex, *fragment;
	const char *defines[GPU_DEFINES_MAX]; /* ends with NULL unless all entries are used */
};
enum status gpu_program_get(struct gpu *gpu, const struct gpu_program_request *request,
			    struct gpu_program **out) FURROW_CHECKED;
/* Writes the program's name for plans and listings: "VERTEX FRAGMENT DEFINE ...", cut to `size`. Pure. */
#define GPU_PROGRAM_NAME 256
void gpu_program_name(const struct gpu_program_request *request, char *name, size_t size);
/* Calls `each` with every linked program, the last linked first, and with the number of passes that used it so far. */
void gpu_programs_each(const struct gpu *gpu, void (*each)(void *user, const char *name, uint64_t passes), void *user);
/* Tells the gpu that all programs are linked. Programs linked later are counted (stats.unplanned), and a note names the first
 * of them. */
void gpu_seal(struct gpu *gpu);

/* --- buffers: gpu_buffer.c --- */
/* Makes a buffer of fixed size. Without data it is filled with zeros. */
enum gpu_buffer_use { GPU_INDICES, GPU_STORAGE };
enum status gpu_buffer_create(struct gpu *gpu, enum gpu_buffer_use use, size_t bytes,
			      const void *data_or_null, struct gpu_buffer **out) FURROW_CHECKED;
void gpu_buffer_destroy(struct gpu_buffer *buffer);
void gpu_buffer_write(struct gpu_buffer *buffer, size_t offset, size_t bytes, const void *data); /* waits for the GPU */
void gpu_buffer_read(struct gpu_buffer *buffer, size_t offset, size_t bytes, void *data); /* waits for the GPU */
/* Begins a read and does not wait for it, like gpu_texture_read_into. Offsets are multiples of 4. */
void gpu_buffer_read_into(struct gpu_buffer *buffer, size_t offset, size_t bytes, struct gpu_staging *staging,
			  size_t staging_offset);
/* fills bytes with zeros; offset and bytes are multiples of 4 */
void gpu_buffer_clear(struct gpu_buffer *buffer, size_t offset, size_t bytes);

/* --- lists: gpu_list.c --- */
/* Storage that passes read and the CPU writes anew, as a whole, before some of them. A pass reads what was written last when it was
 * run, however late the GPU comes to it. gpu_list_bytes: the GPU memory of a list for `bytes`, for plans; pure. */
#define GPU_LIST_COPIES 4
uint64_t gpu_list_bytes(size_t bytes);
enum status gpu_list_create(struct gpu *gpu, size_t bytes, struct gpu_list **out) FURROW_CHECKED;
void gpu_list_destroy(struct gpu_list *list);
void gpu_list_write(struct gpu_list *list, size_t bytes, const void *data); /* may wait for passes of four writings before */

/* --- passes: gpu_pass.c --- */
#define GPU_PASS_TEXTURES 9
#define GPU_PASS_BUFFERS 6
#define GPU_PASS_IMAGES 8
struct gpu_pass {
	enum gpu_stage stage; /* the pass is counted under this stage */
	struct gpu_program *program;
	struct gpu_target *target;
	struct gpu_rect viewport; /* within the target; nothing outside it is written */
	struct gpu_texture *textures[GPU_PASS_TEXTURES]; /* layout(binding = i); NULL: none */
	struct gpu_buffer *storage[GPU_PASS_BUFFERS];    /* layout(std430, binding = i) */
	struct gpu_list *lists[GPU_PASS_BUFFERS];        /* layout(std430, binding = i), only read; of storage and list i one is NULL */
	/* Bound as layout(binding = i), with all layers of an array; integer formats. The pass may read and write them. Every
	 * later pass, copy and read sees what it wrote. The target's textures must not be among them. */
	struct gpu_texture *images[GPU_PASS_IMAGES];
	bool only_reads; /* the pass does not write storage and images; such passes need not wait for each other */
	bool beside; /* the pass reads and writes no post that passes since the last one without this wrote, so it does not wait for them */
	struct gpu_buffer *block; /* layout(std140, binding = 1): GPU_STORAGE that earlier passes wrote; NULL: none */
	const void *params; /* std140 block, layout(binding = 0). The bytes are copied. NULL: none */
	size_t params_bytes; /* at most 16 KiB */
	/* The geometry. Without indices, and instances 0: one triangle that covers the viewport; full.vert makes it from
	 * gl_VertexID. Without indices, and instances > 0: that many strips of four vertices each. With indices: triangles with
	 * uint16 indices, drawn `instances` times. */
	struct gpu_buffer *indices;
	uint32_t index_count, instances;
	uint32_t first_index;
	bool wide_indices; /* indices are uint32 */
	bool depth_test;  /* draws only what is nearer; depth is reversed, so the test is GREATER */
	bool cull_back;   /* does not draw back faces; counter-clockwise is front */
	bool cull_front;  /* does not draw front faces; not together with cull_back */
	/* Blending; if the target is sRGB, of linear light. At most one of these. */
	bool multiply;    /* multiplies the target's colours by the drawn colours; keeps the lesser alpha */
	bool fill;        /* adds the drawn colours with the weight 1 - alpha of the target, to its colours with the weight alpha; takes the drawn alpha */
};
void gpu_pass_run(struct gpu *gpu, const struct gpu_pass *pass);

/* --- counters: gpu_query.c --- */
/* Counts the samples that pass the depth test in all passes between begin and end. Only one counter may be between begin and
 * end at a time. Never waits. */
enum status gpu_counter_create(struct gpu *gpu, struct gpu_counter **out) FURROW_CHECKED;
void gpu_counter_destroy(struct gpu_counter *counter); /* counter may be NULL */
void gpu_counter_begin(struct gpu_counter *counter);
void gpu_counter_end(struct gpu_counter *counter);
/* Gives the results that have arrived since the last call: the sum of samples, and the number of counts. After gpu_finish all
 * have arrived. If too many counts are in flight, a new count gives no result. */
void gpu_counter_take(struct gpu_counter *counter, uint64_t *samples, uint64_t *times);

/* --- slots: gpu_slots.c --- */
/*
 * A slot holds one tile on the GPU. There are two pools of slots. Memory of a slot is allocated when the slot is first needed,
 * then reused, and freed at the end.
 *
 * A base slot holds base heights: a (cells + 1)^2 R32I texture in 2^-18 m relative to the store's reference, with an FBO. It
 * also holds soil classes (R8UI) if they were loaded. A deform slot holds planes (base/plane.h), each a texture of its own
 * format. A base slot has a deform slot only while its tile is deformed.
 *
 * Offset, disturbance and marks that fade are drawn. So every deformed tile has them, also coarser tiles. The other planes are the soil's state
 * at the working level. If gpu_slots_deform or an upload needs one of them, all are made.
 */
#define GPU_DRAWN_PLANES (PLANE_BIT(PLANE_OFFSET) | PLANE_BIT(PLANE_DISTURBANCE) | PLANE_MARKS)
struct gpu_slot {
	struct gpu_texture *base;           /* NULL: no tile was ever loaded into this slot */
	struct gpu_texture *classes;        /* NULL: no soil classes were ever loaded into this slot */
	struct gpu_texture *planes[PLANES]; /* NULL: the tile is not deformed, or the slots lack this plane; it counts as zeros */
	struct gpu_target *target;          /* FBO with the drawn planes as colours, in the planes' order; NULL: the tile is not deformed */
};
/* Returns the array of which a texture of a slot is a layer, and its layer. NULL: it is none (gpu_slots_in_arrays). */
struct gpu_texture *gpu_texture_array(const struct gpu_texture *texture, uint32_t *layer);
/* Makes the pools. `count`: number of base slots. `planes`: a mask of the planes that may be used; the offset is always one of
 * them. */
enum status gpu_slots_create(struct gpu *gpu, uint32_t cells, uint32_t count, unsigned planes,
			     struct gpu_slots **out) FURROW_CHECKED;
/* From now on base heights and drawn planes are layers of a few arrays. One pass can read and write those of many tiles. Arrays are
 * made as they are needed, up to 256 layers at once. Call it before a tile is loaded. */
enum status gpu_slots_in_arrays(struct gpu_slots *slots) FURROW_CHECKED;
unsigned gpu_slots_planes(const struct gpu_slots *slots); /* returns the mask of planes that may be used */
void gpu_slots_destroy(struct gpu_slots *slots);
const struct gpu_slot *gpu_slots_get(const struct gpu_slots *slots, uint32_t slot);
/* Gives the bytes of all slots, including free deform slots. Scratch textures do not count. */
struct gpu_slots_bytes {
	uint64_t base, classes, planes[PLANES];
};
void gpu_slots_bytes(const struct gpu_slots *slots, struct gpu_slots_bytes *bytes);
/* How many slots were allocated so far (they stay until the end), and what was computed in them. */
struct gpu_slots_figures {
	uint64_t base_slots, class_slots, deform_slots, state_slots, patches;
	/* gpu_slots_in_arrays: arrays of base heights and their layers; the same for each drawn plane */
	uint64_t base_arrays, base_layers, deform_arrays, deform_layers;
	uint64_t subdivided, decimated; /* base tiles interpolated; decimations of a deformed tile */
};
void gpu_slots_figures(const struct gpu_slots *slots, struct gpu_slots_figures *figures);
/* How tiles below level 0 get their base in slots: not at all, by interpolation, or with relief. */
enum gpu_division { GPU_UNDIVIDED, GPU_DIVIDED, GPU_DIVIDED_RELIEF };
/* Adds to `plan` the lines of slots with these planes (0: nothing is deformed), and of the ring of
 * pass parameters. `classes`: there are soil classes.
 * `arrays`: they lie in arrays. `decimates`: coarser levels are used. `effect`: the effect that needs the planes other than
 * disturbance. Pure. */
void gpu_slots_plan(uint32_t cells, unsigned planes, bool classes, enum gpu_division division, bool arrays, bool decimates,
		    const char *effect, struct plan *plan);
/* The same of slots that mirror tiles in host memory, for pictures. `planes`: those of the tiles; only drawn ones have textures. classes_effect: the
 * effect that draws classes; NULL: none are drawn. `effect`: what draws pictures. Pure. */
void gpu_slots_plan_mirror(uint32_t cells, unsigned planes, const char *classes_effect, const char *effect, struct plan *plan);
/* Links all programs that these slots can run. */
enum status gpu_slots_warm(struct gpu_slots *slots, enum gpu_division division,
			   bool decimates) FURROW_CHECKED;
/* Planes lie in a staging buffer without padding, row 0 first, each at its offset in bytes. The offset is a multiple of 4 for
 * planes of int32, of 2 for uint16. The functions below only begin transfers and never wait. */
#define GPU_NO_PLANE SIZE_MAX /* as an offset: the plane is missing or not wanted */
/* Fill the slot's base heights. The first takes posts. The second runs a pass that interpolates a patch of level-0 posts; its
 * arguments are those of lattice_subdivide. */
enum status gpu_slots_upload_base(struct gpu_slots *slots, uint32_t slot, struct gpu_staging *staging,
				  size_t posts) FURROW_CHECKED;
enum status gpu_slots_subdivide_base(struct gpu_slots *slots, uint32_t slot, struct gpu_staging *staging,
				     size_t patch, int shift, uint32_t sub_x, uint32_t sub_y) FURROW_CHECKED;
/* The same with relief, which has no classes, for the tile. */
enum status gpu_slots_subdivide_relief(struct gpu_slots *slots, uint32_t slot,
				       struct gpu_staging *staging, size_t patch, uint32_t sub_x,
				       uint32_t sub_y, struct tile tile,
				       const struct relief *relief) FURROW_CHECKED;
/* Fills the soil class of every post, uint8. The classes stay until the next upload. */
enum status gpu_slots_upload_classes(struct gpu_slots *slots, uint32_t slot, struct gpu_staging *staging,
				     size_t classes) FURROW_CHECKED;
/*
 * Slots that mirror tiles in host memory, for pictures. The tile's posts are read before the call returns, and nothing waits for
 * the GPU.
 */
/* Fills the slot's base heights; and the soil class of every post. */
enum status gpu_slots_put_base(struct gpu_slots *slots, uint32_t slot, const int32_t *posts) FURROW_CHECKED;
enum status gpu_slots_put_classes(struct gpu_slots *slots, uint32_t slot, const uint8_t *classes) FURROW_CHECKED;
/* Fills the drawn planes inside `rect`. A slot that is not deformed gets a deform slot with the drawn planes, and whole planes.
 * `planes`: each is the whole tile, in the plane's own type; NULL: zeros. Planes that are not drawn are ignored. */
enum status gpu_slots_put_drawn(struct gpu_slots *slots, uint32_t slot, struct gpu_rect rect, const void *const planes[PLANES])
	FURROW_CHECKED;
/* Makes the slot deformed: gives it a deform slot with all planes that may be used. New planes are zeros. */
enum status gpu_slots_deform(struct gpu_slots *slots, uint32_t slot) FURROW_CHECKED;
/* Takes the deform slot away, before another tile is loaded into this slot. */
void gpu_slots_undeform(struct gpu_slots *slots, uint32_t slot);
/* `places`: an offset in the staging buffer for each plane. The upload fills all planes of the deform slot; a plane with
 * GPU_NO_PLANE gets zeros. The read copies each plane that has an offset; a plane that the slot lacks gives zeros at once.
 * Planes outside the mask of gpu_slots_create are not uploaded, and read as zeros. */
enum status gpu_slots_upload_deform(struct gpu_slots *slots, uint32_t slot, struct gpu_staging *staging,
				    const size_t places[PLANES]) FURROW_CHECKED;
enum status gpu_slots_read_deform(struct gpu_slots *slots, uint32_t slot, struct gpu_staging *staging,
				  const size_t places[PLANES]) FURROW_CHECKED;
/* Copies every 2^steps-th post of slot `fine` inside `rect` into slot `coarse`, to (to_x, to_y): the drawn planes. `rect`
 * is in posts of `fine`; its first post must also be a post of the coarse level. A fine slot that is not deformed counts as
 * zeros. A coarse slot that is not deformed first gets a deform slot of zeros, with the drawn planes. */
enum status gpu_slots_decimate(struct gpu_slots *slots, uint32_t fine, struct gpu_rect rect, int steps,
			       uint32_t coarse, uint32_t to_x, uint32_t to_y) FURROW_CHECKED;

#endif
