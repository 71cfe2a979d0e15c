/* A field of posts. */
#include "deform/reference/reference.h"

enum status reference_ground_init(struct reference_ground *ground, int width, int height, double spacing)
{
	size_t count = (size_t)width * (size_t)height;
	*ground = (struct reference_ground){
		.width = width,
		.height = height,
		.spacing = spacing,
		.written = {0, 0, width, height},
		.base = mem_calloc(count, sizeof(double)),
		.offset = mem_calloc(count, sizeof(double)),
		.carried = mem_calloc(count, sizeof(double)),
		.contact = mem_calloc(count, sizeof(uint8_t)),
		.hole = mem_calloc(count, sizeof(bool)),
	};
	if (ground->base != NULL && ground->offset != NULL && ground->carried != NULL && ground->contact != NULL && ground->hole != NULL)
		return STATUS_OK;
	reference_ground_finish(ground);
	return fail_memory("reference");
}

void reference_ground_finish(struct reference_ground *ground)
{
	mem_free(ground->base);
	mem_free(ground->offset);
	mem_free(ground->carried);
	mem_free(ground->contact);
	mem_free(ground->hole);
	*ground = (struct reference_ground){0};
}
