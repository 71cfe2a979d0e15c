/*
 * The context's life, its counts, and its failure.
 *
 * States: usable -> failed, for good. It fails at the first GL error, when the context is lost, or when its creation fails. That
 * failure is kept. After it, only destroy functions call GL, and every function that can fail returns the kept failure.
 */

#include "gpu/internal.h"

bool gpu_usable(const struct gpu *gpu)
{
	assert(pthread_equal(gpu->owner, pthread_self()));
	return gpu->failure.status == STATUS_OK;
}

enum status gpu_fail(struct gpu *gpu, enum status status)
{
	if (gpu->failure.status == STATUS_OK)
		failure_capture(&gpu->failure, status);
	return failure_restore(&gpu->failure);
}

static const char *error_name(GLenum error)
{
	switch (error) {
	case GL_INVALID_ENUM:
		return "invalid enum";
	case GL_INVALID_VALUE:
		return "invalid value";
	case GL_INVALID_OPERATION:
		return "invalid operation";
	case GL_INVALID_FRAMEBUFFER_OPERATION:
		return "invalid framebuffer operation";
	case GL_OUT_OF_MEMORY:
		return "out of memory";
	default:
		return "unknown error";
	}
}

enum status gpu_check(struct gpu *gpu, const char *what)
{
	if (!gpu_usable(gpu))
		return failure_restore(&gpu->failure);
	if (glGetGraphicsResetStatus() != GL_NO_ERROR)
		return gpu_fail(gpu, fail_with(STATUS_FAILED,
			"%s: the GPU was reset and what was on it is lost; run again, what was committed is kept", what));
	GLenum error = glGetError();
	if (error == GL_NO_ERROR)
		return STATUS_OK;
	if (error == GL_OUT_OF_MEMORY)
		return gpu_fail(gpu, fail_with(STATUS_FAILED,
			"%s: the GPU is out of memory; lower cache.slots or close other programs", what));
	return gpu_fail(gpu, fail_with(STATUS_FAILED,
		"%s: GL says %s (%s); report this, or try another GL driver", what, error_name(error), gpu->info.renderer));
}

static uint32_t samples_most(void)
{
	static const GLenum names[] = {GL_MAX_SAMPLES, GL_MAX_COLOR_TEXTURE_SAMPLES, GL_MAX_DEPTH_TEXTURE_SAMPLES};
	GLint least = INT32_MAX;
	for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
		GLint samples = 1;
		glGetIntegerv(names[i], &samples);
		least = samples < least ? samples : least;
	}
	return least > 1 ? (uint32_t)least : 1;
}

static bool vertices_pass(void)
{
	GLint blocks = 0, components = 0;
	glGetIntegerv(GL_MAX_VERTEX_SHADER_STORAGE_BLOCKS, &blocks);
	glGetIntegerv(GL_MAX_VARYING_COMPONENTS, &components);
	return blocks > 1 && components >= 4 * GPU_PASSED_MOST;
}

static const char *gl_text(GLenum name)
{
	const char *text = (const char *)glGetString(name);
	return text != NULL ? text : "";
}

enum status gpu_create(const struct gpu_params *params, struct gpu **out)
{
	enum status status;
	struct gpu *gpu = mem_calloc(1, sizeof *gpu);
	TRY_MEM(gpu, "GL context");
	gpu->owner = pthread_self();
	status = gpu_egl_open(params->draws, &gpu->egl);
	if (status != STATUS_OK) {
		mem_free(gpu);
		return status;
	}
	gpu->info = (struct gpu_info){
		.vendor = gl_text(GL_VENDOR),
		.renderer = gl_text(GL_RENDERER),
		.version = gl_text(GL_VERSION),
		.software = gpu->egl.software,
		.samples_most = samples_most(),
		.vertices_pass = vertices_pass(),
	};
	/* What never changes. A vertex array is needed even by draws without attributes. */
	glCreateVertexArrays(1, &gpu->vertex_array);
	glBindVertexArray(gpu->vertex_array);
	glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
	glDepthFunc(GL_GREATER);
	glFrontFace(GL_CCW);
	glCullFace(GL_BACK);
	glDisable(GL_DITHER);
	glPixelStorei(GL_PACK_ALIGNMENT, 1);
	glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
	status = gpu_check(gpu, "GL context");
	if (status != STATUS_OK) {
		gpu_destroy(gpu);
		return status;
	}
	*out = gpu;
	return STATUS_OK;
}

void gpu_destroy(struct gpu *gpu)
{
	if (gpu == NULL)
		return;
	assert(pthread_equal(gpu->owner, pthread_self()));
	assert(gpu->stats.textures == 0);
	gpu_programs_finish(gpu);
	gpu_ring_finish(gpu);
	gpu_timer_finish(gpu);
	glDeleteVertexArrays(1, &gpu->vertex_array);
	gpu_egl_close(&gpu->egl);
	mem_free(gpu);
}

const struct gpu_info *gpu_info(const struct gpu *gpu)
{
	static const struct gpu_info none = {.vendor = "none", .renderer = "none", .version = "none"};
	return gpu != NULL ? &gpu->info : &none;
}

void gpu_stats(struct gpu *gpu, struct gpu_stats *stats)
{
	*stats = (struct gpu_stats){0};
	if (gpu == NULL)
		return;
	if (gpu_usable(gpu))
		gpu_timer_collect(gpu);
	*stats = gpu->stats;
}

void gpu_finish(struct gpu *gpu)
{
	if (gpu_usable(gpu))
		glFinish();
}

void gpu_start(struct gpu *gpu)
{
	if (gpu_usable(gpu))
		glFlush();
}

static GLbitfield written_bits(const struct gpu *gpu)
{
	GLbitfield bits = 0;
	if (gpu->storage_written)
		bits |= GL_SHADER_STORAGE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT | GL_UNIFORM_BARRIER_BIT |
			GL_ELEMENT_ARRAY_BARRIER_BIT | GL_FRAMEBUFFER_BARRIER_BIT;
	if (gpu->images_written)
		bits |= GL_SHADER_IMAGE_ACCESS_BARRIER_BIT | GL_TEXTURE_FETCH_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT |
			GL_FRAMEBUFFER_BARRIER_BIT | GL_PIXEL_BUFFER_BARRIER_BIT;
	return bits;
}

void gpu_written_barrier(struct gpu *gpu)
{
	const GLbitfield bits = written_bits(gpu);
	if (bits != 0)
		glMemoryBarrier(bits);
	gpu->storage_written = false;
	gpu->images_written = false;
	gpu->drawn = true; /* by the call that follows */
}

void gpu_drawn_barrier(struct gpu *gpu)
{
	GLbitfield bits = written_bits(gpu);
	if (gpu->drawn)
		bits |= GL_SHADER_IMAGE_ACCESS_BARRIER_BIT | GL_SHADER_STORAGE_BARRIER_BIT;
	if (bits != 0)
		glMemoryBarrier(bits);
	gpu->storage_written = false;
	gpu->images_written = false;
	gpu->drawn = false;
}
