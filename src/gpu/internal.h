/* What the files of gpu share: the objects behind the handles, and the state that is cached. */
#ifndef FURROW_GPU_INTERNAL_H
#define FURROW_GPU_INTERNAL_H

#include <assert.h>
#include <epoxy/egl.h>
#include <epoxy/gl.h>
#include <pthread.h>

#include "gpu/gpu.h"
#include "gpu/shader_table.h"

/* --- gpu_egl.c: a current OpenGL 4.5 core context without a window --- */
struct gpu_egl {
	EGLDisplay display;
	EGLContext context;
	bool software;
};
enum status gpu_egl_open(bool draws, struct gpu_egl *egl) FURROW_CHECKED;
void gpu_egl_close(struct gpu_egl *egl); /* takes one that was never opened, all zero */

/* --- gpu_ring.c: where the parameters of passes live until they were drawn --- */
/*
 * A ring of segments, each with a mapped buffer. Passes append to the current segment. When it is full, a fence is put behind it,
 * and the next segment becomes current. If that one's fence has not passed yet, a new segment is inserted before it instead.
 * So writing never waits, and never changes bytes that a queued draw still reads.
 */
#define GPU_RING_SEGMENTS 64
#define GPU_RING_BYTES ((size_t)128 * 1024) /* of a segment */
struct gpu_ring_segment {
	GLuint buffer;
	uint8_t *map;
	GLsync fence; /* NULL: nothing queued reads it */
};
struct gpu_ring {
	struct gpu_ring_segment segments[GPU_RING_SEGMENTS];
	uint32_t count, current; /* count 0: nothing was ever written */
	size_t used;             /* of the current segment, bytes */
};
/* Copies `bytes` and binds them as uniform block 0. */
enum status gpu_ring_bind(struct gpu *gpu, const void *params, size_t bytes) FURROW_CHECKED;
void gpu_ring_finish(struct gpu *gpu);

/* --- gpu_timer.c: how long each stage's passes took --- */
#define GPU_TIMER_QUERIES 512
struct gpu_timer {
	GLuint queries[GPU_TIMER_QUERIES]; /* made when first needed, on hardware only */
	uint8_t stages[GPU_TIMER_QUERIES]; /* what query i measures */
	uint32_t first, count;             /* those in flight, a ring */
	bool running;
	uint64_t timed[GPU_STAGES]; /* passes of which the time is known */
	double ms[GPU_STAGES], began;
};
void gpu_timer_begin(struct gpu *gpu, enum gpu_stage stage);
void gpu_timer_end(struct gpu *gpu, enum gpu_stage stage);
/* Takes what has ended, without waiting, into the gpu's stats. */
void gpu_timer_collect(struct gpu *gpu);
void gpu_timer_finish(struct gpu *gpu);

struct gpu {
	pthread_t owner;
	struct gpu_egl egl;
	struct gpu_info info;
	struct gpu_stats stats;
	struct failure failure; /* STATUS_OK until the first failure, which stays */
	struct gpu_program *programs;
	struct gpu_ring ring;
	struct gpu_timer timer;
	GLuint vertex_array;
	/* What is bound, so that it is not bound again. Destroyed objects are taken out. */
	const struct gpu_program *program;
	const struct gpu_target *target;
	const struct gpu_texture *textures[GPU_PASS_TEXTURES];
	const struct gpu_texture *images[GPU_PASS_IMAGES];
	bool images_only_read[GPU_PASS_IMAGES]; /* bound so */
	const struct gpu_buffer *indices;
	bool depth_test, culls, culls_front, blends, srgb;
	bool sealed; /* no program should be missing any more */
	bool storage_written; /* a pass had storage buffers; no barrier since */
	bool images_written;  /* a pass had images; no barrier since */
	bool only_read;       /* the passes that had either since then only read them */
};

/* Asserts that the caller is the owner. True if nothing failed so far: GL may be called. */
bool gpu_usable(const struct gpu *gpu);
/* Records a failure as the sticky one and returns its status. */
enum status gpu_fail(struct gpu *gpu, enum status status);
/* Before GL reads or writes what a pass may have written into storage buffers or images. */
void gpu_written_barrier(struct gpu *gpu);

struct gpu_texture {
	struct gpu *gpu;
	GLuint name;
	GLenum kind; /* GL_TEXTURE_2D, GL_TEXTURE_2D_ARRAY or GL_TEXTURE_2D_MULTISAMPLE */
	enum gpu_format format;
	uint32_t width, height, layers; /* layers 1 for a plain one */
	uint32_t levels;                /* of mipmaps; 1: none */
	uint64_t bytes;
};

bool gpu_format_is_integer(enum gpu_format format);
GLenum gpu_format_internal(enum gpu_format format);
size_t gpu_texel_bytes(const struct gpu_texture *texture);
size_t gpu_rect_bytes(const struct gpu_texture *texture, struct gpu_rect rect);

struct gpu_staging {
	struct gpu *gpu;
	GLuint name;
	size_t bytes;
	uint8_t *map;
	GLsync fence; /* NULL: idle */
	bool direct;  /* transfers take the mapped bytes as any other memory and are over at once */
};

/* Behind a transfer that was begun with it. */
void gpu_staging_fence(struct gpu_staging *staging);

struct gpu_target {
	struct gpu *gpu;
	GLuint name;
	uint32_t width, height; /* what all attachments have */
	uint32_t colours;
	bool depth, srgb, integer;
};

struct gpu_buffer {
	struct gpu *gpu;
	GLuint name;
	enum gpu_buffer_use use;
	size_t bytes;
};

struct gpu_program {
	struct gpu_program *next;
	GLuint name;
	const struct shader_text *table;
	uint64_t passes; /* that ran with it */
	char *key; /* vertex, fragment and defines, a line each */
};

/* Makes `target` what is drawn into. */
void gpu_target_bind(struct gpu *gpu, const struct gpu_target *target);

/* --- gpu_shader.c: one shader's text from its files --- */
#define GPU_SHADER_FILES 16
struct gpu_shader {
	char *text; /* mem_free */
	size_t length, capacity;
	const char *files[GPU_SHADER_FILES]; /* by their number in the joined text's line numbers */
	uint32_t file_count;
};
/* Joins `path` of `table` with what it includes (each file once); `defines` follow #version. */
enum status gpu_shader_assemble(const struct shader_text *table, const char *path,
				const char *const *defines, struct gpu_shader *shader) FURROW_CHECKED;
void gpu_shader_finish(struct gpu_shader *shader);
/* The first error of a driver's log, and where it is; `line` 0: the driver did not say. */
void gpu_shader_locate(const struct gpu_shader *shader, const char *log, const char **file, int *line,
		       char *text, size_t text_bytes);

/* --- gpu_program.c --- */
/* gpu_program_get over another table of shaders than gpu_shader_table. */
enum status gpu_program_get_from(struct gpu *gpu, const struct shader_text *table,
				 const struct gpu_program_request *request, struct gpu_program **out) FURROW_CHECKED;
void gpu_programs_finish(struct gpu *gpu);

/* --- gpu_slots_plan.c: the programs of slots --- */
const struct gpu_program_request *gpu_slots_subdivide_request(void);
const struct gpu_program_request *gpu_slots_decimate_request(unsigned planes);
struct gpu *gpu_slots_gpu(const struct gpu_slots *slots);

#endif
