/*
 * One pass: state, parameters, draw or dispatch. Only what differs from the pass before is set; the cache is
 * the gpu's and knows of every bind, since nothing else binds.
 */
#include "gpu/internal.h"

static void set_flag(GLenum flag, bool *now, bool wanted)
{
	if (*now != wanted)
		(wanted ? glEnable : glDisable)(flag);
	*now = wanted;
}

static void bind_inputs(struct gpu *gpu, const struct gpu_pass *pass)
{
	for (GLuint i = 0; i < GPU_PASS_TEXTURES; i++) {
		const struct gpu_texture *texture = pass->textures[i];
		if (texture == NULL || texture == gpu->textures[i])
			continue;
		assert(texture->gpu == gpu);
		glBindTextureUnit(i, texture->name);
		gpu->textures[i] = texture;
	}
	for (GLuint i = 0; i < GPU_PASS_BUFFERS; i++) {
		if (pass->storage[i] == NULL)
			continue;
		assert(pass->storage[i]->gpu == gpu && pass->storage[i]->use == GPU_STORAGE);
		glBindBufferBase(GL_SHADER_STORAGE_BUFFER, i, pass->storage[i]->name);
		gpu->storage_written = true;
	}
	for (GLuint i = 0; i < GPU_PASS_BUFFERS; i++) {
		if (pass->lists[i] == NULL)
			continue;
		assert(pass->lists[i]->gpu == gpu && pass->storage[i] == NULL);
		gpu_list_bind(pass->lists[i], i);
	}
	if (pass->block != NULL) {
		assert(pass->block->gpu == gpu && pass->block->use == GPU_STORAGE);
		glBindBufferBase(GL_UNIFORM_BUFFER, 1, pass->block->name);
	}
	for (GLuint i = 0; i < GPU_PASS_IMAGES; i++) {
		const struct gpu_texture *image = pass->images[i];
		if (image == NULL)
			continue;
		assert(image->gpu == gpu && gpu_format_is_integer(image->format));
		if (image != gpu->images[i] || pass->only_reads != gpu->images_only_read[i])
			glBindImageTexture(i, image->name, 0, image->kind == GL_TEXTURE_2D_ARRAY, 0,
					   pass->only_reads ? GL_READ_ONLY : GL_READ_WRITE, gpu_format_internal(image->format));
		gpu->images[i] = image;
		gpu->images_only_read[i] = pass->only_reads;
		gpu->images_written = true;
	}
}

static void draw(struct gpu *gpu, const struct gpu_pass *pass)
{
	if (pass->indices == NULL && pass->instances == 0) {
		glDrawArrays(GL_TRIANGLES, 0, 3);
		return;
	}
	if (pass->indices == NULL) {
		glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, (GLsizei)pass->instances);
		return;
	}
	assert(pass->indices->use == GPU_INDICES && pass->index_count % 3 == 0);
	size_t bytes = pass->wide_indices ? sizeof(uint32_t) : sizeof(uint16_t);
	assert((size_t)pass->first_index + pass->index_count <= pass->indices->bytes / bytes && pass->instances > 0);
	if (gpu->indices != pass->indices)
		glVertexArrayElementBuffer(gpu->vertex_array, pass->indices->name);
	gpu->indices = pass->indices;
	glDrawElementsInstanced(GL_TRIANGLES, (GLsizei)pass->index_count, pass->wide_indices ? GL_UNSIGNED_INT : GL_UNSIGNED_SHORT,
				(const void *)(pass->first_index * bytes), (GLsizei)pass->instances);
}

/* True if the pass's shaders have storage buffers or images. */
static bool shares(const struct gpu_pass *pass)
{
	for (size_t i = 0; i < GPU_PASS_BUFFERS; i++)
		if (pass->storage[i] != NULL)
			return true;
	for (size_t i = 0; i < GPU_PASS_IMAGES; i++)
		if (pass->images[i] != NULL)
			return true;
	return false;
}

/* The fixed-function state that a draw needs. */
static void set_drawing(struct gpu *gpu, const struct gpu_pass *pass)
{
	const struct gpu_rect *view = &pass->viewport;
	gpu_target_bind(gpu, pass->target);
	set_flag(GL_DEPTH_TEST, &gpu->depth_test, pass->depth_test);
	assert(!(pass->cull_back && pass->cull_front));
	set_flag(GL_CULL_FACE, &gpu->culls, pass->cull_back || pass->cull_front);
	if (gpu->culls && gpu->culls_front != pass->cull_front)
		glCullFace(pass->cull_front ? GL_FRONT : GL_BACK);
	gpu->culls_front = gpu->culls ? pass->cull_front : gpu->culls_front;
	assert(!(pass->multiply && pass->fill));
	set_flag(GL_BLEND, &gpu->blends, pass->multiply || pass->fill);
	if (pass->multiply)
		glBlendFuncSeparate(GL_ZERO, GL_SRC_COLOR, GL_ONE, GL_ONE);
	else if (pass->fill)
		glBlendFuncSeparate(GL_ONE_MINUS_DST_ALPHA, GL_DST_ALPHA, GL_ONE, GL_ZERO);
	if (gpu->blends)
		glBlendEquationSeparate(GL_FUNC_ADD, pass->multiply ? GL_MIN : GL_FUNC_ADD);
	glViewport((GLint)view->x, (GLint)view->y, (GLsizei)view->width, (GLsizei)view->height);
}

/* Asserts that the pass is described as its program needs it. Returns false if there is nothing to run. */
static bool is_described(const struct gpu *gpu, const struct gpu_pass *pass)
{
	const struct gpu_rect *view = &pass->viewport;
	const struct gpu_target *target = pass->target;
	assert(pass->stage < GPU_STAGES && target != NULL && target->gpu == gpu);
	assert(view->x <= target->width && view->width <= target->width - view->x);
	assert(view->y <= target->height && view->height <= target->height - view->y);
	(void)gpu, (void)target; /* where asserts are off */
	return view->width > 0 && view->height > 0;
}

void gpu_pass_run(struct gpu *gpu, const struct gpu_pass *pass)
{
	if (!gpu_usable(gpu) || !is_described(gpu, pass))
		return;
	if (pass->params != NULL && gpu_ring_bind(gpu, pass->params, pass->params_bytes) != STATUS_OK)
		return;
	gpu_timer_begin(gpu, pass->stage);
	if (!pass->beside && !(gpu->only_read && pass->only_reads))
		(shares(pass) ? gpu_drawn_barrier : gpu_written_barrier)(gpu);
	gpu->only_read = pass->only_reads;
	if (gpu->program != pass->program)
		glUseProgram(pass->program->name);
	gpu->program = pass->program;
	bind_inputs(gpu, pass);
	set_drawing(gpu, pass);
	draw(gpu, pass);
	gpu->drawn = true;
	gpu_timer_end(gpu, pass->stage);
	gpu->stats.passes[pass->stage]++;
	pass->program->passes++;
}
