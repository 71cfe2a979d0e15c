/*
 * Textures and the targets over them.
 *
 * Invariants:
 *   1. A texture has one mip level, and is sampled NEAREST and clamped. There are three exceptions. A texture created mipmapped has
 *      all levels, filters within a level, and repeats. One created filtered filters. A texture of several samples a pixel does not filter.
 *   2. Data in and out is tight, in the format's own type, row 0 first.
 *
 * GL orders copies, clears, uploads and draws among themselves. Textures that passes wrote as images need a barrier, and so do
 * passes with images after copies, clears, uploads and draws (gpu_drawn_barrier).
 */
#include <string.h>

#include "gpu/internal.h"

struct format {
	GLenum internal, transfer, type;
	uint32_t bytes;
};

static const struct format formats[] = {
	[GPU_R32I] = {GL_R32I, GL_RED_INTEGER, GL_INT, 4},
	[GPU_R8UI] = {GL_R8UI, GL_RED_INTEGER, GL_UNSIGNED_BYTE, 1},
	[GPU_R8] = {GL_R8, GL_RED, GL_UNSIGNED_BYTE, 1},
	[GPU_R16] = {GL_R16, GL_RED, GL_UNSIGNED_SHORT, 2},
	[GPU_R16F] = {GL_R16F, GL_RED, GL_HALF_FLOAT, 2},
	[GPU_R32F] = {GL_R32F, GL_RED, GL_FLOAT, 4},
	[GPU_RGBA32I] = {GL_RGBA32I, GL_RGBA_INTEGER, GL_INT, 16},
	[GPU_RGBA32F] = {GL_RGBA32F, GL_RGBA, GL_FLOAT, 16},
	[GPU_RGBA8] = {GL_RGBA8, GL_RGBA, GL_UNSIGNED_BYTE, 4},
	[GPU_SRGB8_ALPHA8] = {GL_SRGB8_ALPHA8, GL_RGBA, GL_UNSIGNED_BYTE, 4},
	[GPU_DEPTH32F] = {GL_DEPTH_COMPONENT32F, GL_DEPTH_COMPONENT, GL_FLOAT, 4},
};

static uint32_t level_side(uint32_t side, uint32_t level)
{
	return side >> level > 0 ? side >> level : 1;
}

uint64_t gpu_texture_bytes(enum gpu_format format, uint32_t width, uint32_t height, uint32_t layers, uint32_t levels)
{
	uint64_t texels = 0;
	for (uint32_t level = 0; level < levels; level++)
		texels += (uint64_t)level_side(width, level) * level_side(height, level);
	return texels * (layers > 0 ? layers : 1) * formats[format].bytes;
}

/* Sets how the texture is sampled, and counts it. If GL has failed, destroys it. */
static enum status settle(struct gpu_texture *texture, GLint filter, GLint wrap, struct gpu_texture **out)
{
	struct gpu *gpu = texture->gpu;
	if (texture->kind != GL_TEXTURE_2D_MULTISAMPLE) { /* which is not filtered */
		glTextureParameteri(texture->name, GL_TEXTURE_MIN_FILTER, texture->levels > 1 ? GL_LINEAR_MIPMAP_NEAREST : filter);
		glTextureParameteri(texture->name, GL_TEXTURE_MAG_FILTER, filter);
		glTextureParameteri(texture->name, GL_TEXTURE_WRAP_S, wrap);
		glTextureParameteri(texture->name, GL_TEXTURE_WRAP_T, wrap);
	}
	enum status status = gpu_check(gpu, "texture");
	if (status != STATUS_OK) {
		glDeleteTextures(1, &texture->name);
		mem_free(texture);
		return status;
	}
	gpu->stats.textures++;
	gpu->stats.bytes += texture->bytes;
	*out = texture;
	return STATUS_OK;
}

