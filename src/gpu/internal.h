/* What the files of this folder share: the structs behind the handles, and the cached GL state. */
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
void gpu_egl_close(struct gpu_egl *egl); /* egl may be all zeros: never opened */

/* --- gpu_turn.c: one thread at a time where GL is software --- */
void gpu_turn_begin(void); /* waits until each thread that asked before has ended its turn */
void gpu_turn_end(void);

/* --- gpu_ring.c: memory of pass parameters until the GPU has used them --- */
/*
 * A ring of segments, each with a mapped buffer. Passes append their parameters to the current segment. When it is full, a
 * fence is inserted after its last use, and the next segment becomes current. If the fence of that next segment has not passed
 * yet, a new segment is inserted before it and used instead. So writing never waits, and never changes bytes that a queued draw
 * still reads.
 */
#define GPU_RING_SEGMENTS 64
#define GPU_RING_BYTES ((size_t)128 * 1024) /* bytes of a segment */
struct gpu_ring_segment {
	GLuint buffer;
	uint8_t *map;
	GLsync fence; /* NULL: no queued draw reads this segment */
};
struct gpu_ring {
	struct gpu_ring_segment segments[GPU_RING_SEGMENTS];
	uint32_t count, current; /* count 0: the ring was never written to */
	size_t used;             /* bytes used in the current segment */
};
/* Copies `bytes` of parameters into the ring and binds them as uniform block 0. */
enum status gpu_ring_bind(struct gpu *gpu, const void *params, size_t bytes) FURROW_CHECKED;
void gpu_ring_finish(struct gpu *gpu);

/* --- gpu_timer.c: time of the passes of each stage --- */
#define GPU_TIMER_QUERIES 512
struct gpu_timer {
	GLuint queries[GPU_TIMER_QUERIES]; /* made when first needed; on hardware only */
	uint8_t stages[GPU_TIMER_QUERIES]; /* the stage that query i measures */
	uint32_t first, count;             /* queries in flight, as a ring */
	bool running;
	uint64_t timed[GPU_STAGES]; /* number of passes whose time is known */
	double ms[GPU_STAGES], began;
};
void gpu_timer_begin(struct gpu *gpu, enum gpu_stage stage);
void gpu_timer_end(struct gpu *gpu, enum gpu_stage stage);
/* Adds the times of finished queries to the gpu's stats. Does not wait. */
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
	/* What is bound now, so that it is not bound again. A destroyed object is removed here. */
	const struct gpu_program *program;
	const struct gpu_target *target;
	const struct gpu_texture *textures[GPU_PASS_TEXTURES];
	const struct gpu_texture *images[GPU_PASS_IMAGES];
	bool images_only_read[GPU_PASS_IMAGES]; /* bound for reading only */
	const struct gpu_buffer *indices;
	bool depth_test, culls, culls_front, blends, srgb;
	bool sealed; /* gpu_seal was called: no new program should be needed */
	bool storage_written; /* a pass with storage buffers ran, and no barrier since */
	bool images_written;  /* a pass with images ran, and no barrier since */
	bool drawn;           /* GL drew, cleared, copied or uploaded something, and no barrier since */
	bool only_read;       /* all passes since then that had storage or images only read them */
};

/* Asserts that the caller's thread owns the gpu. Returns true if GL may be called, that is, if nothing has failed so far. */
bool gpu_usable(const struct gpu *gpu);
/* Records a failure as the sticky failure and returns its status. */
enum status gpu_fail(struct gpu *gpu, enum status status);
/* Call this before GL reads or writes what a pass may have written into storage buffers or images. */
void gpu_written_barrier(struct gpu *gpu);
/* Call this before a pass with storage buffers or images. As gpu_written_barrier; what GL itself wrote is also done before the pass's
 * shaders begin. GL promises that order for textures that a shader samples, but not for images and storage buffers. */
void gpu_drawn_barrier(struct gpu *gpu);

struct gpu_texture {
	struct gpu *gpu;
	GLuint name;
	GLenum kind; /* GL_TEXTURE_2D, GL_TEXTURE_2D_ARRAY or GL_TEXTURE_2D_MULTISAMPLE */
	enum gpu_format format;
	uint32_t width, height, layers; /* layers is 1 for a plain texture */
	uint32_t levels;                /* number of mip levels; 1: no mipmaps */
	uint64_t bytes;                 /* 0: a view */
	struct gpu_texture *array;      /* of a view: the array of which it is a layer; otherwise NULL */
	uint32_t array_layer;
};
/* Creates a texture that is one layer of an array. It has the array's posts: what is written to one is read from the other. The array must
 * live longer. */
