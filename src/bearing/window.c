/* The planes of one window, which are used again for each contact and region. */
#include "bearing/internal.h"

#include "base/memory.h"

#define ALIGN 64

static size_t aligned(size_t bytes)
{
	return (bytes + ALIGN - 1) / ALIGN * ALIGN;
}

/* Places the planes of `posts` posts in memory. Returns the bytes; memory NULL: only counts them. */
static size_t place(struct bearing *bearing, size_t posts, char *memory)
{
	struct soil_planes *p = &bearing->window.planes;
	const size_t whole = aligned(posts * sizeof(int32_t)), byte = aligned(posts);
	size_t used = 0;
	const struct {
		int32_t **plane;
		bool kept;
	} wholes[] = {
		{&p->base, true}, {&p->offset, true}, {&p->deposited, bearing->planes & PLANE_BIT(PLANE_DEPOSITED)},
		{&p->sinkage, bearing->planes & PLANE_BIT(PLANE_PLASTIC_SINKAGE)}, {&p->shear, bearing->planes & PLANE_BIT(PLANE_SHEAR)},
		{&p->dug, bearing->planes & PLANE_BIT(PLANE_DUG)}, {&p->settled, bearing->planes & PLANE_BIT(PLANE_SETTLED)},
		{&p->loose, bearing->planes & PLANE_BIT(PLANE_LOOSE)}, {&p->floor, bearing->planes & PLANE_BIT(PLANE_FLOOR)},
		{&p->density, bearing->planes & PLANE_BIT(PLANE_DENSITY)}, {&p->slope, bearing->planes & PLANE_BIT(PLANE_SLOPE)},
		{&bearing->window.marks.healed, bearing->planes & PLANE_BIT(PLANE_HEALED)}, {&bearing->window.marks.risen, bearing->planes & PLANE_BIT(PLANE_RISEN)},
		{&bearing->window.marks.grown, bearing->planes & PLANE_BIT(PLANE_GROWN)},
		{&bearing->window.deposits, bearing->conserves},
		{&bearing->window.carried, bearing->conserves},
	};
	for (size_t i = 0; i < sizeof wholes / sizeof *wholes; i++) {
		*wholes[i].plane = memory != NULL && wholes[i].kept ? (void *)(memory + used) : NULL;
		used += wholes[i].kept ? whole : 0;
	}
	uint8_t **const bytes[] = {&p->contact, &bearing->window.owners, &bearing->window.patch};
	for (size_t i = 0; i < (bearing->bears ? sizeof bytes / sizeof *bytes : 1); i++, used += byte)
		*bytes[i] = memory != NULL ? (void *)(memory + used) : NULL;
	p->disturbance = p->classes = p->levels = NULL;
	if (bearing->params.disturbance) {
		p->disturbance = memory != NULL ? (void *)(memory + used) : NULL;
		used += byte;
	}
	if (bearing->params.soil_count > 1) {
		p->classes = memory != NULL ? (void *)(memory + used) : NULL;
		used += byte;
	}
	if (bearing->params.raster_count > 0) {
		p->levels = memory != NULL ? (void *)(memory + used) : NULL;
		used += aligned(posts * SOIL_RASTERS);
	}
	return used;
}

enum status bearing_scratch_need(struct bearing *bearing, size_t bytes)
{
	struct bearing_window *window = &bearing->window;
	if (bytes > window->scratch_bytes) {
		mem_free(window->scratch);
		window->scratch_bytes = 0;
		TRY(mem_make(&window->scratch, bytes, 1, "the soil around a body"));
		window->scratch_bytes = bytes;
	}
	return STATUS_OK;
}

static enum status need_words(struct bearing *bearing, size_t words)
{
	struct bearing_window *window = &bearing->window;
	if (words > window->word_count) {
		mem_free(window->words);
		window->word_count = 0;
		TRY(mem_make(&window->words, words, sizeof *window->words, "the soil around a body"));
		window->word_count = words;
	}
	return STATUS_OK;
}

enum status bearing_window_need(struct bearing *bearing, struct post_rect rect)
{
	struct bearing_window *window = &bearing->window;
	const size_t width = (size_t)(rect.x1 - rect.x0), height = (size_t)(rect.y1 - rect.y0), posts = aligned(width * (height + (bearing->bears ? 1 : 0))); /* a row more: parts are read in whole blocks */
	if (posts > window->posts) {
		mem_free(window->memory);
		window->posts = window->bytes = 0;
		const size_t bytes = place(bearing, posts, NULL);
		TRY(mem_make(&window->memory, bytes, 1, "the soil around a body"));
		window->posts = posts;
		window->bytes = bytes;
		place(bearing, posts, window->memory);
	}
	window->planes.rect = rect;
	window->planes.width = width;
	if (!bearing->conserves)
		return STATUS_OK;
	const size_t laying = soil_lay_scratch(width, height), sliding = soil_sliding_scratch(&bearing->rule, &window->planes);
	TRY(bearing_scratch_need(bearing, laying > sliding ? laying : sliding));
	return need_words(bearing, (width / SOIL_BLOCK + 2) * (height / SOIL_BLOCK + 2));
}

