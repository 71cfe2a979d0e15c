#include "base/recent.h"

#include "base/memory.h"

enum status recent_create(struct recent *recent, uint32_t count)
{
	*recent = (struct recent){.count = count, .places = mem_calloc(count, sizeof *recent->places)};
	return recent->places != NULL ? STATUS_OK : fail_memory("a cache of tiles");
}

void recent_finish(struct recent *recent)
{
	mem_free(recent->places);
}

uint32_t recent_find(const struct recent *recent, uint64_t key)
{
	for (uint32_t i = 0; i < recent->count; i++)
		if (recent->places[i].used != 0 && recent->places[i].key == key)
			return i;
	return RECENT_NONE;
}

uint32_t recent_oldest(const struct recent *recent, uint32_t spared)
{
	uint32_t oldest = RECENT_NONE;
	for (uint32_t i = 0; i < recent->count; i++)
		if (i != spared && (oldest == RECENT_NONE || recent->places[i].used < recent->places[oldest].used))
			oldest = i;
	return oldest;
}

void recent_use(struct recent *recent, uint32_t place, uint64_t key)
{
	recent->places[place] = (struct recent_place){key, ++recent->clock};
}

void recent_empty(struct recent *recent, uint32_t place)
{
	recent->places[place].used = 0;
}