enum status gpu_texture_create_view(struct gpu_texture *array, uint32_t layer, struct gpu_texture **out) FURROW_CHECKED;

/* --- gpu_pool.c: textures that are views of layers of arrays --- */
struct gpu_pool;
/* `most`: how many textures may be taken. Square ones. */
enum status gpu_pool_create(struct gpu *gpu, enum gpu_format format, uint32_t side, uint32_t most, struct gpu_pool **out) FURROW_CHECKED;
void gpu_pool_destroy(struct gpu_pool *pool); /* after its textures */
enum status gpu_pool_take(struct gpu_pool *pool, struct gpu_texture **out) FURROW_CHECKED; /* the caller destroys it */
void gpu_pool_return(struct gpu_pool *pool, struct gpu_texture *last); /* destroys the texture that was taken last, which may be taken again */
void gpu_pool_figures(const struct gpu_pool *pool, uint64_t *arrays, uint64_t *layers, uint64_t *bytes); /* NULL: none */

bool gpu_format_is_integer(enum gpu_format format);
GLenum gpu_format_internal(enum gpu_format format);
size_t gpu_texel_bytes(const struct gpu_texture *texture);
size_t gpu_rect_bytes(const struct gpu_texture *texture, struct gpu_rect rect);

struct gpu_staging {
	struct gpu *gpu;
	GLuint name;
	size_t bytes;
	uint8_t *map;
	GLsync fence; /* passes when all transfers have finished; NULL: idle */
	bool direct;  /* in software: transfers use the mapped bytes as plain memory and end at once */
};

/* Inserts the fence after a transfer that was begun with this staging buffer. */
void gpu_staging_fence(struct gpu_staging *staging);

struct gpu_target {
	struct gpu *gpu;
	GLuint name;
	uint32_t width, height; /* size of all attachments */
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
	uint64_t passes; /* passes that used this program */
	char *key; /* its files and defines, each on a line */
};

struct gpu_list {
	struct gpu *gpu;
	GLuint name;
	size_t bytes; /* of a copy */
	uint8_t *map; /* of all copies */
	uint32_t copy;
	GLsync fences[GPU_LIST_COPIES];
};
/* Binds the copy that was written last. */
void gpu_list_bind(const struct gpu_list *list, uint32_t binding);

/* Makes `target` the target of drawing. */
void gpu_target_bind(struct gpu *gpu, const struct gpu_target *target);

/* --- gpu_shader.c: joins a shader's text from its files --- */
#define GPU_SHADER_FILES 32
struct gpu_shader {
	char *text; /* freed with mem_free */
	size_t length, capacity;
	const char *files[GPU_SHADER_FILES]; /* indexed by the file number in #line of the joined text */
	uint32_t file_count;
};
/* Joins the file `path` of `table` with the files it includes, each file once. `defines` are put after #version. */
enum status gpu_shader_assemble(const struct shader_text *table, const char *path,
				const char *const *defines, struct gpu_shader *shader) FURROW_CHECKED;
void gpu_shader_finish(struct gpu_shader *shader);
/* Finds the first error in a driver's log, and its place. `line` 0: the driver gave no line. */
void gpu_shader_locate(const struct gpu_shader *shader, const char *log, const char **file, int *line,
		       char *text, size_t text_bytes);

/* --- gpu_program.c: compiles and links programs --- */
/* As gpu_program_get, with another table of shaders than gpu_shader_table. */
enum status gpu_program_get_from(struct gpu *gpu, const struct shader_text *table,
				 const struct gpu_program_request *request, struct gpu_program **out) FURROW_CHECKED;
void gpu_programs_finish(struct gpu *gpu);

/* --- gpu_slots_plan.c: the programs that slots use --- */
const struct gpu_program_request *gpu_slots_subdivide_request(bool relief);
const struct gpu_program_request *gpu_slots_decimate_request(unsigned planes);
struct gpu *gpu_slots_gpu(const struct gpu_slots *slots);

#endif