static int32_t *mark_of(const struct bearing_window *window, enum plane plane)
{
	return plane == PLANE_HEALED ? window->marks.healed : plane == PLANE_RISEN ? window->marks.risen : window->marks.grown;
}

static void gather_marks(struct bearing *bearing, const struct tile_slot *held, size_t count, struct post_rect part)
{
	struct soil_planes planes;
	if ((bearing->planes & PLANE_MARKS) == 0)
		return;
	const size_t at = bearing_window_part(&bearing->window, part, &planes);
	for (int plane = PLANE_HEALED; plane <= PLANE_GROWN; plane++)
		if (bearing->planes & PLANE_BIT(plane))
			resident_host_gather_mark(bearing->slots, held, count, &planes, (enum plane)plane, mark_of(&bearing->window, (enum plane)plane) + at);
}

void bearing_marks_scatter(struct bearing *bearing, const struct tile_slot *held, size_t count, struct post_rect changed)
{
	for (int plane = PLANE_HEALED; plane <= PLANE_GROWN; plane++)
		if (bearing->planes & PLANE_BIT(plane))
			resident_host_scatter_mark(bearing->slots, held, count, &bearing->window.planes, (enum plane)plane, mark_of(&bearing->window, (enum plane)plane),
						   changed);
}

void bearing_window_clear(struct bearing *bearing)
{
	const struct soil_planes *planes = &bearing->window.planes;
	memset(planes->contact, 0, planes->width * (size_t)(planes->rect.y1 - planes->rect.y0));
	resident_host_gather(bearing->slots, NULL, 0, planes);
	gather_marks(bearing, NULL, 0, planes->rect);
}

size_t bearing_window_part(const struct bearing_window *window, struct post_rect part, struct soil_planes *planes)
{
	const struct soil_planes *all = &window->planes;
	const size_t at = (size_t)(part.y0 - all->rect.y0) * all->width + (size_t)(part.x0 - all->rect.x0);
	*planes = *all;
	planes->rect = part;
	int32_t **const wholes[] = {&planes->base, &planes->offset, &planes->deposited, &planes->sinkage, &planes->shear, &planes->dug,
				    &planes->settled, &planes->loose, &planes->floor, &planes->density, &planes->slope};
	for (size_t i = 0; i < sizeof wholes / sizeof *wholes; i++)
		*wholes[i] = *wholes[i] != NULL ? *wholes[i] + at : NULL;
	uint8_t **const bytes[] = {&planes->disturbance, &planes->classes, &planes->contact};
	for (size_t i = 0; i < sizeof bytes / sizeof *bytes; i++)
		*bytes[i] = *bytes[i] != NULL ? *bytes[i] + at : NULL;
	planes->levels = planes->levels != NULL ? planes->levels + SOIL_RASTERS * at : NULL;
	return at;
}

/* What bodies alone read and change. */
static void drop_memory(struct soil_planes *planes)
{
	planes->sinkage = planes->shear = planes->dug = planes->settled = planes->loose = planes->floor = planes->density = NULL;
}

static void gather_memory(struct bearing *bearing, const struct tile_slot *held, size_t count, struct post_rect part)
{
	struct soil_planes planes;
	if (post_rect_empty(part) || bearing->window.planes.sinkage == NULL)
		return;
	bearing_window_part(&bearing->window, part, &planes);
	planes.base = planes.offset = planes.deposited = planes.slope = NULL;
	planes.disturbance = planes.classes = planes.levels = NULL;
	resident_host_gather(bearing->slots, held, count, &planes);
}

void bearing_window_gather(struct bearing *bearing, const struct tile_slot *held, size_t count, bool slides, bool whole)
{
	struct soil_planes planes;
	struct post_rect part = {0, 0, 0, 0};
	for (size_t i = 0; i < count && !whole; i++)
		part = post_rect_joined(part, tile_post_rect(bearing->params.extent, held[i].tile));
	part = whole ? bearing->window.planes.rect : post_rect_intersect(part, bearing->window.planes.rect);
	if (post_rect_empty(part))
		return;
	bearing_window_part(&bearing->window, part, &planes);
	if (!slides)
		planes.slope = NULL;
	if (slides)
		planes.disturbance = planes.levels = NULL;
	gather_memory(bearing, held, count, slides ? (struct post_rect){0, 0, 0, 0} : post_rect_intersect(part, bearing->under));
	drop_memory(&planes);
	resident_host_gather(bearing->slots, held, count, &planes);
	if (!slides)
		gather_marks(bearing, held, count, part);
}

void bearing_window_finish(struct bearing_window *window)
{
	mem_free_all(window->memory, window->scratch, window->words);
}