/* Of more than one sample: one level and no layers. */
static enum status create(struct gpu *gpu, enum gpu_format format, uint32_t width, uint32_t height, uint32_t layers,
			  uint32_t levels, uint32_t samples, struct gpu_texture **out)
{
	GLenum internal = formats[format].internal;
	if (!gpu_usable(gpu))
		return failure_restore(&gpu->failure);
	assert(width > 0 && height > 0);
	struct gpu_texture *texture = mem_alloc(1, sizeof *texture);
	TRY_MEM(texture, "texture");
	*texture = (struct gpu_texture){
		.gpu = gpu,
		.kind = samples > 1 ? GL_TEXTURE_2D_MULTISAMPLE : layers > 0 ? GL_TEXTURE_2D_ARRAY : GL_TEXTURE_2D,
		.format = format,
		.width = width,
		.height = height,
		.layers = layers > 0 ? layers : 1,
		.levels = levels,
	};
	texture->bytes = samples * gpu_texture_bytes(format, width, height, layers, levels);
	GLint filter = levels > 1 ? GL_LINEAR : GL_NEAREST, wrap = levels > 1 ? GL_REPEAT : GL_CLAMP_TO_EDGE;
	glCreateTextures(texture->kind, 1, &texture->name);
	if (samples > 1)
		glTextureStorage2DMultisample(texture->name, (GLsizei)samples, internal, (GLsizei)width, (GLsizei)height, GL_TRUE);
	else if (layers > 0)
		glTextureStorage3D(texture->name, (GLsizei)levels, internal, (GLsizei)width, (GLsizei)height, (GLsizei)layers);
	else
		glTextureStorage2D(texture->name, (GLsizei)levels, internal, (GLsizei)width, (GLsizei)height);
	return settle(texture, filter, wrap, out);
}

enum status gpu_texture_create(struct gpu *gpu, enum gpu_format format, uint32_t width, uint32_t height, uint32_t layers,
			       struct gpu_texture **out)
{
	return create(gpu, format, width, height, layers, 1, 1, out);
}

enum status gpu_texture_create_view(struct gpu_texture *array, uint32_t layer, struct gpu_texture **out)
{
	struct gpu *gpu = array->gpu;
	assert(array->kind == GL_TEXTURE_2D_ARRAY && array->levels == 1 && layer < array->layers);
	if (!gpu_usable(gpu))
		return failure_restore(&gpu->failure);
	struct gpu_texture *texture = mem_alloc(1, sizeof *texture);
	TRY_MEM(texture, "texture");
	*texture = (struct gpu_texture){.gpu = gpu, .kind = GL_TEXTURE_2D, .format = array->format, .width = array->width, .height = array->height,
					.layers = 1, .levels = 1, .array = array, .array_layer = layer};
	glGenTextures(1, &texture->name);
	glTextureView(texture->name, GL_TEXTURE_2D, array->name, formats[array->format].internal, 0, 1, layer, 1);
	return settle(texture, GL_NEAREST, GL_CLAMP_TO_EDGE, out);
}

struct gpu_texture *gpu_texture_array(const struct gpu_texture *texture, uint32_t *layer)
{
	*layer = texture->array_layer;
	return texture->array;
}

enum status gpu_texture_create_sampled(struct gpu *gpu, enum gpu_format format, uint32_t width, uint32_t height,
				       uint32_t samples, struct gpu_texture **out)
{
	assert(samples > 1 && samples <= gpu->info.samples_most);
	return create(gpu, format, width, height, 0, 1, samples, out);
}

uint32_t gpu_mipmap_levels(uint32_t size)
{
	uint32_t levels = 1;
	while (size >> levels > 0)
		levels++;
	return levels;
}

enum status gpu_texture_create_mipmapped(struct gpu *gpu, enum gpu_format format, uint32_t size, uint32_t layers,
					 struct gpu_texture **out)
{
	assert(size > 1 && layers > 0 && !gpu_format_is_integer(format));
	return create(gpu, format, size, size, layers, gpu_mipmap_levels(size), 1, out);
}

enum status gpu_texture_create_filtered(struct gpu *gpu, enum gpu_format format, uint32_t size, uint32_t layers, struct gpu_texture **out)
{
	assert(size > 0 && layers > 0 && !gpu_format_is_integer(format));
	TRY(create(gpu, format, size, size, layers, 1, 1, out));
	glTextureParameteri((*out)->name, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
	glTextureParameteri((*out)->name, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
	return STATUS_OK;
}

void gpu_texture_destroy(struct gpu_texture *texture)
{
	if (texture == NULL)
		return;
	struct gpu *gpu = texture->gpu;
	assert(pthread_equal(gpu->owner, pthread_self()));
	for (size_t i = 0; i < GPU_PASS_TEXTURES; i++)
		if (gpu->textures[i] == texture)
			gpu->textures[i] = NULL;
	for (size_t i = 0; i < GPU_PASS_IMAGES; i++)
		if (gpu->images[i] == texture)
			gpu->images[i] = NULL;
	glDeleteTextures(1, &texture->name);
	gpu->stats.textures--;
	gpu->stats.bytes -= texture->bytes;
	mem_free(texture);
}

static void assert_inside(const struct gpu_texture *texture, uint32_t layer, struct gpu_rect rect)
{
	assert(layer < texture->layers);
	assert(rect.x <= texture->width && rect.width <= texture->width - rect.x);
	assert(rect.y <= texture->height && rect.height <= texture->height - rect.y);
	(void)texture, (void)layer, (void)rect;
}

size_t gpu_format_bytes(enum gpu_format format)
{
	return formats[format].bytes;
}

size_t gpu_texel_bytes(const struct gpu_texture *texture)
{
	return formats[texture->format].bytes;
}

size_t gpu_rect_bytes(const struct gpu_texture *texture, struct gpu_rect rect)
{
	return (size_t)rect.width * rect.height * gpu_texel_bytes(texture);
}

/* Where a layer of a texture lies. That of a view lies in its array. Transfers name the array: with NVIDIA's driver 580 a tile that was uploaded
 * to a view was not read back from it. */
struct storage {
	GLuint name;
	GLenum kind;
	GLint layer;
};

static struct storage storage_of(const struct gpu_texture *texture, uint32_t layer)
{
	const struct gpu_texture *array = texture->array;
	if (array != NULL)
		return (struct storage){array->name, array->kind, (GLint)texture->array_layer};
	return (struct storage){texture->name, texture->kind, (GLint)layer};
}

void gpu_texture_upload(struct gpu_texture *texture, uint32_t layer, struct gpu_rect rect, const void *data)
{
	const struct format *format = &formats[texture->format];
	assert_inside(texture, layer, rect);
	if (!gpu_usable(texture->gpu) || rect.width == 0 || rect.height == 0)
		return;
	gpu_written_barrier(texture->gpu);
	const struct storage to = storage_of(texture, layer);
	if (to.kind == GL_TEXTURE_2D)
		glTextureSubImage2D(to.name, 0, (GLint)rect.x, (GLint)rect.y, (GLsizei)rect.width,
				    (GLsizei)rect.height, format->transfer, format->type, data);
	else
		glTextureSubImage3D(to.name, 0, (GLint)rect.x, (GLint)rect.y, to.layer, (GLsizei)rect.width,
				    (GLsizei)rect.height, 1, format->transfer, format->type, data);
	texture->gpu->stats.uploads++;
	texture->gpu->stats.upload_bytes += gpu_rect_bytes(texture, rect);
}

void gpu_texture_upload_part(struct gpu_texture *texture, uint32_t layer, struct gpu_rect rect, const void *data)
{
	const size_t first = ((size_t)rect.y * texture->width + rect.x) * gpu_texel_bytes(texture);
	if (!gpu_usable(texture->gpu))
		return;
	glPixelStorei(GL_UNPACK_ROW_LENGTH, (GLint)texture->width);
	gpu_texture_upload(texture, layer, rect, (const char *)data + first);
	glPixelStorei(GL_UNPACK_ROW_LENGTH, 0);
}

void gpu_texture_upload_level(struct gpu_texture *texture, uint32_t level, const void *data)
{
	const struct format *format = &formats[texture->format];
	uint32_t side = level_side(texture->width, level);
	assert(texture->kind == GL_TEXTURE_2D_ARRAY && level < texture->levels);
	if (!gpu_usable(texture->gpu))
		return;
	gpu_written_barrier(texture->gpu);
	glTextureSubImage3D(texture->name, (GLint)level, 0, 0, 0, (GLsizei)side, (GLsizei)side, (GLsizei)texture->layers,
			    format->transfer, format->type, data);
	texture->gpu->stats.uploads++;
	texture->gpu->stats.upload_bytes += (uint64_t)side * side * texture->layers * format->bytes;
}

void gpu_texture_read(struct gpu_texture *texture, uint32_t layer, struct gpu_rect rect, void *data)
{
	const struct format *format = &formats[texture->format];
	size_t bytes = gpu_rect_bytes(texture, rect);
	assert_inside(texture, layer, rect);
	if (bytes == 0)
		return;
	if (!gpu_usable(texture->gpu)) {
		memset(data, 0, bytes);
		return;
	}
	assert(bytes <= INT32_MAX);
	gpu_written_barrier(texture->gpu);
	const struct storage from = storage_of(texture, layer);
	glGetTextureSubImage(from.name, 0, (GLint)rect.x, (GLint)rect.y, from.layer, (GLsizei)rect.width,
			     (GLsizei)rect.height, 1, format->transfer, format->type, (GLsizei)bytes, data);
	texture->gpu->stats.read_backs++;
	texture->gpu->stats.read_back_bytes += bytes;
}

void gpu_texture_clear(struct gpu_texture *texture, uint32_t layer, struct gpu_rect rect, int32_t value)
{
	const struct format *format = &formats[texture->format];
	const int32_t all[4] = {value, value, value, value};
	uint8_t byte = (uint8_t)value;
	uint16_t half = (uint16_t)value;
	assert_inside(texture, layer, rect);
	if (!gpu_usable(texture->gpu) || rect.width == 0 || rect.height == 0)
		return;
	gpu_written_barrier(texture->gpu);
	const struct storage to = storage_of(texture, layer);
	glClearTexSubImage(to.name, 0, (GLint)rect.x, (GLint)rect.y, to.layer, (GLsizei)rect.width,
			   (GLsizei)rect.height, 1, format->transfer, format->type,
			   format->bytes == 1 ? (const void *)&byte : format->bytes == 2 ? (const void *)&half : all);
}

void gpu_texture_copy(struct gpu_texture *from, uint32_t from_layer, uint32_t from_x, uint32_t from_y,
		      struct gpu_texture *to, uint32_t to_layer, struct gpu_rect to_rect)
{
	assert(from->gpu == to->gpu && from->format == to->format);
	assert_inside(from, from_layer, (struct gpu_rect){from_x, from_y, to_rect.width, to_rect.height});
	assert_inside(to, to_layer, to_rect);
	if (!gpu_usable(to->gpu) || to_rect.width == 0 || to_rect.height == 0)
		return;
	gpu_written_barrier(to->gpu);
	const struct storage source = storage_of(from, from_layer), into = storage_of(to, to_layer);
	glCopyImageSubData(source.name, source.kind, 0, (GLint)from_x, (GLint)from_y, source.layer, into.name, into.kind,
			   0, (GLint)to_rect.x, (GLint)to_rect.y, into.layer, (GLsizei)to_rect.width,
			   (GLsizei)to_rect.height, 1);
	to->gpu->stats.copies++;
	to->gpu->stats.copy_bytes += gpu_rect_bytes(to, to_rect);
}

bool gpu_format_is_integer(enum gpu_format format)
{
	return formats[format].transfer == GL_RED_INTEGER || formats[format].transfer == GL_RGBA_INTEGER;
}

GLenum gpu_format_internal(enum gpu_format format)
{
	return formats[format].internal;
}

static void attach(struct gpu_target *target, GLenum point, struct gpu_attachment attachment)
{
	const struct gpu_texture *texture = attachment.texture;
	assert(attachment.layer < texture->layers);
	if (texture->kind != GL_TEXTURE_2D_ARRAY)
		glNamedFramebufferTexture(target->name, point, texture->name, 0);
	else
		glNamedFramebufferTextureLayer(target->name, point, texture->name, 0, (GLint)attachment.layer);
	assert(target->width == 0 || (target->width == texture->width && target->height == texture->height));
	target->width = texture->width;
	target->height = texture->height;
}

/* Complete: the caller's. Otherwise it is destroyed. */
static enum status seal(struct gpu *gpu, struct gpu_target *target, struct gpu_target **out)
{
	enum status status;
	TRY_OR(failed, gpu_check(gpu, "render target"));
	if (glCheckNamedFramebufferStatus(target->name, GL_DRAW_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
		TRY_OR(failed, gpu_fail(gpu, fail_with(STATUS_FAILED,
			"render target: %s does not support it; use another GL driver", gpu->info.renderer)));
	*out = target;
	return STATUS_OK;
failed:
	glDeleteFramebuffers(1, &target->name);
	mem_free(target);
	return status;
}

enum status gpu_target_create(struct gpu *gpu, const struct gpu_attachment *colours, uint32_t count,
			      struct gpu_attachment depth, struct gpu_target **out)
{
	static const GLenum points[8] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1, GL_COLOR_ATTACHMENT2,
					 GL_COLOR_ATTACHMENT3, GL_COLOR_ATTACHMENT4, GL_COLOR_ATTACHMENT5,
					 GL_COLOR_ATTACHMENT6, GL_COLOR_ATTACHMENT7};
	if (!gpu_usable(gpu))
		return failure_restore(&gpu->failure);
	assert(count <= 8 && (count > 0 || depth.texture != NULL));
	struct gpu_target *target = mem_calloc(1, sizeof *target);
	TRY_MEM(target, "render target");
	target->gpu = gpu;
	target->colours = count;
	glCreateFramebuffers(1, &target->name);
	for (uint32_t i = 0; i < count; i++) {
		enum gpu_format format = colours[i].texture->format;
		attach(target, points[i], colours[i]);
		target->srgb = target->srgb || format == GPU_SRGB8_ALPHA8;
		target->integer = target->integer || gpu_format_is_integer(format);
	}
	if (depth.texture != NULL) {
		attach(target, GL_DEPTH_ATTACHMENT, depth);
		target->depth = true;
	}
	glNamedFramebufferDrawBuffers(target->name, (GLsizei)count, points);
	return seal(gpu, target, out);
}

enum status gpu_target_create_bare(struct gpu *gpu, uint32_t width, uint32_t height, struct gpu_target **out)
{
	if (!gpu_usable(gpu))
		return failure_restore(&gpu->failure);
	assert(width > 0 && height > 0);
	struct gpu_target *target = mem_calloc(1, sizeof *target);
	TRY_MEM(target, "render target");
	*target = (struct gpu_target){.gpu = gpu, .width = width, .height = height};
	glCreateFramebuffers(1, &target->name);
	glNamedFramebufferParameteri(target->name, GL_FRAMEBUFFER_DEFAULT_WIDTH, (GLint)width);
	glNamedFramebufferParameteri(target->name, GL_FRAMEBUFFER_DEFAULT_HEIGHT, (GLint)height);
	return seal(gpu, target, out);
}

void gpu_target_destroy(struct gpu_target *target)
{
	if (target == NULL)
		return;
	assert(pthread_equal(target->gpu->owner, pthread_self()));
	if (target->gpu->target == target)
		target->gpu->target = NULL;
	glDeleteFramebuffers(1, &target->name);
	mem_free(target);
}

void gpu_target_bind(struct gpu *gpu, const struct gpu_target *target)
{
	if (gpu->target != target)
		glBindFramebuffer(GL_DRAW_FRAMEBUFFER, target->name);
	gpu->target = target;
	if (gpu->srgb != target->srgb)
		(target->srgb ? glEnable : glDisable)(GL_FRAMEBUFFER_SRGB);
	gpu->srgb = target->srgb;
}

void gpu_target_clear(struct gpu_target *target, const float rgba[4])
{
	const float depth = 0;
	assert(!target->integer);
	if (!gpu_usable(target->gpu))
		return;
	gpu_target_bind(target->gpu, target);
	for (uint32_t i = 0; i < target->colours; i++)
		glClearNamedFramebufferfv(target->name, GL_COLOR, (GLint)i, rgba);
	if (target->depth)
		glClearNamedFramebufferfv(target->name, GL_DEPTH, 0, &depth);
}

void gpu_target_resolve(struct gpu_target *from, struct gpu_target *to)
{
	struct gpu *gpu = from->gpu;
	GLint width = (GLint)from->width, height = (GLint)from->height;
	assert(to->gpu == gpu && to->width == from->width && to->height == from->height && to->srgb == from->srgb);
	if (!gpu_usable(gpu))
		return;
	gpu_timer_begin(gpu, GPU_RESOLVE);
	gpu_written_barrier(gpu);
	gpu_target_bind(gpu, to); /* for its encoding: whether what is averaged is light */
	glBlitNamedFramebuffer(from->name, to->name, 0, 0, width, height, 0, 0, width, height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
	gpu_timer_end(gpu, GPU_RESOLVE);
	gpu->stats.passes[GPU_RESOLVE]++;
}
